"""HingedBody: the solver that chooses order and step, and the limits of those that do not."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hinged_body_truth import LOADS, SLANTED, SPINNING_UP, anchor_inputs, true_state
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

from ulna import Slave, UnitError

MASS, LEVER, GRAVITY = 1.561, 0.17901, 9.80665
ABOUT_HINGE = 0.020226 + MASS * LEVER**2  # kg m2, of the default body about its default axis
MUSCLE_OFF = {"stiffness": 0.0, "damping": 0.0}
FREE = {"gravity": [0.0, 0.0, 0.0]} | MUSCLE_OFF
SLOPES = {"target_angle": 1.1, "torque": -0.8, "tip_force": [2.0, 0.5, -3.0], "tip_torque": [0.3, 0.7, -0.2]}
# An anchor that tumbles: its angular velocity is quadratic in time, about no fixed axis.
TUMBLING = {
    "anchor_orientation": [0.8, 0.2, -0.4, 0.4],
    "anchor_angular_velocity": [2.0, -1.0, 3.0],
    "anchor_angular_acceleration": [-4.0, 6.0, 1.0],
    "anchor_angular_acceleration_rate": [5.0, 3.0, -7.0],
    "anchor_acceleration": [0.4, -3.0, 2.0],
    "anchor_acceleration_rate": [3.0, 1.0, -2.0],
}
LOADED = LOADS | {f"{name}_rate": slope for name, slope in SLOPES.items()}


def hinge(values: dict) -> Slave:
    """A HingedBody at t = 0 with these parameters and inputs."""
    body = Slave("HingedBody")
    for name, value in values.items():
        body.set(name, value)
    body.initialize(start=0.0)
    return body


def state_after(end: float, values: dict, steps: int = 1) -> np.ndarray:
    """Angle (rad) and rate (rad/s) at `end`; the inputs go on along their slopes only if there is one step."""
    with hinge({"solver": "taylor"} | values) as body:
        for k in range(steps):
            body.step(k * end / steps, end / steps)
        return np.array([body.get("angle"), body.get("rate")])


def integrated(slope: Callable, start: list[float], end: float) -> np.ndarray:
    """State at `end` by DOP853 at 3e-14."""
    return solve_ivp(slope, (0.0, end), start, method="DOP853", rtol=3e-14, atol=1e-15).y[:, -1]


def planar_truth(stiffness: float, damping: float, start: list[float], end: float) -> np.ndarray:
    """The default forearm under LOADED, written out in its plane; the axis is -y."""

    def slope(t: float, y: np.ndarray) -> list[float]:
        angle, rate = y
        target, torque, force, couple = (LOADS[name] + np.multiply(SLOPES[name], t) for name in LOADS)
        moment = 0.35017 * (force[2] * math.cos(angle) - force[0] * math.sin(angle)) - couple[1]
        weight = -MASS * GRAVITY * LEVER * math.cos(angle)
        muscle = stiffness * (target - angle) - damping * rate
        return [rate, (weight + muscle + torque + moment) / ABOUT_HINGE]

    return integrated(slope, start, end)


def spatial_truth(inputs: dict, end: float) -> np.ndarray:
    """SLANTED on an anchor that follows its angular velocity: the balance of angular momentum about the hinge."""
    mass, axis, center = SLANTED["mass"], np.array(SLANTED["axis"]), np.array(SLANTED["center_of_mass"])
    about_hinge = np.diag(SLANTED["inertia"]) + mass * (center @ center * np.eye(3) - np.outer(center, center))

    def now(name: str, t: float) -> np.ndarray:
        return np.array(inputs.get(name, 0.0)) + np.multiply(inputs.get(f"{name}_rate", 0.0), t)

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        angle, rate, q = y[0], y[1], y[2:]
        spin = now("anchor_angular_velocity", 0.0) + t * np.array(inputs["anchor_angular_acceleration"])
        spin = spin + t**2 / 2 * np.array(inputs["anchor_angular_acceleration_rate"])
        anchor = Rotation.from_quat(np.roll(q, -1))
        body = (anchor * Rotation.from_rotvec(angle * axis)).as_matrix()
        n, inertia = anchor.apply(axis), body @ about_hinge @ body.T
        whole = spin + rate * n
        turned = now("anchor_angular_acceleration", t) + rate * np.cross(spin, n)
        pull = mass * (np.array(SLANTED["gravity"]) - now("anchor_acceleration", t))
        torque = np.cross(body @ center, pull) + np.cross(body @ SLANTED["tip"], now("tip_force", t))
        torque += now("tip_torque", t) - inertia @ turned - np.cross(whole, inertia @ whole)
        muscle = SLANTED["stiffness"] * (now("target_angle", t) - angle) + now("torque", t)
        muscle -= (SLANTED["damping"] + SLANTED["friction"]) * rate
        turning = np.concatenate([[-spin @ q[1:]], spin * q[0] + np.cross(spin, q[1:])]) / 2
        return np.concatenate([[rate, (n @ torque + muscle) / (n @ inertia @ n)], turning])

    start = [SLANTED["initial_angle"], SLANTED["initial_rate"], *inputs["anchor_orientation"]]
    return integrated(slope, start, end)[:2]


# --- what the tolerance promises ---


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_error_is_within_the_tolerance_a_second_under_loads_that_change(tolerance: float) -> None:
    stiffness, damping, end = 6.0, 0.2, 3.0
    values = {"stiffness": stiffness, "damping": damping, "initial_angle": 0.3, "initial_rate": 1.0}
    truth = planar_truth(stiffness, damping, [0.3, 1.0], end)
    error = state_after(end, values | LOADED | {"tolerance": tolerance}) - truth
    # damped, so that no error grows; 1e-13 for the round-off of both
    assert abs(error[0]) < tolerance * end + 1e-13


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_error_is_within_the_tolerance_a_second_on_a_tumbling_anchor(tolerance: float) -> None:
    end = 1.5
    inputs = LOADED | TUMBLING
    error = state_after(end, SLANTED | inputs | {"tolerance": tolerance}) - spatial_truth(inputs, end)
    # an angle of some ten rad, a rate of some ten rad/s
    assert abs(error[0]) < tolerance * end + 1e-12


def test_it_agrees_with_lagrange_on_an_anchor_that_spins_up() -> None:
    error = state_after(0.8, SLANTED | LOADS | anchor_inputs(SPINNING_UP, 0.0)) - true_state(SPINNING_UP, 0.8)
    assert np.abs(error).max() < 1e-9


@pytest.mark.parametrize("amplitude", [0.1, 1.0, 2.0, 3.0])
def test_pendulum_passes_the_bottom_at_the_time_of_the_elliptic_integral(amplitude: float) -> None:
    quarter = math.sqrt(ABOUT_HINGE / (MASS * GRAVITY * LEVER)) * ellipk(math.sin(amplitude / 2) ** 2)
    values = MUSCLE_OFF | {"initial_angle": amplitude - math.pi / 2, "tolerance": 1e-14}
    angle = state_after(5 * quarter, values)[0]
    # round-off: of the angle by 2e-16 at a rate of some 10 rad/s, more near the top where motions part
    assert abs(angle + math.pi / 2) < 3e-13


@pytest.mark.parametrize("end", [0.01, 0.2, 1.0, 10.0])
def test_series_with_gaps_are_not_cut_short(end: float) -> None:
    """Let go level and at rest, only every fourth power of time is there."""

    def slope(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -MASS * GRAVITY * LEVER * math.cos(y[0]) / ABOUT_HINGE]

    error = state_after(end, MUSCLE_OFF | {"tolerance": 1e-9})[0] - integrated(slope, [0.0, 0.0], end)[0]
    assert abs(error) < 1e-9 * end


@pytest.mark.parametrize("steps", [1, 7, 100, 5000])
def test_error_does_not_depend_on_the_communication_step(steps: int) -> None:
    values = MUSCLE_OFF | {"initial_angle": 0.3, "tolerance": 1e-10}
    fine = state_after(5.0, values | {"tolerance": 1e-14})
    # a pendulum's error of rate becomes one of phase: some 5 w T
    assert np.abs(state_after(5.0, values, steps) - fine).max() < 3e-9


def test_automatic_takes_the_series_whatever_the_step() -> None:
    for step in (1e-4, 1e-2, 1.0):
        values = SLANTED | LOADED | TUMBLING | {"tolerance": 1e-7}
        by_series, chosen = (state_after(step, values | {"solver": s}) for s in ("taylor", "automatic"))
        np.testing.assert_array_equal(by_series, chosen)


# --- extremes ---


@pytest.mark.parametrize("damping", [3.0, 100.0, 1e4])
def test_overdamped_muscle_follows_both_its_modes(damping: float) -> None:
    stiffness, target, end = 25.0, 0.7, 0.3
    half, square = damping / (2 * ABOUT_HINGE), stiffness / ABOUT_HINGE
    fast = half + math.sqrt(half**2 - square)
    slow = square / fast
    exact = target * (1 - (fast * math.exp(-slow * end) - slow * math.exp(-fast * end)) / (fast - slow))
    values = {"gravity": [0, 0, 0], "stiffness": stiffness, "damping": damping, "target_angle": target}
    # fast = 30 to 142 000 1/s; the tolerance is 1e-9 rad/s
    assert abs(state_after(end, values)[0] - exact) < 1e-9


@pytest.mark.parametrize("rate", [1e2, 1e4, 1e6])
def test_free_body_turns_on_at_any_rate(rate: float) -> None:
    angle, last = state_after(2.0, FREE | {"initial_rate": rate})
    assert angle == pytest.approx(2 * rate, rel=1e-12)
    assert last == rate


@pytest.mark.parametrize("rate", [1e2, 1e4])
def test_weight_takes_no_energy_from_a_fast_spin(rate: float) -> None:
    with hinge(MUSCLE_OFF | {"initial_rate": rate, "solver": "automatic"}) as body:
        start = body.get("kinetic_energy") + body.get("potential_energy")
        body.step(0.0, 0.5)
        end = body.get("kinetic_energy") + body.get("potential_energy")
    # some h rate / 2 steps, each a rounding of the rate
    assert end == pytest.approx(start, rel=1e-12)


def test_a_motion_too_fast_to_follow_is_refused() -> None:
    with (
        hinge(MUSCLE_OFF | {"initial_rate": 1e15}) as body,
        pytest.raises(UnitError, match=r"internal steps of .* rate"),
    ):
        body.step(0.0, 1.0)


# --- solvers of a fixed step ---


def test_rk4_follows_a_tumbling_anchor_to_the_seventh_power_of_the_communication_step() -> None:
    inputs = TUMBLING | LOADED

    def error(end: float) -> float:
        values = SLANTED | inputs | {"solver": "rk4", "solver_step": end / 400}
        return abs(state_after(end, values)[0] - state_after(end, values | {"solver": "taylor", "tolerance": 1e-14})[0])

    # an orientation off by the fifth power, integrated twice; the integral of the angular velocity alone: by the third
    assert math.log2(error(0.2) / error(0.1)) == pytest.approx(7, abs=0.6)


def warnings_of(solver: str, factor: float, values: dict) -> list[str]:
    """Warnings over three steps whose internal step is `factor` / w, w = sqrt(stiffness / inertia)."""
    step = factor / math.sqrt(25.0 / ABOUT_HINGE)
    with hinge({"gravity": [0, 0, 0], "solver": solver, "solver_step": 1.001 * step} | values) as body:
        for k in range(3):
            body.step(k * step, step)
        return [text for status, _, text in body.messages.latest if status == "warning"]


@pytest.mark.parametrize(("solver", "limit"), [("semi_implicit_euler", 2.0), ("rk4", math.sqrt(8))])
def test_step_beyond_the_limit_of_the_solver_is_warned_of_once(solver: str, limit: float) -> None:
    assert warnings_of(solver, 0.999 * limit, {"damping": 0.0}) == []
    (warning,) = warnings_of(solver, 1.001 * limit, {"damping": 0.0})
    assert "unstable" in warning
    assert f"{limit / math.sqrt(25.0 / ABOUT_HINGE):.3g} s" in warning


def test_weight_counts_as_stiffness_where_there_is_no_muscle() -> None:
    step = math.sqrt(8 * ABOUT_HINGE / (MASS * GRAVITY * LEVER))
    for factor, warned in ((0.999, 0), (1.001, 1)):
        with hinge(MUSCLE_OFF | {"solver": "rk4", "solver_step": 1.0}) as body:
            body.step(0.0, factor * step)
            assert len(body.messages.latest) == warned


def test_explicit_euler_is_warned_of_at_every_step_without_damping() -> None:
    assert len(warnings_of("explicit_euler", 1e-3, {"damping": 0.0})) == 1
    assert warnings_of("explicit_euler", 1e-3, {}) == []


@pytest.mark.parametrize("solver", ["taylor", "automatic"])
def test_what_chooses_its_steps_is_never_unstable(solver: str) -> None:
    values = {"damping": 0.0, "initial_angle": 1e-3}
    assert warnings_of(solver, 300.0, values) == []
    step = 300.0 / math.sqrt(25.0 / ABOUT_HINGE)
    angle = state_after(step, {"gravity": [0, 0, 0], "solver": solver} | values)[0]
    # 48 swings: a relative error of rate is one of phase, over 300 rad
    assert angle == pytest.approx(1e-3 * math.cos(300.0), abs=1e-9 * 300.0)
