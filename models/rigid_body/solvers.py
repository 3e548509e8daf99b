"""RigidBody: the orders that its solvers declare, what they keep, and the points at which whole steps are judged.

Sources: Austin, Krishnaprasad and Wang, J. Comput. Phys. 107 (1993) 105 (the midpoint keeps energy and angular momentum
and is no Poisson map); Dullweber, Leimkuhler and McLachlan, J. Chem. Phys. 107 (1997) 5840 (splitting); Hairer and
Vilmart, J. Phys. A 39 (2006) 13225 (Moser-Veselov).
"""

from ..declared import CHOSEN, EVERY, Solver

KINDS = {"free": "without torque", "loaded": "with torques"}
MOMENTUM = "angular momentum and the quaternion's length"
ENERGY = "the energy of rotation"
BRACKET = "the bracket of orientation and angular momentum: a Poisson map"
BODY_BRACKET = "the bracket of the body momenta: a Poisson map in body axes"

SOLVERS = {
    "explicit_euler": Solver({"free": 1, "loaded": 1}, {MOMENTUM}),
    "notes": Solver({"free": 1, "loaded": 1}, {MOMENTUM}),
    "midpoint": Solver({"free": 2, "loaded": 2}, {MOMENTUM, ENERGY}),
    "splitting": Solver({"free": 2, "loaded": 2}, {MOMENTUM, BRACKET, BODY_BRACKET}),
    "rk4": Solver({"free": 4, "loaded": 4}, {MOMENTUM}),
    "moser_veselov": Solver({"free": 10, "loaded": 2}, {MOMENTUM, ENERGY, BODY_BRACKET}),
    "taylor": Solver({"free": CHOSEN, "loaded": CHOSEN}, {MOMENTUM}),
    "exact": Solver({"free": EVERY, "loaded": CHOSEN}, {MOMENTUM, ENERGY, BRACKET, BODY_BRACKET}),
    "automatic": Solver({"free": EVERY, "loaded": CHOSEN}, {MOMENTUM, ENERGY, BRACKET, BODY_BRACKET}),
}

_SETTINGS = {"h": [0.5], "solver_step": [1.0], "tolerance": [1e-9]}
_BODY = _SETTINGS | {
    "mass": [1.25],
    "inertia": [1.0, 2.0, 2.5],
    "gravity": [0.5, -1.0, -2.0],
    "base": [0.25, -0.5, 0.125],
    "tip": [-0.125, 0.25, 0.5],
    "position": [0.5, -0.25, 1.0],
    "attitude": [0.25, -0.5, 0.125],
    "linear_momentum": [0.75, -1.0, 0.5],
    "angular_momentum": [0.75, 2.0, -1.0],
}
_LOADS = {
    "h": [0.375],
    "force": [0.5, -0.25, 1.0],
    "torque": [0.25, 0.5, -0.125],
    "base_force": [-0.5, 0.25, 0.75],
    "base_torque": [0.125, -0.25, 0.5],
    "tip_force": [0.25, 0.75, -0.5],
    "tip_torque": [-0.25, 0.125, 0.375],
    "force_rate": [-1.0, 0.5, 0.25],
    "torque_rate": [0.5, 0.25, -0.75],
    "base_force_rate": [0.25, -0.5, 1.0],
    "base_torque_rate": [-0.75, 0.5, 0.25],
    "tip_force_rate": [0.5, 1.0, -0.25],
    "tip_torque_rate": [0.25, -0.5, 0.75],
}
_NEAR_THE_MIDDLE = {"inertia": [1.0, 2.0, 3.0], "angular_momentum": [0.125, 2.0, 0.25], "attitude": [0.0, 0.0, 0.0]}
"""Near the separatrix, where the closed form takes its other series."""

CASES = {"free": [_BODY, _BODY | _NEAR_THE_MIDDLE], "loaded": [_BODY | _LOADS]}
"""By kind; `attitude` is the stereographic projection of the orientation, and what is not given is zero."""
