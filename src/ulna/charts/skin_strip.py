"""The filmstrip of skins: one elbow under four methods, bent and twisted; the tear and its cure."""

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from ..bench.arm_skin import posed
from ..bench.skinning import ELBOW, SPOKES, Array, about, product, turned
from ..pictures import save
from ..plot import SKIN
from .skin_measuring import bent

METHODS = {
    "rigid": "rigid\ntears",
    "linear_blend": "linear_blend\ncollapses",
    "dual_quaternion": "dual_quaternion\nbulges",
    "compensated": "compensated\nbulges less",
}
FRAMES = [("flexion", angle) for angle in (0.0, 45.0, 90.0, 120.0, 150.0)] + [("twist", 90.0), ("twist", 180.0)]
VERTICES = 4096
INSIDE = (0.72, 0.13, 0.15)
"""Colour of what is seen from within the arm, through a tear or on a fold."""
LIGHT = np.array([0.3, -0.75, 0.59])
VIEWER = product(about([1.0, 0.0, 0.0], 14.0), about([0.0, 0.0, 1.0], -32.0))
"""Turns the arm before one who looks along y: a little from above, and from the outside of the elbow."""
STRETCHED = 4.0
"""Times its length at rest: a triangle with such an edge is left out, for a skin would be open there."""
BANDS = 8
"""Stripes around the arm, so that a twist is seen."""


def seen(method: str, bend: str, angle: float) -> tuple[Array, Array]:
    """Triangles [n, 3, 2] m from the elbow as the viewer sees them, the farthest first; and their colours [n, 3]."""
    with posed(method, bent(bend, 0.0), VERTICES) as skin:
        triangles = skin.get("triangles").reshape(-1, 3)[:-4]
        rest = edges(skin.get("vertices").T.astype(float)[triangles])
        skin.set("forearm_orientation", bent(bend, -angle if bend == "flexion" else angle).fore)
        corners = turned(VIEWER, skin.get("vertices").T.astype(float) - ELBOW)[triangles]
    whole = np.all(edges(corners) < STRETCHED * rest, axis=1)
    triangles, corners = triangles[whole], corners[whole]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
    spokes = triangles % SPOKES
    spoke = np.where(np.ptp(spokes, axis=1) > 1, SPOKES - 1, spokes.min(axis=1))
    shade = (0.45 + 0.55 * np.abs(normals @ LIGHT)) * np.where(spoke * BANDS // SPOKES % 2 == 0, 1.0, 0.82)
    colors = np.where((normals[:, 1] < 0.0)[:, None], SKIN, INSIDE) * shade[:, None]
    order = np.argsort(-corners[..., 1].mean(axis=1))
    return corners[order][..., [0, 2]], np.clip(colors[order], 0.0, 1.0)


def edges(corners: Array) -> Array:
    """Lengths [n, 3] m of the edges of triangles [n, 3, 3]."""
    return np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)


def draw_strip(path: Path) -> None:
    """Writes the picture: a method a row, a bend a column."""
    figure = Figure(figsize=(14.0, 6.9), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(METHODS), len(FRAMES))
    figure.subplots_adjust(left=0.11, right=0.995, top=0.955, bottom=0.01, wspace=0.03, hspace=0.03)
    for row, (method, label) in zip(axes, METHODS.items(), strict=True):
        name, _, what = label.partition("\n")
        row[0].text(-0.04, 0.56, name, transform=row[0].transAxes, ha="right", fontsize=11, weight="bold")
        row[0].text(-0.04, 0.40, what, transform=row[0].transAxes, ha="right", fontsize=11, color="#555555")
        for ax, (bend, angle) in zip(row, FRAMES, strict=True):
            faces, colors = seen(method, bend, angle)
            ax.add_collection(PolyCollection(faces, facecolors=colors, edgecolors=colors, linewidths=0.2))
            ax.set(xlim=(-0.16, 0.16), ylim=(-0.12, 0.17), aspect="equal")
            ax.set(xticks=[], yticks=[], facecolor="#f4f5f7")
            ax.spines[:].set_visible(False)
            if method == "rigid":
                ax.set_title(f"{bend} {angle:.0f}°" if angle else "at rest", fontsize=12)
    save(figure, [path])
