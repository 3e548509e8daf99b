"""Spins about the principal axes: the true growth of a small error, and what each solver makes of it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ulna.bench.measuring import choices, started
from ulna.bench.rigid_body import matrix_of, motion
from ulna.stability import theory
from ulna.stability.small_errors import spin
from ulna.stability.tumbling import INERTIA

SOLVERS = choices("RigidBody", "solver")
LEAST, MIDDLE, GREATEST = range(3)
EULER = ("explicit_euler", "notes")
OTHERS = [solver for solver in SOLVERS if solver not in EULER]


def wander(solver: str, axis: int, angle: float, steps: int, error: float) -> float:
    """Largest angle (rad) between spin and axis, looked at a hundred times, after an `error` (rad) at the start."""
    rate = np.full(3, error / math.sqrt(2))
    rate[axis] = 1.0
    span, most = steps / 100 * angle, 0.0
    with started("RigidBody", **motion(solver, tuple(rate), angle)) as body:
        for look in range(100):
            body.step(look * span, span)
            w = matrix_of(body.get("orientation")).T @ body.get("angular_velocity")
            most = max(most, math.acos(min(1.0, abs(w[axis]) / np.linalg.norm(w))))
    return most


@pytest.mark.parametrize("axis", [LEAST, MIDDLE, GREATEST])
@pytest.mark.parametrize("inertia", [INERTIA, (0.4, 1.1, 1.3)])
def test_the_linear_theory_is_that_of_eulers_equations(inertia, axis):
    def slope(_: float, w: np.ndarray) -> np.ndarray:
        return np.cross(np.multiply(inertia, w), w) / inertia

    columns = []
    for column in ((axis + 1) % 3, (axis + 2) % 3):
        ends = []
        for error in (1e-4, -1e-4):
            rate = np.zeros(3)
            rate[axis], rate[column] = 1.7, error
            ends.append(solve_ivp(slope, (0, 0.5), rate, rtol=1e-13, atol=1e-16, method="DOP853").y[:, -1])
        columns.append((ends[0] - ends[1])[[(axis + 1) % 3, (axis + 2) % 3]] / 2e-4)
    found = np.log(np.linalg.eigvals(np.transpose(columns)).astype(complex)) / 0.5
    expected = theory.growth_rate(inertia, axis, 1.7)
    # the square of the error, and the integrator's tolerance over the error
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex([expected, -expected]), atol=1e-7)
    assert bool(expected.real > 0) is (axis == MIDDLE)


@pytest.mark.parametrize("solver", SOLVERS)
def test_rates_about_all_axes_tend_to_the_theory(solver):
    for axis in (LEAST, MIDDLE, GREATEST):
        found = np.log(spin(solver, INERTIA, axis, 0.001)) / 0.001
        exact = theory.growth_rate(INERTIA, axis, 1.0)
        # order one is off by h (2 a_b a_c - a_b - a_c) / 4 = 1.12 h at most; the others by the maps' round-off
        bound = 1.3e-3 if solver in EULER else 1e-6
        np.testing.assert_allclose(np.sort_complex(found), np.sort_complex([exact, -exact]), atol=bound)


@pytest.mark.parametrize("solver", theory.SPIN_FACTORS)
@pytest.mark.parametrize("axis", [LEAST, MIDDLE, GREATEST])
@pytest.mark.parametrize("angle", [0.03, 0.3, 1.0, 2.0, 3.0])
def test_the_step_makes_of_a_small_error_exactly_what_theory_says(solver, axis, angle):
    found = np.sort_complex(spin(solver, INERTIA, axis, angle).astype(complex))
    expected = np.sort_complex(theory.SPIN_FACTORS[solver](INERTIA, axis, angle).astype(complex))
    # the square of the small error and its round-off, 1e-10 each, magnified by the largest factor
    np.testing.assert_allclose(found, expected, atol=3e-9 * np.abs(expected).max() ** 2)


@pytest.mark.parametrize("solver", EULER)
def test_eulers_turn_leaves_the_stable_spin_about_the_greatest_moment(solver):
    # growth 0.111 a second: 1e-3 rad becomes 1 rad after 63 s
    assert wander(solver, GREATEST, 0.1, 1500, 1e-3) > 1.0
    assert wander(solver, LEAST, 0.1, 1500, 1e-3) < 4e-3, "about the least it damps, which is as wrong"


@pytest.mark.parametrize("solver", OTHERS)
def test_all_others_keep_the_stable_spins_and_lose_the_middle_one(solver):
    # a circle about a stable axis is an ellipse: its axes differ by a factor of 2 at most for these moments
    assert wander(solver, LEAST, 0.1, 1500, 1e-3) < 4e-3
    assert wander(solver, GREATEST, 0.1, 1500, 1e-3) < 4e-3
    assert wander(solver, MIDDLE, 0.1, 1500, 1e-3) > 1.0


def test_the_splitting_loses_the_stable_spin_where_its_trace_passes_two():
    def excess(angle: float) -> float:
        return abs(theory.splitting_factors(INERTIA, GREATEST, angle).sum().real) - 2

    limit = brentq(excess, 1.0, 2.2)
    assert wander("splitting", GREATEST, 0.98 * limit, 20_000, 1e-4) < 2e-3
    assert wander("splitting", GREATEST, 1.02 * limit, 20_000, 1e-4) > 0.1


@pytest.mark.parametrize("axis", [LEAST, GREATEST])
def test_runge_kutta_pumps_a_little_and_the_geometric_ones_not_at_all(axis):
    assert np.abs(spin("rk4", INERTIA, axis, 1.0)).max() > 1 + 1e-4
    for solver in ("midpoint", "splitting", "moser_veselov"):
        assert np.abs(spin(solver, INERTIA, axis, 1.0)).max() < 1 + 1e-9


def test_the_map_draws_these_rates(found):
    for row in found["spins"]:
        # within the attitude limit of every solver but the two of order one
        if row["angle"] < 0.02 and row["solver"] not in EULER:
            assert row["growth"] == pytest.approx(row["theory_growth"], abs=1e-4)
            assert row["circling"] == pytest.approx(row["theory_circling"], abs=1e-4)
