"""The map of couplings drawn: measured cells, theory's borders over them, growth, loops, and what the watch says."""

import math
from os import PathLike
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..pictures import save
from ..watch import SHARE
from .coupling_measuring import FASTER, LIGHT, MORE_DAMPED, RELAXED_GAIN, SHOWN
from .coupling_theory import UNDAMPED_GROWTH, reduced_mass
from .hinges import SLENDERNESS
from .mobility import settling_mass_ratio
from .oscillator import theory_of
from .picture import name
from .verdict_map import draw_cells

VERDICTS = {"accurate": "#a8d5a2", "bounded": "#f3d48b", "neither": "#e8a49c", "did not settle": "#b9b3c9"}
TITLES = {
    "jacobi_order_0": "jacobi",
    "gauss_seidel_order_0": "gauss_seidel",
    "iterated": "iterated",
    "jacobi_order_1": "jacobi, extrapolation 1",
    "gauss_seidel_order_1": "gauss_seidel, extrapolation 1",
    "newton": "newton",
}
COLORS = dict(zip(TITLES, ("#c0392b", "#e08a1f", "#3d8b57", "#8a4fa3", "#1f8a9e", "#444444"), strict=True))
MARKS = dict(zip(TITLES, "osP^vD", strict=True))
ELBOW = (1e5, 50.0)
"""N/m and N s/m of the cross in every map, at 1 ms."""


def draw_coupling(found: dict[str, Any], *paths: str | PathLike) -> None:
    """Writes the map of what `measure_coupling` found; the ending of each path chooses the format."""
    figure = Figure(figsize=(15, 16), dpi=90, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(4, 12, height_ratios=(0.12, 1.06, 1, 1))
    _legend(figure.add_subplot(grid[0, :]))
    for place, master in enumerate(TITLES):
        row, column = divmod(place, 3)
        _map(figure.add_subplot(grid[1 + row, 4 * column : 4 * column + 4]), found, master, row == 0, column == 0)
    for place, panel in enumerate((_undamped, _loops, _swings, _energies)):
        panel(figure.add_subplot(grid[3, 3 * place : 3 * place + 3]), found)
    figure.suptitle("Two RigidBody units held by a CompliantJoint: what each master makes of k, c and H", fontsize=16)
    save(figure, paths)


def _legend(ax: Axes) -> None:
    meanings = {
        "accurate": "accurate: frequency and damping within 1 %",
        "bounded": "bounded, but wrong",
        "neither": "neither: errors grow",
        "did not settle": "did not settle",
    }
    handles: list[Any] = [Patch(color=color, label=meanings[kind]) for kind, color in VERDICTS.items()]
    handles += [
        Line2D([], [], color="black", linewidth=2, label="theory: stable up to here"),
        Line2D([], [], color="#1d6b2f", linestyle="--", linewidth=2, label="theory: accurate up to here"),
        Line2D([], [], color="#4b3f72", linestyle=":", linewidth=2, label="theory: plain iteration, relaxed iteration"),
        Line2D([], [], color="black", marker="X", linestyle="", label="k = 1e5 N/m, c = 50 N s/m, H = 1 ms"),
    ]
    ax.axis("off")
    ax.legend(handles=handles, loc="center", ncols=4, frameon=False, fontsize=10)


def _map(ax: Axes, found: dict[str, Any], master: str, upper: bool, left: bool) -> None:
    """Cells by verdict, and the borders that theory sees."""
    cells = [row for row in found["cells"] if row["master"] == master]
    draw_cells(ax, cells, "z", "zeta", VERDICTS, log=True)
    borders = [row for row in found["borders"] if row["master"] == master]
    heights = [row["zeta"] for row in borders]
    ax.plot([row["stable"] for row in borders], heights, color="black", linewidth=2)
    ax.plot([row["accurate"] for row in borders], heights, "--", color="#1d6b2f", linewidth=2)
    if master == "iterated":
        ax.plot([row["iteration"] for row in borders], heights, ":", color="#4b3f72", linewidth=2)
        # the gain z^2 / 6 + zeta z is that at which even the least share of a change is too much
        relaxed = [3 * (math.sqrt(h**2 + RELAXED_GAIN * 2 / 3) - h) for h in heights]
        ax.plot(relaxed, heights, ":", color="#4b3f72", linewidth=2)
    m = reduced_mass(*found["about"]["masses"])
    step, (k, c) = found["about"]["step"], ELBOW
    ax.plot(
        step * math.sqrt(k / m), c / (2 * math.sqrt(k * m)), "X", color="black", markersize=9, markeredgecolor="white"
    )
    ax.set(xscale="log", yscale="log", xlim=FASTER, ylim=MORE_DAMPED)
    y = "damping ratio, c / (2 sqrt(k m))" if left else ""
    name(ax, TITLES[master], "H sqrt(k/m)", y)
    ax.grid(visible=False)
    if upper:
        top = ax.secondary_xaxis(
            "top", functions=(lambda z: m * (z / step) ** 2, lambda k: step * np.sqrt(np.maximum(k, 0.0) / m))
        )
        top.set_xlabel(f"k [N/m] at H = 1 ms, m = {m:.3f} kg", fontsize=9)


def _undamped(ax: Axes, found: dict[str, Any]) -> None:
    z = np.geomspace(0.04, 1.2, 50)
    for master in TITLES:
        power, factor = UNDAMPED_GROWTH[theory_of(master)]
        rows = [row for row in found["undamped"] if row["master"] == master]
        if factor == 0.0:
            least = max(abs(row["growth"]) for row in rows)
            ax.plot([], [], MARKS[master], color=COLORS[master], label=f"{TITLES[master]}: within {least:.0e} of 0")
            continue
        ax.plot(z, factor * z**power, "--", color=COLORS[master], linewidth=1)
        ax.plot([r["z"] for r in rows], [r["theory"] for r in rows], "-", color=COLORS[master], linewidth=1)
        x, y = [row["z"] for row in rows], [row["growth"] for row in rows]
        ax.plot(x, y, MARKS[master], color=COLORS[master], markersize=5, label=TITLES[master])
    ax.set(xscale="log", yscale="log", ylim=(1e-6, 30))
    name(ax, "No damper: growth of errors", "H w;  lines: theory, dashed: leading term", "growth rate / w")
    ax.legend(fontsize=8, frameon=False, loc="upper left", borderaxespad=0.1)


def _loops(ax: Axes, found: dict[str, Any]) -> None:
    """Where plain passes through two hinged bodies settle."""
    for inside, color, mark, label in (
        (True, VERDICTS["accurate"], "s", "passes converge"),
        (False, VERDICTS["neither"], "s", "passes diverge"),
    ):
        rows = [row for row in found["loops"] if (row["gain"] < 1.0) == inside]
        x, y = [math.degrees(row["elbow"]) for row in rows], [row["ratio"] for row in rows]
        ax.plot(x, y, mark, color=color, markersize=9, label=label)
    angles = np.linspace(0, math.pi, 200)
    line = [settling_mass_ratio(SLENDERNESS, angle) for angle in angles]
    ax.plot(np.degrees(angles), line, color="black", linewidth=2, label="theory: gain 1")
    rows = found["mass_ratios"]
    x, y = [math.degrees(row["elbow"]) for row in rows], [row["measured"] for row in rows]
    ax.plot(x, y, "o", color="white", markeredgecolor="black", markersize=5, label="measured border")
    worst = max(row[master] for row in found["loops"] for master in ("iterated", "newton"))
    note = f"iterated, newton: solved at every point,\naccelerations within {worst:.0e}"
    ax.text(0.5, 0.91, note, fontsize=8, transform=ax.transAxes, ha="center", bbox={"color": "white"})
    ax.set(yscale="log", xlim=(-6, 186), xticks=range(0, 181, 45))
    name(ax, "Hinge on hinge: plain passes", "angle of the elbow [degrees]", "mass / mass felt at the tip")
    ax.legend(fontsize=8, loc="lower center", ncols=2, framealpha=1.0)


def _swings(ax: Axes, found: dict[str, Any]) -> None:
    for row in found["swings"]:
        turns, master = np.array(row["angle"]) / (2 * math.pi), row["master"]
        if master:
            ax.plot(turns, row["distance"], color=COLORS[master], linewidth=1.5, label=TITLES[master])
        else:
            ax.plot(turns, row["distance"], "k--", linewidth=1.5, label="true")
    name(ax, "Stable but wrong", f"swings;  H w = {SHOWN}, damping ratio {LIGHT}", "distance / that at the start")
    ax.set_ylim(-1.3, 2.3)
    ax.legend(fontsize=8, frameon=False, loc="upper right", ncols=2)


def _energies(ax: Axes, found: dict[str, Any]) -> None:
    for master in TITLES:
        rows = [row for row in found["energies"] if row["master"] == master]
        z, system = np.array([row["z"] for row in rows]), np.array([row["system"] for row in rows])
        ax.plot(z, np.abs([row["created"] for row in rows]) / system, "-", color=COLORS[master], linewidth=1)
        watched = np.abs([row["watched"] for row in rows]) / system
        for flagged in (True, False):
            which = [k for k, row in enumerate(rows) if row["warned"] == flagged and watched[k] > 0.0]
            face = COLORS[master] if flagged else "none"
            ax.plot(z[which], watched[which], MARKS[master], color=COLORS[master], markersize=5, markerfacecolor=face)
    ax.axhline(SHARE, color="black", linewidth=1, linestyle=":")
    ax.set(xscale="log", yscale="log", ylim=(1e-7, 10))
    y = "|energy| / that of the system"
    note = "filled: the watch warns;\ncolours as on the left"
    ax.text(0.98, 0.02, note, transform=ax.transAxes, ha="right", va="bottom", fontsize=8)
    name(ax, "Energy from nowhere, two swings", "H w;  lines: true, marks: the watch", y)
