"""Poses of targets before an ultrasonic sensor, and what wave theory says of each: for the sensor's chart."""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bench.measuring import started
from ..checks.textbook import load_model

Array = NDArray[np.float64]
FOREARM_LENGTH, FOREARM_RADIUS = 0.25, 0.04  # m
CLEAR = 0.05  # m, between sensor and forearm
NEAREST, FARTHEST = 0.02, 4.0  # m, the sensor's range
WALL = "wall"  # in the name of a truth that has one behind
EDGE = 3.3e-3  # m: no edge of a round body's mesh is longer than 1.03 of it, .4 wavelength
PARTS = ("hearing", "echoes", "surfaces", "meshes")  # of the textbook
LAST_PEAK = 4e-4  # s: an echo that arrives in time is waited for until it is loudest


@dataclass(frozen=True)
class Pose:
    """A target: the unit's inputs, and its echoes as a spectrum."""

    inputs: dict[str, Any]
    spectrum: Callable[[Any], NDArray[np.complex128]]
    """Of the device of `models/ultrasonic_sensor/hearing.py`."""
    mesh: Callable[[], Any] | None = None
    """Of the body, a Mesh of `models/ultrasonic_sensor/meshes.py`; None where it has none."""
    behind: dict[str, Any] = field(default_factory=dict)
    """Those of the inputs that the mesh does not stand for: a wall's."""


def theory() -> SimpleNamespace:
    """The modules `hearing`, `echoes`, `surfaces` and `meshes` of the textbook.

    Raises ModuleNotFoundError, with what installs it, without CasADi or SciPy.
    """
    try:
        parts = {name: load_model(f"ultrasonic_sensor.{name}") for name in PARTS}
    except ModuleNotFoundError as error:
        message = f"the truths of the sensor need {error.name}: pip install 'ulna[peers]' brings CasADi and SciPy"
        raise ModuleNotFoundError(message, name=error.name) from None
    return SimpleNamespace(**parts)


def device(**settings: Any) -> Any:
    """The truth's picture of the default sensor, in the air that the unit has; `settings` as `hearing.Device` has."""
    with started("UltrasonicSensor") as sensor:
        speed, absorption, baseline = (sensor.get(name) for name in ("speed_of_sound", "absorption", "baseline"))
    nearest, farthest = (2 * np.hypot(reach, baseline / 2) / speed for reach in (NEAREST, FARTHEST))
    within = {"minimum_time": nearest, "maximum_time": farthest + LAST_PEAK}
    return theory().hearing.Device(speed, absorption, **(within | settings))


def direction(rng: np.random.Generator, widest: float) -> Array:
    """Up to `widest` degrees off the axis, to any side."""
    return towards(rng.uniform(0, widest), rng.uniform(0, 2 * np.pi))


def towards(degrees: float, about: float) -> Array:
    """A direction off the axis, `about` (rad) of it from the baseline's direction."""
    off = np.radians(degrees)
    return np.array([np.cos(off), np.sin(off) * np.cos(about), np.sin(off) * np.sin(about)])


def plane(rng: np.random.Generator) -> Pose:
    """Anywhere in range, tilted by up to 45 degrees."""
    return plane_at(rng.uniform(0.1, 3.9), direction(rng, 45.0))


def plane_at(distance: float, towards: Array) -> Pose:
    """With its perpendicular from the sensor in a direction."""
    point, normal = distance * towards, -towards
    return Pose(
        {"plane_point": point, "plane_normal": normal}, lambda d: theory().echoes.image_source(d, point, normal)
    )


def sphere(rng: np.random.Generator) -> Pose:
    """Radius 3 to 20 cm, up to 40 degrees off the axis."""
    return sphere_at(rng.uniform(0.15, 2.5), direction(rng, 40.0), rng.uniform(0.03, 0.2))


def sphere_at(distance: float, towards: Array, radius: float) -> Pose:
    """With its surface at a distance."""
    center = (distance + radius) * towards
    inputs = {"sphere_center": center, "sphere_radius": radius}
    return Pose(inputs, lambda d: theory().echoes.rigid_sphere(d, center, radius), _capsule(center, center, radius))


def forearm(rng: np.random.Generator) -> Pose:
    """A capsule in any attitude, up to 30 degrees off the axis and 2 m away, clear of the sensor."""
    while True:
        center, axis = rng.uniform(0.1, 2.0) * direction(rng, 30.0), rng.normal(size=3)
        half = FOREARM_LENGTH / 2 * axis / np.linalg.norm(axis)
        nearest = min(np.linalg.norm(center + share * half) for share in np.linspace(-1, 1, 21))
        if nearest > FOREARM_RADIUS + CLEAR:
            return capsule_at(center - half, center + half, FOREARM_RADIUS)


def capsule_at(start: Array, end: Array, radius: float) -> Pose:
    """A capsule about an axis."""

    def spectrum(d: Any) -> NDArray[np.complex128]:
        return theory().echoes.kirchhoff(d, *theory().surfaces.capsule_surface(start, end, radius))

    inputs = {"capsule_1_start": start, "capsule_1_end": end, "capsule_1_radius": radius}
    return Pose(inputs, spectrum, _capsule(start, end, radius))


def _capsule(start: Array, end: Array, radius: float) -> Callable[[], Any]:
    return lambda: theory().meshes.capsule_mesh(start, end, radius, EDGE)


def box(rng: np.random.Generator) -> Pose:
    """Edges of 5 to 30 cm, a face turned to the sensor within 20 degrees."""
    axis, angle = rng.normal(size=3), np.radians(rng.uniform(0, 20.0))
    turn = np.append(np.cos(angle / 2), np.sin(angle / 2) * axis / np.linalg.norm(axis))
    size, center = rng.uniform(0.05, 0.3, 3), rng.uniform(0.35, 1.5) * direction(rng, 10.0)
    w, u = turn[0], turn[1:]
    axes = np.array([e + 2 * np.cross(u, np.cross(u, e) + w * e) for e in np.eye(3)])

    def spectrum(d: Any) -> NDArray[np.complex128]:
        return theory().echoes.kirchhoff(d, *theory().surfaces.box_surface(center, axes, size, d.ears))

    inputs = {"box_center": center, "box_orientation": turn, "box_size": size}
    return Pose(inputs, spectrum, lambda: theory().meshes.box_mesh(center, axes, size, EDGE))


def before_a_wall(
    draw: Callable[[np.random.Generator], Pose], reach: Callable[[Pose], tuple[Array, float]]
) -> Callable:
    """What `draw` puts there, with a wall behind whose perpendicular is clear of it: nothing is in the shade."""

    def drawn(rng: np.random.Generator) -> Pose:
        while True:
            target = draw(rng)
            middle, size = reach(target)
            far = np.linalg.norm(middle)
            aside = direction(rng, 20.0)
            wall = plane_at(rng.uniform(far + size, 3.5), aside)
            # the way to the wall's mirror point passes the target by more than a Fresnel zone
            if np.linalg.norm(middle - aside * np.dot(middle, aside)) > size + 0.12:
                return both(target, wall)

    return drawn


def both(body: Pose, wall: Pose) -> Pose:
    """Their echoes add up."""
    return Pose(body.inputs | wall.inputs, lambda d: body.spectrum(d) + wall.spectrum(d), body.mesh, wall.inputs)


def _ball_of_sphere(pose: Pose) -> tuple[Array, float]:
    return pose.inputs["sphere_center"], pose.inputs["sphere_radius"]


def _ball_of_forearm(pose: Pose) -> tuple[Array, float]:
    middle = (pose.inputs["capsule_1_start"] + pose.inputs["capsule_1_end"]) / 2
    return middle, FOREARM_LENGTH / 2 + FOREARM_RADIUS


TRUTHS: dict[str, Callable[[np.random.Generator], Pose]] = {
    "plane": plane,
    "sphere": sphere,
    "forearm": forearm,
    "box": box,
    "sphere, wall": before_a_wall(sphere, _ball_of_sphere),
    "forearm, wall": before_a_wall(forearm, _ball_of_forearm),
}
SOURCES = {
    "plane": "image source",
    "sphere": "partial waves",
    "forearm": "Kirchhoff integral",
    "box": "Kirchhoff integral",
    "sphere, wall": "both, summed",
    "forearm, wall": "both, summed",
}
