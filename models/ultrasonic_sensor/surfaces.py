"""Surfaces in small cells, for the Kirchhoff integral of `echoes`: points [m, 3], normals [m, 3] and areas [m], SI."""

import numpy as np

from .hearing import Array


def grid(first: Array, second: Array) -> tuple[Array, Array, float]:
    """Midpoints of a grid between evenly spaced edges, and the area of a cell in the two parameters."""
    a, b = ((edges[1:] + edges[:-1]) / 2 for edges in (first, second))
    A, B = np.meshgrid(a, b, indexing="ij")
    return A.ravel(), B.ravel(), float((first[1] - first[0]) * (second[1] - second[0]))


def capsule_surface(start: Array, end: Array, radius: float, pitch: float = 0.0012) -> tuple[Array, Array, Array]:
    """Points, normals and areas of a capsule, cells about `pitch` m wide."""
    whole = end - start
    length = np.linalg.norm(whole)
    axis = whole / length
    side = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.9 else [0, 1.0, 0])
    side /= np.linalg.norm(side)
    up = np.cross(axis, side)
    turns = np.linspace(0, 2 * np.pi, int(2 * np.pi * radius / pitch) + 2)
    along, angle, cell = grid(np.linspace(0, length, int(length / pitch) + 2), turns)
    normal = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up
    parts = [(start + along[:, None] * axis + radius * normal, normal, np.full(along.size, cell * radius))]
    for center, out in ((start, -axis), (end, axis)):
        rise, angle, cell = grid(np.linspace(0, np.pi / 2, int(np.pi / 2 * radius / pitch) + 2), turns)
        flat = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up
        normal = np.sin(rise)[:, None] * out + np.cos(rise)[:, None] * flat
        parts.append((center + radius * normal, normal, radius**2 * np.cos(rise) * cell))
    return tuple(np.concatenate(part) for part in zip(*parts, strict=True))


def rectangle_surface(
    center: Array, normal: Array, sides: tuple[Array, Array], pitch: float = 0.0012
) -> tuple[Array, Array, Array]:
    """Points, normals and areas of a rectangle; `sides` are its two edges as vectors."""
    counts = [int(np.linalg.norm(side) / pitch) + 2 for side in sides]
    a, b, cell = grid(*[np.linspace(-0.5, 0.5, count) for count in counts])
    points = center + a[:, None] * sides[0] + b[:, None] * sides[1]
    area = cell * np.linalg.norm(np.cross(*sides))
    return points, np.tile(normal, (a.size, 1)), np.full(a.size, area)


def box_surface(
    center: Array, axes: Array, size: Array, ears: tuple[Array, Array], pitch: float = 0.0012
) -> tuple[Array, Array, Array]:
    """The faces of a box, axes as rows of `axes`, that both ears see."""
    parts = []
    for i in range(3):
        for sign in (-1.0, 1.0):
            normal = sign * axes[i]
            middle = center + normal * size[i] / 2
            if all(np.dot(ear - middle, normal) > 0 for ear in ears):
                others = tuple(axes[j] * size[j] for j in range(3) if j != i)
                parts.append(rectangle_surface(middle, normal, others, pitch))
    return tuple(np.concatenate(part) for part in zip(*parts, strict=True))
