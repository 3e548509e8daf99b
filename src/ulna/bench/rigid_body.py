"""RigidBody: what a step of each solver costs, and how far off it is without torque, where the attitude is hardest."""

import numpy as np

from .measuring import TOLERANCE, Array, fixed_step_solvers, integrated, repeated_step, side_by_side, started
from .tables import Table

INERTIA = (1.0, 2.0, 3.0)  # kg m2
END = 100.0  # s
STEPS = (0.1, 0.01, 0.001)  # s
TIMED_STEPS = 20_000
TUMBLE = (0.6, 1.0, 0.4)  # rad/s
MIDDLE_AXIS = (0.01, 1.0, 0.01)  # rad/s


def true_attitude(rate: tuple[float, ...]) -> Array:
    """Rotation matrix [3, 3] at END, from Euler's equations and the body axes in the world."""

    def slope(_: float, y: Array) -> Array:
        w, axes = y[:3], y[3:].reshape(3, 3)
        moment = np.multiply(INERTIA, w)
        euler = [
            (moment[1] * w[2] - moment[2] * w[1]) / INERTIA[0],
            (moment[2] * w[0] - moment[0] * w[2]) / INERTIA[1],
            (moment[0] * w[1] - moment[1] * w[0]) / INERTIA[2],
        ]
        spin = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
        return np.concatenate([euler, (axes @ spin).ravel()])

    return integrated(slope, [*rate, *np.eye(3).ravel()], END)[3:].reshape(3, 3)


def matrix_of(q: Array) -> Array:
    """Rotation matrix [3, 3] of a unit quaternion w, x, y, z."""
    cross = np.array([[0.0, -q[3], q[2]], [q[3], 0.0, -q[1]], [-q[2], q[1], 0.0]])
    return np.eye(3) + 2 * q[0] * cross + 2 * cross @ cross


def errors(solver: str, rate: tuple[float, ...], step: float, truth: Array) -> tuple[float, float]:
    """Attitude (rad) and energy (relative) off at END."""
    with started("RigidBody", **motion(solver, rate, step)) as body:
        energy = body.get("kinetic_energy")
        body.step(0.0, END)
        chord = np.linalg.norm(matrix_of(body.get("orientation")) - truth) / np.sqrt(8)
        return 2 * np.arcsin(min(1.0, chord)), abs(body.get("kinetic_energy") / energy - 1)


def motion(solver: str, rate: tuple[float, ...], step: float) -> dict:
    """Parameters of a body that spins without weight."""
    return {
        "inertia": INERTIA,
        "gravity": np.zeros(3),
        "initial_angular_velocity": rate,
        "solver": solver,
        "solver_step": step,
    }


def bench(rounds: int) -> list[Table]:
    """Time of an internal step, and errors after 100 s, for each solver."""
    solvers = fixed_step_solvers("RigidBody")
    bodies = {solver: started("RigidBody", **motion(solver, TUMBLE, STEPS[-1])) for solver in solvers}
    cost = side_by_side({s: repeated_step(body, TIMED_STEPS * STEPS[-1]) for s, body in bodies.items()}, rounds)
    tumble, middle_axis = true_attitude(TUMBLE), true_attitude(MIDDLE_AXIS)
    speed, drift = [], []
    for solver in solvers:
        seconds, ratio = cost[solver]
        attitudes, energies = zip(*(errors(solver, TUMBLE, step, tumble) for step in STEPS), strict=True)
        middle, _ = errors(solver, MIDDLE_AXIS, STEPS[-1], middle_axis)
        speed.append((solver, seconds / TIMED_STEPS * 1e9, ratio, *attitudes, middle))
        drift.append((solver, *energies))
    return [
        Table(
            "RigidBody: solvers",
            f"One doStep of {TIMED_STEPS} internal steps. Error of the attitude (rad) after {END:g} s without torque, "
            f"I = {INERTIA} kg m2, w = {TUMBLE} rad/s; about the middle axis: w = {MIDDLE_AXIS} rad/s. "
            f"Reference: DOP853 at {TOLERANCE:g}.",
            (
                "solver",
                "ns a step",
                "ratio",
                *(f"attitude, {step:g} s" for step in STEPS),
                f"middle axis, {STEPS[-1]:g} s",
            ),
            speed,
        ),
        Table(
            "RigidBody: energy",
            f"Relative error after the same {END:g} s, which without torque keep it.",
            ("solver", *(f"{step:g} s" for step in STEPS)),
            drift,
        ),
    ]
