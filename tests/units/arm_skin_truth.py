"""Skinning of the default arm, written a second time in NumPy and SciPy: the judge of ArmSkin."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

UPPER_ARM, FOREARM, RADIUS, HALF_WIDTH, SPOKES = 0.30, 0.40, 0.04, 0.06, 32
ELBOW = np.array([UPPER_ARM, 0.0, 0.0])

GENERAL = {
    "upper": Rotation.from_rotvec([0.3, -0.5, 0.8]),
    "shoulder": np.array([0.05, -0.10, 0.02]),
    "fore": Rotation.from_rotvec([0.3, -0.5, 0.8]) * Rotation.from_rotvec([0.6, 1.1, -0.2]),
    "elbow": np.array([0.05, -0.10, 0.02]) + Rotation.from_rotvec([0.3, -0.5, 0.8]).apply(ELBOW) + [0.004, 0.0, -0.003],
}
"""A pose without symmetry: both bones turned, and their elbows 5 mm apart."""


def wxyz(rotation: Rotation) -> Array:
    """Quaternion w, x, y, z of a rotation."""
    return np.roll(rotation.as_quat(), 1)


def about(axis: str, degrees: float) -> Rotation:
    """Rotation about one axis; the bones lie along x, so x twists and y flexes."""
    return Rotation.from_euler(axis, degrees, degrees=True)


def rings(vertex_count: int) -> tuple[Array, Array, Array]:
    """Rest rings as the unit's README places them: from the elbow [n] m, radius [n] m, normal along x [n]."""
    count = vertex_count // SPOKES
    end, half_zone = count // 10, count // 4
    straight = count - 1 - 2 * end - 2 * half_zone
    free = np.array([UPPER_ARM, FOREARM]) - RADIUS - HALF_WIDTH
    upper = 1 + int(np.floor((straight - 2) * free[0] / free.sum() + 0.5))
    angle = np.pi / 2 * (np.arange(end) + 0.5) / (end + 0.5)
    left, right = RADIUS - UPPER_ARM, FOREARM - RADIUS
    x = np.concatenate(
        [
            left - RADIUS * np.cos(angle),
            np.linspace(left, -HALF_WIDTH, upper + 1)[:-1],
            np.linspace(-HALF_WIDTH, HALF_WIDTH, 2 * half_zone + 1),
            np.linspace(HALF_WIDTH, right, straight - upper + 1)[1:],
            right + RADIUS * np.cos(angle[::-1]),
        ]
    )
    tube = np.ones(count - 2 * end)
    radius = RADIUS * np.concatenate([np.sin(angle), tube, np.sin(angle[::-1])])
    normal_x = np.concatenate([-np.cos(angle), 0 * tube, np.cos(angle[::-1])])
    return x, radius, normal_x


def rest_mesh(vertex_count: int = 2048) -> tuple[Array, Array]:
    """Rest vertices from the elbow [n, 3] m and their unit normals [n, 3], in float64."""
    x, radius, normal_x = rings(vertex_count)
    angle = 2 * np.pi * np.arange(SPOKES) / SPOKES
    around = np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=-1)
    along = np.array([1.0, 0.0, 0.0])
    vertices = x[:, None, None] * along + radius[:, None, None] * around
    normals = normal_x[:, None, None] * along + np.sqrt(1 - normal_x**2)[:, None, None] * around
    return vertices.reshape(-1, 3), normals.reshape(-1, 3)


def smoothstep(x: Array) -> Array:
    """Weight of the forearm at a distance x from the elbow along the bone, m."""
    s = np.clip((x + HALF_WIDTH) / (2 * HALF_WIDTH), 0, 1)
    return 3 * s**2 - 2 * s**3


def multiply(a: Array, b: Array) -> Array:
    """Hamilton products [n, 4] of quaternions w, x, y, z."""
    real = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], axis=-1, keepdims=True)
    imaginary = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([real, imaginary], axis=-1)


def skinned(
    method: str, y: Array, upper: Rotation, shoulder: Array, fore: Rotation, elbow: Array, weight: Array | None = None
) -> Array:
    """Deformed points [n, 3] m of rest points y [n, 3] m from the elbow.

    Textbook forms in world coordinates: the mean of the images; Kavan et al. (2008), algorithm 1, on the dual
    quaternions q + eps t q / 2 of the two bones' motions.
    """
    w = (smoothstep(y[:, 0]) if weight is None else weight)[:, None]
    if method == "rigid":
        w = (y[:, :1] >= 0).astype(float)
    if method != "dual_quaternion":
        return (1 - w) * (upper.apply(y + ELBOW) + shoulder) + w * (fore.apply(y) + elbow)
    p, q = wxyz(upper), wxyz(fore)
    q = -q if p @ q < 0 else q
    dual_p = 0.5 * multiply(np.append(0.0, shoulder), p)
    dual_q = 0.5 * multiply(np.append(0.0, elbow - fore.apply(ELBOW)), q)
    b, d = (1 - w) * p + w * q, (1 - w) * dual_p + w * dual_q
    norm = np.linalg.norm(b, axis=1, keepdims=True)
    b, d = b / norm, d / norm
    v = y + ELBOW
    turned = v + 2 * np.cross(b[:, 1:], np.cross(b[:, 1:], v) + b[:, :1] * v)
    return turned + 2 * (b[:, :1] * d[:, 1:] - d[:, :1] * b[:, 1:] + np.cross(b[:, 1:], d[:, 1:]))


def bone_distance(points: Array, hand: Array) -> Array:
    """Distance [n] m of points [n, 3] m to the two bones' segments: shoulder, elbow, hand."""
    distances = []
    for start, end in ((np.zeros(3), ELBOW), (ELBOW, hand)):
        axis = end - start
        share = np.clip((points - start) @ axis / (axis @ axis), 0, 1)
        distances.append(np.linalg.norm(points - start - share[:, None] * axis, axis=1))
    return np.minimum(*distances)


def six_volumes(points: Array, triangles: NDArray[np.int32]) -> Array:
    """Six times the signed volume of the tetrahedron of each triangle and the origin, m3."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c))
