"""The whole chart: measured, written as JSON, drawn, and what follows from it."""

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from .draw import draw
from .machine import machine
from .measure import FULL, QUICK, Effort, Point, timed, unit_candidates
from .peers import peer_candidates
from .problems import Problem, problems
from .statements import Statement, statements

NOTES = """One communication step to the end, with many internal steps; what only calls cost, at communication \
steps down to 1 ms. Processor time of a C loop, median of {rounds} interleaved runs.
DOP853 and CVODE (BDF) call Python for each right-hand side: compare their evaluations, not their time.
MuJoCo's mj_step, its profiler off, does more than these bodies need: collision, constraints, actuators, sensors, \
trees of bodies. Here there is one body and nothing of that, but the machinery is passed through.
A right-hand side: all torques at one instant, or one coefficient of a Taylor series; the closed form has none.
Reference: Taylor series in whole numbers, 45 digits. {machine}."""


def rigid_body(folder: Path, quick: bool = False, say: Callable[[str], None] = lambda _: None) -> list[Statement]:
    """Writes rigid_body.json and the pictures into `folder`; returns what the solvers are held to.

    Raises FileNotFoundError where the units are not built, or where there is no C compiler.
    """
    effort = QUICK if quick else FULL
    all_problems = problems()
    points: list[Point] = []
    for problem in all_problems:
        say(problem.title)
        points += measured(problem, effort)
    say("statements")
    found = statements(all_problems, points, effort.rounds)
    folder.mkdir(parents=True, exist_ok=True)
    here = machine()
    write(folder / "rigid_body.json", points, found, here)
    notes = NOTES.format(rounds=effort.rounds, machine=f"{here['processor']}, {here['system']}")
    for work, stem in (("seconds", "rigid_body"), ("evaluations", "rigid_body_evaluations")):
        say(f"picture of {work}")
        draw(all_problems, points, work, notes, [folder / f"{stem}.{kind}" for kind in ("png", "svg")])
    return found


def measured(problem: Problem, effort: Effort) -> list[Point]:
    """All points of one problem, of the unit and of the peers, timed in turn."""
    candidates = [*unit_candidates(problem, effort), *peer_candidates(problem, effort)]
    return timed(candidates, problem.end, effort.rounds)


def write(path: Path, points: list[Point], found: list[Statement], here: dict[str, str]) -> None:
    """All points and statements as JSON."""
    document = {
        "machine": here,
        "units": {"error": "rad", "seconds": "s per simulated s", "evaluations": "per simulated s"},
        "points": [asdict(point) for point in points],
        "statements": [{**asdict(statement), "holds": statement.holds} for statement in found],
    }
    path.write_text(json.dumps(document, indent=1) + "\n")
