"""The map of the sensor drawn: cells and the border of theory; interference, temperature, grazing planes, the beam."""

import math
from os import PathLike
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.projections.polar import PolarAxes

from ..charts.draw_sensor import look
from ..pictures import save
from . import sensor_theory as theory
from .picture import name
from .sensor_measuring import (
    CELSIUS,
    FARTHEST,
    FIELD_OF_VIEW,
    GRAZED_FROM,
    MAPS,
    POLE_RADIUS,
    SPHERE_RADIUS,
    TARGETS,
    THRESHOLD,
    WRONG,
    heard_to,
    pair,
    place,
)
from .verdict_map import draw_cells

VERDICTS = {
    "right": "#a8d5a2",
    "silent": "#eeeeee",
    "wrong": "#f3d48b",
    "missed": "#8fb0d4",
    "false echo": "#dd8477",
}
MEANINGS = {
    "right": f"heard, within {1e3 * WRONG:g} mm",
    "silent": "no echo, and none is audible",
    "wrong": f"heard, more than {1e3 * WRONG:g} mm off",
    "missed": "audible, and not heard",
    "false echo": "heard, and not audible",
}
TITLES = {
    "plane": ("plane", "tilt, degrees"),
    "sphere": (f"ball, radius {100 * SPHERE_RADIUS:g} cm", "offset, m"),
    "forearm": ("forearm across", "offset, m"),
}
GRAZED = ("ray", "cone", "specular")
"""To a plane `automatic` is `specular`."""
BEAMS = {
    "plane": ("wall, turned", "#1f5f99", "o"),
    "forearm": ("forearm across", "#d55e00", "D"),
    "pole": (f"pole across, radius {1e3 * POLE_RADIUS:g} mm", "#009e73", "^"),
    "sphere": (f"ball, radius {100 * SPHERE_RADIUS:g} cm", "#8a4fa3", "s"),
}


def draw_sensor(found: dict[str, Any], *paths: str | PathLike) -> None:
    """Writes the map of what `measure_sensor` found; the ending of each path chooses the format."""
    figure = Figure(figsize=(17, 15), dpi=90)
    FigureCanvasAgg(figure)
    _legend(figure.add_axes((0.03, 0.915, 0.94, 0.035)))
    fidelities = found["about"]["fidelities"]
    maps = figure.add_gridspec(
        3, len(fidelities), left=0.06, right=0.66, bottom=0.35, top=0.88, wspace=0.09, hspace=0.3
    )
    for row, target in enumerate(MAPS):
        for column, fidelity in enumerate(fidelities):
            ax = figure.add_subplot(maps[row, column])
            _map(ax, found, fidelity, target)
            words, aside = TITLES[target]
            name(ax, "" if row else fidelity, aside, "" if column else f"{words}\nrange, m")
            ax.grid(visible=False)
            if column:
                ax.tick_params(labelleft=False)
    _beam(figure.add_axes((0.675, 0.37, 0.31, 0.5), projection="polar"), found)
    curves = figure.add_gridspec(1, 4, left=0.045, right=0.985, bottom=0.05, top=0.285, wspace=0.24)
    for place_, panel in enumerate((_gaps, _temperatures, _errors, _levels)):
        panel(figure.add_subplot(curves[0, place_]), found)
    title = "Where fidelities of the ultrasonic sensor fail: measured on UltrasonicSensor, beside theory"
    figure.suptitle(title, fontsize=16, y=0.98)
    save(figure, paths)


def _legend(ax: Axes) -> None:
    handles: list[Any] = [Patch(color=color, label=MEANINGS[kind]) for kind, color in VERDICTS.items()]
    words = f"theory: level {THRESHOLD:g} dB (the forearm endless)"
    handles.append(Line2D([], [], color="black", linewidth=1.8, label=words))
    ax.axis("off")
    ax.legend(handles=handles, loc="center", ncols=6, frameon=False, fontsize=10.5, handlelength=1.4, columnspacing=1.4)


def _map(ax: Axes, found: dict[str, Any], fidelity: str, target: str) -> None:
    """Cells by verdict, and the border of theory."""
    cells = [row for row in found["cells"] if (row["fidelity"], row["target"]) == (fidelity, target)]
    if not cells:
        ax.text(0.5, 0.5, "no mesh\nis endless", transform=ax.transAxes, ha="center", va="center", color="#777777")
        ax.set(xticks=[], yticks=[])
        return
    asides, ranges = draw_cells(ax, cells, "aside", "range", VERDICTS)
    x, y = np.linspace(0.0, asides[-1], 160), np.linspace(ranges[0], ranges[-1], 160)
    ax.contour(x, y, _levels_on(target, x, y), levels=[THRESHOLD], colors="black", linewidths=1.8)
    ax.set(xlim=(0, asides[-1]), ylim=(ranges[0], ranges[-1]))


def _levels_on(target: str, asides: np.ndarray, ranges: np.ndarray) -> np.ndarray:
    """Levels of theory on a grid, [ranges, asides]."""
    here = theory.air()
    _, mirror, radius = TARGETS[target]

    def at(reach: float, aside: float) -> float:
        distance, angle = place(target, reach, aside)
        return theory.level(mirror, distance, angle, radius, here) if distance > 0 else math.inf

    return np.array([[max(at(reach, aside), -300.0) for aside in asides] for reach in ranges])


def _beam(ax: PolarAxes, found: dict[str, Any]) -> None:
    """How far each target is heard; the cone of other simulators for comparison."""
    for target, (words, color, mark) in BEAMS.items():
        rows = [row for row in found["beam"] if row["target"] == target]
        around = np.radians(np.linspace(rows[0]["angle"], rows[-1]["angle"], 251))
        ax.plot(around, [heard_to(target, angle, theory.air()) for angle in around], color=color, linewidth=1.4)
        angles = np.radians([row["angle"] for row in rows])
        ax.plot(angles, [row["measured"] for row in rows], mark, color=color, markersize=4, label=words)
    half = FIELD_OF_VIEW / 2
    rim = np.linspace(-half, half, 30)
    ax.fill([0.0, *rim], [0.0, *[FARTHEST] * len(rim)], color="#d55e00", alpha=0.12, linewidth=0)
    ax.text(0.0, 0.86 * FARTHEST, "cone", ha="center", color="#a04000", fontsize=10)
    ax.set_theta_zero_location("N")
    ax.set_thetamin(-80)
    ax.set_thetamax(80)
    ax.set_rlim(0, FARTHEST)
    ax.set_title("The beam that emerges: heard up to, m\nmarks measured, lines theory", fontsize=12, pad=10)
    ax.legend(fontsize=10, loc="lower center", bbox_to_anchor=(0.5, -0.06), ncols=2, frameon=False)
    ax.grid(alpha=0.35, linewidth=0.6)


def _gaps(ax: Axes, found: dict[str, Any]) -> None:
    shares = np.linspace(0.0, 2.0, 401)
    ax.plot(shares, [pair(share, theory.air()) for share in shares], color="black", linewidth=1.4, label="theory")
    for fidelity in ("cone", "specular"):
        own = [row for row in found["gaps"] if row["fidelity"] == fidelity]
        color, mark = look(fidelity)
        x, y = [row["gap"] for row in own], [row["measured"] for row in own]
        ax.plot(x, y, mark, color=color, markersize=4, label=fidelity)
    ax.axvline(0.25, color="#777777", linestyle=":", linewidth=1)
    ax.text(0.27, -25.5, "quarter wavelength", fontsize=9, color="#555555")
    ax.set(xlim=(0, 2), ylim=(-27, 8))
    name(ax, "Two equal poles: sum over the nearer alone", "gap, wavelengths", "dB")
    ax.legend(fontsize=9, loc="lower right", framealpha=1.0)


def _temperatures(ax: Axes, found: dict[str, Any]) -> None:
    celsius = np.linspace(*CELSIUS, 100)
    for humidity, color in ((0.0, "#d55e00"), (0.5, "#0072b2"), (1.0, "#009e73")):
        rows = [row for row in found["temperatures"] if row["humidity"] == humidity]
        curve = [100 * theory.firmware_error(value, humidity) for value in celsius]
        ax.plot(celsius, curve, color=color, linewidth=1.4)
        words = f"device, humidity {100 * humidity:g} %"
        device = [100 * row["device_error"] for row in rows]
        ax.plot([row["celsius"] for row in rows], device, "o", color=color, markersize=4, label=words)
    rows = [row for row in found["temperatures"] if row["humidity"] == 0.5]
    x, y = [row["celsius"] for row in rows], [100 * row["error"] for row in rows]
    ax.plot(x, y, "k.", markersize=4, label="distance in this air")
    ax.set(xlim=CELSIUS)
    name(ax, "58 µs/cm: marks measured, lines gas theory", "temperature, C", "error of the distance, %")
    ax.legend(fontsize=9, framealpha=1.0)


def _errors(ax: Axes, found: dict[str, Any]) -> None:
    tilts = np.linspace(0, 85, 200)
    known = {"ray": theory.ray_error, "cone": lambda tilt: theory.cone_error(tilt, FIELD_OF_VIEW)}
    for fidelity in GRAZED:
        rows = [row for row in found["grazing"] if row["fidelity"] == fidelity]
        color, mark = look(fidelity)
        if fidelity in known:
            curve = [100 * known[fidelity](math.radians(tilt)) for tilt in tilts]
            ax.plot(tilts, curve, color=color, linewidth=1.4)
        x, y = [row["tilt"] for row in rows], [100 * row["error"] for row in rows]
        ax.plot(x, y, mark, color=color, markersize=4, label=fidelity)
    ax.set(xlim=(0, 88), ylim=(0.0, 1e3))
    ax.set_yscale("symlog", linthresh=0.1)
    name(ax, f"Plane at {GRAZED_FROM:g} m, grazed: too far by", "tilt, degrees", "error of the distance, %")
    ax.legend(fontsize=9, loc="lower right", framealpha=1.0)


def _levels(ax: Axes, found: dict[str, Any]) -> None:
    tilts = np.linspace(0, 88, 300)
    curve = [theory.level("plane", GRAZED_FROM, math.radians(tilt), 0.0, theory.air()) for tilt in tilts]
    ax.plot(tilts, curve, color="black", linewidth=1.4, label="theory")
    for fidelity in GRAZED:
        rows = [row for row in found["grazing"] if row["fidelity"] == fidelity]
        color, mark = look(fidelity)
        ax.plot([r["tilt"] for r in rows], [r["level"] for r in rows], mark, color=color, markersize=4, label=fidelity)
    ax.axhline(THRESHOLD, color="#777777", linestyle=":", linewidth=1)
    ax.text(1, THRESHOLD + 1, "threshold", fontsize=9, color="#555555")
    ax.set(xlim=(0, 88), ylim=(-80, 10))
    name(ax, f"Plane at {GRAZED_FROM:g} m, grazed: level", "tilt, degrees", "dB")
    ax.legend(fontsize=9, loc="upper right", framealpha=1.0)
