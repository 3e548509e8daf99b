"""Weights of two bones for a closed surface without any: bounded biharmonic weights.

Jacobson, Baran, Popovic, Sorkine, "Bounded biharmonic weights for real-time deformation", ACM Transactions on
Graphics 30 (4), 2011. TetGen cuts the volume within the surface into tetrahedra and keeps the surface's vertices and
triangles as they are; libigl finds the weight w of the second bone there: of all functions that are 0 on the first
bone, 1 on the second, and nowhere below 0 or above 1, the one with the least integral of (laplacian w)^2 (their
equations 2 to 6). With two bones the weight of the first is 1 - w.

The bones end short of the joint, `half_width` on both sides. In a thin limb w then varies along it alone, with no slope
at the bones' ends: the cubic 3 s^2 - 2 s^3, ArmSkin's own weight.
"""

from contextlib import chdir
from tempfile import TemporaryDirectory
from types import ModuleType

import numpy as np

INSTALL = "automatic weights need libigl and TetGen: pip install 'ulna[skin]'"
# what the solver leaves of 0 and 1 far from the joint: 10 um at 1 m
NEGLIGIBLE = 1e-5
SHAPE = 1.4
"""Of a tetrahedron: largest radius of its circumscribed sphere, in shortest edges."""


def check_closed(vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Raises ValueError where a surface is not closed, not of one piece, or its triangles face inward.

    Vertices at one place must be one.
    """
    starts, ends = (np.roll(triangles, -k, axis=1).ravel() for k in range(2))
    count = len(vertices)
    forth, back = starts * count + ends, ends * count + starts
    numbers, times = np.unique(forth, return_counts=True)
    if times.max() > 1:
        edge = _edge(vertices, numbers[times > 1][0])
        raise ValueError(f"has more than two triangles at {edge}, or two that face apart; allowed: two at every edge")
    alone = np.setdiff1d(forth, back)
    if len(alone):
        edge = _edge(vertices, alone[0])
        raise ValueError(
            f"is not closed: {edge} has a triangle on one side only, as have {len(alone) - 1} more; allowed: a surface "
            "without holes"
        )
    pieces = libigl().facet_components(triangles.astype(np.int64))[0]
    if pieces > 1:
        raise ValueError(f"has {pieces} separate pieces; allowed: one closed surface, or a mesh that --mesh names")
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    if np.sum(a * np.cross(b, c)) <= 0.0:
        raise ValueError("has triangles that face inward; allowed: counterclockwise from outside")


def surface_distance(vertices: np.ndarray, triangles: np.ndarray, point: np.ndarray) -> float:
    """m, from a point to the nearest of the surface."""
    square, _, _ = libigl().point_mesh_squared_distance(point[None], vertices, triangles.astype(np.int64))
    return float(np.sqrt(square[0]))


def biharmonic_shares(vertices: np.ndarray, triangles: np.ndarray, joints: np.ndarray, half_width: float) -> np.ndarray:
    """Weights (n,) of the second bone in vertices (n, 3), m, of a closed surface.

    `joints` (3, 3), m: where the first bone begins, where both meet, where the second ends. Raises ValueError where a
    bone is not longer than `half_width` or leaves the surface, or the surface crosses itself; ModuleNotFoundError
    without libigl or TetGen.
    """
    igl = libigl()
    edges = vertices[triangles] - vertices[np.roll(triangles, 1, axis=1)]
    spacing = float(np.median(np.linalg.norm(edges, axis=2)))
    bones = [_handle(joints[end], joints[1], half_width, spacing) for end in (0, 2)]
    handles = np.concatenate(bones)
    inside = igl.fast_winding_number(vertices, triangles.astype(np.int64), handles) > 0.5
    if not inside.all():
        place = ", ".join(f"{number:.4g}" for number in handles[np.argmin(inside)])
        raise ValueError(f"a bone leaves the surface at ({place}) m; allowed: shoulder, elbow and wrist within it")
    nodes, cells = _cells(np.concatenate([vertices, handles]), triangles)
    # of the nodes given, TetGen keeps number and place
    fixed = np.arange(len(vertices), len(vertices) + len(handles))
    values = np.repeat([0.0, 1.0], [len(bone) for bone in bones])[:, None]
    found = igl.bbw(nodes, cells.astype(np.int64), fixed, values)[: len(vertices), 0]
    if not np.all(np.isfinite(found)):
        raise ValueError("has no biharmonic weights; allowed: a surface without triangles that are next to nothing")
    found = np.clip(found, 0.0, 1.0)
    return np.where(found < NEGLIGIBLE, 0.0, np.where(found > 1.0 - NEGLIGIBLE, 1.0, found))


def _handle(end: np.ndarray, joint: np.ndarray, half_width: float, spacing: float) -> np.ndarray:
    """Points (k, 3) of a bone, no farther apart than `spacing`, from its end to `half_width` before the joint."""
    length = float(np.linalg.norm(joint - end))
    if not 0.0 < half_width < length:
        raise ValueError(f"blend_half_width = {half_width:.4g} m; allowed range: above 0, below a bone, {length:.4g} m")
    reach = 1.0 - half_width / length
    shares = np.linspace(0.0, reach, 2 + int(reach * length / spacing))[:, None]
    return end + shares * (joint - end)


def _cells(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes, the points first, and tetrahedra (t, 4) within the triangles."""
    try:
        import tetgen
    except ModuleNotFoundError:
        raise ModuleNotFoundError(INSTALL) from None
    mesher = tetgen.TetGen(points, triangles.astype(np.int32))
    try:
        # it leaves a file of what crosses where it is called
        with TemporaryDirectory() as folder, chdir(folder):
            nodes, cells, *_ = mesher.tetrahedralize(plc=True, quality=True, nobisect=True, minratio=SHAPE, quiet=True)
    except RuntimeError as error:
        raise ValueError(f"cannot be cut into tetrahedra: {error} Allowed: none that crosses itself") from None
    if len(nodes) < len(points) or not np.array_equal(nodes[: len(points)], points):
        raise ValueError("cannot be cut into tetrahedra that keep its vertices; allowed: no two of them at one place")
    return nodes, cells


def _edge(vertices: np.ndarray, number: int) -> str:
    ends = (vertices[k] for k in divmod(int(number), len(vertices)))
    return "the edge from ({}) to ({}) m".format(*(", ".join(f"{x:.4g}" for x in end) for end in ends))


def libigl() -> ModuleType:
    """The library; raises ModuleNotFoundError, with what installs it."""
    try:
        import igl
    except ModuleNotFoundError:
        raise ModuleNotFoundError(INSTALL) from None
    return igl
