"""Triangle meshes of capsules, spheres, boxes and rectangles, counterclockwise from outside, with normals."""

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
    return Mesh(start + vertices, normals, ring_triangles(rings, around))


def ring_triangles(rings: int, around: int) -> NDArray[np.int32]:
    """Between two poles, the first vertex and the last, and the rings in between: [2 rings around, 3]."""
    last = rings * around + 1
    here, ring = np.arange(around), np.arange(rings - 1)[:, None]
    after, turned = (here + 1) % around, ring % 2 == 1
    a, b, c, d = (1 + r * around + i for r in (ring, ring + 1) for i in (here, after))
    strips = [(a, np.where(turned, d, b), c), (np.where(turned, a, b), np.where(turned, b, d), np.where(turned, d, c))]
    poles = [
        (np.full(around, 0), 1 + after, 1 + here),
        (np.full(around, last), last - around + here, last - around + after),
    ]
    return np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in poles + strips]).astype(np.int32)


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


def box_mesh(center: Array, axes: Array, size: Array, edge: float) -> Mesh:
    """A box, its axes as rows of `axes`, its edges as in `size`; each face by itself."""
    edges = axes * np.reshape(size, (3, 1))
    faces = []
    for i in range(3):
        for sign in (-1.0, 1.0):
            sides = sign * edges[(i + 1) % 3], edges[(i + 2) % 3]
            faces.append(plate_mesh(center + sign * edges[i] / 2, sides, edge))
    return joined(*faces)


def joined(*meshes: Mesh) -> Mesh:
    """Several as one."""
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, first, strict=False)]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate(triangles).astype(np.int32),
    )
