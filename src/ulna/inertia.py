"""Mass, centre and principal inertia of simple solids and of closed triangle meshes, all of one density.

Everything follows from the matrix of second moments about the centre, S = integral of density r r^T dV, kg m2. The
inertia tensor is trace(S) 1 - S, so the principal axes are those of S, and each principal moment is the sum of the two
other eigenvalues of S: no moment can exceed the other two together, whatever the shape.

What the class notes miss. Their "integral of m r^2", and "of m |r|", are single numbers, but a body resists a turn
about each axis differently. A box of 1 x 2 x 3 m that weighs 6000 kg:

>>> brick = box((1.0, 2.0, 3.0), density=1000.0)
>>> [round(float(moment), 6) for moment in brick.moments]
[2500.0, 5000.0, 6500.0]

The integral of density |r|^2 dV is 7000 kg m2, more than any of these: it is trace(S), half the sum of the moments,
8 % to 180 % too much. The integral of density |r| dV is 6106 kg m and no inertia at all: at twice the size the moments
are 32 times as large (mass 8, squares 4), and it only 16 times. Neither has a cross term, hence no principal axes.

Source of the moments of a mesh: the divergence theorem as signed tetrahedra from the centre to every triangle; Blow and
Binstock, "How to find the inertia tensor (or other mass properties) of a 3D solid body represented by a triangle mesh"
(2004); Mirtich, "Fast and accurate computation of polyhedral mass properties", J. Graphics Tools 1:31 (1996).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Proper signs of three axes: what is left to choose once their lines are known.
SIGNS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])


@dataclass(frozen=True, eq=False)
class Inertia:
    """Mass and its distribution; the arrays cannot be written to.

    `moments` and the frame of `orientation` are what RigidBody calls `inertia` and body axes. Where moments are equal
    their axes are any in that plane, or in space.
    """

    mass: float
    """kg"""
    center: Array
    """Centre of mass, [3], m, in the axes of the shape."""
    moments: Array
    """Principal moments about the centre, [3], kg m2, ascending."""
    orientation: Array
    """Unit quaternion w, x, y, z, [4], principal axes to those of the shape: right-handed, the least turn, w >= 0."""

    def tensor(self, about: ArrayLike | None = None) -> Array:
        """Inertia tensor, [3, 3], kg m2, in the axes of the shape, about its centre or the point `about` ([3], m)."""
        axes = _matrix(self.orientation)
        tensor = axes * self.moments @ axes.T
        if about is None:
            return tensor
        lever = np.asarray(about, float) - self.center
        return tensor + self.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))


def box(size: Sequence[float], density: float) -> Inertia:
    """A box of edges `size`, [3], m, along x, y, z about the origin; `density` kg/m3.

    S = m/12 diag(x^2, y^2, z^2). Raises ValueError for what is not positive and finite.
    """
    if np.shape(size) != (3,):
        raise ValueError(f"size: three edges (m) are needed, not shape {np.shape(size)}")
    for name, edge in zip(("size[0]", "size[1]", "size[2]"), size, strict=True):
        _check_positive(name, edge, "m")
    _check_positive("density", density, "kg/m3")
    edges = np.asarray(size, float)
    mass = density * edges.prod()
    return _solid(mass, np.zeros(3), np.diag(mass / 12 * edges**2))


def sphere(radius: float, density: float) -> Inertia:
    """A ball of `radius` m about the origin; `density` kg/m3.

    S = m/5 r^2 1. Raises ValueError for what is not positive and finite.
    """
    return capsule(radius, 0.0, density)


def cylinder(radius: float, length: float, density: float) -> Inertia:
    """A cylinder of `radius` and `length` m along z about the origin; `density` kg/m3.

    S = m diag(r^2/4, r^2/4, length^2/12). Raises ValueError for what is not positive and finite.
    """
    _check_positive("radius", radius, "m")
    _check_positive("length", length, "m")
    _check_positive("density", density, "kg/m3")
    mass = density * math.pi * radius**2 * length
    across = mass * radius**2 / 4
    return _solid(mass, np.zeros(3), np.diag([across, across, mass * length**2 / 12]))


def capsule(radius: float, length: float, density: float) -> Inertia:
    """A cylinder of `radius` and `length` m along z about the origin, and a half ball on each end; `density` kg/m3.

    `length` is that of the cylinder alone, and may be 0. With masses c of the cylinder and b of both half balls
    S_xx = S_yy = c r^2/4 + b r^2/5 and S_zz = c length^2/12 + b (length^2/4 + 3/8 length r + r^2/5): the half balls are
    shifted by length/2. Raises ValueError for what is not positive and finite.
    """
    _check_positive("radius", radius, "m")
    _check_positive("density", density, "kg/m3")
    if not (math.isfinite(length) and length >= 0.0):
        raise ValueError(f"length = {length} m: it must be finite and at least 0")
    middle = density * math.pi * radius**2 * length
    ends = density * 4 / 3 * math.pi * radius**3
    across = middle * radius**2 / 4 + ends * radius**2 / 5
    along = middle * length**2 / 12 + ends * (length**2 / 4 + 3 / 8 * length * radius + radius**2 / 5)
    return _solid(middle + ends, np.zeros(3), np.diag([across, across, along]))


def mesh(vertices: ArrayLike, triangles: ArrayLike, density: float) -> Inertia:
    """The solid inside a closed mesh: `vertices`, [n, 3], m; `triangles`, [m, 3], indices; `density` kg/m3.

    Corners run counterclockwise seen from outside; a cavity is a shell that runs the other way round. Exact for the
    polyhedron up to round-off. Raises ValueError that names the edge, triangle or vertex where the mesh is not closed
    or not oriented, and for an inside-out mesh. Shells that cut through one another are not noticed: their overlap
    counts twice.
    """
    vertices = np.asarray(vertices, float)
    triangles = np.asarray(triangles)
    _check_positive("density", density, "kg/m3")
    _check_arrays(vertices, triangles)
    _check_closed(triangles)
    corners = vertices[triangles]
    # from the middle, so that a far origin costs no digits
    middle = (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1))) / 2
    corners = corners - middle
    volumes = _tetrahedra(corners)
    volume = volumes.sum()
    if abs(volume) <= 1e-15 * np.ptp(corners, axis=(0, 1)).max() ** 3:
        raise ValueError("the mesh encloses no volume")
    if volume < 0.0:
        raise ValueError(
            f"the mesh is inside out (its volume is {volume:g} m3): corners must run counterclockwise "
            "seen from outside; swap two corners of every triangle"
        )
    center = volumes @ corners.sum(axis=1) / (4 * volume)
    corners = corners - center
    sums = corners.sum(axis=1)
    # over a tetrahedron with one corner at the origin: V/20 (s s^T + sum of p p^T), s the sum of the corners p
    shares = density * _tetrahedra(corners) / 20
    second = np.einsum("t,ti,tj->ij", shares, sums, sums) + np.einsum("t,tci,tcj->ij", shares, corners, corners)
    return _solid(density * volume, middle + center, second)


def _tetrahedra(corners: Array) -> Array:
    """Signed volumes, [m], m3, of the tetrahedra from the origin to triangles, [m, 3, 3], m."""
    return np.einsum("ti,ti->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6


def _solid(mass: float, center: Array, second: Array) -> Inertia:
    """From the second moments about the centre, [3, 3], kg m2, in the axes of the shape."""
    # of -S, for descending order: the least moment has the greatest S, and equal ones keep their order
    values, axes = np.linalg.eigh(-second)
    values = -values
    axes = axes * np.sign(np.linalg.det(axes))
    axes = axes * SIGNS[np.argmax(SIGNS @ np.diag(axes))]
    arrays = np.array(center), np.array([values[1] + values[2], values[0] + values[2], values[0] + values[1]])
    result = Inertia(float(mass), *arrays, _quaternion(axes))
    for array in (result.center, result.moments, result.orientation):
        array.setflags(write=False)
    return result


def _matrix(q: Array) -> Array:
    """Rotation matrix, [3, 3], of a unit quaternion w, x, y, z."""
    cross = np.array([[0.0, -q[3], q[2]], [q[3], 0.0, -q[1]], [-q[2], q[1], 0.0]])
    return np.eye(3) + 2 * q[0] * cross + 2 * cross @ cross


def _quaternion(matrix: Array) -> Array:
    """Unit quaternion w, x, y, z, w >= 0, of a rotation matrix, [3, 3].

    The eigenvector of the greatest eigenvalue of Bar-Itzhack's symmetric matrix (J. Guidance 23:1085, 2000): there is
    no angle at which it loses digits.
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix
    symmetric = np.array(
        [
            [a + e + i, h - f, c - g, d - b],
            [h - f, a - e - i, b + d, c + g],
            [c - g, b + d, e - a - i, f + h],
            [d - b, c + g, f + h, i - a - e],
        ]
    )
    q = np.linalg.eigh(symmetric)[1][:, -1]
    return (q if q[0] >= 0.0 else -q) + 0.0  # no negative zeros


def _check_positive(name: str, value: float, unit: str) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name} = {value} {unit}: it must be finite and more than 0")


def _check_arrays(vertices: Array, triangles: NDArray) -> None:
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError(f"vertices: the shape must be (n, 3), not {vertices.shape}")
    if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu" or not len(triangles):
        raise ValueError(
            f"triangles: whole numbers of shape (m, 3) are needed, not {triangles.dtype} {triangles.shape}"
        )
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if bad.size:
        raise ValueError(f"vertex {bad[0]} is not finite: {vertices[bad[0]]}")
    bad = np.flatnonzero(((triangles < 0) | (triangles >= len(vertices))).any(axis=1))
    if bad.size:
        raise ValueError(
            f"triangle {bad[0]} is {triangles[bad[0]].tolist()}, but vertices are 0 to {len(vertices) - 1}"
        )
    bad = np.flatnonzero((triangles == np.roll(triangles, 1, axis=1)).any(axis=1))
    if bad.size:
        raise ValueError(f"triangle {bad[0]} has a corner twice: {triangles[bad[0]].tolist()}")


def _check_closed(triangles: NDArray) -> None:
    """Every edge must be run along as often one way as the other; then the surface has no boundary."""
    starts, ends = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    edges = np.stack([np.minimum(starts, ends), np.maximum(starts, ends)], axis=1)
    unique, of_edge = np.unique(edges, axis=0, return_inverse=True)
    of_edge = of_edge.reshape(-1)
    balance = np.bincount(of_edge, weights=np.where(starts < ends, 1.0, -1.0))
    bad = np.flatnonzero(balance)
    if not bad.size:
        return
    first, last = unique[bad[0]].tolist()
    owners = (np.flatnonzero(of_edge == bad[0]) // 3).tolist()
    if len(owners) == 1:
        raise ValueError(
            f"the mesh is not closed: only triangle {owners[0]} has the edge of vertices {first} and {last} "
            f"({bad.size} such edges); close the hole, or merge vertices that lie at the same place"
        )
    if len(owners) % 2:
        raise ValueError(f"the mesh is not closed: triangles {owners} share the edge of vertices {first} and {last}")
    raise ValueError(
        f"the mesh is not oriented: triangles {owners} run the same way along the edge of vertices {first} and {last}; "
        "swap two corners of those that are turned round"
    )
