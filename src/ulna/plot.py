"""Pictures of a run: its curves in small multiples, and its scene at a few instants."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import ceil, cos, degrees, sin
from os import PathLike

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from .drawing import parts, series, skin_like, source_of, units_of
from .results import Results
from .scene import Scene, SceneUnit
from .skeleton import multiply, rotate
from .targets import true_distance

COLUMNS = 3
MOST_PANELS = 9
DOTS_PER_INCH = 100
COLORS = ("#1f5f99", "#e06c1f", "#3d8b57", "#8a4fa3", "#b3374a", "#5a5a5a")
MOST_ELEMENTS = 4
SKIN = (0.86, 0.60, 0.48)
# Turns the world before a viewer who looks along y: -15 degrees about z, then 10 about x.
VIEW = multiply(np.array([cos(0.087), sin(0.087), 0.0, 0.0]), np.array([cos(0.131), 0.0, 0.0, -sin(0.131)]))

# Title, unit on the axis, factor to it, and the variables of one unit that belong in one panel, with their labels.
GROUPS: tuple[tuple[str, str, float, dict[str, str]], ...] = (
    ("elbow", "degrees", degrees(1.0), {"target_angle": "target", "angle": "angle"}),
    ("energy", "J", 1.0, {"kinetic_energy": "kinetic", "potential_energy": "potential"}),
    ("elbow zone", "of rest", 1.0, {"blend_volume_ratio": "volume", "minimum_section_ratio": "least section"}),
    ("longest stretch of an edge", "mm", 1e3, {"elbow_gap": "gap"}),
    ("folded triangles", "%", 100.0, {"fold_fraction": "folded"}),
)
# What else is shown while there is room, in this order; then whatever was recorded.
VECTORS = ("position", "angular_velocity", "tip_position", "angular_momentum", "orientation", "velocity")
AXES = {3: "xyz", 4: "wxyz"}


@dataclass
class Panel:
    """Curves of one physical unit over time: (label, values), and dots (label, times, values)."""

    title: str
    unit: str
    curves: list[tuple[str, np.ndarray]] = field(default_factory=list)
    dots: list[tuple[str, np.ndarray, np.ndarray]] = field(default_factory=list)
    wide: bool = False
    """Whether it takes a whole row; its first curve, which the others are held to, is drawn broad and pale."""


def plot(results: Results, path: str | PathLike, scene: Scene | None = None) -> None:
    """Writes a PNG of at most nine panels. With the scene, sensors show the true distance beside the measured one."""
    chosen = panels(results, scene)
    whole, rest = ([panel for panel in chosen if panel.wide == wide] for wide in (True, False))
    columns = COLUMNS if whole else min(COLUMNS, max(1, len(rest)))
    rows = max(1, len(whole) + ceil(len(rest) / columns))
    figure = Figure(
        figsize=(4.2 * columns, 2.5 * rows + 0.3 + 0.8 * len(whole)), dpi=DOTS_PER_INCH, layout="constrained"
    )
    FigureCanvasAgg(figure)
    heights = [3.3] * len(whole) + [2.5] * (rows - len(whole))
    grid = figure.add_gridspec(rows, columns, height_ratios=heights)
    places = [grid[row, :] for row in range(len(whole))]
    places += [grid[len(whole) + number // columns, number % columns] for number in range(len(rest))]
    first = None
    for number, (panel, place) in enumerate(zip([*whole, *rest], places, strict=True)):
        ax = figure.add_subplot(place, sharex=first)
        first = first or ax
        _draw(ax, results.time, panel)
        lowest = number >= len(chosen) - columns
        ax.tick_params(labelbottom=lowest)
        ax.set_xlabel("time [s]" if lowest else "")
    figure.savefig(path, pil_kwargs={"optimize": True})


def panels(results: Results, scene: Scene | None) -> list[Panel]:
    """What is worth a panel; a column that does not change is not, unless it belongs with others that do."""
    chosen = list(_range_panels(results, scene)) if scene else []
    names = list(dict.fromkeys(name.split(".")[0] for name in results))
    chosen += [_group_panel(results, unit, group) for group in GROUPS for unit in names]
    grouped = {variable for *_, variables in GROUPS for variable in variables}
    rest = [name for name in results if name.split(".")[1] not in grouped and results[name].dtype.kind == "f"]
    if chosen and chosen[0]:
        sensors = {unit.name for unit in units_of(scene, "UltrasonicSensor")}
        rest = [name for name in rest if name.split(".")[0] not in sensors]
    rest.sort(key=lambda name: VECTORS.index(name.split(".")[1]) if name.split(".")[1] in VECTORS else len(VECTORS))
    chosen += [_plain_panel(results, name) for name in rest]
    return [panel for panel in chosen if panel][:MOST_PANELS]


def _range_panels(results: Results, scene: Scene) -> Iterator[Panel | None]:
    """Of each sensor; of those that ride on one frame, together."""
    groups: dict[str, list[SceneUnit]] = {}
    for sensor in units_of(scene, "UltrasonicSensor"):
        carrier = source_of(scene, sensor.position)
        groups.setdefault(carrier.name if carrier else sensor.name, []).append(sensor)
    for carrier, sensors in groups.items():
        try:
            if len(sensors) == 1:
                yield _range_panel(results, scene, sensors[0])
            else:
                yield _ranges_panel(results, scene, carrier, sensors)
        except KeyError:
            yield None


def _range_panel(results: Results, scene: Scene, sensor: SceneUnit) -> Panel:
    """The distance from the sensor to the nearest surface, and the pings; raises KeyError for what is not recorded."""
    distance, valid, sequence = (
        series(results, scene, f"{sensor.name}.{v}") for v in ("distance", "valid", "sequence")
    )
    rows = np.flatnonzero(np.diff(sequence)) + 1
    heard, silent = rows[valid[rows]], rows[~valid[rows]]
    panel = Panel(f"{sensor.name}: distance", "m")
    panel.curves.append(("true", true_distance(results, scene, sensor)))
    panel.dots.append(("heard", results.time[heard], distance[heard]))
    panel.dots.append(("no echo", results.time[silent], distance[silent]))
    return panel


def _ranges_panel(results: Results, scene: Scene, carrier: str, sensors: list[SceneUnit]) -> Panel:
    """What several sensors in one place say, beside the distance to the nearest surface."""
    said = [(sensor.name, series(results, scene, f"{sensor.name}.distance")) for sensor in sensors]
    return Panel(f"{carrier}: distance", "m", [("true", true_distance(results, scene, sensors[0])), *said], wide=True)


def _group_panel(results: Results, unit: str, group: tuple[str, str, float, dict[str, str]]) -> Panel | None:
    title, symbol, factor, variables = group
    curves = [(label, results[f"{unit}.{v}"] * factor) for v, label in variables.items() if f"{unit}.{v}" in results]
    if not any(np.ptp(values) > 0.0 for _, values in curves):
        return None
    if title == "energy" and len(curves) == 2:
        curves.append(("sum", curves[0][1] + curves[1][1]))
    return Panel(f"{unit}: {title}", symbol, curves)


def _plain_panel(results: Results, name: str) -> Panel | None:
    values = results[name].reshape(len(results), -1)
    if values.shape[1] > MOST_ELEMENTS or not np.any(np.ptp(values, axis=0) > 0.0):
        return None
    labels = AXES.get(values.shape[1], [""])
    unit, variable = name.split(".")
    return Panel(
        f"{unit}: {variable.replace('_', ' ')}", results.units[name], list(zip(labels, values.T, strict=False))
    )


def _draw(ax: Axes, time: np.ndarray, panel: Panel) -> None:
    looks = [{"linewidth": 1.4, "alpha": 1.0}] * len(panel.curves)
    if panel.wide:
        # what lies under a curve is seen on both sides of it
        widths = 1.2 + 0.8 * np.arange(len(panel.curves) - 2, -1, -1)
        looks = [{"linewidth": 9.0, "alpha": 0.25}, *({"linewidth": width, "alpha": 1.0} for width in widths)]
    for (label, values), color, look in zip(panel.curves, COLORS, looks, strict=False):
        ax.plot(time, values, color=color, label=label, **look)
    for (label, times, values), color, mark in zip(panel.dots, COLORS[1:], (".", "x"), strict=False):
        ax.plot(times, values, mark, color=color, markersize=4, label=label)
    ax.set_title(panel.title, fontsize=10, loc="left")
    ax.set_ylabel(f"[{panel.unit}]")
    ax.ticklabel_format(axis="y", useOffset=False)
    ax.grid(alpha=0.25, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
    ax.margins(x=0.0)
    if len(panel.curves) + len(panel.dots) > 1:
        ax.legend(
            fontsize=8,
            frameon=False,
            ncols=6 if panel.wide else 4,
            loc="lower right",
            bbox_to_anchor=(1.02, 0.96),
            handlelength=0.9,
            handletextpad=0.4,
            columnspacing=0.8,
        )


def filmstrip(results: Results, scene: Scene, path: str | PathLike, times: Sequence[float] | None = None) -> None:
    """Writes a PNG of the scene at some times (s; five by default), from the side, x to the right and z up.

    Rigid things, and the skin as ArmSkin computes it. Raises KeyError if the motion of something was not recorded.
    """
    if times is None:
        times = results.time[0] + np.ptp(results.time) * np.linspace(0.1, 0.9, 5)
    rows = [int(np.argmin(np.abs(results.time - time))) for time in times]
    views = [_view(*_triangles(results, scene, row)) for row in rows]
    corners = np.concatenate([faces.reshape(-1, 2) for faces, _ in views])
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.04 * (high - low).max()
    width, height = high - low + 2.0 * margin
    figure = Figure(figsize=(12.0, 0.4 + 12.0 / len(rows) * height / width), dpi=DOTS_PER_INCH, layout="constrained")
    FigureCanvasAgg(figure)
    for ax, row, (faces, colors) in zip(figure.subplots(1, len(rows), squeeze=False).flat, rows, views, strict=True):
        ax.add_collection(PolyCollection(faces, facecolors=colors, edgecolors=colors, linewidths=0.3))
        ax.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
        ax.set(xticks=[], yticks=[], facecolor="#f4f5f7")
        ax.spines[:].set_visible(False)
        ax.set_title(f"{results.time[row]:.1f} s", fontsize=10)
    figure.savefig(path, pil_kwargs={"optimize": True})


def _view(faces: np.ndarray, colors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Those triangles, (n, 3, 2), that face a viewer a little above and aside, the nearest last; and their colours."""
    turned = rotate(VIEW, faces)
    edges = turned[:, 1:] - turned[:, :1]
    seen = np.cross(edges[:, 0], edges[:, 1])[:, 1] < 0.0
    turned, colors = turned[seen], colors[seen]
    order = np.argsort(-turned[..., 1].mean(axis=1))
    return turned[order][..., [0, 2]], colors[order]


def _triangles(results: Results, scene: Scene, row: int) -> tuple[np.ndarray, np.ndarray]:
    """All triangles of the scene at a row, (n, 3, 3) in the world, m; and their colours, (n, 3), in a fixed light."""
    faces, colors = [], []
    for part in parts(results, scene):
        placed = rotate(part.orientation[row], part.shape.vertices.astype(float)) + part.position[row]
        faces.append(placed[part.shape.triangles])
        colors.append(part.shape.colors[part.shape.triangles[:, 0]])
    for unit in units_of(scene, "ArmSkin"):
        with skin_like(unit) as skin:
            for name in ("upper_arm_position", "upper_arm_orientation", "forearm_position", "forearm_orientation"):
                skin.set(name, series(results, scene, f"{unit.name}.{name}")[row])
            faces.append(skin.get("vertices").T[skin.get("triangles").reshape(-1, 3)[:-4]].astype(float))
        colors.append(np.tile(SKIN, (len(faces[-1]), 1)))
    corners, colors = np.concatenate(faces), np.concatenate(colors)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
    light = np.array([0.3, -0.75, 0.6])
    brightness = 0.45 + 0.55 * np.clip(normals @ light, 0.0, 1.0)
    return corners, np.clip(colors * brightness[:, None], 0.0, 1.0)
