"""The map of skins drawn: measured cells, closed forms over them; folds, sections, volume and flips as curves."""

import math
from os import PathLike
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..charts.draw_skin import COLORS, MARKS
from ..pictures import save
from . import skin_theory as theory
from .picture import name
from .skin_measuring import COLLAPSED, FOLLOWED, LARGEST, SHORTER, TORN, WIDTH
from .verdict_map import draw_cells

VERDICTS = {
    "sound": "#a8d5a2",
    "folded": "#f3d48b",
    "collapsed": "#ec9f86",
    "folded, collapsed": "#c9635b",
    "flipped": "#b39ac9",
    "torn": "#b5b5b5",
}
MEANINGS = {
    "sound": "sound",
    "folded": "folded: a triangle is inverted",
    "collapsed": f"collapsed: a section below {COLLAPSED:.0%} of rest",
    "folded, collapsed": "folded and collapsed",
    "flipped": "flipped: gone through the bone's axis",
    "torn": f"torn: open by more than r/{1 / TORN:.0f}",
}
COLUMNS = {
    "rigid": "rigid",
    "linear_blend": "linear_blend",
    "dual_quaternion": "dual_quaternion, hinge",
    "center_of_rotation": "center_of_rotation",
    "compensated": "compensated",
}
"""`hinge` is the same where the bones share the elbow."""


def draw_skin(found: dict[str, Any], *paths: str | PathLike) -> None:
    """Writes the map of what `measure_skin` found; the ending of each path chooses the format."""
    figure = Figure(figsize=(16, 13), dpi=90)
    FigureCanvasAgg(figure)
    _legend(figure.add_axes((0.04, 0.895, 0.95, 0.05)))
    maps = figure.add_gridspec(2, 5, left=0.045, right=0.985, bottom=0.40, top=0.865, wspace=0.16, hspace=0.24)
    for place, (method, title) in enumerate(COLUMNS.items()):
        for row, bend in enumerate(LARGEST):
            ax = figure.add_subplot(maps[row, place])
            _map(ax, found, method, bend)
            name(ax, title if row == 0 else "", f"{bend}, degrees", "" if place else "half width of the blend, h / r")
            ax.grid(visible=False)
    curves = figure.add_gridspec(1, 4, left=0.045, right=0.985, bottom=0.045, top=0.33, wspace=0.24)
    for place, panel in enumerate((_folds, _sections, _volumes, _flips)):
        panel(figure.add_subplot(curves[0, place]), found)
    title = "Where skins tear, fold, collapse and flip: angle of the elbow and width of the blend, measured on ArmSkin"
    figure.suptitle(title, fontsize=16, y=0.98)
    save(figure, paths)


def _legend(ax: Axes) -> None:
    handles: list[Any] = [Patch(color=color, label=MEANINGS[kind]) for kind, color in VERDICTS.items()]
    handles.append(Line2D([], [], color="black", linewidth=2, label="closed form"))
    handles.append(Line2D([], [], color="black", linewidth=2, linestyle="--", label="smooth surface in float64"))
    ax.axis("off")
    ax.legend(handles=handles, loc="center", ncols=4, frameon=False, fontsize=10.5)


def _map(ax: Axes, found: dict[str, Any], method: str, bend: str) -> None:
    """Cells by verdict, and the borders that theory sees."""
    cells = [row for row in found["cells"] if (row["method"], row["bend"]) == (method, bend)]
    _, ratios = draw_cells(ax, cells, "angle", "ratio", VERDICTS)
    if bend == "flexion":
        folds = [row for row in found["folds"] if row["method"] == method]
        smooth = [row for row in folds if not row["closed_form"]]
        ax.plot([row["theory"] for row in smooth], [row["ratio"] for row in smooth], "k--", linewidth=2)
        widths = np.linspace(0.2, 4.2, 200)
        closed = [theory.fold_angle(method, width) for width in widths]
        if closed[0] is not None:
            ax.plot(closed, widths, color="black", linewidth=2)
    for angle in _upright(method, bend):
        ax.axvline(angle, color="black", linewidth=2)
    ax.set(xlim=(0, LARGEST[bend]), ylim=(ratios[0], ratios[-1]), xticks=np.linspace(0, LARGEST[bend], 5))


def _upright(method: str, bend: str) -> list[float]:
    """Degrees of the borders that do not depend on the width."""
    if method == "rigid":
        torn = 2 * math.degrees(math.asin(TORN / 2))
        return [torn, 360.0 - torn]
    if method != "linear_blend":
        return []
    collapsed = 2 * math.degrees(math.acos(COLLAPSED ** {"flexion": 1.0, "twist": 0.5}[bend]))
    return [collapsed] if bend == "flexion" else [collapsed, 180.0]


def _folds(ax: Axes, found: dict[str, Any]) -> None:
    widths = np.linspace(0.05, 4, 200)
    for method, title in COLUMNS.items():
        rows = [row for row in found["folds"] if row["method"] == method and math.isfinite(row["measured"])]
        if not rows:
            continue
        closed = [theory.fold_angle(method, width) for width in widths]
        if closed[0] is not None:
            ax.plot(widths, closed, color=COLORS[method])
        else:
            smooth = [(row["ratio"], row["theory"]) for row in rows]
            ax.plot(*zip(*smooth, strict=True), "--", color=COLORS[method])
        look = {"color": COLORS[method], "markersize": 5}
        x, y = [row["ratio"] for row in rows], [row["measured"] for row in rows]
        ax.plot(x, y, MARKS[method], label=title, **look)
    ax.set(ylim=(0, 180), xlim=(0, 4), yticks=range(0, 181, 30))
    name(ax, "First fold: marks measured, lines theory", "h / r", "flexion, degrees")
    ax.legend(fontsize=8.5, loc="lower right", framealpha=1.0)


LOOKS = {("linear_blend", "flexion"): "o", ("linear_blend", "twist"): "s"}


def _curve(ax: Axes, found: dict[str, Any], key: str, law: dict[str, Any]) -> None:
    """The linear blend beside its laws, and all others as one: they keep sections."""
    angles = np.linspace(0, 180, 200)
    for (method, bend), mark in LOOKS.items():
        rows = [row for row in found["curves"] if (row["method"], row["bend"]) == (method, bend)]
        color = COLORS[method] if bend == "flexion" else "#8c2d04"
        words, curve = law[bend]
        ax.plot(angles, [curve(angle) for angle in angles], color=color)
        x, y = [row["angle"] for row in rows], [row[key] for row in rows]
        ax.plot(x, y, mark, color=color, markersize=4.5, label=f"linear_blend, {bend}: {words}", markevery=2)
    for method in ("dual_quaternion", "center_of_rotation", "compensated"):
        rows = [row for row in found["curves"] if (row["method"], row["bend"]) == (method, "flexion")]
        look = {"color": COLORS[method], "markersize": 4.5, "linewidth": 1, "markevery": 3}
        ax.plot([row["angle"] for row in rows], [row[key] for row in rows], f"-{MARKS[method]}", label=method, **look)
    ax.set(xlim=(0, 180), ylim=(-0.62, 1.05), xticks=range(0, 181, 45), yticks=np.linspace(0, 1, 6))
    ax.legend(fontsize=8.5, loc="lower left", framealpha=1.0)


def _sections(ax: Axes, found: dict[str, Any]) -> None:
    words = {"flexion": "cos(a/2)", "twist": "cos²(a/2)"}
    law = {
        bend: (words[bend], lambda angle, bend=bend: theory.section("linear_blend", bend, angle)) for bend in LARGEST
    }
    _curve(ax, found, "section", law)
    name(ax, f"Least section, h = {WIDTH} r", "a: flexion or twist, degrees", "of rest")


def _volumes(ax: Axes, found: dict[str, Any]) -> None:
    words = {"flexion": "1 - 9/70 (1 - cos a)", "twist": "1 - 9/35 (1 - cos a)"}
    _curve(ax, found, "volume", {b: (words[b], lambda angle, b=b: theory.volume(b, angle)) for b in LARGEST})
    name(ax, f"Volume of the zone, h = {WIDTH} r", "a: flexion or twist, degrees", "of rest")


def _flips(ax: Axes, found: dict[str, Any]) -> None:
    """Of what a vertex does in a degree."""
    for mode, color, width in ((SHORTER, "#c0392b", 1.4), (FOLLOWED, COLORS["dual_quaternion"], 2.6)):
        rows = [row for row in found["flips"] if (row["method"], row["mode"]) == ("dual_quaternion", mode)]
        ax.plot([r["angle"] for r in rows], [r["move"] for r in rows], color=color, linewidth=width, label=mode)
    ax.axhline(2.0, color="black", linestyle=":", linewidth=1)
    ax.axhline(math.pi / 180, color="black", linestyle=":", linewidth=1)
    ax.text(715, 2.2, "2 r: through the whole arm", ha="right", va="bottom", fontsize=9)
    ax.text(715, 0.019, "π r / 180: with the hand", ha="right", va="bottom", fontsize=9)
    ax.set(yscale="log", ylim=(0.008, 6), xlim=(0, 720), xticks=range(0, 721, 180))
    name(ax, "Flips: dual_quaternion, two turns", "twist, degrees", "largest move in a degree / r")
    ax.legend(fontsize=8.5, loc="center right", framealpha=1.0)
