"""The reference against integrators and laws that share nothing with it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ulna.charts.problems import Problem, problems
from ulna.charts.reference import Quadratic, integrate

ALL = {problem.name: problem for problem in problems()}
BODIES = [name for name, problem in ALL.items() if problem.unit == "RigidBody"]


def test_series_gives_sine_and_cosine_to_forty_digits() -> None:
    from fractions import Fraction

    from mpmath import mp, mpf, sin

    circle = Quadratic((0.0, 1.0, 1.0), ((0, Fraction(1), 1, 2), (1, Fraction(-1), 0, 2)))
    found = integrate(circle, 10.0)[0]
    with mp.workdps(60):
        assert abs(mpf(found.numerator) / found.denominator - sin(10)) < mpf(10) ** -40


@pytest.mark.parametrize("name", ALL)
def test_reference_is_that_of_dop853(name: str) -> None:
    problem = ALL[name]
    found = solve_ivp(
        problem.system.slope, (0.0, problem.end), problem.system.first, method="DOP853", rtol=3e-14, atol=3e-16
    )
    # some hundred steps, each off by the tolerance, and what the motion makes of it
    assert problem.error(found.y[problem.place, -1]) < 1e-10


@pytest.mark.parametrize("name", ["free_asymmetric", "driven_hinge"])
def test_reference_does_not_depend_on_order_or_step(name: str) -> None:
    system, end = ALL[name].system, ALL[name].end
    pairs = zip(integrate(system, end), integrate(system, end, order=36, digits=50), strict=True)
    assert max(abs(a - b) for a, b in pairs) < 1e-40


def turned(q: list, v: list) -> list:
    """Body axes to world axes, in whatever numbers come."""
    w, x, y, z = q
    return [
        (w * w + x * x - y * y - z * z) * v[0] + 2 * (x * y - w * z) * v[1] + 2 * (x * z + w * y) * v[2],
        2 * (x * y + w * z) * v[0] + (w * w - x * x + y * y - z * z) * v[1] + 2 * (y * z - w * x) * v[2],
        2 * (x * z - w * y) * v[0] + 2 * (y * z + w * x) * v[1] + (w * w - x * x - y * y + z * z) * v[2],
    ]


@pytest.mark.parametrize("name", BODIES)
def test_reference_keeps_what_the_motion_keeps_to_forty_digits(name: str) -> None:
    """The energy and the vertical angular momentum; without weight all of the angular momentum."""
    from fractions import Fraction

    problem = ALL[name]
    inertia = [Fraction(moment) for moment in problem.values["inertia"]]
    weight = 0 if "tip_force" not in problem.values else -Fraction(problem.values["tip_force"][2])
    lever = 0 if not weight else Fraction(problem.values["tip"][2])

    def kept(state: list) -> list:
        rate, q = state[:3], state[3:7]
        square = sum(component * component for component in q)
        momentum = [component / square for component in turned(q, [i * w for i, w in zip(inertia, rate, strict=True)])]
        height = turned(q, [0, 0, lever])[2] / square
        energy = sum(i * w * w for i, w in zip(inertia, rate, strict=True)) / 2 + weight * height
        return [energy, momentum[2], *(momentum[:2] if not weight else [])]

    before, after = kept([Fraction(v) for v in problem.system.first]), kept(integrate(problem.system, problem.end))
    # the orientation is given in doubles, and the weight seen from the body is computed in them once
    bound = 1e-40 if not weight else 1e-13
    assert max(abs(a - b) for a, b in zip(before, after, strict=True)) < bound


def angled(problem: Problem, angle: float) -> np.ndarray:
    """The truth turned by an angle about the body's x axis."""
    w, x, y, z = problem.truth
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    return np.array([w * c - x * s, x * c + w * s, y * c + z * s, z * c - y * s])


@pytest.mark.parametrize("angle", [1e-12, 1e-6, 1.0, 3.0])
def test_error_is_the_angle_between_two_orientations(angle: float) -> None:
    problem = ALL["free_asymmetric"]
    assert problem.error(angled(problem, angle)) == pytest.approx(angle, rel=1e-3)
    assert problem.error(-angled(problem, angle)) == pytest.approx(angle, rel=1e-3)  # the same orientation
