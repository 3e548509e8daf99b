"""What an ultrasonic sensor of a scene has before it, from a run's results: the nearest point of each target."""

from collections.abc import Iterator

import numpy as np

from .drawing import series
from .results import Results
from .scene import Scene, SceneUnit
from .skeleton import rotate


def nearest_points(
    results: Results, scene: Scene, sensor: SceneUnit, rows: np.ndarray, start: np.ndarray
) -> Iterator[np.ndarray]:
    """Of each target whose place was recorded, the point (n, 3), m, nearest to the sensor at some rows.

    `start` (n, 3), m, is where the sensor is there. Where a target is absent its point is not a number.
    """

    def values(name: str) -> np.ndarray:
        return series(results, scene, f"{sensor.name}.{name}")[rows]

    def plane() -> np.ndarray:
        normal = values("plane_normal")
        square = np.sum(normal**2, axis=1, keepdims=True)
        height = np.sum((start - values("plane_point")) * normal, axis=1, keepdims=True)
        return start - height * normal / np.where(square > 0.0, square, np.nan)

    def on_ball(center: np.ndarray, radius: np.ndarray) -> np.ndarray:
        way = center - start
        length = np.linalg.norm(way, axis=1)
        there = (radius > 0.0) & (length > 0.0)
        return start + way * np.where(there, 1.0 - radius / np.where(there, length, 1.0), np.nan)[:, None]

    def capsule(name: str) -> np.ndarray:
        first, second = values(f"{name}_start"), values(f"{name}_end")
        axis = second - first
        square = np.sum(axis**2, axis=1, keepdims=True)
        share = np.sum((start - first) * axis, axis=1, keepdims=True) / np.where(square > 0.0, square, 1.0)
        return on_ball(first + np.clip(share, 0.0, 1.0) * axis, values(f"{name}_radius"))

    def box() -> np.ndarray:
        center, turn, half = values("box_center"), values("box_orientation"), values("box_size") / 2.0
        half = np.where(np.all(half > 0.0, axis=1, keepdims=True), half, np.nan)
        back = turn * [1.0, -1.0, -1.0, -1.0]
        return center + rotate(turn, np.clip(rotate(back, start - center), -half, half))

    targets = (
        lambda: on_ball(values("sphere_center"), values("sphere_radius")),
        plane,
        lambda: capsule("capsule_1"),
        lambda: capsule("capsule_2"),
        box,
    )
    for target in targets:
        try:
            yield target()
        except KeyError:
            continue


def true_distance(results: Results, scene: Scene, sensor: SceneUnit) -> np.ndarray:
    """To the nearest surface, (n,), m, at all times; not a number without a target.

    Raises KeyError, with the name, if the sensor's position was not recorded.
    """
    start = series(results, scene, f"{sensor.name}.position")
    found = np.full(len(results), np.nan)
    for point in nearest_points(results, scene, sensor, np.arange(len(results)), start):
        found = np.fmin(found, np.linalg.norm(point - start, axis=1))
    return found
