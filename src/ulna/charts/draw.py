"""The picture: error against work, one panel a problem, below each the solver to take for each accuracy."""

from collections.abc import Sequence
from itertools import groupby
from math import sqrt
from pathlib import Path
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, NullFormatter

from ..pictures import save
from .fronts import cheapest, cost, front, solvers_of
from .measure import COMMUNICATION, Point
from .problems import Problem
from .reference import Array
from .style import Look, look

COARSEST, FINEST = 1.0, 1e-15  # rad
CELL = 0.5
"""Decades of error that the strip answers for at a time."""
WORK = {
    "seconds": ("µs of processor time per simulated second", 1e6),
    "evaluations": ("right-hand sides per simulated second", 1.0),
}
TITLES = {
    "seconds": ("Rigid bodies: work against precision", "names the solver to take for that accuracy."),
    "evaluations": ("Rigid bodies: right-hand sides against precision", "names the solver that needs fewest of them."),
}
HALO = [withStroke(linewidth=2.5, foreground="white")]
# Where a label may stand, points from the end of its curve: beside it first, then above and below, then further away.
PLACES = [
    (7.0, 0.0),
    *((x, y) for y in (11.0, -11.0, 20.0, -20.0, 30.0, -30.0, 42.0) for x in (3.0, -25.0, -55.0, -90.0)),
]
CHARACTER, LINE = 5.6, 11.0
"""Room for a letter and for a line, points."""


def draw(problems: Sequence[Problem], points: Sequence[Point], work: str, notes: str, paths: Sequence[Path]) -> None:
    """Writes one picture in each of the formats that the paths name; `work` is seconds or evaluations."""
    figure = Figure(figsize=(15.0, 10.4), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2, 3, left=0.05, right=0.99, top=0.86, bottom=0.06, wspace=0.13, hspace=0.34)
    known = [point for point in points if getattr(point, work)]
    for number, problem in enumerate(problems):
        ax = figure.add_subplot(grid[number // 3, number % 3])
        _panel(ax, problem, [point for point in known if point.problem == problem.name], work)
        if number % 3 == 0:
            ax.set_ylabel(WORK[work][0], fontsize=10)
        ax.set_xlabel("error at the end [rad]        more accurate →", fontsize=10)
    _key(figure.add_subplot(grid[1, 2]), solvers_of(known), notes)
    title, band = TITLES[work]
    figure.text(0.05, 0.957, title, fontsize=18, weight="bold")
    caption = (
        f"Lower is cheaper, further right is more accurate. Grey: the Pareto front. The band along each axis {band}"
    )
    figure.text(0.05, 0.929, caption, fontsize=11.5, color="#333333")
    save(figure, paths)


def _panel(ax: Axes, problem: Problem, known: list[Point], work: str) -> None:
    factor = WORK[work][1]
    points = [point for point in known if point.error <= COARSEST]
    values = [factor * getattr(point, work) for point in points]
    # the band needs its room below the cheapest point
    span = np.log10(max(values) / min(values)) + 0.6
    ax.set(xscale="log", yscale="log", xlim=(2.0 * COARSEST, 0.5 * FINEST))
    ax.set_ylim(min(values) * 10 ** (-0.13 * span), max(values) * 10 ** (0.17 * span))
    ax.set_title(problem.title, loc="left", fontsize=13, weight="bold", pad=20)
    ax.text(0.0, 1.02, problem.about, transform=ax.transAxes, fontsize=9.5, color="#555555")
    ax.grid(alpha=0.22, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(labelsize=9)
    ax.xaxis.set_major_locator(LogLocator(base=100, numticks=9))
    ax.xaxis.set_minor_formatter(NullFormatter())
    never = [name for name in solvers_of(known) if name not in solvers_of(points)]
    if never:
        text = "never within 1 rad: " + ", ".join(look(name).label for name in never)
        ax.text(1.0, 0.985, text, transform=ax.transAxes, ha="right", va="top", fontsize=9, color="#666666")
    by_solver = {name: [p for p in points if p.solver == name] for name in solvers_of(points)}
    errors = np.logspace(np.log10(COARSEST), np.log10(FINEST), 151)
    least = [min(cost(own, error, work) for own in by_solver.values()) for error in errors]
    ax.plot(errors, np.multiply(least, factor), color="#d3d7dc", linewidth=10, solid_capstyle="round", zorder=1)
    curves = [(look(name), *_curve(own, work)) for name, own in by_solver.items()]
    for style, x, y in curves:
        _line(ax, x, y, style, zorder=2 if style.peer else 3)
    for name in ("automatic", "exact"):
        _calls(ax, by_solver.get(name, []), work)
    _labels(ax, curves)
    _strip(ax, points, work)


def _curve(own: list[Point], work: str) -> tuple[Array, Array]:
    """What is drawn of a solver: its front; of one that only its communication step costs, all points."""
    only_calls = all(point.parameter == COMMUNICATION for point in own)
    best = sorted(own, key=lambda p: -getattr(p, work)) if only_calls else front(own, work)
    x = np.array([max(point.error, FINEST) for point in best])
    return x, WORK[work][1] * np.array([getattr(point, work) for point in best])


def _line(ax: Axes, x: Sequence[float], y: Sequence[float], style: Look, zorder: int = 3) -> None:
    ax.plot(
        x,
        y,
        clip_on=False,
        color=style.color,
        marker=style.mark,
        markersize=4.5 if style.peer else 6.0,
        markerfacecolor="white" if style.peer else style.color,
        linewidth=1.2 if style.peer else 2.0,
        linestyle=(0, (4, 2)) if style.peer else "-",
        zorder=zorder,
    )


def _calls(ax: Axes, own: list[Point], work: str) -> None:
    """Says at the dearest point of a solver that only its calls cost how often it is called there."""
    own = [point for point in own if point.parameter == COMMUNICATION]
    if own:
        dearest = max(own, key=lambda p: getattr(p, work))
        at = (max(dearest.error, FINEST), WORK[work][1] * getattr(dearest, work))
        text = f"called every {1e3 * dearest.value:g} ms"
        ax.annotate(
            text,
            at,
            (8, 11),
            textcoords="offset points",
            ha="right",
            va="center",
            fontsize=8.5,
            color="#444444",
            zorder=4,
            path_effects=HALO,
        )


def _labels(ax: Axes, curves: list[tuple[Look, Array, Array]]) -> None:
    """Names at the accurate ends of the curves, each where it covers least of other names and of the curves."""
    scale = 72.0 / ax.figure.dpi
    left, low, right, high = scale * np.array(ax.bbox.extents)
    paths = [scale * ax.transData.transform(np.column_stack([x, y])) for _, x, y in curves]
    drawn = np.concatenate([_densely(path) for path in paths])
    taken = [(left, low, right, low + 0.075 * (high - low))]
    for (_, _, y), path in zip(curves, paths, strict=True):
        # above a curve that ends lower than it starts, the note of `_calls`
        if y[0] > y[-1]:
            taken.append((path[0][0] - 80.0, path[0][1] + 4.0, path[0][0] + 10.0, path[0][1] + 18.0))
    for (style, x, y), path in sorted(zip(curves, paths, strict=True), key=lambda item: item[0][0].peer):
        width = CHARACTER * len(style.label) * (0.9 if style.peer else 1.05)

        def covered(place: tuple[float, float], end: Array = path[-1], width: float = width) -> float:
            a, b = end + place - (0.0, LINE / 2.0)
            c, d = a + width, b + LINE
            inside = (drawn > (a, b)) & (drawn < (c, d))
            names = sum(a < other[2] and other[0] < c and b < other[3] and other[1] < d for other in taken)
            outside = a < left or c > right + 8.0 or d > high
            return 100.0 * names + 200.0 * outside + float(inside.all(axis=1).sum()) + 0.02 * float(np.hypot(*place))

        place = min(PLACES, key=covered)
        start = path[-1] + place - (0.0, LINE / 2.0)
        taken.append((*start, start[0] + width, start[1] + LINE))
        ax.annotate(
            style.label,
            (x[-1], y[-1]),
            place,
            textcoords="offset points",
            fontsize=8.5 if style.peer else 9.5,
            weight="normal" if style.peer else "bold",
            color=style.color,
            va="center",
            zorder=4,
            path_effects=HALO,
        )


def _densely(path: Array) -> Array:
    """Points along a polygon, [n, 2], some 4 apart."""
    if len(path) == 1:
        return path
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    at = np.arange(0.0, lengths[-1], 4.0)
    return np.column_stack([np.interp(at, lengths, path[:, 0]), np.interp(at, lengths, path[:, 1])])


def _strip(ax: Axes, points: list[Point], work: str) -> None:
    """The band along the axis: which solver is the cheapest for each accuracy."""
    cells = np.arange(np.log10(COARSEST), np.log10(FINEST) + 1e-9, -CELL)
    chosen = [(cheapest(points, 10.0 ** (cell - CELL), work), cell) for cell in cells[:-1]]
    decade = 72.0 / ax.figure.dpi * ax.bbox.width / abs(np.diff(np.log10(ax.get_xlim()))[0])
    for name, group in groupby(chosen, key=lambda cell: cell[0]):
        tops = [top for _, top in group]
        if name is None:
            continue
        high, low = 10.0 ** tops[0], 10.0 ** (tops[-1] - CELL)
        ax.axvspan(high, low, 0.0, 0.068, facecolor=look(name).color, edgecolor="white", linewidth=0.8, zorder=5)
        size = min(9.5, 1.5 * len(tops) * CELL * decade / len(look(name).label))
        if size >= 6.0:
            ax.text(
                sqrt(high * low),
                0.032,
                look(name).label,
                transform=ax.get_xaxis_transform(),
                ha="center",
                va="center",
                fontsize=size,
                weight="bold",
                color="white",
                zorder=6,
            )


def _key(ax: Axes, names: list[str], notes: str) -> None:
    """All solvers with their marks, those of the units first, and what has to be said beside the chart."""
    ax.axis("off")
    ax.set(xlim=(0, 1), ylim=(0, 1))
    columns = [[name for name in names if look(name).peer == peer] for peer in (False, True)]
    for column, members in enumerate(columns):
        ax.text(0.5 * column, 1.09, ("Ulna", "peers")[column], fontsize=11, weight="bold", color="#333333")
        for row, name in enumerate(members):
            x, y, style = 0.5 * column, 1.03 - 0.057 * row, look(name)
            _line(ax, [x, x + 0.08], [y, y], style)
            weight = "normal" if style.peer else "bold"
            ax.text(x + 0.11, y, style.label, va="center", fontsize=10, color=style.color, weight=weight)
    text = "\n".join(fill(line, 68) for line in notes.splitlines())
    top = 1.03 - 0.057 * max(map(len, columns)) - 0.01
    ax.text(0.0, top, text, va="top", fontsize=8.8, color="#333333", linespacing=1.4)
