"""The fate of a small error over one step: the linear map that the unit itself makes of it."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..bench.measuring import Array, started
from ..bench.rigid_body import matrix_of, motion
from ..slave import Slave

SMALL = 1e-5  # rad; its square, the part that is not linear, is as small as its round-off
FINEST = 1e-15
"""Tolerance (rad/s) of solvers that choose their steps: errors count against SMALL here."""


def hinge_spring(solver: str, z: float) -> Array:
    """Map [2, 2] of (angle, rate) over one step of a hinge with a spring of 1 N m/rad about 1 kg m2; h = z s."""

    def after(angle: float, rate: float) -> tuple[float, float]:
        values = {
            "mass": 1.0,
            "inertia": [1.0, 1.0, 1.0],
            "center_of_mass": [0.0, 0.0, 0.0],
            "gravity": [0.0, 0.0, 0.0],
            "stiffness": 1.0,
            "damping": 0.0,
            "initial_angle": angle,
            "initial_rate": rate,
            "solver": solver,
            "solver_step": z,
        }
        with _started("HingedBody", values) as body:
            body.step(0.0, z)
            return body.get("angle"), body.get("rate")

    return _map(after, 1.0)


def weight_spring(solver: str, z: float) -> Array:
    """Map [2, 2] of (angle, rate) over one step of a free body that swings under a force of 1 N at 1 m, 1 kg m2.

    The opposite force at the centre keeps it in place. The torque -sin(angle) turns with the body within the step.
    """

    def after(angle: float, rate: float) -> tuple[float, float]:
        values = motion(solver, (0.0, 0.0, rate), z) | {
            "inertia": [1.0, 1.0, 1.0],
            "initial_orientation": [np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)],
            "tip": [1.0, 0.0, 0.0],
            "tip_force": [1.0, 0.0, 0.0],
            "force": [-1.0, 0.0, 0.0],
        }
        with _started("RigidBody", values) as body:
            body.step(0.0, z)
            q = body.get("orientation")
            return 2 * np.arctan2(q[3], q[0]), body.get("angular_velocity")[2]

    return _map(after, SMALL)


def held_spring(solver: str, z: float, sloped: bool = False, sub_steps: int = 1) -> Array:
    """Map [2, 2] of (x, v) over one communication step with the force -x N held, 1 kg, or with its slope -v N/s."""

    def after(x: float, v: float) -> tuple[float, float]:
        values = motion(solver, (0.0, 0.0, 0.0), z / sub_steps) | {
            "initial_position": [x, 0.0, 0.0],
            "initial_velocity": [v, 0.0, 0.0],
            "force": [-x, 0.0, 0.0],
            "force_rate": [-v if sloped else 0.0, 0.0, 0.0],
        }
        with _started("RigidBody", values) as body:
            body.step(0.0, z)
            return body.get("position")[0], body.get("velocity")[0]

    return _map(after, 1.0)


def spin(solver: str, inertia: tuple[float, ...], axis: int, angle: float, steps: int = 1) -> NDArray[np.complex128]:
    """Eigenvalues [2] of what `steps` steps of h|w| = `angle` make of small rates across a spin of 1 rad/s."""
    across = [(axis + 1) % 3, (axis + 2) % 3]

    def after(first: float, second: float) -> Array:
        rate = np.zeros(3)
        rate[axis], rate[across] = 1.0, (first, second)
        with _started("RigidBody", motion(solver, tuple(rate), angle) | {"inertia": inertia}) as body:
            body.step(0.0, angle * steps)
            return (matrix_of(body.get("orientation")).T @ body.get("angular_velocity"))[across]

    return np.linalg.eigvals(_map(after, SMALL))


def factor(linear: Array) -> float:
    """Growth factor of a map: its spectral radius."""
    return float(np.abs(np.linalg.eigvals(linear)).max())


def _map(after: Callable[[float, float], object], small: float) -> Array:
    """The linear map [2, 2], from what becomes of two small errors and their opposites."""
    columns = [np.subtract(after(a, b), after(-a, -b)) / (2 * small) for a, b in ((small, 0.0), (0.0, small))]
    return np.stack(columns, axis=1)


def _started(unit: str, values: dict) -> Slave:
    with Slave(unit) as probe:
        finest = {"tolerance": FINEST} if "tolerance" in probe.description.variables else {}
    return started(unit, **values, **finest)
