"""The command `ulna stability`."""

import json
import math
from collections import Counter
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer
from rich.console import Console
from rich.table import Table

from .coupling_measuring import measure_coupling
from .coupling_picture import TITLES, VERDICTS, draw_coupling
from .measuring import measure
from .picture import draw
from .sensor_measuring import measure_sensor
from .sensor_picture import VERDICTS as SENSOR_VERDICTS
from .sensor_picture import draw_sensor
from .skin_measuring import measure_skin
from .skin_picture import COLUMNS as SKINS
from .skin_picture import draw_skin

COLUMNS = ("solver", "energy", "attitude", "rod: energy", "attitude", "10 000 rad/s: energy", "attitude")
KEYS = [kind + what for kind in ("", "rod_", "fast_") for what in ("energy", "attitude")]


class Subject(StrEnum):
    """What there is a map of."""

    RIGID_BODY = "rigid-body"
    COUPLING = "coupling"
    SKIN = "skin"
    SENSOR = "sensor"


class Map(NamedTuple):
    """How a map is made: name of its files, what is measured, drawn and printed."""

    stem: str
    measure: Callable[[bool], dict[str, Any]]
    draw: Callable[..., None]
    show: Callable[[dict[str, Any]], None]


def stability(
    subject: Annotated[Subject, typer.Argument(help="What the map is of.")] = Subject.RIGID_BODY,
    quick: Annotated[bool, typer.Option("--quick", help="Coarser: fewer points, limits within 10 %.")] = False,
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("results/stability"),
) -> None:
    """Finds where each solver of the rigid bodies, master, skin or sensor fails; draws it against theory."""
    made = MAPS[subject]
    found = made.measure(quick)
    out.mkdir(parents=True, exist_ok=True)
    paths = [out / f"{made.stem}.{ending}" for ending in ("svg", "png", "json")]
    made.draw(found, *paths[:2])
    paths[2].write_text(json.dumps(_finite(found), indent=1) + "\n")
    made.show(found)
    typer.echo(f"{out}: {', '.join(path.name for path in paths)}")


def _finite(value: Any) -> Any:
    """For JSON, which has no infinity: a limit that was not found is null."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _show_solvers(found: dict[str, Any]) -> None:
    table = Table(*COLUMNS, title="largest h |w|, rad", title_justify="left")
    for row in found["tumbling"]:
        table.add_row(row["solver"], *(_limit(row[key]) for key in KEYS))
    springs = Table("unit", "solver", "limit", "theory", title="spring inside the step: largest h sqrt(k/m)")
    for row in found["springs"]:
        springs.add_row(row["unit"], row["solver"], _limit(row["limit"]), _limit(row["theory"]))
    console = Console()
    console.print(table)
    console.print(springs)


def _show_masters(found: dict[str, Any]) -> None:
    table = Table("master", *VERDICTS, title="cells of H sqrt(k/m) and damping ratio", title_justify="left")
    for master, title in TITLES.items():
        counts = Counter(row["verdict"] for row in found["cells"] if row["master"] == master)
        table.add_row(title, *(str(counts[kind]) for kind in VERDICTS))
    ratios = Table("elbow, degrees", "measured", "theory", title="hinge on hinge: mass ratio up to which passes settle")
    for row in found["mass_ratios"]:
        ratios.add_row(f"{math.degrees(row['elbow']):.0f}", _limit(row["measured"]), _limit(row["theory"]))
    console = Console()
    console.print(table)
    console.print(ratios)


def _show_skins(found: dict[str, Any]) -> None:
    table = Table("method", "h/r", "measured", "theory", title="first fold, degrees of flexion", title_justify="left")
    for row in found["folds"]:
        if row["method"] in SKINS:
            table.add_row(row["method"], f"{row['ratio']:g}", _angle(row["measured"]), _angle(row["theory"]))
    Console().print(table)


def _show_sensor(found: dict[str, Any]) -> None:
    kinds = list(SENSOR_VERDICTS)
    table = Table("fidelity", "target", *kinds, title="cells of range, and tilt or offset", title_justify="left")
    for fidelity, target in dict.fromkeys((row["fidelity"], row["target"]) for row in found["cells"]):
        own = [row for row in found["cells"] if (row["fidelity"], row["target"]) == (fidelity, target)]
        counts = Counter(row["verdict"] for row in own)
        table.add_row(fidelity, target, *(str(counts[kind]) for kind in kinds))
    Console().print(table)


def _angle(value: float) -> str:
    return "none" if math.isinf(value) else f"{value:.2f}"


def _limit(value: float | None) -> str:
    if value is None:
        return "-"
    return "none" if math.isinf(value) else f"{value:.3g}"


MAPS = {
    Subject.RIGID_BODY: Map("rigid_body_stability", measure, draw, _show_solvers),
    Subject.COUPLING: Map("coupling_stability", measure_coupling, draw_coupling, _show_masters),
    Subject.SKIN: Map("skin_stability", measure_skin, draw_skin, _show_skins),
    Subject.SENSOR: Map("sensor_stability", measure_sensor, draw_sensor, _show_sensor),
}
