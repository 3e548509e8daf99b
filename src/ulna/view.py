"""Writes a run as one web page: the glTF file played, the sensors' beams and echoes, and plots with a cursor.

The page needs nothing beside it: script, style, scene and signals are inside. What it does is in `viewer`; its script
is bundled from there when Ulna is built.
"""

import base64
import html
import json
from dataclasses import dataclass
from math import asin, radians, sin
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .drawing import parts, series, units_of
from .gltf import glb
from .paths import CHECKOUT, PACKAGE
from .plot import panels
from .results import Results
from .scene import Scene, SceneUnit
from .skeleton import rotate
from .targets import nearest_points

SOURCES = PACKAGE / "viewer"
BUNDLES = (SOURCES / "bundle.js", CHECKOUT / "build" / "viewer" / "bundle.js")
# A curve is drawn by its least and largest value in each of so many spans.
SPANS = 1000
# Where the piston of UltrasonicSensor is 6 dB weaker than ahead, each way, at 40 kHz.
BEAM_HALF_ANGLE = radians(27.5)
BONES = ("upper_arm_position", "upper_arm_orientation", "forearm_position", "forearm_orientation")


@dataclass(frozen=True)
class Pings:
    """The finished pings of a run, n of them: each a line in the world from the sensor to where its echo came from."""

    time: np.ndarray
    """(n,): when they were finished, s."""
    heard: np.ndarray
    """(n,), Boolean."""
    start: np.ndarray
    """(n, 3), m."""
    end: np.ndarray
    """(n, 3), m: as far from the start as was measured."""


def write_view(path: str | PathLike, results: Results, scene: Scene) -> None:
    """Writes the page of a run.

    Raises KeyError, with the name, if a pose was neither recorded nor driven by what was, and FileNotFoundError, with
    the command that makes it, if the page's script has not been built.
    """
    contents = {
        "title": html.escape(scene.name),
        "about": html.escape(f"master {results.summary.get('master', 'unknown')}, {len(results)} rows"),
        "style": (SOURCES / "page.css").read_text(encoding="utf-8"),
        # no string may end the element that holds it
        "run": json.dumps(_run(results, scene)).replace("<", "\\u003c"),
        "glb": _base64(glb(results, scene)),
        "script": _script().read_text(encoding="utf-8"),
    }
    head, *rest = (SOURCES / "page.html").read_text(encoding="utf-8").split("{{")
    pieces = [piece.split("}}", 1) for piece in rest]
    page = head + "".join(contents[name] + text for name, text in pieces)
    Path(path).write_text(page, encoding="utf-8")


def pings(results: Results, scene: Scene, sensor: SceneUnit) -> Pings:
    """What a sensor heard, and from where; raises KeyError, with the name, if one of its outputs was not recorded.

    A sensor tells a distance only. The echo is drawn towards that target, at the time, whose distance is nearest to it;
    where nothing was heard, or the targets were not recorded, straight ahead.
    """
    names = ("sequence", "valid", "distance", "position", "orientation")
    sequence, heard, distance, position, orientation = (series(results, scene, f"{sensor.name}.{n}") for n in names)
    rows = np.flatnonzero(np.diff(sequence)) + 1
    heard, distance, start, orientation = heard[rows], distance[rows], position[rows], orientation[rows]
    direction = rotate(orientation, np.array([1.0, 0.0, 0.0]))
    miss = np.where(heard, np.inf, -np.inf)
    for nearest in nearest_points(results, scene, sensor, rows, start):
        way = nearest - start
        length = np.linalg.norm(way, axis=1)
        length[length == 0.0] = np.nan
        nearer = np.abs(length - distance) < miss
        direction = np.where(nearer[:, None], way / length[:, None], direction)
        miss = np.where(nearer, np.abs(length - distance), miss)
    return Pings(results.time[rows], heard, start, start + distance[:, None] * direction)


def _run(results: Results, scene: Scene) -> dict[str, Any]:
    """What the page is told beside the glTF file."""
    return {
        "start": float(results.time[0]),
        "end": float(results.time[-1]),
        "parts": [part.name for part in parts(results, scene)],
        "skins": _skins(results, scene),
        "sensors": [_sensor(results, scene, unit) for unit in units_of(scene, "UltrasonicSensor")],
        "panels": [
            {
                "title": panel.title,
                "unit": panel.unit,
                "curves": [_curve(label, *thinned(results.time, values)) for label, values in panel.curves],
                "dots": [_curve(*dots) for dots in panel.dots],
            }
            for panel in panels(results, scene)
        ],
    }


def _skins(results: Results, scene: Scene) -> list[list[dict[str, str]]]:
    """The skins, those over the same bones together: of these the page shows one at a time."""
    groups: list[tuple[list[np.ndarray], list[dict[str, str]]]] = []
    for unit in units_of(scene, "ArmSkin"):
        poses = [series(results, scene, f"{unit.name}.{name}") for name in BONES]
        same = next((group for others, group in groups if all(map(np.array_equal, poses, others))), None)
        if same is None:
            groups.append((poses, same := []))
        same.append({"name": unit.name, "method": unit.slave.get("method")})
    return [group for _, group in groups]


def _sensor(results: Results, scene: Scene, unit: SceneUnit) -> dict[str, Any]:
    try:
        heard = pings(results, scene, unit)
        table = np.column_stack([heard.time, heard.heard, heard.start, heard.end])
    except KeyError:
        table = np.zeros(0)
    return {
        "name": unit.name,
        "half_angle": asin(min(1.0, sin(BEAM_HALF_ANGLE) * 40e3 / unit.slave.get("frequency"))),
        "range": unit.slave.get("maximum_range"),
        "pings": _base64(np.asarray(table, "<f4").tobytes()),
    }


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve by its first and last point and the least and the largest value of each span, in order of time."""
    if len(time) <= 2 * SPANS:
        return time, values
    width = -(-len(time) // SPANS)
    starts = np.arange(0, len(time), width)
    spans = np.pad(values, (0, len(starts) * width - len(time)), mode="edge").reshape(-1, width)
    rows = np.concatenate([starts + spans.argmin(axis=1), starts + spans.argmax(axis=1), [0, len(time) - 1]])
    rows = np.unique(np.minimum(rows, len(time) - 1))
    return time[rows], values[rows]


def _curve(label: str, times: np.ndarray, values: np.ndarray) -> dict[str, str]:
    floats = {
        name: _base64(np.asarray(array, "<f4").tobytes()) for name, array in (("times", times), ("values", values))
    }
    return {"label": label, **floats}


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


def _script() -> Path:
    for path in BUNDLES:
        if path.is_file():
            return path
    raise FileNotFoundError(
        "its script was not built, which needs npm and node; install them, then 'make build' or 'pip install .'"
    )
