"""The map drawn: what each method bears, what theory says, and where they fail."""

import math
from os import PathLike
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..pictures import save
from . import theory
from .measuring import LEAST, LEAST_QUICK, LEAST_SPRING
from .tumbling import INERTIA, LARGEST

COLORS = ("#c0392b", "#e08a1f", "#8a6d3b", "#7a9a2e", "#3d8b57", "#1f8a9e", "#1f5f99", "#8a4fa3", "#444444", "#c2478f")
MARKS = "ov<^sDP*x>"
GOLD, BLUE, PALE, RED, GREEN = "#d9a441", "#1f5f99", "#8fb8d9", "#c0392b", "#3d8b57"
AXES = ("least", "middle", "greatest")
TUMBLES = (
    ("energy", "energy within 1 % over 20 000 steps", GOLD, 0.28),
    ("attitude", "attitude within 0.1 rad after 100 s", BLUE, 0.0),
    ("rod_attitude", "the same, inertia of a rod, 1 : 1e6 : 1e6", PALE, -0.28),
)
RIGHT = 1.7 * LARGEST

Style = dict[str, tuple[str, str]]


def draw(found: dict[str, Any], *paths: str | PathLike) -> None:
    """Writes the map of what `measure` found; the ending of each path chooses the format."""
    figure = Figure(figsize=(15, 17), dpi=90, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(3, 12, height_ratios=(1.6, 1, 1))
    names = [row["solver"] for row in found["tumbling"]]
    styles = {name: (COLORS[i % len(COLORS)], MARKS[i % len(MARKS)]) for i, name in enumerate(names)}
    _tumbling(figure.add_subplot(grid[0, :]), found)
    for axis in range(3):
        _spins(figure.add_subplot(grid[1, 4 * axis : 4 * axis + 4]), found, axis, styles)
    _springs(figure.add_subplot(grid[2, 0:3]), found)
    _held(figure.add_subplot(grid[2, 3:6]), found, styles)
    _norms(figure.add_subplot(grid[2, 6:9]), found)
    _moments(figure.add_subplot(grid[2, 9:12]), found)
    figure.suptitle("Where methods fail: RigidBody and HingedBody, measured through the FMUs", fontsize=16)
    save(figure, paths)


def _words(name: str) -> str:
    return name.replace("_", " ")


def name(ax: Axes, title: str, x: str, y: str = "", pad: float = 6.0) -> None:
    """What is written on a panel, and how its axes look."""
    ax.set_title(title, fontsize=12, loc="left", pad=pad)
    ax.set(xlabel=x, ylabel=y)
    ax.grid(alpha=0.25, linewidth=0.6)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)


def _bar(ax: Axes, place: float, limit: float, most: float, text: str, end: float, ink: str = "white") -> None:
    """What is written at the end of a bar: in it, in `ink`, where there is no limit, and behind it otherwise."""
    if math.isinf(limit):
        ax.text(most, place, f"{text}  ", va="center", ha="right", fontsize=9, color=ink)
    else:
        ax.text(end, place, text, va="center", ha="left", fontsize=9)


def _limit(limit: float, least: float) -> str:
    if math.isinf(limit):
        return "no limit"
    return f"{limit:.2g}" if limit else f"less than {least:g}"


def _tumbling(ax: Axes, found: dict[str, Any]) -> None:
    """One group of bars a solver: how large a step may be."""
    rows = found["tumbling"][::-1]
    for key, label, color, shift in TUMBLES:
        least = LEAST if key == "energy" or not found["about"]["quick"] else LEAST_QUICK
        limits = np.array([row[key] for row in rows])
        ends = np.clip(limits, 1.08 * LEAST, RIGHT)
        ax.barh(np.arange(len(rows)) + shift, ends - LEAST, 0.26, LEAST, color=color, label=label)
        for place, (row, limit, end) in enumerate(zip(rows, limits, ends, strict=True)):
            text = _limit(limit, least)
            if math.isinf(limit) and key != "energy":
                text += f", {row[key.replace('attitude', 'error')]:.0e} rad off"
            _bar(ax, place + shift, limit, RIGHT, text, 1.15 * end, "white" if color == BLUE else "black")
    spun = [(row["fast_" + key], place + shift) for key, *_, shift in TUMBLES[:2] for place, row in enumerate(rows)]
    spun = [(limit, place) for limit, place in spun if 0.0 < limit < math.inf]
    ax.plot(*np.transpose(spun), "|", color="black", markersize=12, label="body spins at 10 000 rad/s")
    euler = [place + 0.28 for place, row in enumerate(rows) if row["solver"] in ("explicit_euler", "notes")]
    limits = [found["euler_energy_limit"]] * len(euler)
    ax.plot(limits, euler, "d", color=RED, markersize=5, label="theory: energy that Euler's turn gains")
    ax.set(xscale="log", xlim=(LEAST, RIGHT), ylim=(-0.6, len(rows) - 0.4))
    labels = [_words(row["solver"]) + ("\nchooses its steps" if row["chooses_steps"] else "") for row in rows]
    ax.set_yticks(range(len(rows)), labels, fontsize=10)
    title = f"Largest internal step of a free tumbling body, I = {INERTIA} kg m2, and of a rod"
    name(ax, title, "step times angular velocity, h |w| [rad]", pad=42.0)
    ax.legend(loc="lower left", bbox_to_anchor=(-0.01, 0.99), ncols=3, frameon=False, fontsize=9)


def _spins(ax: Axes, found: dict[str, Any], axis: int, styles: Style) -> None:
    angles = np.geomspace(0.01, 3.0, 300)
    ax.axhline(theory.growth_rate(INERTIA, axis, 1.0).real, color="black", linewidth=1.2, label="the true motion")
    for solver, factors in theory.SPIN_FACTORS.items():
        curve = [math.log(np.abs(factors(INERTIA, axis, angle)).max()) / angle for angle in angles]
        ax.plot(angles, curve, "--", color=styles.get(solver, ("gray", ""))[0], linewidth=1)
    for solver, (color, mark) in styles.items():
        rows = [row for row in found["spins"] if row["solver"] == solver and row["axis"] == axis]
        x, y = [row["angle"] for row in rows], [row["growth"] for row in rows]
        ax.plot(x, y, mark, color=color, markersize=5, markerfacecolor="none", label=_words(solver))
    ax.set(xscale="log", ylim=(-0.35, 1.3))
    y = "growth rate / |w|;  dashed: theory of the method" if axis == 0 else ""
    name(ax, f"Small error, spin about the {AXES[axis]} moment", "h |w| [rad]", y)
    if axis == 0:
        ax.legend(fontsize=9, frameon=False, ncols=2, loc="upper left")


def _springs(ax: Axes, found: dict[str, Any]) -> None:
    rows, most = found["springs"][::-1], 4.0
    colors = [GREEN if row["unit"] == "HingedBody" else BLUE for row in rows]
    ax.barh(range(len(rows)), [min(row["limit"], most) for row in rows], 0.65, color=colors)
    for place, row in enumerate(rows):
        expected = row["theory"]
        if expected is not None and math.isfinite(expected):
            ax.plot([expected] * 2, [place - 0.42, place + 0.42], color=RED, linewidth=2)
        _bar(ax, place, row["limit"], most, _limit(row["limit"], LEAST_SPRING), min(row["limit"], most) + 0.08)
    ax.set_yticks(range(len(rows)), [_words(row["solver"]) for row in rows], fontsize=9)
    ax.set(xlim=(0, most))
    name(ax, "Largest step, spring inside it", "h sqrt(k/m);  red: theory")
    note = "blue: RigidBody\ngreen: HingedBody"
    ax.text(0.99, 0.995, note, transform=ax.transAxes, ha="right", va="top", fontsize=8)


def _held(ax: Axes, found: dict[str, Any], styles: Style) -> None:
    z = np.linspace(0.0, 3.0, 200)
    curves = (
        ("explicit_euler", False, "explicit Euler", COLORS[0], "-"),
        ("notes", False, "notes", COLORS[1], "-"),
        ("", False, "all others", "black", "-"),
        ("", True, "all others, slope given", "black", ":"),
    )
    for solver, sloped, label, color, line in curves:
        ax.plot(
            z, [theory.held_force_factor(solver, x, sloped) for x in z], line, color=color, linewidth=1, label=label
        )
    for solver, (color, mark) in styles.items():
        rows = [row for row in found["held"] if row["solver"] == solver]
        x, y = [row["z"] for row in rows], [row["factor"] for row in rows]
        ax.plot(x, y, mark, color=color, markersize=4, markerfacecolor="none")
    ax.set(ylim=(0.95, 2.5), xlim=(0, 3))
    name(ax, "Spring force held over the step", "h sqrt(k/m);  lines: theory", "growth factor a step")
    ax.legend(fontsize=8, loc="upper left", framealpha=0.9)


def _norms(ax: Axes, found: dict[str, Any]) -> None:
    angles = np.geomspace(0.01, 2.0, 100)
    factors = {"euler": (theory.euler_norm_factor, COLORS[0]), "rk4": (theory.rk4_norm_factor, COLORS[4])}
    for method, (factor, color) in factors.items():
        ax.plot(angles, [abs(factor(angle) - 1) for angle in angles], "-", color=color, linewidth=1)
        rows = [row for row in found["norms"] if row["method"] == method]
        x, y = [row["angle"] for row in rows], [abs(row["factor"] - 1) for row in rows]
        ax.plot(x, y, "o", color=color, markersize=4, label=f"{method}, step by step")
    ax.set(xscale="log", yscale="log", ylim=(1e-15, 1))
    name(ax, "Norm of q, never made a unit", "h |w| [rad];  lines: theory", "|growth factor a step - 1|")
    ax.legend(fontsize=8, frameon=False)


def _moments(ax: Axes, found: dict[str, Any]) -> None:
    kinds = ((True, GREEN, ".", "accepted"), (False, RED, "x", "refused"))
    for accepted, color, mark, label in kinds:
        points = [row["moments"][:2] for row in found["moments"] if row["accepted"] is accepted]
        ax.plot(*np.reshape(points, (-1, 2)).T, mark, color=color, markersize=4, markeredgewidth=0.7, label=label)
    edge = np.linspace(0, 2.1, 2)
    ax.plot(edge, 1 + edge, "k-", edge, edge - 1, "k-", edge, 1 - edge, "k-", linewidth=1)
    ax.set(xlim=(0, 2.1), ylim=(0, 2.1), aspect="equal")
    name(ax, "Inertia that RigidBody takes", "I1 / I3;  lines: triangle inequality", "I2 / I3")
    ax.legend(fontsize=8, loc="upper left", framealpha=0.9)
