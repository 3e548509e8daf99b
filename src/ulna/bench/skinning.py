"""The skin of the default arm in float64, from the textbooks: what ArmSkin's vertices and normals are measured against.

All is analytic in the rest points, so complex ones carry a derivative (Squire and Trapp, SIAM Review 40 (1), 1998).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

UPPER_ARM, FOREARM, RADIUS, HALF_WIDTH, SPOKES = 0.30, 0.40, 0.04, 0.06, 32  # m; vertices a ring
ELBOW = np.array([UPPER_ARM, 0.0, 0.0])
ON_THE_ELBOW = 1e-12  # m; a ring there may be placed with a rounding


@dataclass(frozen=True)
class Pose:
    """Quaternions w, x, y, z of the two bones, and where shoulder and elbow are, m."""

    upper: Array
    shoulder: Array
    fore: Array
    elbow: Array

    @property
    def nearer_fore(self) -> Array:
        """The forearm's quaternion, of the sign nearer to the upper arm's."""
        return self.fore if self.upper @ self.fore >= 0 else -self.fore


def about(axis: list[float], degrees: float) -> Array:
    """Quaternion of the turn about an axis of any length."""
    half = np.radians(degrees) / 2
    return np.append(np.cos(half), np.sin(half) * np.divide(axis, np.linalg.norm(axis)))


def product(a: NDArray, b: NDArray) -> NDArray:
    """Hamilton products of quaternions [..., 4]."""
    scalar = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], axis=-1, keepdims=True)
    return np.concatenate(
        [scalar, a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])], axis=-1
    )


def turned(q: NDArray, v: NDArray) -> NDArray:
    """Vectors [n, 3] turned by unit quaternions [..., 4]."""
    return v + 2 * np.cross(q[..., 1:], np.cross(q[..., 1:], v) + q[..., :1] * v)


def rest_mesh(vertex_count: int) -> tuple[Array, Array]:
    """Rest points [n, 3] m from the elbow, placed as in ArmSkin's README, and two tangents of the surface [2, n, 3]."""
    count = vertex_count // SPOKES
    end, half_zone = count // 10, count // 4
    straight = count - 1 - 2 * end - 2 * half_zone
    free = np.array([UPPER_ARM, FOREARM]) - RADIUS - HALF_WIDTH
    upper = 1 + int((straight - 2) * free[0] / free.sum() + 0.5)
    polar = np.pi / 2 * (np.arange(end) + 0.5) / (end + 0.5)
    ends = (RADIUS - UPPER_ARM, FOREARM - RADIUS)
    tube = [
        np.linspace(ends[0], -HALF_WIDTH, upper + 1)[:-1],
        np.linspace(-HALF_WIDTH, HALF_WIDTH, 2 * half_zone + 1),
        np.linspace(HALF_WIDTH, ends[1], straight - upper + 1)[1:],
    ]
    x = np.concatenate([ends[0] - RADIUS * np.cos(polar), *tube, ends[1] + RADIUS * np.cos(polar[::-1])])
    flat = np.ones(count - 2 * end)
    sine = np.concatenate([np.sin(polar), flat, np.sin(polar[::-1])])
    cosine = np.concatenate([-np.cos(polar), 0 * flat, np.cos(polar[::-1])])
    angle = 2 * np.pi * np.arange(SPOKES) / SPOKES
    along = np.array([1.0, 0.0, 0.0])
    outward = np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([0 * angle, -np.sin(angle), np.cos(angle)], axis=1)
    x, sine, cosine = (values[:, None, None] for values in (x, sine, cosine))
    points = x * along + RADIUS * sine * outward
    tangents = np.stack([0 * x + across, sine * along - cosine * outward])  # their cross product points outward
    return points.reshape(-1, 3), tangents.reshape(2, -1, 3)


def skinned(method: str, points: NDArray, pose: Pose) -> NDArray:
    """Deformed points [n, 3] m of rest points [n, 3] m from the elbow; raises KeyError for an unknown method.

    Linear blend: Magnenat-Thalmann et al. (1988). Dual quaternions: Kavan et al. (2008), algorithm 1. Centres of
    rotation: Le and Hodgins (2016).
    """
    return METHODS[method](points, pose)


def smoothstep(points: NDArray) -> NDArray:
    """Weight [n, 1] of the forearm."""
    x = points[:, :1]
    s = np.where(np.abs(x.real) < HALF_WIDTH, (x + HALF_WIDTH) / (2 * HALF_WIDTH), x.real > 0)
    return 3 * s**2 - 2 * s**3


def mean_image(points: NDArray, pose: Pose, weight: NDArray) -> NDArray:
    """The mean of the images by the two bones."""
    images = turned(pose.upper, points + ELBOW) + pose.shoulder, turned(pose.fore, points) + pose.elbow
    return (1 - weight) * images[0] + weight * images[1]


def rigid(points: NDArray, pose: Pose) -> NDArray:
    """The image by the nearer bone."""
    return mean_image(points, pose, np.where(points[:, :1].real >= -ON_THE_ELBOW, 1.0, 0.0))


def linear_blend(points: NDArray, pose: Pose) -> NDArray:
    """The mean of the two images, by the weight."""
    return mean_image(points, pose, smoothstep(points))


def mean_turn(points: NDArray, pose: Pose) -> tuple[NDArray, NDArray]:
    """Weight [n, 1], and the mean [n, 4] of the bones' quaternions, of unit length."""
    weight = smoothstep(points)
    real = (1 - weight) * pose.upper + weight * pose.nearer_fore
    return weight, real / np.sqrt(np.sum(real * real, axis=1, keepdims=True))


def hinge(points: NDArray, pose: Pose) -> NDArray:
    """Turned about the elbow, which is carried to the mean of its images."""
    weight, turn = mean_turn(points, pose)
    return turned(turn, points) + mean_image(0 * points, pose, weight)


def dual_quaternion(points: NDArray, pose: Pose) -> NDArray:
    """The image by the normalised mean of the two motions, each q + eps t q / 2 with the world's translation t."""
    weight = smoothstep(points)
    p, q = pose.upper, pose.nearer_fore
    moves = pose.shoulder, pose.elbow - turned(pose.fore, ELBOW)
    duals = [product(np.append(0.0, move), r) / 2 for move, r in zip(moves, (p, q), strict=True)]
    real, dual = (1 - weight) * p + weight * q, (1 - weight) * duals[0] + weight * duals[1]
    square = np.sum(real * real, axis=1, keepdims=True)
    conjugate = np.concatenate([real[:, :1], -real[:, 1:]], axis=1)
    return turned(real / np.sqrt(square), points + ELBOW) + 2 * product(dual, conjugate)[:, 1:] / square


def rotation_center(points: NDArray, weight: NDArray) -> NDArray:
    """Optimised centres [n, 3] on the bone: Le and Hodgins (2016), equation 1, over the bands of the points' rings."""
    x = points[::SPOKES, :1].real
    x = x[np.abs(x) < HALF_WIDTH * (1 + ON_THE_ELBOW)][:, None]
    w = smoothstep(x)
    other, place, length = (w[1:] + w[:-1]).T / 2, (x[1:] + x[:-1]) / 2, np.diff(x, axis=0).T
    center = np.zeros_like(points)
    for rows in np.array_split(np.arange(len(points)), 1 + len(points) // 1000):
        likeness = length * other * (1 - other) * np.exp(-(((weight[rows] - other) / 0.1) ** 2))
        center[rows, :1] = likeness @ place / likeness.sum(axis=1, keepdims=True)
    return center


def center_of_rotation(points: NDArray, pose: Pose) -> NDArray:
    """Turned about a centre that is carried to the mean of its images: Le and Hodgins (2016), algorithm 1."""
    weight, turn = mean_turn(points, pose)
    center = rotation_center(points, weight)
    return turned(turn, points - center) + mean_image(center, pose, weight)


def compensated(points: NDArray, pose: Pose) -> NDArray:
    """As `hinge`, after sections are drawn in and made wider, so that the zone's swept volume stays."""
    weight, turn = mean_turn(points, pose)
    relative = product(pose.upper * [1, -1, -1, -1], pose.nearer_fore)
    inward = np.cross(relative[1:], [1.0, 0.0, 0.0])
    nodes, mass = np.polynomial.legendre.leggauss(100)
    s, mass = (nodes + 1) / 2, mass / 2
    w = 3 * s**2 - 2 * s**3
    lost = draw(w) * 6 * s * (1 - s) * (inward @ inward) / (1 - 2 * w * (1 - w) * (1 - relative[0]))
    share = 4 * w * (1 - w)
    square, linear = mass @ (share**2 * (1 - lost)), mass @ (share * (1 - lost))
    widening = (np.sqrt(linear**2 + square * (mass @ lost)) - linear) / square
    wider = (1 + 4 * widening * weight * (1 - weight)) * np.array([0.0, 1.0, 1.0]) + [1.0, 0.0, 0.0]
    return turned(turn, wider * points + HALF_WIDTH * draw(weight) * inward) + mean_image(0 * points, pose, weight)


def draw(weight: NDArray) -> NDArray:
    """How far sections are drawn in, in half widths of the zone."""
    return 0.32 * weight * (1 - weight) * (1 + 3 * (1 - 2 * weight) ** 2)


METHODS = {
    "rigid": rigid,
    "linear_blend": linear_blend,
    "hinge": hinge,
    "dual_quaternion": dual_quaternion,
    "center_of_rotation": center_of_rotation,
    "compensated": compensated,
}


def normals(method: str, points: Array, tangents: Array, pose: Pose) -> Array:
    """Unit normals [n, 3] of the deformed surface: the cross product of the tangents' images, by the complex step."""
    reach = 1e-30
    images = [skinned(method, points + 1j * reach * t, pose).imag / reach for t in tangents]
    normal = np.cross(*images)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def bone_distance(points: Array, hand: Array) -> Array:
    """Distance [n] m of points [n, 3] m to the bones, from the shoulder at the origin by ELBOW to the hand."""
    distances = []
    for start, end in ((np.zeros(3), ELBOW), (ELBOW, hand)):
        bone = end - start
        share = np.clip((points - start) @ bone / (bone @ bone), 0, 1)[:, None]
        distances.append(np.linalg.norm(points - start - share * bone, axis=1))
    return np.minimum(*distances)
