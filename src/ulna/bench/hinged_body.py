"""HingedBody: what a step of each solver costs, how far off it is, and up to which step it is stable."""

import math

import numpy as np

from ..slave import Slave
from .measuring import TOLERANCE, Array, fixed_step_solvers, integrated, repeated_step, side_by_side, started
from .tables import Table

STEPS = (0.01, 0.001)  # s
TIMED_STEPS = 10_000
SWING_END, REACH_END, REACH = 10.0, 0.5, 1.5  # s, s, rad
SWING = {"stiffness": 0.0, "damping": 0.0}
SPINNING_ANCHOR = {"anchor_angular_velocity": [0.6, 0.0, 0.8], "anchor_angular_acceleration": [0.0, 0.1, 0.0]}
LIMIT_STEPS = 300


def default_forearm() -> dict[str, float]:
    """The default body in its plane: moment of inertia about the hinge kg m2, moment of its weight N m, muscle."""
    with Slave("HingedBody") as body:
        mass, lever = body.get("mass"), body.get("center_of_mass")[0]
        return {
            "inertia": body.get("inertia")[1] + mass * lever**2,
            "weight": -mass * lever * body.get("gravity")[2],
            "stiffness": body.get("stiffness"),
            "damping": body.get("damping"),
        }


def true_angle(forearm: dict[str, float], target: float, end: float) -> float:
    """Angle (rad) at `end`, from rest at 0: inertia a'' = -weight cos a + stiffness (target - a) - damping a'."""

    def slope(_: float, y: Array) -> list[float]:
        muscle = forearm["stiffness"] * (target - y[0]) - forearm["damping"] * y[1]
        return [y[1], (muscle - forearm["weight"] * math.cos(y[0])) / forearm["inertia"]]

    return float(integrated(slope, [0.0, 0.0], end)[0])


def angle_after(end: float, values: dict) -> float:
    """Angle (rad) of the unit after one communication step to `end`."""
    with started("HingedBody", **values) as body:
        body.step(0.0, end)
        return body.get("angle")


def stable_up_to(solver: str, forearm: dict[str, float]) -> float:
    """Largest step (s) at which the faster mode of the default muscle does not grow, by bisection."""
    half = forearm["damping"] / (2 * forearm["inertia"])
    decay = half + math.sqrt(half**2 - forearm["stiffness"] / forearm["inertia"])
    low, high = 0.1 / decay, 3.5 / decay
    start = {"gravity": np.zeros(3), "initial_angle": 1e-3, "initial_rate": -1e-3 * decay, "solver": solver}
    while high - low > 1e-3 * low:
        middle = (low + high) / 2
        grown = abs(angle_after(LIMIT_STEPS * middle, start | {"solver_step": middle})) > 1e-3
        low, high = (low, middle) if grown else (middle, high)
    return low


def bench(rounds: int) -> list[Table]:
    """Time of an internal step, errors of the angle, and the limit of stability, for each solver."""
    solvers = fixed_step_solvers("HingedBody")
    forearm = default_forearm()
    calls = {}
    for solver in solvers:
        for anchor, inputs in (("rest", {}), ("spin", SPINNING_ANCHOR)):
            body = started("HingedBody", solver=solver, solver_step=STEPS[-1], **inputs)
            calls[solver, anchor] = repeated_step(body, TIMED_STEPS * STEPS[-1])
    cost = side_by_side(calls, rounds)
    swing = true_angle(forearm | SWING, 0.0, SWING_END)
    reach = true_angle(forearm, REACH, REACH_END)
    speed, accuracy = [], []
    for solver in solvers:
        runs = [{"solver": solver, "solver_step": step} for step in STEPS]
        (seconds, ratio), (_, spin_ratio) = cost[solver, "rest"], cost[solver, "spin"]
        limit = 1e3 * stable_up_to(solver, forearm)
        speed.append((solver, seconds / TIMED_STEPS * 1e9, ratio, spin_ratio, limit))
        swings = [abs(angle_after(SWING_END, SWING | values) - swing) for values in runs]
        reaches = [abs(angle_after(REACH_END, {"target_angle": REACH} | values) - reach) for values in runs]
        accuracy.append((solver, *swings, *reaches))
    return [
        Table(
            "HingedBody: solvers",
            f"One doStep of {TIMED_STEPS} internal steps. Stable: the largest step with the default muscle.",
            ("solver", "ns a step", "ratio", "ratio, anchor spins", "stable up to, ms"),
            speed,
        ),
        Table(
            "HingedBody: errors of the angle, rad",
            f"The default forearm let go level without muscle, after {SWING_END:g} s; with its muscle, {REACH_END:g} s "
            f"after a step of the target by {REACH:g} rad. Reference: DOP853 at {TOLERANCE:g}.",
            (
                "solver",
                *(f"swing, {1e3 * step:g} ms" for step in STEPS),
                *(f"muscle, {1e3 * step:g} ms" for step in STEPS),
            ),
            accuracy,
        ),
    ]
