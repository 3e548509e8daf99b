"""Skinning of the default arm, written a second time in NumPy and SciPy: the judge of ArmSkin."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

UPPER_ARM, FOREARM, RADIUS, HALF_WIDTH, SPOKES = 0.30, 0.40, 0.04, 0.06, 32
ELBOW = np.array([UPPER_ARM, 0.0, 0.0])
DRAW = 0.32  # how far `compensated` draws sections in, in half widths of the zone

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


def relative(upper: Rotation, fore: Rotation) -> Array:
    """Quaternion from the upper arm to the forearm, the shorter way."""
    q = wxyz(upper.inv() * fore)
    return -q if q[0] < 0 else q


def centers(weight: Array, vertex_count: int = 2048) -> Array:
    """Optimised centres of rotation along the bone [n] m at weights [n]: Le and Hodgins (2016), equation 1.

    The sum over the bands of the zone, for every weight anew: s = w (1-w) v (1-v) exp(-(w-v)^2 / sigma^2), sigma = 0.1,
    v the mean weight of a band's corners.
    """
    x, r, _ = rings(vertex_count)
    w = smoothstep(x)
    v, place = (w[1:] + w[:-1]) / 2, (x[1:] + x[:-1]) / 2
    area = (r[1:] + r[:-1]) * np.hypot(np.diff(x), np.diff(r))
    likeness = area * v * (1 - v) * np.exp(-(((weight[:, None] - v) / 0.1) ** 2))
    return likeness @ place / likeness.sum(axis=1)


def widening(q: Array) -> float:
    """How much wider the middle of the zone must be for the volume to stay: the swept volume, solved numerically."""
    nodes, mass = np.polynomial.legendre.leggauss(100)
    s, mass = (nodes + 1) / 2, mass / 2
    w, w_rate = 3 * s**2 - 2 * s**3, 6 * s * (1 - s)
    sine = np.linalg.norm(q[1:])
    axis, inward = q[1:] / sine, np.cross(q[1:], [1, 0, 0])
    # the angle is 2 atan(w sin / (1 - w + w cos)), sin and cos of half the turn
    angle_rate = 2 * sine / (1 - 2 * w * (1 - w) * (1 - q[0])) * w_rate / (2 * HALF_WIDTH)
    drawn = HALF_WIDTH * DRAW * w * (1 - w) * (1 + 3 * (1 - 2 * w) ** 2)
    # the velocity of a section's middle along its normal: 1 + angle' (axis x middle) along the bone
    gain = angle_rate * drawn * np.cross(axis, inward)[0]
    return brentq(lambda k: mass @ ((1 + 4 * k * w * (1 - w)) ** 2 * (1 + gain) - 1), 0, 0.5, xtol=1e-15)


def skinned(
    method: str, y: Array, upper: Rotation, shoulder: Array, fore: Rotation, elbow: Array, weight: Array | None = None
) -> Array:
    """Deformed points [n, 3] m of rest points y [n, 3] m from the elbow.

    Textbook forms in world coordinates: the mean of the images; Kavan et al. (2008), algorithm 1, on the dual
    quaternions q + eps t q / 2 of the two bones' motions; a turn about the elbow; Le and Hodgins (2016), algorithm 1;
    a turn about the elbow after sections were drawn in and made wider.
    """
    w = (smoothstep(y[:, 0]) if weight is None else weight)[:, None]
    if method == "rigid":
        w = (y[:, :1] >= 0).astype(float)

    def mean_image(v: Array) -> Array:
        return (1 - w) * (upper.apply(v + ELBOW) + shoulder) + w * (fore.apply(v) + elbow)

    if method in ("rigid", "linear_blend"):
        return mean_image(y)
    p, q = wxyz(upper), wxyz(fore)
    q = -q if p @ q < 0 else q
    b = (1 - w) * p + w * q
    norm = np.linalg.norm(b, axis=1, keepdims=True)
    b = b / norm

    def turned(v: Array) -> Array:
        return v + 2 * np.cross(b[:, 1:], np.cross(b[:, 1:], v) + b[:, :1] * v)

    if method == "hinge":
        return turned(y) + mean_image(0 * y)
    if method == "center_of_rotation":
        center = centers(w[:, 0])[:, None] * [1.0, 0.0, 0.0]
        return turned(y - center) + mean_image(center)
    if method == "compensated":
        t = relative(upper, fore)
        inward = HALF_WIDTH * DRAW * w * (1 - w) * (1 + 3 * (1 - 2 * w) ** 2) * np.cross(t[1:], [1.0, 0.0, 0.0])
        wider = (1 + 4 * widening(t) * w * (1 - w)) * [0.0, 1.0, 1.0] + [1.0, 0.0, 0.0]
        return turned(wider * y + inward) + mean_image(0 * y)
    dual_p = 0.5 * multiply(np.append(0.0, shoulder), p)
    dual_q = 0.5 * multiply(np.append(0.0, elbow - fore.apply(ELBOW)), q)
    d = ((1 - w) * dual_p + w * dual_q) / norm
    return turned(y + ELBOW) + 2 * (b[:, :1] * d[:, 1:] - d[:, :1] * b[:, 1:] + np.cross(b[:, 1:], d[:, 1:]))


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
