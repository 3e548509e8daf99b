"""The flat file of a mesh that ArmSkin deforms in place of its own, `resources/mesh.bin`: see ArmSkin's README."""

import struct
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

MAGIC, FORMAT = b"UlnaSkin", 1
MOST_JOINTS, INFLUENCES = 256, 4


@dataclass(frozen=True)
class SkinMesh:
    """A mesh of n vertices and t triangles in an arm's rest frame: the bone along x, the elbow at the origin; SI."""

    vertices: np.ndarray
    """(n, 3), m."""
    normals: np.ndarray
    """(n, 3): outward, of length 1."""
    gradients: np.ndarray
    """(n, 3), 1/m: of the forearm's share in a vertex, along the skin at least."""
    weights: np.ndarray
    """(n, 4): of the influences; they sum to 1."""
    joints: np.ndarray
    """(n, 4): numbers of the influences' joints; any where the weight is 0."""
    forearm: np.ndarray
    """(j,): of each joint, true where it follows the forearm, false where it follows the upper arm."""
    triangles: np.ndarray
    """(t, 3): vertices counted from 0, counterclockwise from outside; no more than 2 n."""
    upper_arm_length: float
    forearm_length: float
    radius: float
    """Of the capsules that stand for the arm, m."""
    blend_half_width: float
    """Of the zone around the elbow in which the weights change, m: where the twist along the forearm begins."""

    @property
    def shares(self) -> np.ndarray:
        """(n,): the forearm's share in each vertex."""
        return np.sum(self.weights * self.forearm[self.joints], axis=1) / np.sum(self.weights, axis=1)


def write_mesh(path: str | PathLike, mesh: SkinMesh) -> None:
    """Writes `mesh.bin`. Raises ValueError where shapes do not fit; ArmSkin's loader checks the values."""
    count = len(mesh.vertices)
    shapes = {"vertices": 3, "normals": 3, "gradients": 3, "weights": INFLUENCES, "joints": INFLUENCES}
    for name, width in shapes.items():
        if getattr(mesh, name).shape != (count, width):
            raise ValueError(f"{name} has shape {getattr(mesh, name).shape}, not ({count}, {width})")
    if mesh.triangles.ndim != 2 or mesh.triangles.shape[1] != 3:
        raise ValueError(f"triangles has shape {mesh.triangles.shape}, not (t, 3)")
    if not 1 <= len(mesh.forearm) <= MOST_JOINTS:
        raise ValueError(f"{len(mesh.forearm)} joints; allowed range: 1 to {MOST_JOINTS}")
    lengths = mesh.upper_arm_length, mesh.forearm_length, mesh.radius, mesh.blend_half_width
    header = struct.pack("<8s4I4d8x", MAGIC, FORMAT, count, len(mesh.triangles), len(mesh.forearm), *lengths)
    joints = np.zeros(MOST_JOINTS, np.uint8)
    joints[: len(mesh.forearm)] = mesh.forearm
    rows = [np.ascontiguousarray(getattr(mesh, name).T, "<f4") for name in list(shapes)[:4]]
    rows += [np.ascontiguousarray(mesh.joints.T, np.uint8), np.ascontiguousarray(mesh.triangles, "<i4")]
    Path(path).write_bytes(header + joints.tobytes() + b"".join(row.tobytes() for row in rows))


def weight_gradients(vertices: np.ndarray, triangles: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Gradients (n, 3), 1/m, of numbers (n,) at vertices: of the linear function on each triangle, the mean by area.

    Vertices at one place, as at a seam of textures, count as one.
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    square = np.maximum(np.sum(area * area, axis=1, keepdims=True), np.finfo(float).tiny)
    slope = sum(shares[triangles[:, k]][:, None] * np.cross(area, edge) for k, edge in enumerate((c - b, a - c, b - a)))
    size = np.sqrt(square)
    _, same = np.unique(vertices, axis=0, return_inverse=True)
    same = same.ravel()
    total, sizes = np.zeros((same.max() + 1, 3)), np.zeros((same.max() + 1, 1))
    for k in range(3):
        np.add.at(total, same[triangles[:, k]], slope / square * size)
        np.add.at(sizes, same[triangles[:, k]], size)
    return (total / np.maximum(sizes, np.finfo(float).tiny))[same]
