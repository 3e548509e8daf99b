"""The chart of the sensor: what a ping costs at each fidelity, and how it agrees with wave theory."""

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from .draw_sensor import Found, draw_sensor
from .machine import machine
from .sensor_measuring import FULL, QUICK, accuracies, costs, percentile
from .sensor_statements import sensor_statements
from .sensor_truths import SOURCES
from .statements import Statement

UNITS = {
    "seconds": "s of a ping, all of it, or of a ray",
    "detection": "1, share of the poses at which both hear or neither does",
    "median, percentile_95, errors": "m, of c/2 times the echo width",
    "level_median, level_percentile_95, level_errors": "dB",
}


def sensor(folder: Path, quick: bool = False, say: Callable[[str], None] = lambda _: None) -> list[Statement]:
    """Writes sensor.json and the pictures into `folder`; returns what the fidelities are held to.

    Raises FileNotFoundError where the units are not built or there is no C compiler, ModuleNotFoundError without SciPy
    or CasADi.
    """
    effort = QUICK if quick else FULL
    here = machine()
    rows = list(accuracies(effort, say))
    say("cost of a ping")
    prices, bare, mesh = costs(effort)
    found = sensor_statements(rows, prices, bare, mesh)
    folder.mkdir(parents=True, exist_ok=True)
    document = {
        "machine": here,
        "units": UNITS,
        "truths": SOURCES,
        "accuracies": [
            {
                **asdict(row),
                "median": _number(percentile(row.errors, 50)),
                "percentile_95": _number(percentile(row.errors, 95)),
                "level_median": _number(percentile(row.level_errors, 50)),
                "level_percentile_95": _number(percentile(row.level_errors, 95)),
            }
            for row in rows
        ],
        "costs": [asdict(price) for price in prices],
        "bare": bare,
        "mesh": mesh and asdict(mesh),
        "statements": [{**asdict(statement), "holds": statement.holds} for statement in found],
    }
    (folder / "sensor.json").write_text(json.dumps(document, indent=1) + "\n")
    say("picture")
    named = f"{here['processor']}, {here['system']}"
    draw_sensor(Found(rows, prices), named, [folder / f"sensor.{kind}" for kind in ("png", "svg")])
    return found


def _number(value: float) -> float | None:
    """For JSON, which has no number for an error of no pose."""
    return None if value != value else value
