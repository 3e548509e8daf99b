"""Where the sensor's fidelities fail, measured on the FMU: over pose, gap, temperature and grazing angle; its beam."""

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..bench.measuring import choices, started
from ..charts.sensor_truths import EDGE
from ..charts.sensor_truths import theory as textbook
from ..slave import Slave
from . import sensor_theory as theory

FLIGHT = 0.05  # s, longer than any
NEAREST, FARTHEST = 0.02, 4.0  # m, the sensor's range
THRESHOLD = -36.0  # dB
ALL_HEARD = -150.0  # dB
WRONG = 0.01  # m, from which a distance is wrong
SPHERE_RADIUS, ARM_RADIUS, ARM_LENGTH, POLE_RADIUS, POLE_LENGTH = 0.1, 0.04, 0.25, 0.015, 4.0  # m
FIELD_OF_VIEW = math.radians(15.0)  # of `cone`
POLES_AT, POLES_ASIDE = 1.0, math.radians(5.0)  # m; above and below the axis, so that none shades the other
CELSIUS = (-10.0, 50.0)
GRAZED_FROM = 0.5  # m
NEAR_FIELD = 0.06  # m: beyond, a level falls with the distance in every direction


def direction(aside: float) -> np.ndarray:
    """Off the axis by an angle, across the baseline."""
    return np.array([math.cos(aside), 0.0, math.sin(aside)])


def plane(distance: float, aside: float) -> dict[str, Any]:
    """A plane whose perpendicular from the sensor is so long, and so far off the axis."""
    return {"plane_point": distance * direction(aside), "plane_normal": -direction(aside)}


def sphere(distance: float, aside: float) -> dict[str, Any]:
    """A sphere whose surface is so far away."""
    return {"sphere_center": (distance + SPHERE_RADIUS) * direction(aside), "sphere_radius": SPHERE_RADIUS}


def forearm(distance: float, aside: float) -> dict[str, Any]:
    """A forearm across, along the baseline."""
    return rod(distance, aside, ARM_RADIUS, ARM_LENGTH)


def pole(distance: float, aside: float) -> dict[str, Any]:
    """A long pole across."""
    return rod(distance, aside, POLE_RADIUS, POLE_LENGTH)


def rod(distance: float, aside: float, radius: float, length: float, number: int = 1) -> dict[str, Any]:
    """A capsule along the baseline, whose wall is so far away."""
    center, half = (distance + radius) * direction(aside), np.array([0.0, length / 2, 0.0])
    ends = {f"capsule_{number}_start": center - half, f"capsule_{number}_end": center + half}
    return ends | {f"capsule_{number}_radius": radius}


TARGETS = {"plane": (plane, "plane", 0.0), "sphere": (sphere, "sphere", SPHERE_RADIUS)}
TARGETS |= {"forearm": (forearm, "forearm", ARM_RADIUS), "pole": (pole, "forearm", POLE_RADIUS)}
"""How it is placed, what its mirror is to the theory, and its radius."""
MAPS = ("plane", "sphere", "forearm")


class Ears:
    """A sensor of one fidelity, pinged again and again from its start."""

    def __init__(self, fidelity: str, **values: Any):
        """Nothing is rounded."""
        self._sensor: Slave = started("UltrasonicSensor", **values, fidelity=fidelity, resolution=0.0)
        self._start = self._sensor.save()
        self.air = theory.Air(self._sensor.get("speed_of_sound"), self._sensor.get("absorption"))

    def ping(self, inputs: dict[str, Any], *read: str) -> list[Any]:
        """Outputs after one ping at what the inputs say."""
        self._sensor.restore(self._start)
        for name, value in inputs.items():
            self._sensor.set(name, value)
        self._sensor.step(0.0, FLIGHT)
        return [self._sensor.get(name) for name in read]

    def hears(self, inputs: dict[str, Any]) -> bool:
        """Whether there is an echo."""
        return bool(self.ping(inputs, "valid")[0])


def takes(fidelity: str, target: str) -> bool:
    """Whether it can be put before it: no mesh is endless."""
    return fidelity != "surface" or target != "plane"


def before(fidelity: str, target: str) -> tuple[Ears, Callable[[float, float], dict[str, Any]]]:
    """A sensor, and what its inputs are by distance (m) and angle (rad) of a target.

    `surface` gets a ball and a forearm as meshes, `automatic` a forearm's beside its capsule.
    """
    made, _, radius = TARGETS[target]
    half = {"sphere": 0.0, "forearm": ARM_LENGTH / 2}.get(target)
    if half is None or fidelity not in ("surface", "automatic") or (fidelity, target) == ("automatic", "sphere"):
        return Ears(fidelity), made
    ends = np.array([0.0, -half, 0.0]), np.array([0.0, half, 0.0])
    mesh = textbook().meshes.capsule_mesh(*ends, radius, EDGE)

    def placed(distance: float, aside: float) -> dict[str, Any]:
        moved = {"surface_vertices": (mesh.vertices + (distance + radius) * direction(aside)).T}
        return moved if fidelity == "surface" else moved | made(distance, aside)

    return Ears(fidelity, **mesh.inputs()), placed


def measure_sensor(quick: bool = False) -> dict[str, Any]:
    """All that the map shows: cells by verdict, interference, temperature, grazing planes, and the beam."""
    side = 14 if quick else 40
    fidelities = choices("UltrasonicSensor", "fidelity")
    return {
        "about": {"threshold": THRESHOLD, "wrong": WRONG, "side": side, "fidelities": fidelities},
        "cells": [row for f in fidelities for t in MAPS if takes(f, t) for row in cells(f, t, side)],
        "gaps": list(gaps(25 if quick else 97)),
        "temperatures": list(temperatures(10.0 if quick else 5.0)),
        "grazing": [row for f in fidelities if takes(f, "plane") for row in grazing(f, 6.0 if quick else 2.0)],
        "beam": [row for target in TARGETS for row in beam(target, 15.0 if quick else 3.0)],
    }


def place(target: str, reach: float, aside: float) -> tuple[float, float]:
    """Distance to the surface (m) and angle (rad) of a cell: a plane at a tilt in degrees, others at an offset in m."""
    if target == "plane":
        return reach, math.radians(aside)
    return math.hypot(reach, aside) - TARGETS[target][2], math.atan2(aside, reach)


def verdict(heard: bool, audible: bool, error: float) -> str:
    """Of a cell: whether there was an echo and should be, and how far off the distance is, m."""
    if heard != audible:
        return "false echo" if heard else "missed"
    if not heard:
        return "silent"
    return "right" if abs(error) < WRONG else "wrong"


def cells(fidelity: str, target: str, side: int) -> Iterator[dict[str, Any]]:
    """Over range, and tilt or offset."""
    ears, placed = before(fidelity, target)
    _, mirror, radius = TARGETS[target]
    asides = np.linspace(0.0, 85.0 if target == "plane" else 1.2, side)
    for reach in np.linspace(0.2, 3.95, side):
        for aside in asides:
            distance, angle = place(target, float(reach), float(aside))
            level = theory.level(mirror, distance, angle, radius, ears.air)
            heard, read = ears.ping(placed(distance, angle), "valid", "distance")
            audible = level >= THRESHOLD and NEAREST < distance < FARTHEST
            where = {"fidelity": fidelity, "target": target, "range": float(reach), "aside": float(aside)}
            said = {"level": level, "heard": heard, "error": read - distance if heard else math.nan}
            yield {**where, **said, "verdict": verdict(heard, audible, said["error"])}


def gaps(count: int) -> Iterator[dict[str, Any]]:
    """Two equal poles: how much louder than the nearer alone, by the gap in wavelengths; measured by the threshold."""
    for fidelity in ("cone", "specular"):
        here = Ears(fidelity).air
        near = rod(POLES_AT, POLES_ASIDE, POLE_RADIUS, POLE_LENGTH)
        alone = loudest(fidelity, near)
        for share in np.linspace(0.0, 2.0, count):
            gap = float(share) * here.speed / theory.FREQUENCY
            both = near | rod(POLES_AT + gap, -POLES_ASIDE, POLE_RADIUS, POLE_LENGTH, 2)
            found = {"measured": loudest(fidelity, both) - alone, "theory": pair(float(share), here)}
            yield {"fidelity": fidelity, "gap": float(share), **found}


def pair(gap: float, here: theory.Air) -> float:
    """By theory; the gap in wavelengths."""
    gap *= here.speed / theory.FREQUENCY
    first, second = (theory.level("forearm", POLES_AT + more, POLES_ASIDE, POLE_RADIUS, here) for more in (0.0, gap))
    return theory.interference(gap, 10 ** ((second - first) / 20), here)


def loudest(fidelity: str, inputs: dict[str, Any]) -> float:
    """Highest threshold, dB, that the sum of the echoes passes; of what has no threshold, the level it gives."""
    if fidelity == "cone":
        return Ears(fidelity).ping(inputs, "level")[0]
    low, high = -80.0, 20.0
    while high - low > 1e-3:
        middle = (low + high) / 2
        low, high = (middle, high) if Ears(fidelity, threshold=middle).hears(inputs) else (low, middle)
    return (low + high) / 2


def temperatures(step: float) -> Iterator[dict[str, Any]]:
    """Error of the firmware's distance of a wall at 2 m, relative, beside that of the distance in this air."""
    for humidity in (0.0, 0.5, 1.0):
        for celsius in np.arange(CELSIUS[0], CELSIUS[1], step):
            ears = Ears("specular", temperature=celsius + theory.KELVIN, humidity=humidity, threshold=ALL_HEARD)
            device, distance = ears.ping(plane(2.0, 0.0), "device_distance", "distance")
            yield {
                "celsius": float(celsius),
                "humidity": humidity,
                "device_error": device / 2.0 - 1,
                "error": distance / 2.0 - 1,
                "theory": theory.firmware_error(float(celsius), humidity),
            }


def grazing(fidelity: str, step: float) -> Iterator[dict[str, Any]]:
    """Distance and level of a plane that is tilted more and more, threshold out of the way."""
    ears = Ears(fidelity, threshold=ALL_HEARD)
    for tilt in np.arange(0.0, 88.1, step):
        inputs = plane(GRAZED_FROM, math.radians(tilt))
        heard, distance, level = ears.ping(inputs, "valid", "distance", "level")
        error = distance / GRAZED_FROM - 1 if heard else math.nan
        yield {"fidelity": fidelity, "tilt": float(tilt), "error": error, "level": level if heard else math.nan}


def beam(target: str, step: float) -> Iterator[dict[str, Any]]:
    """How far a target is heard in each direction by the default sensor, beside theory."""
    ears = Ears("specular")
    made = TARGETS[target][0]
    for degrees in np.arange(-75.0, 75.1, step):
        aside = math.radians(degrees)
        measured = theory.farthest(lambda d, a=aside: ears.hears(made(d, a)), NEAR_FIELD, FARTHEST - 1e-3)
        yield {
            "target": target,
            "angle": float(degrees),
            "measured": measured,
            "theory": heard_to(target, aside, ears.air),
        }


def heard_to(target: str, aside: float, here: theory.Air) -> float:
    """By theory, m."""
    _, mirror, radius = TARGETS[target]

    def audible(distance: float) -> bool:
        return theory.level(mirror, distance, aside, radius, here) >= THRESHOLD

    return theory.farthest(audible, NEAR_FIELD, FARTHEST - 1e-3)
