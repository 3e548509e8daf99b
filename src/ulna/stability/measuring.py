"""All measurements of the map, as one table of plain numbers."""

import math
import platform
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..bench.measuring import choices
from ..slave import Slave, UnitError
from . import small_errors, theory
from .search import largest
from .tumbling import (
    ENERGY_ERROR,
    ENERGY_STEPS,
    INERTIA,
    LARGEST,
    ROD,
    SPEED,
    attitude_error,
    attitude_limit,
    chooses_steps,
    energy_limit,
    true_rates,
)

FAST = 1e4  # rad/s
LEAST = 1e-5
LEAST_QUICK = 1e-3
LEAST_SPRING = 0.05
USUAL = 0.01  # rad, the step at which the attitude error is told
MARGIN = 1e-8  # of a growth factor; the maps are known to 1e-9
SPIN_ANGLES = tuple(np.geomspace(0.01, 3.0, 13).tolist())
HELD_ANGLES = tuple(np.linspace(0.25, 3.0, 12).tolist())
NORM_ANGLES = tuple(np.geomspace(0.01, 2.0, 12).tolist())
MOMENTS = 21

Row = dict[str, Any]


def measure(quick: bool = False) -> dict[str, Any]:
    """Everything that the map shows: lists of rows by topic.

    An infinite limit means that none was found up to LARGEST; 0 that it is below the least that was tried. With `quick`
    limits are known within 10 % instead of 1 %, attitudes are tried with steps of 1e-3 and more, grids are coarser.
    """
    solvers = choices("RigidBody", "solver")
    every = 4 if quick else 1
    return {
        "about": {
            "quick": quick,
            "machine": f"{platform.system()} {platform.machine()}",
            "inertia": INERTIA,
            "rod": ROD,
        },
        "tumbling": [_tumbling(solver, quick) for solver in solvers],
        "euler_energy_limit": euler_energy_limit(),
        "springs": list(_springs(1.1 if quick else 1.01)),
        "held": list(_held(solvers, HELD_ANGLES[::every])),
        "spins": list(_spins(solvers, SPIN_ANGLES[::every])),
        "norms": list(_norms(NORM_ANGLES[::every])),
        "moments": list(_moments(11 if quick else MOMENTS)),
    }


def euler_energy_limit() -> float:
    """The theory's h|w| (rad) for the energy of explicit Euler and the notes, over the time that it takes."""
    limit = 0.002  # the time over which is averaged; it matters little
    for _ in range(2):
        rates = true_rates(ENERGY_STEPS * limit / SPEED)
        limit = theory.euler_energy_limit(INERTIA, rates, ENERGY_STEPS, ENERGY_ERROR)
    return limit


def spring_limit(unit: str, solver: str, ratio: float = 1.01) -> float:
    """Largest z = h sqrt(k/m) of a spring inside the step: the muscle's, or a swing under a force for RigidBody."""
    step = {"HingedBody": small_errors.hinge_spring, "RigidBody": small_errors.weight_spring}[unit]
    return largest(lambda z: small_errors.factor(step(solver, z)) <= 1 + MARGIN, LEAST_SPRING, LARGEST, ratio)


def _tumbling(solver: str, quick: bool) -> Row:
    low, ratio = (LEAST_QUICK, 1.1) if quick else (LEAST, 1.01)
    kinds = {"": {}, "rod_": {"inertia": ROD}, "fast_": {"spin": FAST / SPEED}}
    row: Row = {"solver": solver, "chooses_steps": chooses_steps(solver)}
    for kind, motion in kinds.items():
        row[kind + "energy"] = energy_limit(solver, LEAST, ratio, **motion)
        row[kind + "attitude"] = attitude_limit(solver, low, ratio, **motion)
        row[kind + "error"] = attitude_error(solver, USUAL, **motion)
    return row


def _springs(ratio: float) -> Iterator[Row]:
    for unit in ("RigidBody", "HingedBody"):
        for solver in choices(unit, "solver"):
            limit = spring_limit(unit, solver, ratio)
            yield {"unit": unit, "solver": solver, "limit": limit, "theory": theory.SPRING_LIMITS.get(solver)}


def _held(solvers: list[str], angles: tuple[float, ...]) -> Iterator[Row]:
    for solver in solvers:
        for sloped in (False, True):
            for z in angles:
                found = small_errors.factor(small_errors.held_spring(solver, z, sloped))
                expected = theory.held_force_factor(solver, z, sloped)
                yield {"solver": solver, "sloped": sloped, "z": z, "factor": found, "theory": expected}


def _spins(solvers: list[str], angles: tuple[float, ...]) -> Iterator[Row]:
    for solver in solvers:
        for axis in range(3):
            exact = theory.growth_rate(INERTIA, axis, 1.0)
            for angle in angles:
                rates = np.log(small_errors.spin(solver, INERTIA, axis, angle)) / angle
                found = rates[np.argmax(rates.real)]
                yield {
                    **{
                        "solver": solver,
                        "axis": axis,
                        "angle": angle,
                        "growth": found.real,
                        "circling": abs(found.imag),
                    },
                    **{"theory_growth": exact.real, "theory_circling": exact.imag},
                }


def _norms(angles: tuple[float, ...]) -> Iterator[Row]:
    """A quaternion that is not made a unit again, turned by a constant rate: (0, w) q / 2 is a matrix times q."""
    x, y, z = np.array([0.6, 0.0, 0.8])
    turning = np.array([[0, -x, -y, -z], [x, 0, -z, y], [y, z, 0, -x], [z, -y, x, 0]]) / 2
    for method, order, expected in (("euler", 1, theory.euler_norm_factor), ("rk4", 4, theory.rk4_norm_factor)):
        for angle in angles:
            step = sum(np.linalg.matrix_power(turning * angle, n) / math.factorial(n) for n in range(order + 1))
            q, steps = np.array([1.0, 0.0, 0.0, 0.0]), 100
            for _ in range(steps):
                q = step @ q
            grown = float(np.linalg.norm(q)) ** (1 / steps)
            yield {"method": method, "angle": angle, "factor": grown, "theory": expected(angle)}


def _moments(count: int) -> Iterator[Row]:
    """Which ratios of two moments to the third RigidBody takes."""
    with Slave("RigidBody") as body:
        for first in np.linspace(0.06, 2.05, count):
            for second in np.linspace(0.06, 2.05, count):
                moments = (float(first), float(second), 1.0)
                body.set("inertia", moments)
                try:
                    body.initialize()
                    accepted = True
                except UnitError:
                    accepted = False
                body.reset()
                yield {"moments": moments, "accepted": accepted, "theory": theory.is_inertia(moments)}
