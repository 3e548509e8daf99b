"""Triangle meshes of simple bodies, fine enough for an echo at 40 kHz: what the sensor's `surface` is fed with."""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SPACING = 2.4e-3
"""m between rings, rows, and along them: no edge, nor a diagonal, is longer than .4 wavelength, 3.4 mm."""


class TriangleMesh(NamedTuple):
    """A surface, counterclockwise from outside."""

    vertices: Array
    """[n, 3] m"""
    normals: Array
    """[n, 3], of length 1"""
    triangles: NDArray[np.int32]
    """[m, 3]"""

    @property
    def inputs(self) -> dict[str, Any]:
        """As the sensor takes it, the size first: all x, all y, all z; two triangles a vertex, the rest at vertex 0."""
        rows = np.zeros((2 * len(self.vertices), 3), np.int32)
        rows[: len(self.triangles)] = self.triangles
        return {
            "surface_vertex_count": len(self.vertices),
            "surface_vertices": self.vertices.T,
            "surface_normals": self.normals.T,
            "surface_triangles": rows.reshape(2, -1, 3),
        }

    def moved(self, offset: Array) -> "TriangleMesh":
        """The same elsewhere, by [3] m."""
        return self._replace(vertices=self.vertices + offset)

    def lit(self, ears: tuple[Array, Array]) -> int:
        """How many triangles both ears are outside of."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        normals, seen = np.cross(b - a, c - a), np.ones(len(a), bool)
        for ear in ears:
            seen &= np.sum(normals * (ear - a), axis=1) > 0
        return int(np.count_nonzero(seen))


def capsule(start: Array, end: Array, radius: float, spacing: float = SPACING) -> TriangleMesh:
    """A capsule about the axis from `start` to `end`; a sphere where they are one."""
    length = float(np.linalg.norm(end - start))
    rise = np.linspace(0.0, np.pi / 2, int(np.ceil(np.pi / 2 * radius / spacing)) + 1)
    cap = radius * np.stack([-np.cos(rise), np.sin(rise)], axis=1)
    wall = np.linspace(0.0, length, int(np.ceil(length / spacing)) + 1)[1:]
    walls = np.stack([wall, np.full(len(wall), radius)], axis=1) if length else np.empty((0, 2))
    profile = np.concatenate([cap, walls, [length, 0.0] - cap[-2::-1] * [1.0, -1.0]])
    axis = (end - start) / length if length else np.array([1.0, 0.0, 0.0])
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side /= np.linalg.norm(side)
    vertices, triangles = revolved(profile, spacing)
    normals = vertices - np.clip(vertices[:, :1], 0.0, length) * [1.0, 0.0, 0.0]
    turn = np.array([axis, side, np.cross(axis, side)])
    return TriangleMesh(start + vertices @ turn, normals @ turn / radius, triangles)


def sphere(center: Array, radius: float, spacing: float = SPACING) -> TriangleMesh:
    """A sphere."""
    return capsule(center, center, radius, spacing)


def revolved(profile: Array, spacing: float) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and triangles of a body about +x of rings (x, radius), [k, 2] m; those of no radius are one vertex."""
    counts = [max(3, int(np.ceil(2 * np.pi * r / spacing))) if r > 1e-9 else 1 for _, r in profile]
    rings, strips, first = [], [], 0
    for (x, r), count in zip(profile, counts, strict=True):
        turn = 2 * np.pi * np.arange(count) / count
        rings.append(np.stack([np.full(count, x), r * np.cos(turn), r * np.sin(turn)], axis=1))
    for near, far in pairwise(counts):
        strips.append(stitched(near, far) + first)
        first += near
    triangles = np.concatenate(strips)
    a, b, c = triangles.T
    return np.concatenate(rings), triangles[(a != b) & (b != c) & (c != a)].astype(np.int32)


def stitched(near: int, far: int) -> NDArray[np.int64]:
    """Triangles [near + far, 3] between a ring of vertices 0 to near - 1, and one of the next `far`."""
    i, j = np.arange(near), np.arange(far)
    apex = np.floor((i + 0.5) * far / near + 0.5).astype(int)
    back = np.searchsorted(apex, j, side="right")
    here = np.stack([i, (i + 1) % near, near + apex % far], axis=1)
    there = np.stack([back % near, near + (j + 1) % far, near + j], axis=1)
    return np.concatenate([here, there])


def box(center: Array, axes: Array, size: Array, spacing: float = SPACING) -> TriangleMesh:
    """A box, its axes as rows of `axes`; each face by itself."""
    faces, triangles, count = [], [], 0
    for i in range(3):
        for sign in (-1.0, 1.0):
            second, third = (i + 1) % 3, (i + 2) % 3
            face = rectangle(
                center + sign * axes[i] * size[i] / 2,
                sign * axes[second] * size[second],
                axes[third] * size[third],
                spacing,
            )
            faces.append(face)
            triangles.append(face.triangles + count)
            count += len(face.vertices)
    vertices, normals = (np.concatenate([getattr(face, name) for face in faces]) for name in ("vertices", "normals"))
    return TriangleMesh(vertices, normals, np.concatenate(triangles))


def rectangle(center: Array, first: Array, second: Array, spacing: float = SPACING) -> TriangleMesh:
    """A rectangle with two edges as vectors, seen from the side of their cross product."""
    rows, columns = (int(np.ceil(np.linalg.norm(edge) / spacing)) + 1 for edge in (first, second))
    a, b = np.meshgrid(np.linspace(-0.5, 0.5, rows), np.linspace(-0.5, 0.5, columns), indexing="ij")
    vertices = center + a.reshape(-1, 1) * first + b.reshape(-1, 1) * second
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1)
    halves = [[corner, corner + columns, corner + 1], [corner + 1, corner + columns, corner + columns + 1]]
    normal = np.cross(first, second)
    normals = np.tile(normal / np.linalg.norm(normal), (len(vertices), 1))
    return TriangleMesh(vertices, normals, np.concatenate([np.stack(h, axis=1) for h in halves]).astype(np.int32))
