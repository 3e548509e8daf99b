"""The command `ulna chart`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from ..names import unknown
from .coupling import coupling
from .rigid_body import rigid_body
from .sensor import sensor
from .skin import skin
from .statements import Statement

CHARTS = {"rigid-body": rigid_body, "coupling": coupling, "skin": skin, "sensor": sensor}


def chart(
    name: Annotated[str, typer.Argument(metavar="CHART", help=f"Which chart: {', '.join(CHARTS)}.")],
    quick: Annotated[bool, typer.Option("--quick", help="Fewer points and repeats, within a minute.")] = False,
    out: Annotated[Path | None, typer.Option(help="Folder to write to; default: results/chart-CHART.")] = None,
) -> None:
    """Draws accuracy against time: of solvers beside other libraries, couplings of an arm, skins, the sensor."""
    console = Console()
    if name not in CHARTS:
        raise typer.BadParameter(unknown("ulna", "chart", name, CHARTS))
    folder = out or Path("results") / f"chart-{name}"
    with console.status(name) as status:
        try:
            found = CHARTS[name](folder, quick, status.update)
        except (FileNotFoundError, ModuleNotFoundError) as error:
            raise typer.BadParameter(str(error)) from None
    show(found, console)
    written = sorted(path.name for path in folder.iterdir() if path.stem.startswith(name.replace("-", "_")))
    console.print(f"{folder}: {', '.join(written)}", markup=False, highlight=False)


def show(found: list[Statement], console: Console) -> None:
    """Prints the statements."""
    table = Table("statement", "value", "bound", "", "", title="What this is held to", title_justify="left")
    for statement in found:
        bound = f"{'at most' if statement.most else 'at least'} {statement.bound:g}"
        verdict = "[green]holds[/]" if statement.holds else "[red]fails[/]"
        table.add_row(statement.claim, f"{statement.value:.3g}", bound, verdict, statement.note)
    console.print(table)
