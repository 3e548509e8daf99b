"""The engine that tells identities from equations that only look like them."""

from fractions import Fraction

import casadi as ca
import pytest
from casadi import SX

from ulna.checks.graph import UnsupportedError, simplest_fraction
from ulna.checks.identity import depends, vanishes

x, y, a, b = (SX.sym(name) for name in "xyab")
q, r = SX.sym("q", 4), SX.sym("r", 4)
POSITIVE = {"x": (0.5, 2.0), "y": (0.5, 2.0)}


def product(p, s):
    """Hamilton's product."""
    return ca.vertcat(p[0] * s[0] - ca.dot(p[1:], s[1:]), p[0] * s[1:] + s[0] * p[1:] + ca.cross(p[1:], s[1:]))


EXACT = {
    "Lagrange's four squares": ca.sumsqr(product(q, r)) - ca.sumsqr(q) * ca.sumsqr(r),
    "partial fractions": 1 / x - 1 / (x + 1) - 1 / (x * (x + 1)),
    "Pythagoras": ca.sin(a) ** 2 + ca.cos(a) ** 2 - 1,
    "addition of angles": ca.sin(a + b) - ca.sin(a) * ca.cos(b) - ca.cos(a) * ca.sin(b),
    "half an angle, the angle itself beside it": x * a * (ca.cos(a) - 2 * ca.cos(a / 2) ** 2 + 1),
    "a third of an angle": ca.sin(a) - 3 * ca.sin(a / 3) + 4 * ca.sin(a / 3) ** 3,
    "tangent": ca.tan(a) * ca.cos(a) - ca.sin(a),
    "a unit vector": ca.sumsqr(q / ca.norm_2(q)) - 1,
    "a power of 3/2": (x**2 + 1) ** 1.5 - (x**2 + 1) * ca.sqrt(x**2 + 1),
    "thirds as doubles": (1.0 / 3.0) * x - x / 3,
    "thirds of thirds, multiplied as doubles": (1.0 / 3.0) * (1.0 / 7.0) * x - x / 21,
}


@pytest.mark.parametrize("claim", EXACT)
def test_an_algebraic_identity_is_shown_exactly(claim):
    shown = vanishes(EXACT[claim])
    assert shown.vanishes
    assert "exact" in shown.how or shown.how == "symbols"


def test_roots_of_positive_numbers_multiply():
    expression = ca.sqrt(x) * ca.sqrt(y) - ca.sqrt(x * y) + ca.sqrt(x**2) - x
    assert vanishes(expression, POSITIVE).how.startswith("exact")


@pytest.mark.parametrize(
    "expression",
    [ca.exp(a + b) - ca.exp(a) * ca.exp(b), ca.log(x * y) - ca.log(x) - ca.log(y), x**1.3 * x**0.7 - x**2],
)
def test_other_functions_are_shown_in_50_digits(expression):
    shown = vanishes(expression, POSITIVE)
    assert shown.vanishes and shown.how.startswith("50 digits")


# each is zero or next to zero somewhere, or to double precision
NOT_ZERO = {
    "a product with many roots": ca.vertcat(*[x - k for k in range(9)]).T @ SX.ones(9) + x * (x - 1) * (x - 2),
    "a term of 1e-30": ca.sin(a) ** 2 + ca.cos(a) ** 2 - 1 + 1e-30 * x,
    "a third to nine digits": x / 3 - 0.333333333 * x,
    "the sine's series": ca.sin(x) - x + x**3 / 6 - x**5 / 120,
    "an order exchanged": product(q, r) - product(r, q),
    "a root with the wrong sign below zero": ca.sqrt(x**2) - x,
    "one element of many": ca.vertcat(x - x, y * 0, ca.exp(a) - ca.exp(b)),
}


@pytest.mark.parametrize("claim", NOT_ZERO)
def test_what_is_not_zero_is_found(claim):
    shown = vanishes(NOT_ZERO[claim])
    assert not shown.vanishes
    assert "counterexample" in shown.how


def test_the_degree_in_the_bound_is_that_of_the_polynomial():
    # (x + y)^5 - sum of binomials: degree 5, so at most 5 / (2^61 - 1) of the points are zeros of another quintic
    binomials = x**5 + 5 * x**4 * y + 10 * x**3 * y**2 + 10 * x**2 * y**3 + 5 * x * y**4 + y**5
    shown = vanishes((x + y) ** 5 - binomials)
    assert shown.bound == "degree 5: < 1e-35"


def test_what_has_branches_is_refused():
    with pytest.raises(UnsupportedError):
        vanishes(ca.fmax(x, y) - ca.fmin(x, y))


def test_an_expression_without_real_values_is_refused():
    with pytest.raises(UnsupportedError, match="no value"):
        vanishes(ca.log(-x) * ca.log(y), POSITIVE)


def test_dependence_sees_through_terms_that_cancel():
    assert depends(ca.vertcat((x + y) ** 2 - x**2 - 2 * x * y - y**2, x * y, ca.exp(x) - 1)) == [False, True, True]


@pytest.mark.parametrize(
    ("value", "fraction"),
    [
        (1 / 6, Fraction(1, 6)),
        (-2 / 3, Fraction(-2, 3)),
        (0.1, Fraction(1, 10)),
        (7.0, Fraction(7)),
        (0.0, Fraction(0)),
    ],
)
def test_a_constant_is_read_as_the_simple_fraction_it_stands_for(value, fraction):
    assert simplest_fraction(value) == fraction


def test_a_constant_that_stands_for_no_simple_fraction_is_read_as_it_is():
    assert simplest_fraction(3.141592653589793) == Fraction(3.141592653589793)
    assert simplest_fraction(1e-300) == Fraction(1e-300)
