"""The quaternion's norm, and the moments that no body has."""

import numpy as np
import pytest

from ulna import UnitError
from ulna.bench.measuring import choices, started
from ulna.bench.rigid_body import motion
from ulna.stability import theory


def test_a_quaternion_that_is_not_made_a_unit_grows_as_theory_says(found):
    for row in found["norms"]:
        # a hundredth root of a product of a hundred rounded steps
        assert row["factor"] == pytest.approx(row["theory"], abs=1e-14)
    euler = [row["factor"] - 1 for row in found["norms"] if row["method"] == "euler"]
    assert min(euler) > 1e-5, "the least angle, 0.01 rad, gives (0.01 / 2)^2 / 2"


def test_without_it_eulers_norm_is_far_off_after_a_minute():
    # 1 rad/s at 10 ms, 6000 steps: (1 + 2.5e-5)^3000
    assert theory.euler_norm_factor(0.01) ** 6000 == pytest.approx(1.0779, abs=1e-4)
    # Runge-Kutta loses a^6/144, a = h|w|/2: nothing here, all of it at 3 rad
    assert abs(theory.rk4_norm_factor(0.01) ** 6000 - 1) < 1e-11
    assert abs(theory.rk4_norm_factor(3.0) - 1) > 0.05


@pytest.mark.parametrize("solver", choices("RigidBody", "solver"))
@pytest.mark.parametrize("step", [0.001, 0.5])
def test_every_solver_keeps_the_norm(solver, step):
    with started("RigidBody", **motion(solver, (0.6, 1.0, 0.4), step)) as body:
        body.step(0.0, 20_000 * step)
        # the last normalisation alone leaves a rounding
        assert np.linalg.norm(body.get("orientation")) == pytest.approx(1.0, abs=5e-16)


def test_moments_are_taken_exactly_where_the_triangle_inequality_holds(found):
    assert {row["accepted"] for row in found["moments"]} == {True, False}
    for row in found["moments"]:
        assert row["accepted"] is row["theory"], row["moments"]


@pytest.mark.parametrize("unit", ["RigidBody", "HingedBody"])
@pytest.mark.parametrize("place", range(3))
def test_a_moment_a_millionth_above_the_others_sum_is_refused_and_one_below_is_not(unit, place):
    moments = np.roll([2.0, 0.7, 1.3], place)
    with started(unit, inertia=moments * np.where(moments == 2.0, 1 - 1e-6, 1.0)):
        pass
    with pytest.raises(UnitError, match=rf"inertia\[{place + 1}\] = .* at most their sum"):
        started(unit, inertia=moments * np.where(moments == 2.0, 1 + 1e-6, 1.0))
