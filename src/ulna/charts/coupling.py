"""The chart of couplings: one swinging arm, built and stepped every way there is."""

import json
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

from ..bench.masters import macro_steps
from .arms import planar_arm
from .chains import chain_costs
from .coupled import FULL, QUICK, measured
from .coupling_statements import coupling_statements
from .draw_coupling import Drawn, draw_coupling
from .machine import machine
from .statements import Statement

UNITS = {
    "step": "s",
    "tolerance": "1",
    "error": "rad",
    "seconds": "s per simulated s; of chains and macro steps: s of one",
    "unit_steps": "per simulated s",
    "macro_steps": "per simulated s",
    "largest_gap": "m",
}


def coupling(folder: Path, quick: bool = False, say: Callable[[str], None] = lambda _: None) -> list[Statement]:
    """Writes coupling.json and the pictures into `folder`; returns what the couplings are held to.

    Raises FileNotFoundError where the units are not built or there is no C compiler, ModuleNotFoundError without CasADi
    or SciPy.
    """
    effort = QUICK if quick else FULL
    arm = replace(planar_arm(), end=effort.end)
    here = machine()
    points, failures = measured(arm, effort, say)
    say("chains")
    costs = chain_costs(effort.lengths, effort.rounds)
    say("macro steps")
    macro = macro_steps(effort.macro_rounds)
    found = coupling_statements(points, costs, macro, arm.end)
    folder.mkdir(parents=True, exist_ok=True)
    document = {
        "machine": here,
        "units": UNITS,
        "end": arm.end,
        "points": [asdict(point) for point in points],
        "failed": [asdict(failure) for failure in failures],
        "chains": [asdict(cost) for cost in costs],
        "macro_steps": macro,
        "statements": [{**asdict(statement), "holds": statement.holds} for statement in found],
    }
    (folder / "coupling.json").write_text(json.dumps(document, indent=1) + "\n")
    say("picture")
    drawn = Drawn(points, costs, arm.end, effort.rounds, len(failures), f"{here['processor']}, {here['system']}")
    draw_coupling(drawn, [folder / f"coupling.{kind}" for kind in ("png", "svg")])
    return found
