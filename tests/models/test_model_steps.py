"""What the models claim of steps: shown on solvers written here, and refuted on broken ones."""

from functools import cache

import casadi as ca
import pytest
from casadi import SX

from ulna.checks.identity import vanishes
from ulna.checks.textbook import load_model

STATES = {
    "rigid_body": ("position", "orientation", "linear_momentum", "angular_momentum"),
    "hinged_body": ("angle", "rate"),
}
RUNGE_KUTTA = ((0, 1 / 6), (1 / 2, 1 / 3), (1 / 2, 1 / 3), (1, 1 / 6))
"""Reach of each stage, and its weight, in steps."""

BODY = load_model("rigid_body")


@cache
def model(unit):
    return load_model(unit)


def product(a, b):
    """Hamilton's, from his table."""
    w, v, s, u = a[0], a[1:], b[0], b[1:]
    return ca.vertcat(w * s - ca.dot(v, u), w * u + s * v + ca.cross(v, u))


def loads_at(values, time):
    """Inputs that are linear in time, and an anchor that turns about one axis."""
    now = {name: values[name] + time * values[f"{name}_rate"] for name in values if f"{name}_rate" in values}
    if "anchor_angular_velocity" in values:
        rate, slope, bend = (
            values[f"anchor_angular_{name}"] for name in ("velocity", "acceleration", "acceleration_rate")
        )
        turn = time * rate + time**2 / 2 * slope + time**3 / 6 * bend
        length = ca.norm_2(turn)
        turned = ca.vertcat(ca.cos(length / 2), ca.sin(length / 2) * turn / length)
        now["anchor_orientation"] = product(turned, values["anchor_orientation"])
        now["anchor_angular_velocity"] = rate + time * slope + time**2 / 2 * bend
    return values | now


def rates(unit, values, time):
    results = model(unit).equations(loads_at(values, time))
    return {name: results[f"der({name})"] for name in STATES[unit]}


def on_unit_sphere(states):
    if "orientation" in states:
        states = states | {"orientation": states["orientation"] / ca.norm_2(states["orientation"])}
    return states


def euler(unit, values, h):
    slope = rates(unit, values, values["elapsed"])
    return on_unit_sphere({name: values[name] + h * slope[name] for name in STATES[unit]})


def runge_kutta(unit, values, h, stages=RUNGE_KUTTA):
    after = {name: values[name] for name in STATES[unit]}
    slope = dict.fromkeys(STATES[unit], 0)
    for reach, weight in stages:
        stage = {name: values[name] + reach * h * slope[name] for name in STATES[unit]}
        slope = rates(unit, values | stage, values["elapsed"] + reach * h)
        after = {name: after[name] + weight * h * slope[name] for name in STATES[unit]}
    return on_unit_sphere(after)


def notes(unit, values, h):
    """Momenta from the old forces, then place and attitude from the new momenta, in the old attitude."""
    slope = rates(unit, values, values["elapsed"])
    momenta = {name: values[name] + h * slope[name] for name in ("linear_momentum", "angular_momentum")}
    moved = rates(unit, values | momenta, values["elapsed"])
    places = {name: values[name] + h * moved[name] for name in ("position", "orientation")}
    return on_unit_sphere(momenta | places)


def semi_implicit(unit, values, h):
    rate = values["rate"] + h * rates(unit, values, values["elapsed"])["rate"]
    return {"rate": rate, "angle": values["angle"] + h * rate}


def five_rotations(q, momentum, inertia, h):
    """Turns about the body axes 1, 2, 3, 2, 1, each the exact motion of its part of the energy."""
    for axis, part in ((0, h / 2), (1, h / 2), (2, h), (1, h / 2), (0, h / 2)):
        along = product(product(ca.vertcat(q[0], -q[1:]), ca.vertcat(0, momentum)), q)[1 + axis]
        half = part * along / inertia[axis] / 2
        q = product(q, ca.vertcat(ca.cos(half), ca.sin(half) * SX.eye(3)[:, axis]))
    return q


def splitting(unit, values, h):
    """Half a kick by the torque, free rotation, half a kick; the forces are linear in time."""
    before = rates(unit, values, values["elapsed"])
    kicked = values["angular_momentum"] + h / 2 * before["angular_momentum"]
    q = five_rotations(values["orientation"], kicked, values["inertia"], h)
    after = rates(unit, values | {"orientation": q}, values["elapsed"] + h)
    push, last = before["linear_momentum"], after["linear_momentum"]
    way = h * values["linear_momentum"] + h**2 / 6 * (2 * push + last)
    return on_unit_sphere(
        {
            "position": values["position"] + way / values["mass"],
            "orientation": q,
            "linear_momentum": values["linear_momentum"] + h / 2 * (push + last),
            "angular_momentum": kicked + h / 2 * after["angular_momentum"],
        }
    )


SOLVERS = {
    "rigid_body": {"explicit_euler": euler, "notes": notes, "splitting": splitting, "rk4": runge_kutta},
    "hinged_body": {"explicit_euler": euler, "semi_implicit_euler": semi_implicit, "rk4": runge_kutta},
}


def stepper(unit, **changed):
    """The solvers above as the models want them, some of them changed."""

    def step(solver, values, h):
        return (SOLVERS[unit] | changed)[solver](unit, values, h)

    return step


def refuted(unit, claims):
    return [claim for claim, expression in claims.items() if not vanishes(expression, model(unit).SAMPLES).vanishes]


def test_the_solvers_of_the_rigid_body_keep_what_is_claimed():
    assert refuted("rigid_body", BODY.step_identities(stepper("rigid_body"))) == []


def test_the_solvers_of_the_hinge_keep_what_is_claimed():
    claims = model("hinged_body").step_identities(stepper("hinged_body"))
    # rk4's series on Lagrange's equations is long: the C's is the one that the checks judge
    claims = {claim: expression for claim, expression in claims.items() if not claim.startswith("rk4: agrees")}
    assert refuted("hinged_body", claims) == []


def test_the_solvers_lose_what_is_claimed():
    claims = BODY.step_failures(stepper("rigid_body"))
    assert refuted("rigid_body", claims) == list(claims)


def test_a_wrong_weight_in_runge_kutta_costs_its_order():
    stages = (*RUNGE_KUTTA[:3], (1, 1 / 7))
    broken = stepper("rigid_body", rk4=lambda unit, values, h: runge_kutta(unit, values, h, stages))
    assert "rk4: agrees with the exact flow up to h^4" in refuted("rigid_body", BODY.step_identities(broken))


def test_old_velocity_for_new_is_not_symplectic():
    """The notes' step with the old velocity is explicit Euler."""
    claims = BODY.step_identities(stepper("rigid_body", notes=euler))
    assert refuted("rigid_body", claims) == [
        "notes: place and attitude from the new momenta, those from the old forces",
        "notes: symplectic in translation, in any field of force",
    ]


@pytest.mark.parametrize(
    ("changed", "claim"),
    [
        ({"explicit_euler": notes}, "explicit_euler and rk4 are not symplectic in translation"),
        (
            {"explicit_euler": runge_kutta},
            "no solver is better than its order: each departs from the exact flow at the next power of h",
        ),
    ],
)
def test_a_solver_in_the_place_of_another_is_noticed(changed, claim):
    """Failures are claims too: they break where a solver loses less than it is known to lose."""
    expression = BODY.step_failures(stepper("rigid_body", **changed))[claim]
    assert vanishes(expression, BODY.SAMPLES).vanishes


def test_the_semi_implicit_step_with_the_old_rate_does_not_keep_areas():
    claims = model("hinged_body").step_identities(stepper("hinged_body", semi_implicit_euler=euler))
    (claim,) = [claim for claim in claims if "keeps areas" in claim]
    assert refuted("hinged_body", {claim: claims[claim]}) == [claim]


@pytest.mark.parametrize(
    ("solver", "poisson"), [(splitting, True), (notes, False), (euler, False), (runge_kutta, False)]
)
def test_the_poisson_residual_tells_a_splitting_from_the_rest(solver, poisson):
    """Composed of exact motions of Hamiltonians, a splitting is a Poisson map; no other solver here is one."""
    residual = BODY.poisson_residual(stepper("rigid_body", chosen=solver), "chosen")
    assert vanishes(residual, BODY.SAMPLES).vanishes == poisson
