"""RigidBody: what one step of each solver keeps, and how far its series agrees with the exact flow.

Source: Hairer, Lubich and Wanner, *Geometric Numerical Integration*, II.1 (order), VI.2 and VII.4 (Poisson maps).
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
    skew,
    step_series,
    substituted,
    unit_quaternion,
)
from .equations import LOADS, STATES, equations, symbols
from .solvers import BODY_BRACKET, BRACKET, ENERGY, MOMENTUM, SOLVERS

Step = Callable[[str, Values, SX], Mapping[str, SX]]

ORDERS = {name: SOLVERS[name].orders["loaded"] for name in ("explicit_euler", "notes", "splitting", "rk4")}
"""Of those whose step is one formula, without a branch."""
NO_POISSON_MAP = tuple(name for name in ORDERS if BRACKET not in SOLVERS[name].keeps)


def point() -> Values:
    """Free symbols, with loads that change in time; the orientation has length 1, to which a step returns it."""
    slopes = {f"{name}_rate": SX.sym(f"{name}_rate", 3) for name in LOADS}
    return symbols() | slopes | {"orientation": unit_quaternion("attitude"), "elapsed": SX.sym("elapsed")}


def motion(values: Values) -> list[tuple[SX, SX]]:
    """The exact flow of free symbols: the states first, and the loads that change in time, with their rates."""
    rates = equations(values)
    moving = [(values[name], rates[f"der({name})"]) for name in STATES]
    return moving + [(values[name], values[f"{name}_rate"]) for name in LOADS]


def _later(values: Values) -> Values:
    """The loads at `elapsed`."""
    return values | {name: values[name] + values["elapsed"] * values[f"{name}_rate"] for name in LOADS}


def _without(values: Values, *names: str) -> Values:
    return values | {rate: SX.zeros(3) for name in names for rate in (name, f"{name}_rate")}


def _stacked(states: Mapping[str, SX]) -> SX:
    return ca.vertcat(*[states[name] for name in STATES])


def _series_error(step: Step, solver: str, count: int) -> list[SX]:
    """Taylor coefficients 0 to `count` of the step less those of the exact flow."""
    values = point()
    symbol = values | {"orientation": SX.sym("orientation", 4)}
    h = SX.sym("h")
    exact = flow_series(_stacked(symbol), motion(symbol), count)
    taken = step_series(_stacked(step(solver, symbol, h)), h, count)
    later = _later(symbol)
    loaded = [substituted(b, [(symbol[name], later[name]) for name in LOADS]) for b in exact]
    here = [(symbol["orientation"], values["orientation"])]
    return [substituted(a - b, here) for a, b in zip(taken, loaded, strict=True)]


def _written_out(values: Values, h: SX, *, new: bool) -> Values:
    """Explicit Euler, or with `new` the notes' step: velocities from the new momenta, in the old attitude."""
    rates = equations(_later(values))
    momenta = {name: values[name] + h * rates[f"der({name})"] for name in ("linear_momentum", "angular_momentum")}
    moved = equations(values | momenta) if new else rates
    turned = values["orientation"] + h * moved["der(orientation)"]
    places = {"position": values["position"] + h * moved["der(position)"], "orientation": turned / ca.norm_2(turned)}
    return momenta | places


def _translation_map(step: Step, solver: str) -> SX:
    """M^T J M - J of one step's Jacobian in position and momentum, in a field of force with a potential."""
    values = _without(point(), *LOADS)
    x, momentum, stiffness = values["position"], values["linear_momentum"], SX.sym("stiffness", 3)
    potential = ca.dot(stiffness, x**2) + x[0] * x[1] * x[2] + ca.dot(x, x) ** 2
    after = step(solver, values | {"force": -ca.gradient(potential, x)}, SX.sym("h"))
    slope = ca.jacobian(ca.vertcat(after["position"], after["linear_momentum"]), ca.vertcat(x, momentum))
    area = ca.blockcat([[SX(3, 3), SX.eye(3)], [-SX.eye(3), SX(3, 3)]])
    return ca.vec(slope.T @ area @ slope - area)


def _poisson_matrix(q: SX, momentum: SX) -> SX:
    """The bracket of orientation and angular momentum, 7x7: a turn of the world turns both."""
    turning = ca.horzcat(*[left(ca.vertcat(0, SX.eye(3)[:, i])) @ q / 2 for i in range(3)])
    return ca.blockcat([[SX(4, 4), turning], [-turning.T, -skew(momentum)]])


def poisson_residual(step: Step, solver: str) -> SX:
    """D B(z) D^T - B(z1) of a torque-free step z -> z1 with the Jacobian D: zero for a Poisson map, 49 elements."""
    values = _without(point(), *LOADS)
    q, momentum = SX.sym("orientation", 4), values["angular_momentum"]
    after = step(solver, values | {"orientation": q}, SX.sym("h"))
    turned, moved = after["orientation"], after["angular_momentum"]
    slope = ca.jacobian(ca.vertcat(turned, moved), ca.vertcat(q, momentum))
    residual = slope @ _poisson_matrix(q, momentum) @ slope.T - _poisson_matrix(turned, moved)
    return substituted(ca.vec(residual), [(q, values["orientation"])])


def body_poisson_residual(step: Step, solver: str) -> SX:
    """The same of the momenta in body axes, m -> m1: D [m] D^T - [m1], 9 elements."""
    values = _without(point(), *LOADS)
    attitude, body = rotation_matrix(values["orientation"]), SX.sym("body_momentum", 3)
    after = step(solver, values | {"angular_momentum": attitude @ body}, SX.sym("h"))
    moved = rotation_matrix(after["orientation"]).T @ after["angular_momentum"]
    slope = ca.jacobian(moved, body)
    residual = slope @ skew(body) @ slope.T - skew(moved)
    return substituted(ca.vec(residual), [(body, attitude.T @ values["angular_momentum"])])


def _turned_step(step: Step, solver: str) -> SX:
    """A step seen from turned axes, less the turned step."""
    values, turn, h = point(), unit_quaternion("turn"), SX.sym("h")
    matrix = rotation_matrix(turn)
    world = [*LOADS, *[f"{name}_rate" for name in LOADS], "gravity", "position", "linear_momentum", "angular_momentum"]
    seen = values | {name: matrix @ values[name] for name in world}
    here, there = step(solver, values, h), step(solver, seen | {"orientation": left(turn) @ values["orientation"]}, h)
    return ca.vertcat(
        there["orientation"] - left(turn) @ here["orientation"],
        *[there[name] - matrix @ here[name] for name in STATES if name != "orientation"],
    )


def _energy_error(step: Step, solver: str) -> SX:
    """What a torque-free step adds to the kinetic energy."""
    values = _without(point(), *LOADS)
    after = step(solver, values, SX.sym("h"))
    spin = {name: after[name] for name in ("orientation", "angular_momentum")}
    still = values | {"linear_momentum": SX.zeros(3)}
    return equations(still | spin)["kinetic_energy"] - equations(still)["kinetic_energy"]


def _momentum_error(step: Step, solver: str) -> SX:
    """What a torque-free step changes of the angular momentum, and of the quaternion's length 1."""
    values = _without(point(), *LOADS)
    after = step(solver, values, SX.sym("h"))
    q = after["orientation"]
    return ca.vertcat(after["angular_momentum"] - values["angular_momentum"], ca.dot(q, q) - 1)


QUANTITIES = {
    MOMENTUM: ("free", _momentum_error),
    ENERGY: ("free", _energy_error),
    BRACKET: ("free", poisson_residual),
    BODY_BRACKET: ("free", body_poisson_residual),
}
"""What the exact flow keeps: the kind of case, and what a step changes of it."""


def start(values: Values) -> Values:
    """The parameters with which the body starts from the states of `values`."""
    results = equations(values)
    same = {f"initial_{name}": values[name] for name in ("position", "orientation")}
    return same | {f"initial_{name}": results[name] for name in ("velocity", "angular_velocity")}


def step_identities(step: Step) -> dict[str, SX]:
    """Orders and what is kept, for every solver."""
    h = SX.sym("h")
    claims = {}
    for solver, order in ORDERS.items():
        values = point()
        loaded, free = step(solver, values, h), step(solver, _without(values, *LOADS), h)
        q = loaded["orientation"]
        claims |= {
            f"{solver}: agrees with the exact flow up to h^{order}": ca.vertcat(*_series_error(step, solver, order)),
            f"{solver}: the quaternion after a step has length 1": ca.dot(q, q) - 1,
            f"{solver}: without torque the angular momentum stays": free["angular_momentum"]
            - values["angular_momentum"],
            f"{solver}: without force the momentum changes by the weight": free["linear_momentum"]
            - values["linear_momentum"]
            - h * values["mass"] * values["gravity"],
            f"{solver}: a step in turned axes is the turned step": _turned_step(step, solver),
        }
    values = point()
    for solver, how, new in (
        ("explicit_euler", "all from the old state", False),
        ("notes", "place and attitude from the new momenta, those from the old forces", True),
    ):
        claims[f"{solver}: {how}"] = _stacked(step(solver, values, h)) - _stacked(_written_out(values, h, new=new))
    values = _without(values, *LOADS)
    notes, euler = step("notes", values, h), step("explicit_euler", values, h)
    return claims | {
        "notes: without torque its attitude is explicit Euler's": notes["orientation"] - euler["orientation"],
        "notes: symplectic in translation, in any field of force": _translation_map(step, "notes"),
        "splitting: a Poisson map in rotation": poisson_residual(step, "splitting"),
        "rk4 and splitting: exact in translation, the forces linear in time": ca.vertcat(
            _fall_error(step, "rk4"), _fall_error(step, "splitting")
        ),
    }


def _fall_error(step: Step, solver: str) -> SX:
    """Position and momentum after a step, less those of the parabola that the forces bend."""
    values, h = point(), SX.sym("h")
    after = step(solver, values, h)
    forces = ("force", "base_force", "tip_force")
    later = _later(values)
    force = values["mass"] * values["gravity"] + sum(later[name] for name in forces)
    slope = sum(values[f"{name}_rate"] for name in forces)
    impulse = h * force + h**2 * slope / 2
    way = h * values["linear_momentum"] + h**2 * force / 2 + h**3 * slope / 6
    return ca.vertcat(
        after["linear_momentum"] - values["linear_momentum"] - impulse,
        after["position"] - values["position"] - way / values["mass"],
    )


def step_failures(step: Step) -> dict[str, SX]:
    """What no solver here keeps, or only that for translation."""
    return {
        "no solver is better than its order: each departs from the exact flow at the next power of h": all_differ(
            _series_error(step, solver, order + 1)[-1] for solver, order in ORDERS.items()
        ),
        "explicit_euler, notes and rk4 are no Poisson maps in rotation": all_differ(
            poisson_residual(step, solver) for solver in NO_POISSON_MAP
        ),
        "no solver keeps the energy of rotation": all_differ(_energy_error(step, solver) for solver in ORDERS),
        "explicit_euler and rk4 are not symplectic in translation": all_differ(
            _translation_map(step, solver) for solver in ("explicit_euler", "rk4")
        ),
    }
