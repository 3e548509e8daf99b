"""The picture of the skins: which method to take, its cost against each error, and the errors over the angle."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from ..pictures import save
from .skin_measuring import Cost, Shape
from .skin_statements import BULGE, STRETCH, VOLUME, sound_up_to

# After Okabe & Ito, which stay apart for the colour-blind.
COLORS = {
    "rigid": "#8a8a8a",
    "linear_blend": "#d55e00",
    "hinge": "#56b4e9",
    "dual_quaternion": "#0072b2",
    "center_of_rotation": "#cc79a7",
    "compensated": "#009e73",
}
MARKS = dict(zip(COLORS, "Xsv^DP", strict=True))
GOOD, FAIR, BAD = "#cfe8cb", "#f8e4ae", "#f0bcb4"
NOTES = """Cylinder of radius r, blend zone 3 r long, all of the twist in it. Volume: of the blend zone. Bulge: \
largest distance of a vertex to the bones. Stretch: of the longest edge. Normals: mean angle in the zone to float64 \
truth. Time: position and normal (libigl: position alone), read into NumPy's memory, median of interleaved runs; \
shapes of meshes of {named}."""


class Column(NamedTuple):
    """Of the table: heading, what is shown of a name, how it is written, and up to where it is good and fair."""

    heading: str
    value: Callable[["Found", str], float | None]
    form: str
    good: float
    fair: float


class Found(NamedTuple):
    """All that was measured."""

    costs: Sequence[Cost]
    shapes: Sequence[Shape]

    def at(self, name: str, bend: str, angle: float) -> Shape:
        """The shape at one angle."""
        return next(s for s in self.shapes if (s.name, s.bend, s.angle) == (name, bend, angle))

    def worst(self, name: str, bend: str, error: Callable[[Shape], float | None]) -> float | None:
        """The largest error over all angles."""
        values = [error(s) for s in self.shapes if (s.name, s.bend) == (name, bend)]
        return max((value for value in values if value is not None), default=None)


def _volume(s: Shape) -> float:
    return 100 * s.volume_error


def _volume_error(s: Shape) -> float:
    return abs(_volume(s))


def _bulge(s: Shape) -> float:
    return 100 * (s.bulge - 1)


def _folded(s: Shape) -> float:
    return 100 * s.fold_fraction


def _normal(s: Shape) -> float | None:
    return s.normal_error


def _at(bend: str, angle: float, value: Callable[[Shape], float | None]) -> Callable[[Found, str], float | None]:
    return lambda found, name: value(found.at(name, bend, angle))


def _sound(bend: str) -> Callable[[Found, str], float]:
    """As an angle that is lacking, so that less is better here too."""
    return lambda found, name: -sound_up_to(found.shapes, name, bend)


COLUMNS = (
    Column("ns", lambda found, name: next(1e9 * c.seconds for c in found.costs if c.name == name), ".2f", 1.0, 10.0),
    Column("sound to\nflexion", _sound("flexion"), ".0f°", -80.0, -45.0),
    Column("sound to\ntwist", _sound("twist"), ".0f°", -180.0, -45.0),
    Column("flexion 90\nvolume %", _at("flexion", 90.0, _volume), "+.1f", 1.0, 5.0),
    Column("\nbulge %", _at("flexion", 90.0, _bulge), ".0f", 10.0, 15.0),
    Column("\nfolded %", _at("flexion", 90.0, _folded), ".1f", 0.0, 2.0),
    Column("\nstretch", _at("flexion", 90.0, lambda s: s.stretch), ".1f×", STRETCH, STRETCH),
    Column("flexion 150\nvolume %", _at("flexion", 150.0, _volume), "+.1f", 1.0, 6.0),
    Column("\nbulge %", _at("flexion", 150.0, _bulge), ".0f", 10.0, 15.0),
    Column("\nfolded %", _at("flexion", 150.0, _folded), ".1f", 0.0, 5.0),
    Column("twist 180\nvolume %", _at("twist", 180.0, _volume), "+.1f", 1.0, 5.0),
    Column("normals off\ndegrees", lambda found, name: found.worst(name, "flexion", _normal), ".2g", 1e-3, 1.0),
)


def draw_skin(costs: Sequence[Cost], shapes: Sequence[Shape], named: str, paths: Sequence[Path]) -> None:
    """Writes one picture in each of the formats that the paths name."""
    found = Found(costs, shapes)
    figure = Figure(figsize=(15.0, 14.2), dpi=90, facecolor="white")
    FigureCanvasAgg(figure)
    _table(figure.add_axes((0.02, 0.705, 0.96, 0.225)), found)
    grid = figure.add_gridspec(3, 4, left=0.05, right=0.985, bottom=0.075, top=0.665, wspace=0.26, hspace=0.42)
    errors = (
        ("volume error, %", _volume_error, "symlog", 0.1),
        ("bulge, %", _bulge, "linear", 1.0),
        ("folded triangles, %", _folded, "linear", 1.0),
        ("error of normals, degrees", _normal, "log", 1.0),
    )
    for place, (label, error, scale, linear) in enumerate(errors):
        _cost(figure.add_subplot(grid[0, place]), found, label, error, (scale, linear))
        _curves(figure.add_subplot(grid[1, place]), found, "flexion", label, error, scale)
        twist = ("least section, of rest", lambda s: s.section, "linear") if place == 1 else (label, error, scale)
        _curves(figure.add_subplot(grid[2, place]), found, "twist", *twist)
    figure.text(0.02, 0.972, "Skin of an elbow: which method to take", fontsize=19, weight="bold")
    caption = (
        f"Sound: volume within {100 * VOLUME:.0f} %, bulge below {100 * (BULGE - 1):.0f} %, nothing torn or folded."
    )
    figure.text(0.02, 0.950, f"{caption} Green is good, yellow fair, red bad.", fontsize=12, color="#333333")
    words = NOTES.format(named=named)
    cut = words.rfind(" ", 0, len(words) // 2 + 10)
    figure.text(0.02, 0.012, words[:cut] + "\n" + words[cut + 1 :], fontsize=9, color="#333333", linespacing=1.4)
    save(figure, paths)


def _table(ax: Axes, found: Found) -> None:
    """A row for every method and peer; cells coloured by how good they are."""
    names = [cost.name for cost in found.costs]
    ax.set(xlim=(0, 2.2 + len(COLUMNS)), ylim=(len(names), -1.6))
    ax.axis("off")
    for row, cost in enumerate(found.costs):
        look = {"color": COLORS[cost.method], "weight": "normal" if cost.peer else "bold", "va": "center"}
        ax.text(0.25, row + 0.5, cost.name, fontsize=11.5, **look)
        if not cost.peer:
            ax.plot(0.1, row + 0.5, MARKS[cost.name], color=COLORS[cost.name], markersize=8)
        for place, column in enumerate(COLUMNS):
            value = column.value(found, cost.name)
            x = 2.2 + place
            if value is None:
                ax.text(x + 0.5, row + 0.5, "none", ha="center", va="center", fontsize=10.5, color="#777777")
                continue
            size = value if column.heading.startswith("sound") else abs(value)
            # a rounding of what is written is no difference
            grade = GOOD if size <= column.good + 1e-9 else FAIR if size <= column.fair else BAD
            ax.add_patch(Rectangle((x + 0.02, row + 0.04), 0.96, 0.92, facecolor=grade))
            text = _written(value, column)
            ax.text(x + 0.5, row + 0.5, text, ha="center", va="center", fontsize=11)
    for place, column in enumerate(COLUMNS):
        ax.text(2.7 + place, -0.12, column.heading, ha="center", va="bottom", fontsize=10.5, color="#333333")


def _written(value: float, column: Column) -> str:
    if column.form[-1] in "°×":
        return f"{abs(value):{column.form[:-1]}}{column.form[-1]}"
    text = f"{value:{column.form}}"
    return text.replace("e-0", "e-") if float(text) != 0.0 else "0"


def _cost(ax: Axes, found: Found, label: str, error: Callable[[Shape], float | None], scale: tuple[str, float]) -> None:
    """Time of a vertex against the worst error: filled over flexion, hollow over twist; peers as small dots."""
    for cost in found.costs:
        for bend, face in (("flexion", COLORS[cost.method]), ("twist", "white")):
            value = found.worst(cost.name, bend, error)
            if value is not None:
                look = {"marker": "o" if cost.peer else MARKS[cost.name], "markersize": 6 if cost.peer else 8.5}
                look |= {"markeredgecolor": COLORS[cost.method], "markerfacecolor": face, "markeredgewidth": 1.5}
                ax.plot(1e9 * cost.seconds, value, linestyle="none", clip_on=False, **look)
    kind, linear = scale
    if kind == "symlog":
        ax.set_yscale("symlog", linthresh=linear)
        ax.set_ylim(bottom=0.0)
    else:
        ax.set_yscale(kind)
    ax.set(xscale="log", xlim=(0.3, 300.0))
    _name(ax, f"Cost against {label.partition(',')[0]}", "ns a vertex", f"worst {label}")
    if label.startswith("volume"):
        for marker, text in (("o", "over flexion"), ("o", "over twist"), ("o", "small: peers")):
            face = "white" if "twist" in text else "#444444"
            size = 4 if "peers" in text else 7
            ax.add_line(Line2D([], [], marker=marker, linestyle="none", color="#444444", label=text, markersize=size))
            ax.get_lines()[-1].set_markerfacecolor(face)
        ax.legend(*_last(ax, 3), fontsize=8.5, frameon=False, loc="center right")


def _last(ax: Axes, count: int) -> tuple[list[Line2D], list[str]]:
    lines = ax.get_lines()[-count:]
    return lines, [str(line.get_label()) for line in lines]


def _curves(ax: Axes, found: Found, bend: str, label: str, error: Callable[[Shape], float | None], scale: str) -> None:
    """The error of every method over the angle; of the peers that of the normals alone, for the rest is the same."""
    for cost in found.costs:
        own = [s for s in found.shapes if (s.name, s.bend) == (cost.name, bend)]
        values = [error(s) for s in own]
        if None in values or (cost.peer and error is not _normal):
            continue
        look = {"color": COLORS[cost.method], "linewidth": 1.6, "linestyle": ":" if cost.peer else "-"}
        if not cost.peer:
            look |= {"marker": MARKS[cost.name], "markersize": 4.5, "markevery": max(1, len(own) // 8)}
        # under it lies the same curve of dual_quaternion
        if cost.name == "hinge":
            look |= {"markersize": 7.5, "linewidth": 4.0, "alpha": 0.6}
        ax.plot([s.angle for s in own], values, **look)
    if scale == "symlog":
        ax.set_yscale("symlog", linthresh=0.1)
        ax.set_ylim(bottom=0.0)
    elif scale == "log":
        ax.set(yscale="log", ylim=(1e-8, 100.0))
        ax.text(0.97, 0.70, "dotted: peers, which turn\nthe normals and no more", transform=ax.transAxes, ha="right")
    ax.set(xlim=(0, 180 if bend == "twist" else 150), xticks=range(0, 181 if bend == "twist" else 151, 30))
    _name(ax, f"{bend.capitalize()}: {label.partition(',')[0]}", f"{bend}, degrees", label)


def _name(ax: Axes, title: str, x: str, y: str) -> None:
    ax.set_title(title, fontsize=12, loc="left", weight="bold")
    ax.set(xlabel=x, ylabel=y)
    ax.grid(alpha=0.25, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
