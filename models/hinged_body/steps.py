"""HingedBody: what one step of each solver keeps, and how far its series agrees with the exact flow.

Within a communication step the anchor turns by the integral of its angular velocity: exact while the axis of that turn
stays. `elapsed` is free, so that a step from within the communication step is judged too.
"""

from collections.abc import Callable, Mapping

import casadi as ca
from casadi import SX

from ..algebra import (
    Values,
    all_differ,
    flow_series,
    left,
    rotation_matrix,
    step_series,
    substituted,
    unit_quaternion,
    unit_vector,
)
from .equations import ANCHOR, STATES, anchor_motion, equations, free_symbols, symbols
from .solvers import AREAS, ENERGY, SOLVERS

Step = Callable[[str, Values, SX], Mapping[str, SX]]

ORDERS = {name: SOLVERS[name].orders["turning"] for name in ("explicit_euler", "semi_implicit_euler", "rk4")}
"""Of those whose step is one formula, without a branch."""
SLOPES = ("target_angle", "torque", "tip_force", "tip_torque", "anchor_acceleration", "anchor_angular_acceleration")


def _slopes(values: Values) -> Values:
    return {f"{name}_rate": SX.sym(f"{name}_rate", values[name].numel()) for name in SLOPES}


def point() -> Values:
    """Free symbols, inputs that change in time, the anchor's quaternion of length 1."""
    values = symbols() | {"anchor_orientation": unit_quaternion("anchor_attitude")}
    return values | _slopes(values) | {"elapsed": SX.sym("elapsed")}


def motion(values: Values) -> list[tuple[SX, SX]]:
    """The exact flow of free symbols: the states first, the anchor, and the inputs that change, with their rates."""
    rates = equations(values)
    moving = [(values[name], rates[f"der({name})"]) for name in STATES] + anchor_motion(values)
    return moving + [(values[name], values[f"{name}_rate"]) for name in SLOPES]


def _turning_about(axis: SX, values: Values) -> tuple[Values, SX]:
    """The anchor turns about one axis with a speed quadratic in time; and its turn at `elapsed` as a quaternion."""
    speeds = [SX.sym(name) for name in ("speed", "speed_rate", "speed_rate_rate")]
    names = ("anchor_angular_velocity", "anchor_angular_acceleration", "anchor_angular_acceleration_rate")
    time = values["elapsed"]
    turn = speeds[0] * time + speeds[1] * time**2 / 2 + speeds[2] * time**3 / 6
    quaternion = ca.vertcat(ca.cos(turn / 2), ca.sin(turn / 2) * axis)
    return values | {name: s * axis for name, s in zip(names, speeds, strict=True)}, quaternion


def _later(values: Values, turn: SX) -> Values:
    """The inputs at `elapsed`, where the anchor has turned by a quaternion."""
    time = values["elapsed"]
    later = {name: values[name] + time * values[f"{name}_rate"] for name in SLOPES}
    for kind in ("", "angular_"):
        acceleration, slope = values[f"anchor_{kind}acceleration"], values[f"anchor_{kind}acceleration_rate"]
        later[f"anchor_{kind}velocity"] = values[f"anchor_{kind}velocity"] + time * acceleration + time**2 * slope / 2
    return values | later | {"anchor_orientation": left(turn) @ values["anchor_orientation"]}


def _series_error(step: Step, solver: str, count: int, values: Values, turn: SX) -> list[SX]:
    """Taylor coefficients 0 to `count` of the step less those of the exact flow, the anchor turned as said."""
    symbol = free_symbols()
    symbol |= _slopes(symbol)
    later = _later(values, turn)
    exact = flow_series(ca.vertcat(*[symbol[name] for name in STATES]), motion(symbol), count)
    h = SX.sym("h")
    after = step(solver, values, h)
    taken = step_series(ca.vertcat(*[after[name] for name in STATES]), h, count)
    here = [(symbol[name], later[name]) for name in symbol]
    return [a - substituted(b, here) for a, b in zip(taken, exact, strict=True)]


def _steady_axis_error(step: Step, solver: str, count: int) -> list[SX]:
    values, turn = _turning_about(unit_vector("anchor_axis"), point())
    return _series_error(step, solver, count, values, turn)


def _area(step: Step, solver: str) -> SX:
    """Factor of areas of angle and rate in one step without damping and friction, less 1."""
    values = point() | {"damping": SX(0), "friction": SX(0)}
    after = step(solver, values, SX.sym("h"))
    slope = ca.jacobian(ca.vertcat(after["angle"], after["rate"]), ca.vertcat(values["angle"], values["rate"]))
    return slope[0, 0] * slope[1, 1] - slope[0, 1] * slope[1, 0] - 1


def _energy_error(step: Step, solver: str) -> SX:
    """What a step adds to the energy where the anchor rests, nothing damps, and weight and muscle alone act."""
    values = point()
    still = [name for name in (*ANCHOR, *SLOPES) if name not in ("anchor_orientation", "target_angle")]
    rates = [f"{name}_rate" for name in SLOPES]
    values |= {name: SX.zeros(values[name].numel()) for name in ("damping", "friction", *still, *rates)}
    before, after = equations(values), equations(values | step(solver, values, SX.sym("h")))
    return sum(after[name] - before[name] for name in ("kinetic_energy", "potential_energy"))


QUANTITIES = {AREAS: ("turning", _area), ENERGY: ("resting", _energy_error)}
"""What the exact flow keeps: the kind of case, and what a step changes of it."""


def start(values: Values) -> Values:
    """The parameters with which the body starts from the states of `values`."""
    return {f"initial_{name}": values[name] for name in STATES}


def _turned_step(step: Step, solver: str) -> SX:
    """A step seen from turned axes, less the step."""
    values, _ = _turning_about(unit_vector("anchor_axis"), point())
    turn, h = unit_quaternion("turn"), SX.sym("h")
    matrix = rotation_matrix(turn)
    world = [name for name in ANCHOR if name != "anchor_orientation"] + ["gravity", "tip_force", "tip_torque"]
    world += [f"{name}_rate" for name in world if f"{name}_rate" in values]
    seen = values | {name: matrix @ values[name] for name in world}
    seen["anchor_orientation"] = left(turn) @ values["anchor_orientation"]
    here, there = step(solver, values, h), step(solver, seen, h)
    return ca.vertcat(*[there[name] - here[name] for name in STATES])


def step_identities(step: Step) -> dict[str, SX]:
    """Orders and what is kept, for every solver."""
    claims = {}
    for solver, order in ORDERS.items():
        claims |= {
            f"{solver}: agrees with the exact flow up to h^{order}, the anchor's axis of turn at rest": ca.vertcat(
                *_steady_axis_error(step, solver, order)
            ),
            f"{solver}: a step in turned axes is the same step": _turned_step(step, solver),
        }
    return claims | {
        "semi_implicit_euler: keeps areas of angle and rate without damping, however the anchor moves": _area(
            step, "semi_implicit_euler"
        )
    }


def step_failures(step: Step) -> dict[str, SX]:
    """What no solver here, or not that one, keeps."""
    return {
        "no solver is better than its order: each departs from the exact flow at the next power of h": all_differ(
            _steady_axis_error(step, solver, order + 1)[-1] for solver, order in ORDERS.items()
        ),
        "explicit_euler and rk4 do not keep areas of angle and rate": all_differ(
            _area(step, solver) for solver in ("explicit_euler", "rk4")
        ),
    }
