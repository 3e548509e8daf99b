"""Springs: within the step and held over it, against the textbook's limits."""

import math

import numpy as np
import pytest

from ulna.bench.measuring import choices, started
from ulna.bench.rigid_body import motion
from ulna.stability import theory
from ulna.stability.small_errors import factor, held_spring, hinge_spring, weight_spring

INSIDE = [("HingedBody", solver, hinge_spring) for solver in choices("HingedBody", "solver")]
INSIDE += [("RigidBody", solver, weight_spring) for solver in choices("RigidBody", "solver")]
NAMES = [f"{unit}-{solver}" for unit, solver, _ in INSIDE]
BODY_SOLVERS = choices("RigidBody", "solver")


def swing(solver: str, z: float, steps: int) -> float:
    """Largest amplitude (rad) of a hinge's spring let go at 1 rad, of a hundred looks over `steps` internal steps."""
    values = {"inertia": [1.0] * 3, "mass": 1.0, "center_of_mass": [0.0] * 3, "gravity": [0.0] * 3, "stiffness": 1.0}
    values |= {"damping": 0.0, "initial_angle": 1.0, "solver": solver, "solver_step": z}
    span, most = steps / 100 * z, 0.0
    with started("HingedBody", **values) as body:
        for look in range(100):
            body.step(look * span, span)
            most = max(most, math.hypot(body.get("angle"), body.get("rate")))
    return most


def test_every_solver_has_a_theory():
    assert {solver for _, solver, _ in INSIDE} == set(theory.SPRING_LIMITS)


@pytest.mark.parametrize(("unit", "solver", "step"), INSIDE, ids=NAMES)
def test_a_spring_inside_the_step_holds_up_to_the_limit_and_not_beyond(unit, solver, step):
    limit = theory.SPRING_LIMITS[solver]
    # the maps are known to 1e-9; below the limit a factor of 1 + 1e-8 grows to 1.0002 in 20 000 steps
    holds, fails = (0.1 * limit, 0.99 * limit), (1.01 * limit, 2 * limit)
    if limit == 0.0:
        holds, fails = (), (0.1, 1.0)
    elif limit == math.inf:
        holds, fails = (0.1, 1.0, 1.9, 2.8, 10.0), ()
    assert all(factor(step(solver, z)) <= 1 + 1e-8 for z in holds)
    assert all(factor(step(solver, z)) > 1 + 1e-3 for z in fails)


@pytest.mark.parametrize("z", [0.05, 0.5, 2.0])
def test_factors_of_the_hinge_are_the_stability_functions(z):
    runge_kutta = abs(1 + 1j * z - z**2 / 2 - 1j * z**3 / 6 + z**4 / 24)
    assert factor(hinge_spring("explicit_euler", z)) == pytest.approx(math.sqrt(1 + z**2), rel=1e-14)
    assert factor(hinge_spring("rk4", z)) == pytest.approx(runge_kutta, rel=1e-14)
    # a defective pair at z = 2, the limit itself: its eigenvalues are known to the root of round-off
    assert factor(hinge_spring("semi_implicit_euler", z)) == pytest.approx(1.0, rel=1e-14 if z < 2 else 1e-7)


@pytest.mark.parametrize(("solver", "limit"), [("semi_implicit_euler", 2.0), ("rk4", math.sqrt(8))])
def test_a_long_run_of_the_hinge_agrees(solver, limit):
    # near its limit the ellipse of semi-implicit Euler is 1 / sqrt(1 - (z/2)^2) = 7 times as long as wide
    assert swing(solver, 0.99 * limit, 20_000) < 10.0
    assert swing(solver, 1.01 * limit, 2_000) > 1e6


def test_explicit_euler_lets_any_spring_grow_as_theory_says():
    # sqrt(1 + z^2)^20000 at z = 0.03 is about exp(9)
    assert swing("explicit_euler", 0.03, 20_000) == pytest.approx((1 + 0.03**2) ** 10_000, rel=1e-10)
    assert swing("explicit_euler", 0.001, 2_000) < 1.002


@pytest.mark.parametrize("solver", BODY_SOLVERS)
@pytest.mark.parametrize("sloped", [False, True], ids=["held", "with slope"])
@pytest.mark.parametrize("z", [0.05, 0.7, 1.9, 2.1, 3.0])
def test_a_held_spring_grows_by_the_factor_of_theory(solver, sloped, z):
    expected = theory.held_force_factor(solver, z, sloped)
    assert factor(held_spring(solver, z, sloped)) == pytest.approx(expected, rel=1e-13)


def test_held_forces_pump_any_spring_but_the_notes():
    for z in (0.05, 0.7, 1.9):
        assert theory.held_force_factor("notes", z) == pytest.approx(1.0, abs=1e-12)
        assert theory.held_force_factor("rk4", z) == pytest.approx(math.sqrt(1 + z**2 / 2), rel=1e-14)
        assert theory.held_force_factor("rk4", z, sloped=True) == pytest.approx(math.sqrt(1 + z**4 / 12), rel=1e-14)
    assert theory.held_force_factor("notes", 2.01) > 1.1


@pytest.mark.parametrize("count", [1, 2, 7])
def test_the_notes_hold_a_held_spring_only_with_one_internal_step(count):
    found = factor(held_spring("notes", 0.7, sub_steps=count))
    assert found == pytest.approx(theory.held_sub_steps_factor(0.7, count), rel=1e-13)
    assert found == pytest.approx(math.sqrt(1 + 0.7**2 * (count - 1) / (2 * count)), rel=1e-13)


@pytest.mark.parametrize("solver", ["notes", "rk4", "exact"])
def test_a_long_run_with_a_held_spring_agrees(solver):
    z, steps = 0.1, 2000
    with started("RigidBody", **motion(solver, (0.0, 0.0, 0.0), z), initial_position=[1.0, 0.0, 0.0]) as body:
        most = 0.0
        for step in range(steps):
            body.set("force", -body.get("position"))
            body.step(step * z, z)
            if step >= steps - 70:  # the last turn, of 2 pi / z = 63 steps
                most = max(most, float(np.linalg.norm(body.get("position"))))
    # theory's factor a step; the looks miss the top of the swing by (z / 2)^2 / 2, and the last turn is not the end
    assert most == pytest.approx(theory.held_force_factor(solver, z) ** steps, rel=0.1)


def test_the_map_shows_these_limits(found):
    for row in found["springs"]:
        assert row["limit"] == pytest.approx(row["theory"], rel=0.11)
    for row in found["held"]:
        assert row["factor"] == pytest.approx(row["theory"], rel=1e-13)
