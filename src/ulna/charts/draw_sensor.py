"""The picture of the sensor's fidelities: which to take, cost of a ping against its error, and how errors spread."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from textwrap import wrap
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ..pictures import save
from .draw_skin import BAD, FAIR, GOOD
from .sensor_measuring import SAME, Accuracy, Cost, percentile
from .sensor_peers import Rays
from .sensor_truths import SOURCES, TRUTHS

# After Okabe & Ito, which stay apart for the colour-blind.
LOOKS = {
    "ray": ("#8a8a8a", "v"),
    "cone": ("#d55e00", "s"),
    "specular": ("#0072b2", "o"),
    "surface": ("#009e73", "D"),
    "automatic": ("#000000", "P"),
    Rays.NAME: ("#cc79a7", "X"),
}
NEW = ("#666666", "h")
"""Of a fidelity that the table does not know."""
STYLES = {Rays.NAME: ":", "automatic": (0, (4, 4))}
"""Of curves that lie on another: the ray's, and those of `specular`."""
LEAST = 1e-3  # mm: errors below are drawn here
NOTES = """Range error: c/2 times the echo width, against when the truth's sum of echoes passes the threshold; at the \
poses at which both hear. Agree: both hear, or neither does; before a wall, both within {same:g} mm. {poses} poses of \
each. Planes to 45 degrees and 3.9 m, spheres of 3 to 20 cm to 40 degrees off the axis, a forearm of 25 x 8 cm in any \
attitude, boxes that turn a face; walls stand behind, beside the target. Time: all of a ping through the FMU, or of a \
ray; mean over poses, median of interleaved runs, {named}."""


class Found(NamedTuple):
    """All that was measured."""

    accuracies: Sequence[Accuracy]
    costs: Sequence[Cost]

    @property
    def names(self) -> list[str]:
        """Fidelities, then peers."""
        return list(dict.fromkeys(row.name for row in self.costs))

    def accuracy(self, name: str, truth: str) -> Accuracy | None:
        """None where it cannot be: no mesh is endless."""
        return next((row for row in self.accuracies if (row.name, row.truth) == (name, truth)), None)

    def cost(self, name: str, truth: str) -> float | None:
        """ns of a ping; None where there is no accuracy."""
        return next((1e9 * row.seconds for row in self.costs if (row.name, row.truth) == (name, truth)), None)


class Cell(NamedTuple):
    """What stands in the table, and how good it is."""

    text: str
    grade: str | None


def draw_sensor(found: Found, named: str, paths: Sequence[Path]) -> None:
    """Writes one picture in each of the formats that the paths name."""
    figure = Figure(figsize=(17.0, 11.4), dpi=90, facecolor="white")
    FigureCanvasAgg(figure)
    _table(figure.add_axes((0.015, 0.70, 0.97, 0.205)), found)
    grid = figure.add_gridspec(2, len(TRUTHS), left=0.045, right=0.99, bottom=0.115, top=0.645, wspace=0.14, hspace=0.3)
    for place, truth in enumerate(TRUTHS):
        _cost(figure.add_subplot(grid[0, place]), found, truth, place == 0)
        _spread(figure.add_subplot(grid[1, place]), found, truth, place == 0)
    figure.text(0.015, 0.966, "Ultrasonic sensor: which fidelity to take", fontsize=19, weight="bold")
    words = "Against wave theory. Median / 95th percentile of the range error in mm, and share of the poses at which "
    figure.text(
        0.015, 0.942, f"{words}sensor and truth agree on whether there is an echo.", fontsize=12, color="#333333"
    )
    note = NOTES.format(same=1e3 * SAME, poses=max(row.poses for row in found.accuracies), named=named)
    figure.text(0.015, 0.015, "\n".join(wrap(note, 210)), fontsize=9, color="#333333", linespacing=1.4)
    save(figure, paths)


def look(name: str) -> tuple[str, str]:
    """Colour and mark."""
    return LOOKS.get(name, NEW)


def _table(ax: Axes, found: Found) -> None:
    """A row for every fidelity and peer; cells coloured by how good they are."""
    widths = [1.9, 0.9, *[1.55, 0.75] * len(TRUTHS)]
    edges = np.concatenate([[0.0], np.cumsum(widths)])
    ax.set(xlim=(0, edges[-1]), ylim=(len(found.names), -1.4))
    ax.axis("off")
    for row, name in enumerate(found.names):
        color, mark = look(name)
        ax.plot(0.12, row + 0.5, mark, color=color, markersize=8)
        weight = "normal" if name == Rays.NAME else "bold"
        ax.text(0.27, row + 0.5, name, fontsize=11.5, color=color, weight=weight, va="center")
        for left, width, cell in zip(edges[1:], widths[1:], cells(found, name), strict=False):
            if cell.grade:
                ax.add_patch(Rectangle((left + 0.02, row + 0.05), width - 0.04, 0.9, facecolor=cell.grade))
            ax.text(left + width / 2, row + 0.5, cell.text, ha="center", va="center", fontsize=10.5)
    headings = ["ns a ping\n"]
    for truth in TRUTHS:
        headings += [f"{truth}\nmm", "\nagree"]
    for left, width, heading in zip(edges[1:], widths[1:], headings, strict=False):
        ax.text(left + width / 2, -0.1, heading, ha="center", va="bottom", fontsize=10.5, color="#333333")


def cells(found: Found, name: str) -> Iterator[Cell]:
    """Of a row: time of a ping over all targets, then for each truth range error and detection."""
    costs = [cost for cost in (found.cost(name, truth) for truth in TRUTHS) if cost is not None]
    yield Cell(f"{_short(min(costs))} to {_short(max(costs))}", None)
    for truth in TRUTHS:
        row = found.accuracy(name, truth)
        if row is None:
            yield from [Cell("endless", None), Cell("", None)]
            continue
        half, most = (1e3 * percentile(row.errors, share) for share in (50, 95))
        yield Cell(f"{_short(half)} / {_short(most)}", GOOD if most <= 1.0 else FAIR if most <= 5.0 else BAD)
        share = row.detection
        text = "100 %" if share == 1.0 else f"{100 * share:.1f}"
        yield Cell(text, GOOD if share >= 0.99 else FAIR if share >= 0.9 else BAD)


def _short(value: float) -> str:
    return f"{value:.3g}" if value < 1e3 else f"{value:.0f}" if value < 1e4 else f"{1e-3 * value:.0f}k"


def _cost(ax: Axes, found: Found, truth: str, first: bool) -> None:
    """Time of a ping against error: a bar from the median to the 95th percentile, the mark on it."""
    for name in found.names:
        row, cost = found.accuracy(name, truth), found.cost(name, truth)
        if row is None or cost is None:
            continue
        color, mark = look(name)
        half, most = (max(1e3 * percentile(row.errors, share), LEAST) for share in (50, 95))
        ax.plot([cost, cost], [half, most], color=color, linewidth=1.2, alpha=0.6)
        face = "none" if name == "automatic" else color
        ax.plot(cost, most, mark, color=color, markersize=8, markerfacecolor=face)
        ax.plot(cost, half, mark, color=color, markersize=4.5, markerfacecolor=face)
    ax.set(xscale="log", yscale="log", xlim=(10, 1e7 if "surface" in found.names else 1e4), ylim=(LEAST, 3e4))
    _name(ax, truth, "ns a ping", "range error, mm" if first else "")
    if not first:
        ax.tick_params(labelleft=False)
    ax.text(0.98, 0.98, SOURCES[truth], transform=ax.transAxes, ha="right", va="top", fontsize=9, color="#555555")
    if first:
        ax.text(0.03, 0.03, "large: 95th percentile\nsmall: median", transform=ax.transAxes, fontsize=8.5)


def _spread(ax: Axes, found: Found, truth: str, first: bool) -> None:
    """Share of the poses at which the truth and the sensor agree, by how far apart they may read."""
    for name in found.names:
        row = found.accuracy(name, truth)
        if row is None:
            continue
        share = (row.silent + np.arange(len(row.errors) + 1)) / row.poses
        errors = [LEAST, *np.maximum(1e3 * np.array(row.errors), LEAST), 3e3]
        style = STYLES.get(name, "-")
        ax.step(errors, [*share, share[-1]], linestyle=style, color=look(name)[0], where="post")
    ax.set(xscale="log", xlim=(LEAST, 3e3), ylim=(0, 1.02))
    _name(ax, "", "allowed range error, mm", "share of poses right" if first else "")
    if not first:
        ax.tick_params(labelleft=False)


def _name(ax: Axes, title: str, x: str, y: str) -> None:
    ax.set_title(title, fontsize=12, loc="left", weight="bold")
    ax.set(xlabel=x, ylabel=y)
    ax.grid(alpha=0.25, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
