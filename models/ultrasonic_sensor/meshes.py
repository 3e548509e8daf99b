"""Closed triangle meshes of round bodies: vertices [n, 3] in m, unit normals [n, 3], triangles [m, 3], counterclockwise
from outside."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .hearing import Array


@dataclass(frozen=True)
class Mesh:
    """Vertices [n, 3] in m, their unit normals [n, 3], and the triangles' vertices [m, 3] counted from 0."""

    vertices: Array
    normals: Array
    triangles: NDArray[np.int32]

    @property
    def longest_edge(self) -> float:
        """In m."""
        corners = self.vertices[self.triangles]
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())

    def inputs(self, normals: bool = True) -> dict[str, object]:
        """As UltrasonicSensor takes it, the size first; without its normals the triangles are flat."""
        count = len(self.vertices)
        rows = np.zeros((2 * count, 3), np.int32)
        rows[: len(self.triangles)] = self.triangles
        return {
            "surface_vertex_count": count,
            "surface_vertices": self.vertices.T,
            "surface_triangles": rows.reshape(2, count, 3),
            "surface_normals": self.normals.T if normals else np.zeros((3, count)),
        }


def rings_mesh(start: Array, axis: Array, profile: Array, centers: Array, around: int) -> Mesh:
    """A body of revolution: rings of `around` vertices, every other one turned by half a place, between two poles.

    `profile` [k, 2] are places along the axis and radii, the poles first and last, `centers` [k] where on the axis the
    normals come from, all in m; `axis` is a unit vector.
    """
    side = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.9 else [0, 1.0, 0])
    side /= np.linalg.norm(side)
    rings = len(profile) - 2
    turn = 2 * np.pi * (np.arange(around) + 0.5 * (np.arange(rings)[:, None] % 2)) / around
    out = np.cos(turn)[..., None] * side + np.sin(turn)[..., None] * np.cross(axis, side)
    places = profile[1:-1, 0, None, None] * axis + profile[1:-1, 1, None, None] * out
    vertices = np.concatenate([[profile[0, 0] * axis], places.reshape(-1, 3), [profile[-1, 0] * axis]])
    counts = [1, *[around] * rings, 1]
    normals = vertices - np.repeat(centers, counts)[:, None] * axis
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return Mesh(start + vertices, normals, np.array(ring_triangles(rings, around), np.int32))


def ring_triangles(rings: int, around: int) -> list[tuple[int, int, int]]:
    """Between two poles, the first vertex and the last, and the rings in between."""
    last = rings * around + 1
    rows = []
    for j in range(around):
        after = (j + 1) % around
        rows += [(0, 1 + after, 1 + j), (last, last - around + j, last - around + after)]
        for ring in range(rings - 1):
            a, b, c, d = (1 + r * around + i for r in (ring, ring + 1) for i in (j, after))
            rows += [(a, b, c), (b, d, c)] if ring % 2 == 0 else [(a, d, c), (a, b, d)]
    return rows


def capsule_mesh(start: Array, end: Array, radius: float, edge: float) -> Mesh:
    """A capsule, or with start = end a sphere; edges about `edge` m long, none longer than 1.03 of it."""
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / length if length > 0 else np.array([0.0, 0.0, 1.0])
    step = edge * np.sqrt(3) / 2
    around = int(np.ceil(2 * np.pi * radius / edge))
    rise = np.linspace(0, np.pi / 2, int(np.ceil(np.pi / 2 * radius / step)) + 1)
    wall = np.linspace(0, length, int(np.ceil(length / step)) + 1)[1:-1] if length > 0 else np.zeros(0)
    first = np.stack([-radius * np.cos(rise), radius * np.sin(rise)], axis=1)
    last = first[::-1] * [-1, 1] + [length, 0]
    middle = np.stack([wall, np.full(wall.size, radius)], axis=1)
    profile = np.concatenate([first, middle, last if length > 0 else last[1:]])
    return rings_mesh(start, axis, profile, np.clip(profile[:, 0], 0, length), around)


def plate_mesh(center: Array, sides: tuple[Array, Array], edge: float) -> Mesh:
    """A rectangle, one face of it; `sides` are its edges as vectors, the first crossed with the second its normal."""
    counts = [int(np.ceil(np.linalg.norm(side) / edge)) for side in sides]
    a, b = (np.linspace(-0.5, 0.5, count + 1) for count in counts)
    A, B = np.meshgrid(a, b, indexing="ij")
    vertices = center + A.reshape(-1, 1) * sides[0] + B.reshape(-1, 1) * sides[1]
    i, j = (places.ravel() for places in np.meshgrid(*map(np.arange, counts), indexing="ij"))
    corner = i * (counts[1] + 1) + j
    over = corner + counts[1] + 1
    triangles = np.concatenate([np.stack([corner, over, corner + 1], 1), np.stack([corner + 1, over, over + 1], 1)])
    normal = np.cross(*sides)
    normals = np.tile(normal / np.linalg.norm(normal), (len(vertices), 1))
    return Mesh(vertices, normals, triangles.astype(np.int32))
