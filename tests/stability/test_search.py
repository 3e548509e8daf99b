"""The search for a limit, on conditions whose limit is known."""

import math

import pytest

from ulna.stability.search import largest


@pytest.mark.parametrize("limit", [3e-4, 0.02, 1.0, 7.3])
@pytest.mark.parametrize("ratio", [1.1, 1.001])
def test_a_limit_is_found_within_the_ratio(limit, ratio):
    found = largest(lambda step: step <= limit, 1e-5, 10.0, ratio)
    assert limit / ratio <= found <= limit


def test_no_limit_is_infinite_and_none_that_holds_is_zero():
    assert largest(lambda step: True, 1e-5, 10.0) == math.inf
    assert largest(lambda step: False, 1e-5, 10.0) == 0.0


def test_what_is_right_by_chance_at_one_larger_step_is_no_limit():
    chance = 10.0 / math.sqrt(2) ** 3
    found = largest(lambda step: step <= 0.01 or abs(step / chance - 1) < 0.1, 1e-5, 10.0)
    assert found == pytest.approx(0.01, rel=0.01)
