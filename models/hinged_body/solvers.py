"""HingedBody: the orders that its solvers declare, what they keep, and the points at which whole steps are judged."""

from ..declared import CHOSEN, Solver

KINDS = {"resting": "anchor at rest", "turning": "anchor tumbling"}
AREAS = "areas of angle and rate without damping"
ENERGY = "the energy of an undamped swing"

SOLVERS = {
    "explicit_euler": Solver({"resting": 1, "turning": 1}),
    "semi_implicit_euler": Solver({"resting": 1, "turning": 1}, {AREAS}),
    "rk4": Solver({"resting": 4, "turning": 4}),
    "taylor": Solver({"resting": CHOSEN, "turning": CHOSEN}),
    "automatic": Solver({"resting": CHOSEN, "turning": CHOSEN}),
}

_BODY = {
    "h": [0.125],
    "solver_step": [1.0],
    "tolerance": [1e-9],
    "mass": [1.25],
    "inertia": [1.0, 2.0, 2.5],
    "center_of_mass": [0.5, -0.25, 0.125],
    "tip": [-0.125, 0.75, 0.5],
    "axis_slope": [0.25, -0.5],
    "gravity": [0.5, -1.0, -8.0],
    "stiffness": [6.0],
    "damping": [0.5],
    "friction": [0.25],
    "anchor_attitude": [0.25, -0.5, 0.125],
    "anchor_acceleration": [0.5, -0.25, 1.0],
    "anchor_acceleration_rate": [-1.0, 0.5, 0.25],
    "target_angle": [0.75],
    "target_angle_rate": [-0.5],
    "torque": [0.5],
    "torque_rate": [1.0],
    "tip_force": [0.25, 0.75, -0.5],
    "tip_force_rate": [0.5, 1.0, -0.25],
    "tip_torque": [-0.25, 0.125, 0.375],
    "tip_torque_rate": [0.25, -0.5, 0.75],
    "angle": [0.5],
    "rate": [-1.0],
}
_TUMBLING = {
    "anchor_angular_velocity": [0.75, -1.0, 0.5],
    "anchor_angular_acceleration": [0.5, 0.75, -1.0],
    "anchor_angular_acceleration_rate": [-1.0, 0.5, 0.75],
}

CASES = {"resting": [_BODY], "turning": [_BODY | _TUMBLING]}
"""By kind; `axis_slope` and `anchor_attitude` are stereographic projections, and what is not given is zero."""
