"""The five problems: as parameters of the unit, as equations for the reference, and as a model of MuJoCo."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import cos, sin
from typing import Any

import numpy as np

from .reference import Array, Quadratic, integrate

GRAVITY = 9.80665  # m/s2


@dataclass(frozen=True)
class Problem:
    """One motion, whose `output`, an orientation or an angle (rad), is judged at `end` s."""

    name: str
    title: str
    about: str
    unit: str
    values: dict[str, Any]
    """Parameters and inputs of the unit."""
    system: Quadratic
    place: slice
    """Where in the system's state the orientation or the angle is."""
    end: float
    coarsest: float
    """Largest step worth trying, s."""
    joint: str
    """The body in MuJoCo's MJCF: its joint and its inertia."""
    gravity: float
    turn: tuple[float, ...]
    """Rates of MuJoCo's joint at the start."""
    pose: tuple[float, ...]
    """Place of MuJoCo's joint at the start."""
    applied: float = 0.0
    """Torque in MuJoCo's joint, N m."""

    @property
    def output(self) -> str:
        """Name of the unit's variable that is judged."""
        return "orientation" if self.unit == "RigidBody" else "angle"

    @cached_property
    def truth(self) -> Array:
        """The orientation [4] or the angle [1] at the end, to the last digit of a double."""
        return np.array([float(value) for value in integrate(self.system, self.end)[self.place]])

    def error(self, found: Any) -> float:
        """Angle, rad, between what was found at the end and the truth; NaN if it is no number."""
        found = np.atleast_1d(np.asarray(found, float))
        if found.size == 1:
            return float(abs(found[0] - self.truth[0]))
        w, x, y, z = self.truth
        a, b, c, d = found
        aside = [w * b - x * a - y * d + z * c, w * c + x * d - y * a - z * b, w * d - x * c + y * b - z * a]
        return float(2.0 * np.arctan2(np.linalg.norm(aside), abs(w * a + x * b + y * c + z * d)))


def turning(
    inertia: Sequence[float], lever: float, weight: float, q: Sequence[float], rate: Sequence[float]
) -> Quadratic:
    """Body rates (rad/s), orientation and the weight seen from the body (N), which acts at `lever` m up the z axis.

    Euler's equations about the fixed point; state: rate 0..2, orientation 3..6, weight 7..9, and 1.
    """
    moments = [Fraction(moment) for moment in inertia]
    half, length = Fraction(1, 2), Fraction(lever)
    terms = [(k, (moments[i] - moments[j]) / moments[k], i, j) for k, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1))]
    terms += [(3, -half, 4 + k, k) for k in range(3)] + [(4 + k, half, 3, k) for k in range(3)]
    for k, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        terms += [(4 + k, half, 4 + i, j), (4 + k, -half, 4 + j, i)]
    first = [*rate, *q]
    if weight:
        terms += [(0, -length / moments[0], 8, 10), (1, length / moments[1], 7, 10)]
        for k, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            terms += [(7 + k, Fraction(1), 7 + i, j), (7 + k, Fraction(-1), 7 + j, i)]
    w, x, y, z = q
    down = [-2 * (x * z - w * y), -2 * (y * z + w * x), -(w * w - x * x - y * y + z * z)]
    return Quadratic((*first, *(weight * component for component in down), 1.0), tuple(terms))


def body(rates: Sequence[float], q: Sequence[float], **values: Any) -> dict[str, Any]:
    """Parameters of a RigidBody with these rates in body axes, rad/s, and no gravity."""
    w, u = q[0], np.array(q[1:])
    world = np.array(rates) + 2 * w * np.cross(u, rates) + 2 * np.cross(u, np.cross(u, rates))
    return {"gravity": np.zeros(3), "initial_orientation": q, "initial_angular_velocity": world, **values}


def free(name: str, title: str, about: str, inertia: Sequence[float], rate: Sequence[float]) -> Problem:
    """A body on which nothing acts, for 100 s."""
    level = (1.0, 0.0, 0.0, 0.0)
    return Problem(
        name,
        title,
        about,
        "RigidBody",
        body(rate, level, inertia=inertia),
        turning(inertia, 0.0, 0.0, level, rate),
        slice(3, 7),
        100.0,
        1.0,
        f'<freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{_numbers(inertia)}"/>',
        0.0,
        (0.0, 0.0, 0.0, *rate),
        (0.0, 0.0, 0.0, *level),
    )


def top(name: str, title: str, about: str, inertia: Sequence[float], rate: Sequence[float]) -> Problem:
    """A body of 1 kg on a pivot half a metre below its centre of mass, for 10 s; inertia about the pivot.

    To the unit the pivot is the centre of mass, and the weight a force at the tip.
    """
    lever, mass, tilt = 0.5, 1.0, 0.5
    q = (cos(tilt), sin(tilt), 0.0, 0.0)
    weight = mass * GRAVITY
    central = (inertia[0] - mass * lever**2, inertia[1] - mass * lever**2, inertia[2])
    return Problem(
        name,
        title,
        about,
        "RigidBody",
        body(rate, q, inertia=inertia, tip=[0.0, 0.0, lever], tip_force=[0.0, 0.0, -weight]),
        turning(inertia, lever, weight, q, rate),
        slice(3, 7),
        10.0,
        0.3,
        f'<joint type="ball"/><inertial pos="0 0 {lever}" mass="{mass}" diaginertia="{_numbers(central)}"/>',
        GRAVITY,
        tuple(rate),
        q,
    )


def hinge() -> Problem:
    """A bar of 1.5 kg on a hinge with a little friction, let go level and driven by a constant torque, for 10 s."""
    mass, lever, inertia, friction, torque = 1.5, 0.12, (0.002, 0.01, 0.01), 0.01, 0.5
    moment = Fraction(inertia[1]) + Fraction(mass) * Fraction(lever) ** 2
    one = Fraction(1)
    terms = (
        (0, one, 1, 4),
        (1, Fraction(torque) / moment, 4, 4),
        (1, -Fraction(friction) / moment, 1, 4),
        (1, -Fraction(mass) * Fraction(GRAVITY) * Fraction(lever) / moment, 3, 4),
        (2, one, 1, 3),
        (3, -one, 1, 2),
    )
    values = {
        "mass": mass,
        "inertia": inertia,
        "center_of_mass": [lever, 0.0, 0.0],
        "friction": friction,
        "torque": torque,
        "stiffness": 0.0,
        "damping": 0.0,
    }
    return Problem(
        "driven_hinge",
        "Driven hinge",
        "HingedBody: weight, friction and a torque of 0.5 N m, 10 s",
        "HingedBody",
        values,
        Quadratic((0.0, 0.0, 0.0, 1.0, 1.0), terms),
        slice(0, 1),
        10.0,
        0.3,
        f'<joint type="hinge" axis="0 -1 0" damping="{friction}"/>'
        f'<inertial pos="{lever} 0 0" mass="{mass}" diaginertia="{_numbers(inertia)}"/>',
        GRAVITY,
        (0.0,),
        (0.0,),
        torque,
    )


def _numbers(values: Sequence[float]) -> str:
    return " ".join(map(repr, values))


def problems() -> list[Problem]:
    """All five, in the order of the chart."""
    return [
        free(
            "free_asymmetric",
            "Free, asymmetric",
            "I = (1, 2, 3), w = (.6, 1, .4) rad/s, 100 s",
            (1.0, 2.0, 3.0),
            (0.6, 1.0, 0.4),
        ),
        free(
            "dzhanibekov",
            "Dzhanibekov",
            "I = (1, 2, 3), w = (.01, 1, .01) rad/s, 100 s",
            (1.0, 2.0, 3.0),
            (0.01, 1.0, 0.01),
        ),
        top(
            "symmetric_top",
            "Heavy top, symmetric",
            "I = (1, 1, .6) about the pivot, spin 12 rad/s, 10 s",
            (1.0, 1.0, 0.6),
            (0.2, 0.1, 12.0),
        ),
        top(
            "asymmetric_top",
            "Heavy top, asymmetric",
            "I = (1, 1.3, .6) about the pivot, spin 12 rad/s, 10 s",
            (1.0, 1.3, 0.6),
            (0.2, 0.1, 12.0),
        ),
        hinge(),
    ]
