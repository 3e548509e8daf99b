"""What is concluded from points, on points whose answers are known."""

import pytest

from ulna.charts.fronts import cheapest, cost, front
from ulna.charts.measure import Point, decades


def point(solver: str, error: float, seconds: float) -> Point:
    return Point("any", solver, "solver_step", 0.1, error, seconds, None)


# a method of order two: ten times the work, a hundredth of the error; and one that is dear and accurate
LOW = [point("low", 10.0 ** (-2 * n), 10.0**n) for n in range(5)]
HIGH = [point("high", 1e-3, 20.0), point("high", 1e-12, 30.0)]


def test_front_leaves_out_what_another_beats_in_both() -> None:
    beaten = point("low", 1e-3, 1e4)
    assert front([*LOW, beaten]) == LOW


def test_cost_between_two_points_is_straight_in_logarithms() -> None:
    assert cost(LOW, 1e-3) == pytest.approx(10**1.5)


def test_cost_is_infinite_where_a_solver_does_not_get() -> None:
    assert cost(LOW, 1e-9) == float("inf")


def test_coarser_than_the_coarsest_point_costs_as_much_as_that() -> None:
    assert cost(HIGH, 1.0) == pytest.approx(20.0)


def test_cheapest_changes_where_the_curves_cross() -> None:
    assert cheapest(LOW + HIGH, 1e-1) == "low"
    assert cheapest(LOW + HIGH, 1e-6) == "high"
    assert cheapest(LOW + HIGH, 1e-13) is None


@pytest.mark.parametrize(("factor", "taken"), [(1.1, "automatic"), (1.3, "high")])
def test_default_is_taken_unless_another_is_clearly_cheaper(factor: float, taken: str) -> None:
    default = [point("automatic", p.error, factor * p.seconds) for p in HIGH]
    assert cheapest(HIGH + default, 1e-10) == taken


def test_powers_of_ten_are_among_the_steps() -> None:
    assert {1.0, 0.1, 0.01, 0.001} <= set(decades(1.0, 1e-3, 4))
    assert decades(0.3, 1e-2, 1) == [0.1, 0.01]
