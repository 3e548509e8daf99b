"""The command `ulna check`: judges units, or any FMU by a model of it, and shows the claims as a table."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from .needs import MissingNeedError, MisuseError, require_modules

if TYPE_CHECKING:
    from .claims import Row
    from .hunt import Kill

FAILED = 1
WRONG = 2

console = Console()


def check(
    unit: Annotated[
        str | None,
        typer.Argument(help="Name of a unit, or path of an .fmu file (then with --model); default: all units."),
    ] = None,
    model: Annotated[
        Path | None, typer.Option(help="Python file with equations(values) in CasADi, to hold an FMU against.")
    ] = None,
    mutants: Annotated[
        bool, typer.Option("--mutants", help="Break the units on purpose and see each break found.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON in place of a table.")] = False,
) -> None:
    """Checks equations on symbols, and the FMUs as built against them; exits with 1 if a claim fails."""
    try:
        require_modules()
        holds = _run(unit, model, mutants, as_json)
    except (MissingNeedError, MisuseError, FileNotFoundError) as error:
        typer.echo(f"ulna check: {error}", err=True)
        raise typer.Exit(WRONG) from error
    if not holds:
        raise typer.Exit(FAILED)


def _run(unit: str | None, model: Path | None, mutants: bool, as_json: bool) -> bool:
    # CasADi is loaded on first use: the command line must start without it
    from . import judge

    if mutants:
        from .hunt import hunt

        return _show_hunt(*hunt([unit] if unit else None), as_json)
    is_file = unit is not None and (unit.endswith(".fmu") or "/" in unit)
    if is_file != (model is not None):
        raise MisuseError("a file is judged by a model: ulna check my.fmu --model my_model.py")
    if is_file:
        return _show(judge.judge_fmu(unit, model), as_json)
    names = [unit] if unit else judge.units()
    if not names:
        raise FileNotFoundError("no FMUs found; build them with 'make build' or 'pip install .'")
    return _show((row for name in names for row in judge.judge_unit(name)), as_json)


def _show(rows: Iterable["Row"], as_json: bool) -> bool:
    """Prints the claims, unit by unit as they are judged; True if all hold."""
    if as_json:
        rows = list(rows)
        holds = all(row.holds for row in rows)
        print(json.dumps({"holds": holds, "claims": [asdict(row) for row in rows]}, indent=2))
        return holds
    count = failed = 0
    for name, group in groupby(rows, key=lambda row: row.unit):
        table = Table("claim", "how shown", "bound", "verdict", title=name, title_justify="left")
        for row in group:
            table.add_row(escape(row.claim), escape(row.how), escape(row.bound), verdict(row.holds))
            count += 1
            failed += not row.holds
        console.print(table)
    console.print(f"{count} claims, {failed or 'none'} failed")
    return not failed


def verdict(holds: bool) -> str:
    """The last column of a table."""
    return "holds" if holds else "[bold red]FAILS[/]"


def _show_hunt(kills: list["Kill"], idle: dict[str, list[str]], as_json: bool) -> bool:
    """Prints each mutant with the claims that failed for it; True if all died and every claim found one."""
    alive = sum(not kill.claims for kill in kills)
    useless = [f"{unit}: {claim}" for unit, claims in idle.items() for claim in claims]
    if as_json:
        found = [{"unit": k.mutant.unit, "mutant": k.mutant.about, "killed by": k.claims} for k in kills]
        print(json.dumps({"holds": not (alive or useless), "mutants": found, "claims that found none": idle}, indent=2))
        return not (alive or useless)
    table = Table("unit", "mutant", "killed by")
    for kill in kills:
        more = f" and {len(kill.claims) - 1} more" if len(kill.claims) > 1 else ""
        killer = escape(kill.claims[0]) + more if kill.claims else "[bold red]LIVES[/]"
        table.add_row(kill.mutant.unit, escape(kill.mutant.about), killer)
    console.print(table)
    for claim in useless:
        console.print(f"found no mutant: {claim}", markup=False)
    console.print(f"{len(kills)} mutants, {alive or 'none'} alive; {len(useless) or 'no'} claims found none")
    return not (alive or useless)
