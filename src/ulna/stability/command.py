"""The command `ulna stability rigid-body`."""

import json
import math
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from .measuring import measure
from .picture import draw

STEM = "rigid_body_stability"
COLUMNS = ("solver", "energy", "attitude", "rod: energy", "attitude", "10 000 rad/s: energy", "attitude")
KEYS = [kind + what for kind in ("", "rod_", "fast_") for what in ("energy", "attitude")]


class Subject(StrEnum):
    """What there is a map of."""

    RIGID_BODY = "rigid-body"


def stability(
    subject: Annotated[Subject, typer.Argument(help="What the map is of.")] = Subject.RIGID_BODY,
    quick: Annotated[bool, typer.Option("--quick", help="Coarser: limits within 10 %, fewer points.")] = False,
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("results/stability"),
) -> None:
    """Finds where each solver of the rigid bodies fails, and draws it against theory: SVG, PNG and JSON."""
    found = measure(quick)
    out.mkdir(parents=True, exist_ok=True)
    paths = [out / f"{STEM}.{ending}" for ending in ("svg", "png", "json")]
    draw(found, *paths[:2])
    paths[2].write_text(json.dumps(_finite(found), indent=1) + "\n")
    _show(found)
    typer.echo(f"{out}: {', '.join(path.name for path in paths)}")


def _finite(value: Any) -> Any:
    """For JSON, which has no infinity: a limit that was not found is null."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _show(found: dict[str, Any]) -> None:
    table = Table(*COLUMNS, title="largest h |w|, rad", title_justify="left")
    for row in found["tumbling"]:
        table.add_row(row["solver"], *(_limit(row[key]) for key in KEYS))
    springs = Table("unit", "solver", "limit", "theory", title="spring inside the step: largest h sqrt(k/m)")
    for row in found["springs"]:
        springs.add_row(row["unit"], row["solver"], _limit(row["limit"]), _limit(row["theory"]))
    console = Console()
    console.print(table)
    console.print(springs)


def _limit(value: float | None) -> str:
    if value is None:
        return "-"
    return "none" if math.isinf(value) else f"{value:.3g}"
