"""The picture of the couplings: error against work, what to take for each accuracy, and chains by their length."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import sqrt
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..pictures import save
from .chains import STEP, ChainCost
from .coupled import CoupledPoint
from .draw import HALO
from .fronts import front, solvers_of
from .ways import ONE_WAY, RIGID, STEPPINGS, STIFFNESSES, TWO_WAY, WITH_JOINTS, compliant_name

# After Okabe & Ito, which stay apart for the colour-blind; the stiffer a joint, the darker.
COMPLIANT = [compliant_name(stiffness) for stiffness in STIFFNESSES]
COLORS = {
    ONE_WAY: "#8a8a8a",
    TWO_WAY: "#0072b2",
    **dict(zip(COMPLIANT, ("#e6ab3c", "#d5770f", "#9a3f00"), strict=True)),
    RIGID: "#009e73",
}
MARKS = dict(
    zip(
        [stepping.name for stepping in (*STEPPINGS, *WITH_JOINTS)],
        ("v", "s", "^", "D", "o", "*", "P", "X", "h"),
        strict=True,
    )
)
LARGE = {"*": 1.6, "P": 1.2, "X": 1.2}
COARSEST, FINEST = 4.0, 2e-10
"""rad: the half turn is the largest error there is."""
ACCURATE = 1.0
"""rad: from there on something is recommended."""
WANTED = (0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8)
"""rad."""
NOTES = """Upper arm (1.9 kg) and forearm (1.56 kg) on hinges without friction, let go with the elbow bent. Error: \
the largest angle of a body to the reference (minimal coordinates, DOP853 at 3e-14), every half second of \
{end:g}\u00a0s. Time: of Scene.run in Python, processor time, median of {rounds} interleaved runs, without setting up. \
{failures} runs fail before the end and are left out: coupling.json says why. {machine}."""


@dataclass(frozen=True)
class Drawn:
    """All that the picture shows."""

    points: Sequence[CoupledPoint]
    costs: Sequence[ChainCost]
    end: float
    """s that the arm swings."""
    rounds: int
    failures: int
    machine: str


def draw_coupling(drawn: Drawn, paths: Sequence[Path]) -> None:
    """Writes one picture in each of the formats that the paths name."""
    figure = Figure(figsize=(15.0, 9.4), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    _work(figure.add_axes((0.05, 0.13, 0.54, 0.74)), drawn.points)
    _key(figure.add_axes((0.635, 0.665, 0.355, 0.175)))
    _choice(figure.add_axes((0.635, 0.385, 0.355, 0.225)), drawn.points)
    _chains(figure.add_axes((0.68, 0.13, 0.30, 0.185)), drawn.costs)
    figure.text(0.05, 0.955, "One arm, every coupling: work against precision", fontsize=18, weight="bold")
    caption = (
        "Lower is cheaper, further right is more accurate. Grey: the Pareto front. The band along the axis has the "
        "colour of the way to take for that accuracy."
    )
    figure.text(0.05, 0.925, caption, fontsize=11.5, color="#333333")
    notes = NOTES.format(end=drawn.end, rounds=drawn.rounds, failures=drawn.failures, machine=drawn.machine)
    figure.text(0.05, 0.068, fill(notes, 212), va="top", fontsize=8.8, color="#333333", linespacing=1.4)
    save(figure, paths)


def recommended(points: Iterable[CoupledPoint]) -> list[CoupledPoint]:
    """The Pareto front of the runs within ACCURATE that did not say themselves that they are wrong, coarse first."""
    return front(point for point in points if not point.wrong and point.error <= ACCURATE)


def best(points: Iterable[CoupledPoint], error: float) -> CoupledPoint | None:
    """The cheapest run whose error (rad) is not larger; None if there is none."""
    return next((point for point in recommended(points) if point.error <= error), None)


def _work(ax: Axes, points: Sequence[CoupledPoint]) -> None:
    values = [1e3 * point.seconds for point in points]
    finest = max(FINEST, 0.3 * min(point.error for point in points))
    ax.set(xscale="log", yscale="log", xlim=(COARSEST, finest), ylim=(0.42 * min(values), 2.5 * max(values)))
    ax.set_xlabel("largest error of an angle [rad]        more accurate →", fontsize=11)
    ax.set_ylabel("ms of processor time per simulated second", fontsize=11)
    ax.grid(alpha=0.22, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
    taken = recommended(points)
    errors = [ACCURATE, *(point.error for point in taken)]
    stairs = [(e, 1e3 * p.seconds) for p, *ends in zip(taken, errors, errors[1:], strict=False) for e in ends]
    ax.plot(*zip(*stairs, strict=True), color="#d3d7dc", linewidth=9, solid_joinstyle="round", zorder=1)
    for name in solvers_of(points):
        _curve(ax, [point for point in points if point.solver == name])
    _names(ax, points)
    _stiffnesses(ax, points)
    _band(ax, taken, errors)


def _curve(ax: Axes, own: Sequence[CoupledPoint]) -> None:
    """All points of a way and a master, in the order of their steps; hollow where the run said that it is wrong."""
    color, mark = COLORS[own[0].way], MARKS[own[0].master]
    x, y = [point.error for point in own], [1e3 * point.seconds for point in own]
    ax.plot(x, y, color=color, linewidth=1.2, linestyle=_style(own[0].master), alpha=0.6, zorder=2)
    for wrong, face, edge, width in ((False, color, "white", 0.6), (True, "white", color, 1.3)):
        there = [k for k, point in enumerate(own) if point.wrong == wrong]
        look = {"marker": mark, "markersize": 6.0 * LARGE.get(mark, 1.0), "linestyle": "none"}
        look |= {"markerfacecolor": face, "markeredgecolor": edge, "markeredgewidth": width}
        ax.plot(np.take(x, there), np.take(y, there), **look, zorder=3)


# Where names stand: points from the cheapest (-1) or dearest (1) point of a way, and which side of them is there.
PLACES = {
    ONE_WAY: (-1, (10.0, -4.0), "left"),
    TWO_WAY: (1, (10.0, 2.0), "left"),
    RIGID: (1, (-4.0, 12.0), "right"),
}


def _names(ax: Axes, points: Sequence[CoupledPoint]) -> None:
    """The names of the ways at their curves."""
    for way, (end, offset, side) in PLACES.items():
        seen = [point for point in points if point.way == way and point.error > FINEST]
        if seen:
            point = max(seen, key=lambda p: end * p.seconds)
            place = {"textcoords": "offset points", "ha": side, "va": "bottom" if end > 0 else "top"}
            ax.annotate(way, (point.error, 1e3 * point.seconds), offset, **place, **_look(way))


def _stiffnesses(ax: Axes, points: Sequence[CoupledPoint]) -> None:
    """Names above the columns, all at one height, as the columns are close."""
    columns = {way: [point for point in points if point.way == way] for way in COMPLIANT}
    columns = {way: own for way, own in columns.items() if own}
    top = 1.4e3 * max((point.seconds for own in columns.values() for point in own), default=1.0)
    for number, (way, own) in enumerate(columns.items()):
        error = min(point.error for point in own)
        unit, _, stiffness = way.partition(", ")
        ax.text(error, top, stiffness, ha="center", **_look(way))
        if number == len(columns) // 2:
            ax.text(error, 1.5 * top, unit, ha="center", **_look(way))


def _look(way: str) -> dict[str, Any]:
    """Of a name."""
    return {"fontsize": 11, "weight": "bold", "color": COLORS[way], "path_effects": HALO, "zorder": 5}


def _band(ax: Axes, taken: Sequence[CoupledPoint], errors: Sequence[float]) -> None:
    """The way to take, from each error to the next."""
    ranges = zip(taken, errors, errors[1:], strict=False)
    for way, group in groupby(ranges, key=lambda item: item[0].way):
        (_, high, low), *more = group
        low = more[-1][2] if more else low
        ax.axvspan(high, low, 0.0, 0.04, facecolor=COLORS[way], edgecolor="white", linewidth=0.8, zorder=5)
        if high / low > 30.0:
            place = {"transform": ax.get_xaxis_transform(), "ha": "center", "va": "center"}
            middle = sqrt(high * max(low, FINEST))
            ax.text(middle, 0.019, way, **place, fontsize=10, weight="bold", color="white", zorder=6)


def _key(ax: Axes) -> None:
    """The masters with their marks."""
    ax.axis("off")
    ax.set(xlim=(0, 1), ylim=(0, 1))
    ax.set_title("Masters", loc="left", fontsize=13, weight="bold")
    hollow = {"marker": "o", "markerfacecolor": "white", "linestyle": "none"}
    entries = [(name, 0.025, {"marker": mark, "linestyle": _style(name)}) for name, mark in MARKS.items()]
    for number, (name, reach, look) in enumerate([*entries, ("the run says that it is wrong", 0.0, hollow)]):
        x, y = 0.5 * (number // 5), 0.90 - 0.2 * (number % 5)
        look |= {"color": "#444444", "markersize": 7.0 * LARGE.get(look["marker"], 1.0), "linewidth": 1.2}
        ax.add_line(Line2D([x + 0.04 - reach, x + 0.04 + reach], [y, y], **look))
        ax.text(x + 0.09, y, name, va="center", fontsize=10, color="#333333")


def _style(master: str) -> str | tuple:
    """Of the line through its points."""
    return (0, (3, 2)) if master.endswith("tolerance") else "-"


# Of what is wanted, taken and paid: place, heading, and the side from which it is written.
COLUMNS = (
    (0.0, "error below", "left"),
    (0.19, "way", "left"),
    (0.55, "master", "left"),
    (0.885, "step", "right"),
    (1.0, "ms/s", "right"),
)


def _choice(ax: Axes, points: Sequence[CoupledPoint]) -> None:
    """The cheapest run for each accuracy that may be wanted."""
    ax.axis("off")
    ax.set(xlim=(0, 1), ylim=(0, 1))
    ax.set_title("What to take", loc="left", fontsize=13, weight="bold")
    rows = [(("#777777", "normal"), [heading for _, heading, _ in COLUMNS])]
    for error in WANTED:
        found = best(points, error)
        if found:
            step = f"{1e3 * found.step:.3g} ms" if found.tolerance is None else f"tol. {found.tolerance:g}"
            master = found.master.replace("extrapolated", "extr.").removesuffix(", by tolerance")
            cells = [f"{error:.0e} rad".replace("e-0", "e-"), found.way, master, step, f"{1e3 * found.seconds:.3g}"]
            rows.append(((COLORS[found.way], "bold"), cells))
    for number, ((color, weight), cells) in enumerate(rows):
        for (x, heading, side), cell in zip(COLUMNS, cells, strict=True):
            look = {"color": color, "weight": weight} if heading in ("way", "master") else {"color": "#333333"}
            ax.text(x, 0.92 - 0.125 * number, cell, ha=side, va="center", fontsize=9.5, **look)


def _chains(ax: Axes, costs: Sequence[ChainCost]) -> None:
    lengths, micro = [cost.length for cost in costs], [1e6 * cost.seconds for cost in costs]
    proportion = lengths[-1] * micro[0] / lengths[0]
    title = {"loc": "left", "fontsize": 13, "weight": "bold", "x": -0.15}
    ax.set_title("Rigid joints: a macro step by the length of the chain", **title)
    ax.plot([0, lengths[-1]], [0, proportion], color="#999999", linewidth=1.2, linestyle="--")
    ax.text(0.66 * lengths[-1], 0.75 * proportion, "in proportion", ha="right", color="#777777", fontsize=9.5)
    ax.plot(lengths, micro, color=COLORS[RIGID], marker=MARKS["rigid"], markersize=7, linewidth=1.6)
    ax.set(xlim=(0, lengths[-1] + 0.4), ylim=(0, 1.15 * max(*micro, proportion)))
    ax.set_xlabel(f"bodies in a row, steps of {1e3 * STEP:g} ms", fontsize=10)
    ax.set_ylabel("µs", fontsize=10)
    text = f"{lengths[-1]} bodies: {micro[-1] / micro[0]:.2g} times one"
    place = {"transform": ax.transAxes, "va": "top"}
    ax.text(0.02, 0.98, text, **place, fontsize=10, weight="bold", color=COLORS[RIGID])
    ax.grid(alpha=0.22, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
