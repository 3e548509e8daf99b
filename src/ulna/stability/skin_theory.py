"""Where skins fold, collapse, tear and flip: closed forms for a cylinder, and the smooth surface in float64.

r is the arm's radius, h the blend zone's half width, theta the angle of flexion or twist, the weights the smoothstep.
At the innermost point of the elbow the linear blend goes cos(theta/2) - (3r/2h) sin(theta/2) across the bisecting plane
per length of bone; the turn about the pivot goes through 3 tan(theta/4) / h radians per length there, at r from the
pivot. The skin folds where the first is negative, and where the second is more than 1/r.
"""

import math
from collections.abc import Callable

import numpy as np

from ..bench.skinning import ELBOW, HALF_WIDTH, SPOKES, Array, Pose, about, mean_turn, skinned, turned

RINGS = 65
"""Of the smooth surface's grid over the zone."""
WITHIN = 0.01
"""degrees: of a border that is searched."""


def fold_angle(method: str, ratio: float) -> float | None:
    """Degrees of flexion from which the inner elbow is folded, at h/r; inf if never, None where no form is known."""
    if method == "linear_blend":
        return 2 * math.degrees(math.atan(2 * ratio / 3))
    if method in ("hinge", "dual_quaternion"):
        return 4 * math.degrees(math.atan(ratio / 3)) if ratio < 3 else math.inf
    return None


def section(method: str, bend: str, angle: float) -> float:
    """Smallest vector area of a ring over that at rest; angle in degrees. What turns rings, and no more, keeps them."""
    power = {"flexion": 1, "twist": 2}[bend]
    return abs(math.cos(math.radians(angle) / 2)) ** power if method == "linear_blend" else 1.0


def volume(bend: str, angle: float) -> float:
    """Of the zone over rest, with the linear blend: 1 - (1 - cos theta) times the mean of w (1-w), twice in twist."""
    return 1 - {"flexion": 9 / 70, "twist": 9 / 35}[bend] * (1 - math.cos(math.radians(angle)))


def gap(angle: float) -> float:
    """Width of the tear of binary weights, in radii; angle in degrees, of flexion or twist."""
    return 2 * abs(math.sin(math.radians(angle) / 2))


def smooth_fold_angle(method: str, ratio: float) -> float:
    """Degrees of flexion from which the smooth cylinder's deformation turns its surface inside out; inf below 180.

    From the textbook's formulas: the product of the tangents' images, by the complex step, against the outward
    direction turned by the mean rotation. Angles are compared, so the radius is what makes h/r.
    """
    grid = _cylinder(HALF_WIDTH / ratio)
    return border(lambda angle: _folded(method, angle, *grid), 179.9)


def border(fails: Callable[[float], bool], high: float) -> float:
    """Degrees from which it fails, within WITHIN; inf if not at `high`; 0 if at once."""
    if not fails(high):
        return math.inf
    low = 0.0
    while high - low > WITHIN:
        middle = (low + high) / 2
        low, high = (low, middle) if fails(middle) else (middle, high)
    return (low + high) / 2


def _cylinder(radius: float) -> tuple[Array, Array, Array]:
    """Points [n, 3] m from the elbow, tangents [2, n, 3] and normals [n, 3] of the zone."""
    x = np.repeat(np.linspace(-HALF_WIDTH, HALF_WIDTH, RINGS), SPOKES)
    angle = np.tile(2 * np.pi * np.arange(SPOKES) / SPOKES, RINGS)
    outward = np.stack([0 * x, np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([0 * x, -np.sin(angle), np.cos(angle)], axis=1)
    along = np.tile([1.0, 0.0, 0.0], (len(x), 1))
    return x[:, None] * [1.0, 0.0, 0.0] + radius * outward, np.stack([across, along]), outward


def _folded(method: str, angle: float, points: Array, tangents: Array, outward: Array) -> bool:
    pose = Pose(about([1, 0, 0], 0.0), np.zeros(3), about([0, 1, 0], angle), ELBOW)
    images = [skinned(method, points + 1e-30j * t, pose).imag / 1e-30 for t in tangents]
    carried = turned(mean_turn(points, pose)[1], outward)
    side = np.sum(np.cross(*images) * carried, axis=1)
    return bool(side.min() < 0.0)
