"""The chart of skins: what each method costs, and what it does to the arm."""

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from .draw_skin import draw_skin
from .machine import machine
from .skin_measuring import COST_VERTICES, FULL, QUICK, costs, shapes
from .skin_speed import speeds
from .skin_statements import skin_statements
from .skin_strip import draw_strip
from .statements import Statement

UNITS = {
    "seconds": "s of a vertex, position and normal where there is one; of speeds CPU time",
    "angle": "degrees",
    "volume_error": "1, of the blend zone",
    "bulge": "radii",
    "fold_fraction": "1",
    "stretch": "1, of the longest edge over rest",
    "section": "1, least section of a ring over that at rest",
    "normal_error": "degrees, mean over the blend zone",
}


def skin(folder: Path, quick: bool = False, say: Callable[[str], None] = lambda _: None) -> list[Statement]:
    """Writes skin.json and the pictures into `folder`; returns what the skins are held to.

    Raises FileNotFoundError where the units are not built or there is no C compiler.
    """
    effort = QUICK if quick else FULL
    here = machine()
    say("cost of a vertex")
    prices = costs(effort)
    rows = list(shapes(effort, say))
    fast = list(speeds(effort.rounds, effort.sizes, say))
    found = skin_statements(fast, rows, effort.vertices)
    folder.mkdir(parents=True, exist_ok=True)
    document = {
        "machine": here,
        "units": UNITS,
        "vertices": {"cost": COST_VERTICES, "shape": effort.vertices},
        "costs": [asdict(price) for price in prices],
        "shapes": [asdict(row) for row in rows],
        "speeds": [asdict(speed) for speed in fast],
        "statements": [{**asdict(statement), "holds": statement.holds} for statement in found],
    }
    (folder / "skin.json").write_text(json.dumps(document, indent=1) + "\n")
    say("pictures")
    named = f"{effort.vertices} vertices; time: {COST_VERTICES} vertices, {here['processor']}, {here['system']}"
    draw_skin(prices, rows, named, [folder / f"skin.{kind}" for kind in ("png", "svg")])
    draw_strip(folder / "skin_strip.png")
    return found
