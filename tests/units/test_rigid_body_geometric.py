"""RigidBody's solvers that keep what free rotation keeps: orders, conserved quantities, and where each one ends."""

import math
from fractions import Fraction
from pathlib import Path

import derive_moser_veselov as moser_veselov
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from test_rigid_body import INERTIA, LOADS, TUMBLE, attitude_error, exact_tumble, rotation, run, start

HEADER = Path(__file__).parents[2] / "fmus/rigid_body/moser_veselov_series.h"
SOLVERS = ("midpoint", "splitting", "moser_veselov")
RATE = np.array([0.6, 1.0, 0.4])
FREE = {"inertia": INERTIA, "initial_angular_velocity": RATE, "gravity": [0, 0, 0]}
SPIN = FREE | {"initial_angular_velocity": [0.01, 1.0, 0.01]}
ROD = FREE | {"inertia": [1.0, 1.000001, 1e-6], "initial_angular_velocity": [1.0, 0.01, 1.0]}


def free_attitude(parameters: dict, end: float) -> np.ndarray:
    """Quaternion [4] at `end` (s), from the unit one: DOP853 on the attitude and Euler's equations, at 3e-14."""
    inertia = np.array(parameters["inertia"])

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        w, v = y[0], y[1:4]
        rate = y[4:]
        turn = 0.5 * np.array([-v @ rate, *(w * rate + np.cross(v, rate))])
        return np.concatenate([turn, np.cross(inertia * rate, rate) / inertia])

    first = np.concatenate([[1, 0, 0, 0], parameters["initial_angular_velocity"]])
    return solve_ivp(slope, (0, end), first, "DOP853", rtol=3e-14, atol=3e-14).y[:4, -1]


def energies(parameters: dict, h: float, count: int) -> np.ndarray:
    """Energy at the start and after each of `count` steps, relative to the start."""
    with start(parameters | {"solver_step": h}) as body:
        found = [body.get("kinetic_energy")]
        for k in range(count):
            body.step(k * h, h)
            found.append(body.get("kinetic_energy"))
    return np.array(found) / found[0]


def told(parameters: dict, h: float, steps: int = 1) -> int:
    """How often the log says that a step was beyond the solver's limit."""
    with start(parameters | {"solver_step": h}) as body:
        for k in range(steps):
            body.step(k * h, h)
        return sum("beyond the limit" in message for _, _, message in body.messages.latest)


# --- the series of Moser-Veselov ------------------------------------------------------------


def test_coefficients_in_c_are_those_that_the_script_derives() -> None:
    assert HEADER.read_text() == moser_veselov.header()


@pytest.mark.parametrize("axis", range(3))
def test_coefficients_give_the_sine_of_a_spin_about_an_axis(axis: int) -> None:
    """There J sin(angle) = h L, so that 1 / J = sin(h L / I) / (h L)."""
    inverse, spin = [2, 3, 7], 5
    values = moser_veselov.invariants(inverse, [spin * (j == axis) for j in range(3)])
    for k, polynomials in enumerate(moser_veselov.derive(), 1):
        s, d = (
            sum(value * moser_veselov.product(values, powers) for powers, value in polynomial.items())
            for polynomial in polynomials
        )
        angle = Fraction(inverse[axis] * spin)
        assert s * inverse[axis] + d == inverse[axis] * (-(angle**2)) ** k / math.factorial(2 * k + 1)


# --- orders ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("solver", "order", "steps"), [("midpoint", 2, 100), ("splitting", 2, 100), ("moser_veselov", 10, 20)]
)
def test_free_rotation_has_the_declared_order(solver: str, order: int, steps: int) -> None:
    expected = free_attitude(FREE, 10.0)

    def error(count: int) -> float:
        return attitude_error(run(FREE | {"solver": solver}, 10.0, count)["orientation"], expected)

    assert math.log2(error(steps) / error(2 * steps)) == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("load", [load for load in LOADS if load != "free"])
@pytest.mark.parametrize("solver", SOLVERS)
def test_order_with_torque_is_two(solver: str, load: str) -> None:
    expected = exact_tumble(1.0, load)

    def errors(steps: int) -> np.ndarray:
        last = run(TUMBLE | {"solver": solver}, 1.0, steps, LOADS[load])
        momentum = np.linalg.norm(last["angular_momentum"] - expected["angular_momentum"])
        # a torque in the world that is linear in time is integrated exactly
        return np.array(
            [attitude_error(last["orientation"], expected["orientation"]), momentum if "frames" in load else 0]
        )

    coarse, fine = errors(100), errors(200)
    np.testing.assert_allclose(np.log2(coarse[fine > 0] / fine[fine > 0]), 2, atol=0.05)


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("solver", SOLVERS)
def test_translation_is_exact(solver: str, load: str) -> None:
    expected = exact_tumble(1.0, load)
    last = run(TUMBLE | {"solver": solver}, 1.0, 7, LOADS[load])
    # the bound is DOP853's
    np.testing.assert_allclose(last["position"], expected["position"], atol=1e-12)
    np.testing.assert_allclose(last["linear_momentum"], expected["linear_momentum"], atol=1e-12)


def test_moser_veselov_is_within_round_off_of_another_integrator_at_a_tenth_of_a_second() -> None:
    for parameters in (FREE, SPIN):
        last = run(parameters | {"solver": "moser_veselov"}, 10.0, 100)
        # DOP853 at 3e-14 a step, and 100 turns' roundings
        assert attitude_error(last["orientation"], free_attitude(parameters, 10.0)) < 1e-12


def test_moser_veselov_follows_a_spin_about_the_middle_axis_a_million_times_closer_than_order_two() -> None:
    expected = free_attitude(SPIN, 100.0)
    error = {
        solver: attitude_error(run(SPIN | {"solver": solver}, 100.0, 1000)["orientation"], expected)
        for solver in SOLVERS
    }
    assert error["moser_veselov"] < 1e-9
    assert min(error["midpoint"], error["splitting"]) > 1e6 * error["moser_veselov"]


# --- conserved quantities -------------------------------------------------------------------


@pytest.mark.parametrize("solver", SOLVERS)
def test_angular_momentum_without_torque_is_kept_to_the_bit(solver: str) -> None:
    with start(TUMBLE | {"solver": solver, "solver_step": 0.3}) as body:
        momentum = body.get("angular_momentum")
        body.step(0.0, 300.0)
        np.testing.assert_array_equal(body.get("angular_momentum"), momentum)


@pytest.mark.parametrize(("solver", "turn"), [("midpoint", 2.0), ("moser_veselov", 1.3)])
def test_energy_is_kept_to_round_off_however_long_the_step(solver: str, turn: float) -> None:
    for h in (turn / np.linalg.norm(RATE), 0.01):
        found = energies(FREE | {"solver": solver}, h, 2000)
        # a walk of 2000 roundings of 1e-16
        assert np.ptp(found) < 5e-14


def test_energy_of_the_splitting_stays_in_its_band_and_the_notes_leave_it() -> None:
    h = 0.3 / np.linalg.norm(RATE)
    found = energies(FREE | {"solver": "splitting"}, h, 4000) - 1
    assert 1e-6 < np.max(np.abs(found)) < 1e-2
    assert np.max(np.abs(found[2000:])) < 1.05 * np.max(np.abs(found[:2000]))
    assert energies(FREE | {"solver": "notes"}, h, 4000)[-1] > 1.4


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_way_back_ends_where_it_began(solver: str) -> None:
    there = FREE | {"solver": solver, "solver_step": 0.25}
    with start(there) as body:
        body.step(0.0, 25.0)
        back = {
            "initial_orientation": body.get("orientation"),
            "initial_angular_velocity": -body.get("angular_velocity"),
        }
    with start(there | back) as body:
        body.step(0.0, 25.0)
        assert attitude_error(body.get("orientation"), np.array([1.0, 0, 0, 0])) < 1e-12


def poisson_residual(solver: str, h: float) -> float:
    """Largest element of D [m] D^T - [m_next], D the slope of m -> m_next in body axes: zero for a Poisson map.

    The slope by eight-point differences over 0.02: truncation and rounding are both near 1e-14.
    """
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    spacing = 0.02

    def image(momentum: np.ndarray) -> np.ndarray:
        with start(FREE | {"solver": solver, "solver_step": h, "initial_angular_velocity": momentum / INERTIA}) as body:
            body.step(0.0, h)
            return rotation(body.get("orientation")).T @ body.get("angular_momentum")

    def skew(v: np.ndarray) -> np.ndarray:
        return np.cross(np.eye(3), -v)

    momentum = INERTIA * RATE
    columns = [
        sum(w * (image(momentum + k * spacing * e) - image(momentum - k * spacing * e)) for k, w in weights.items())
        for e in np.eye(3)
    ]
    slope = np.transpose(columns) / spacing
    return np.max(np.abs(slope @ skew(momentum) @ slope.T - skew(image(momentum))))


@pytest.mark.parametrize("h", [0.01, 0.4])
@pytest.mark.parametrize("solver", ["splitting", "moser_veselov"])
def test_splitting_and_moser_veselov_are_poisson_maps(solver: str, h: float) -> None:
    assert poisson_residual(solver, h) < 5e-13


@pytest.mark.parametrize(("solver", "power", "at_a_tenth"), [("notes", 2, 5.4e-3), ("midpoint", 3, 7.8e-5)])
def test_notes_and_midpoint_are_none(solver: str, power: int, at_a_tenth: float) -> None:
    coarse, fine = poisson_residual(solver, 0.1), poisson_residual(solver, 0.05)
    assert coarse == pytest.approx(at_a_tenth, rel=0.1)
    assert math.log2(coarse / fine) == pytest.approx(power, abs=0.1)


# --- where they end -------------------------------------------------------------------------


@pytest.mark.parametrize("h", [2.3, 2.4])
def test_midpoint_ends_where_theory_has_its_growth_rate_at_two(h: float) -> None:
    small, middle, large = inertia = [0.1, 0.6, 0.7]
    growth = math.sqrt((middle - small) * (large - middle) / (small * large))
    spin = FREE | {"solver": "midpoint", "inertia": inertia, "initial_angular_velocity": [0.0, 1.0, 0.0]}
    assert told(spin, h) == (h * growth > 2)


@pytest.mark.parametrize("turn", [1.45, 1.55, 3.0])
def test_moser_veselov_ends_before_a_right_angle_a_step(turn: float) -> None:
    parameters = FREE | {"solver": "moser_veselov"}
    assert told(parameters, turn / np.linalg.norm(RATE)) == (turn > 1.5)


@pytest.mark.parametrize("solver", ["midpoint", "moser_veselov"])
def test_what_is_beyond_the_limit_is_said_once_and_leaves_numbers(solver: str) -> None:
    parameters, h = SPIN | {"solver": solver}, 5.0
    assert told(parameters, h, steps=50) == 1
    last = run(parameters, 50 * h, 50)
    assert abs(np.linalg.norm(last["orientation"]) - 1) < 1e-15


def test_moser_veselov_keeps_its_energy_beyond_its_limit() -> None:
    assert np.ptp(energies(FREE | {"solver": "moser_veselov"}, 2.0 / np.linalg.norm(RATE), 500)) < 1e-13


def test_splitting_has_nothing_to_solve_and_loses_the_attitude_all_the_same() -> None:
    parameters, h = FREE | {"solver": "splitting"}, 2.0
    assert told(parameters, h) == 0
    assert attitude_error(run(parameters, 30.0, 15)["orientation"], free_attitude(parameters, 30.0)) > 0.1


def test_thin_rod_is_beyond_moser_veselov_early_and_the_splitting_fails_on_it() -> None:
    assert told(ROD | {"solver": "moser_veselov"}, 0.005) == 0
    assert told(ROD | {"solver": "moser_veselov"}, 0.05) == 1
    expected = free_attitude(ROD, 10.0)
    error = {s: attitude_error(run(ROD | {"solver": s}, 10.0, 1000)["orientation"], expected) for s in SOLVERS}
    # the rod's long axis takes h L / I = 1e4 rad of each partial turn that the others have to take back
    assert error["splitting"] > 0.1
    assert error["midpoint"] < 1e-3
    # 1e-16 of L is 1e-10 of the rate about the long axis
    assert error["moser_veselov"] < 1e-6


@pytest.mark.parametrize("solver", SOLVERS)
def test_body_at_rest_stays(solver: str) -> None:
    last = run(FREE | {"solver": solver, "initial_angular_velocity": [0, 0, 0]}, 1.0, 10)
    np.testing.assert_array_equal(last["orientation"], [1, 0, 0, 0])


@pytest.mark.parametrize("solver", ["splitting", "moser_veselov"])
@pytest.mark.parametrize("axis", range(3))
def test_fast_spin_about_an_axis_is_exact(solver: str, axis: int) -> None:
    spin, h, steps = 1e4, 1e-5, 1000
    parameters = FREE | {"solver": solver, "initial_angular_velocity": spin * np.eye(3)[axis]}
    last = run(parameters, h * steps, steps)
    expected = np.roll(Rotation.from_rotvec(spin * h * steps * np.eye(3)[axis]).as_quat(), 1)
    # moser_veselov: (h w)^10 / 11! a radian is below rounding
    assert attitude_error(last["orientation"], expected) < 1e-12
