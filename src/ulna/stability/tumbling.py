"""How large a step may be while a free body tumbles: by its energy, and by its attitude."""

import math
from functools import cache

import numpy as np

from ..bench import rigid_body
from ..bench.measuring import Array, started
from ..slave import UnitError
from .search import largest

INERTIA = rigid_body.INERTIA
ROD = (1e-6, 1.0, 1.0)
"""Principal moments (kg m2) 1:1e6. The triangle inequality makes the other two equal within 1e-6."""
RATE = rigid_body.TUMBLE
SPEED = math.hypot(*RATE)
END = rigid_body.END

ENERGY_ERROR, ENERGY_STEPS, LOOKS = 0.01, 20_000, 50
ATTITUDE_ERROR = 0.1  # rad
LARGEST = 10.0
"""A step h|w|, rad, above which no limit is looked for: more than one and a half turns."""


@cache
def true_attitude(inertia: tuple[float, ...]) -> Array:
    """Rotation matrix [3, 3] at END: in closed form for the rod, by DOP853 otherwise."""
    if inertia != ROD:
        return rigid_body.true_attitude(RATE)
    momentum = np.multiply(ROD, RATE)
    about_axis = RATE[0] * (1 - ROD[0] / ROD[1])
    return _turn(momentum / ROD[1] * END) @ _turn(np.array([about_axis, 0.0, 0.0]) * END)


def _turn(vector: Array) -> Array:
    """Rotation matrix [3, 3] by a rotation vector, rad."""
    angle = np.linalg.norm(vector)
    return rigid_body.matrix_of(np.array([math.cos(angle / 2), *(math.sin(angle / 2) / angle * vector)]))


def body(solver: str, step: float, inertia: tuple[float, ...], spin: float):
    """A weightless body that tumbles `spin` times as fast as RATE, with internal steps of `step` s."""
    values = rigid_body.motion(solver, tuple(np.multiply(spin, RATE)), step)
    return started("RigidBody", **values | {"inertia": inertia})


def keeps_energy(solver: str, angle: float, inertia: tuple[float, ...] = INERTIA, spin: float = 1.0) -> bool:
    """Whether the energy stays within 1 % over 20 000 steps of h|w| = `angle`; looked at fifty times."""
    step = angle / (SPEED * spin)
    span = step * ENERGY_STEPS / LOOKS
    with body(solver, step, inertia, spin) as tumbler:
        energy = tumbler.get("kinetic_energy")
        try:
            for look in range(LOOKS):
                tumbler.step(look * span, span)
                # a comparison that is false for what is not a number
                if not abs(tumbler.get("kinetic_energy") / energy - 1) < ENERGY_ERROR:
                    return False
        except UnitError:
            return False
    return True


def attitude_error(solver: str, angle: float, inertia: tuple[float, ...] = INERTIA, spin: float = 1.0) -> float:
    """Angle (rad) off after as many turns as RATE makes in END, in one doStep; nan if the unit gave up."""
    end = END / spin
    step = end / math.ceil(END * SPEED / angle)
    with body(solver, step, inertia, spin) as tumbler:
        try:
            tumbler.step(0.0, end)
        except UnitError:
            return math.nan
        chord = np.linalg.norm(rigid_body.matrix_of(tumbler.get("orientation")) - true_attitude(inertia)) / math.sqrt(8)
        return 2 * math.asin(min(1.0, chord))


def chooses_steps(solver: str) -> bool:
    """Whether a solver of RigidBody pays no heed to `solver_step`, since it chooses its own."""
    ends = []
    for step in (0.5, 0.1):
        with body(solver, step, INERTIA, 1.0) as tumbler:
            tumbler.step(0.0, 0.5)
            ends.append(tumbler.get("orientation"))
    return np.array_equal(*ends)


def energy_limit(solver: str, low: float, ratio: float, **motion) -> float:
    """Largest h|w| (rad) at which the energy is kept."""
    return largest(lambda angle: keeps_energy(solver, angle, **motion), low, LARGEST, ratio)


def attitude_limit(solver: str, low: float, ratio: float, **motion) -> float:
    """Largest h|w| (rad) at which the attitude is within 0.1 rad at the end."""
    return largest(lambda angle: attitude_error(solver, angle, **motion) < ATTITUDE_ERROR, low, LARGEST, ratio)


def true_rates(end: float) -> Array:
    """Body rates [n, 3], rad/s, of the tumbling body, evenly over `end` s; by the classical Runge-Kutta."""
    moments, count = np.array(INERTIA), math.ceil(end / 0.01)
    rates = np.empty((count + 1, 3))
    rates[0] = RATE
    h = end / count

    def slope(w: Array) -> Array:
        x, y, z = w
        a, b, c = moments
        return np.array([(b - c) / a * y * z, (c - a) / b * z * x, (a - b) / c * x * y])

    for i in range(count):
        w = rates[i]
        k1 = slope(w)
        k2 = slope(w + h / 2 * k1)
        k3 = slope(w + h / 2 * k2)
        rates[i + 1] = w + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(w + h * k3))
    return rates
