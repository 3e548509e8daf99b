"""HingedBody against the pendulum, Newton, Euler and Lagrange."""

import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hinged_body_truth import LOADS, OUTPUTS, SLANTED, SPINNING_UP, WANDERING, anchor_inputs, true_state
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

from ulna import Slave, UnitError

DECLARATION = tomllib.loads((Path(__file__).parents[2] / "fmus/hinged_body/unit.toml").read_text())
START = {name: entry.get("start") for name, entry in DECLARATION["parameter"].items()}
ORDERS = {
    solver: int(order[1])
    for solver, text in DECLARATION["enumeration"]["Solver"].items()
    if (order := re.search(r"order (\d+)", text))
}
MASS, LEVER, GRAVITY = START["mass"], START["center_of_mass"][0], 9.80665
ABOUT_HINGE = START["inertia"][1] + MASS * LEVER**2  # kg m2, of the default body about its default axis
MUSCLE_OFF = {"stiffness": 0.0, "damping": 0.0}
HANGING = -math.pi / 2  # rad, of the default body

# In 1.7 s at 500 steps h w = 0.021, at 8000 steps 0.0013. A first-order phase error over 10 rad of phase is some
# 10 h w / 2; that of rk4 10 (h w)^4 / 120; explicit Euler also gains amplitude, which lengthens the period.
PENDULUM = [("explicit_euler", 8000, 0.04), ("semi_implicit_euler", 8000, 0.007), ("rk4", 500, 2e-8)]


def hinge(parameters: dict, version: str = "3.0") -> Slave:
    """A HingedBody with these parameters, initialized at t = 0."""
    body = Slave("HingedBody", version=version)
    for name, value in parameters.items():
        body.set(name, value)
    body.initialize(start=0.0)
    return body


def apply(body: Slave, values: dict) -> None:
    for name, value in values.items():
        body.set(name, value)


def run(parameters: dict, end: float, steps: int, inputs: dict | None = None) -> dict:
    """Angle (rad), rate (rad/s) and energy (J) after one communication step of `steps` internal steps."""
    with hinge(parameters | {"solver_step": end / steps}) as body:
        apply(body, inputs or {})
        body.step(0.0, end)
        return {
            "angle": body.get("angle"),
            "rate": body.get("rate"),
            "energy": body.get("kinetic_energy") + body.get("potential_energy"),
        }


def measured_order(error_of, steps: int) -> float:
    """log2 of the error's fall over a halving of the step."""
    return math.log2(abs(error_of(steps)) / abs(error_of(2 * steps)))


# --- the plane: pendulum, spring, equilibrium ------------------------------------------------


def quarter_period(amplitude: float) -> float:
    """s; a quarter of 4 sqrt(J / m g c) K(sin^2(amplitude / 2)), the compound pendulum's period."""
    return math.sqrt(ABOUT_HINGE / (MASS * GRAVITY * LEVER)) * ellipk(math.sin(amplitude / 2) ** 2)


@pytest.mark.parametrize(("solver", "steps", "bound"), PENDULUM)
def test_pendulum_passes_the_bottom_at_the_time_of_the_elliptic_integral(solver: str, steps: int, bound: float) -> None:
    amplitude = 2.0
    end = 5 * quarter_period(amplitude)
    parameters = MUSCLE_OFF | {"initial_angle": HANGING + amplitude, "solver": solver}

    def error(count: int) -> float:
        return run(parameters, end, count)["angle"] - HANGING

    assert abs(error(steps)) < bound
    assert measured_order(error, steps) == pytest.approx(ORDERS[solver], abs=0.15)


def test_free_swing_keeps_its_energy_at_order_four_or_better() -> None:
    start = MASS * GRAVITY * LEVER * math.sin(0.3)

    def error(steps: int) -> float:
        return run(MUSCLE_OFF | {"initial_angle": 0.3, "solver": "rk4"}, 2.0, steps)["energy"] - start

    # Runge-Kutta of order 4 damps an oscillator by (h w)^6 / 144 a step: order 5 in the energy
    assert abs(error(400)) < 2e-8
    assert measured_order(error, 100) > 3.9


def test_explicit_euler_gains_energy_and_semi_implicit_euler_does_not() -> None:
    parameters = MUSCLE_OFF | {"initial_angle": HANGING + 0.5}
    depth = MASS * GRAVITY * LEVER
    start = -depth * math.cos(0.5)
    frequency = math.sqrt(depth / ABOUT_HINGE)

    def gain(solver: str) -> float:
        """Energy gained in 10 s over the energy of the swing, at 5 ms."""
        return (run(parameters | {"solver": solver}, 10.0, 2000)["energy"] - start) / (start + depth)

    # a linear oscillator gains (h w)^2 a step by Euler: exp(h w^2 T) - 1 = 6; and staggers by h w / 2 at most
    assert gain("explicit_euler") > 3
    assert abs(gain("semi_implicit_euler")) < 0.005 * frequency / 2


@pytest.mark.parametrize("solver", ORDERS)
def test_each_solver_has_its_declared_order_under_loads_that_change_over_the_step(solver: str) -> None:
    stiffness, damping, end = 6.0, 0.2, 0.8
    slopes = {"target_angle": 1.1, "torque": -0.8, "tip_force": [2.0, 0.5, -3.0], "tip_torque": [0.3, 0.7, -0.2]}
    inputs = LOADS | {name + "_rate": slope for name, slope in slopes.items()}
    length = START["tip"][0]

    def slope(t: float, y: np.ndarray) -> list[float]:
        """The default forearm written out in its plane; the axis is -y."""
        angle, rate = y
        target, torque, force, couple = (LOADS[name] + np.multiply(slopes[name], t) for name in LOADS)
        moment = length * (force[2] * math.cos(angle) - force[0] * math.sin(angle)) - couple[1]
        weight = -MASS * GRAVITY * LEVER * math.cos(angle)
        muscle = stiffness * (target - angle) - damping * rate
        return [rate, (weight + muscle + torque + moment) / ABOUT_HINGE]

    exact = solve_ivp(slope, (0, end), [0.3, 1.0], method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    parameters = {
        "stiffness": stiffness,
        "damping": damping,
        "initial_angle": 0.3,
        "initial_rate": 1.0,
        "solver": solver,
    }

    def error(steps: int) -> float:
        end_state = run(parameters, end, steps, inputs)
        return math.hypot(end_state["angle"] - exact[0], (end_state["rate"] - exact[1]) / 10)

    assert measured_order(error, {1: 800, 4: 40}[ORDERS[solver]]) == pytest.approx(ORDERS[solver], abs=0.2)


def test_muscle_and_joint_alone_make_the_damped_oscillator() -> None:
    stiffness, damping, friction, target, end = 25.0, 0.3, 0.2, 0.7, 0.5
    decay = (damping + friction) / (2 * ABOUT_HINGE)
    frequency = math.sqrt(stiffness / ABOUT_HINGE - decay**2)
    phase = frequency * end
    exact = target - target * math.exp(-decay * end) * (math.cos(phase) + decay / frequency * math.sin(phase))
    parameters = {"gravity": [0, 0, 0], "stiffness": stiffness, "damping": damping, "friction": friction}
    end_state = run(parameters, end, 500, {"target_angle": target})
    # h w = 0.019: an error of some target w T (h w)^4 / 120
    assert end_state["angle"] == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_muscle_holds_the_weight_at_the_closed_form_of_equilibrium(version: str) -> None:
    angle = 0.6
    moment = MASS * GRAVITY * LEVER * math.cos(angle)
    with hinge({"initial_angle": 0.0}, version) as body:
        body.set("target_angle", angle + moment / START["stiffness"])
        for k in range(5):
            body.step(float(k), 1.0)
        # slowest mode: about -k / d = -3.1 1/s, so 5 s leave 1e-7 of the start
        assert body.get("angle") == pytest.approx(angle, abs=1e-6)
        assert body.get("rate") == pytest.approx(0.0, abs=1e-6)
        # the anchor carries the weight, and its moment about the hinge: c x m g
        np.testing.assert_allclose(body.get("reaction_force"), [0, 0, -MASS * GRAVITY], atol=1e-5)
        np.testing.assert_allclose(body.get("reaction_torque"), [0, moment, 0], atol=1e-5)


def test_steady_target_is_followed_late_by_damping_and_friction_over_stiffness() -> None:
    target_rate, end = 0.4, 6.0
    parameters = {"gravity": [0, 0, 0], "friction": 1.7, "initial_rate": target_rate}
    late = (START["damping"] + parameters["friction"]) / START["stiffness"]
    # slowest mode -2.6 1/s: 6 s leave 2e-7 of the start
    last = run(parameters, end, 6000, {"target_angle_rate": target_rate})
    assert last["angle"] == pytest.approx(target_rate * (end - late), abs=1e-6)


def test_positive_angle_lifts_the_forearm() -> None:
    with hinge({"initial_angle": math.pi / 2}) as body:
        np.testing.assert_allclose(body.get("tip_position"), [0, 0, START["tip"][0]], atol=1e-15)


@pytest.mark.parametrize(("solver", "limit"), [("semi_implicit_euler", 2.0), ("rk4", 2.828)])
def test_undamped_spring_is_stable_up_to_the_limit_of_the_solver_and_not_beyond(solver: str, limit: float) -> None:
    frequency = math.sqrt(25.0 / ABOUT_HINGE)
    parameters = {"gravity": [0, 0, 0], "damping": 0.0, "solver": solver, "initial_angle": 1e-3}
    steps = 300
    for factor, stable in ((0.99, True), (1.01, False)):
        end = steps * factor * limit / frequency
        assert (abs(run(parameters, end, steps)["angle"]) < 1.0) == stable


# --- space: six point masses on a moved hinge ---


@pytest.mark.parametrize("time", [0.0, 0.37, 1.9])
def test_equation_of_motion_is_lagranges_on_a_tumbling_anchor(time: float) -> None:
    with hinge(SLANTED) as body:
        apply(body, LOADS | anchor_inputs(WANDERING, time))
        expected = float(WANDERING.rate_rate(time, SLANTED["initial_angle"], SLANTED["initial_rate"]))
        assert body.get("der(rate)") == pytest.approx(expected, rel=1e-12)
        assert body.get("der(angle)") == SLANTED["initial_rate"]


@pytest.mark.parametrize("output", OUTPUTS)
def test_outputs_are_those_of_the_point_masses_on_a_tumbling_anchor(output: str) -> None:
    time, angle, rate = 0.37, SLANTED["initial_angle"], SLANTED["initial_rate"]
    motion = WANDERING.motion(time, angle, rate, WANDERING.rate_rate(time, angle, rate))
    expected = np.array(motion[OUTPUTS.index(output)]).squeeze()
    with hinge(SLANTED) as body:
        apply(body, LOADS | anchor_inputs(WANDERING, time))
        # sums of some fifty terms of size up to 50
        np.testing.assert_allclose(body.get(output), expected, rtol=1e-12, atol=1e-12)


def test_torque_about_the_axis_is_all_that_muscle_joint_and_input_give() -> None:
    angle, rate = SLANTED["initial_angle"], SLANTED["initial_rate"]
    with hinge(SLANTED) as body:
        apply(body, LOADS | anchor_inputs(WANDERING, 0.37))
        axis = Rotation.from_quat(np.roll(body.get("orientation"), -1)).apply(SLANTED["axis"])
        driving = SLANTED["stiffness"] * (LOADS["target_angle"] - angle) + LOADS["torque"]
        driving -= (SLANTED["damping"] + SLANTED["friction"]) * rate
        assert axis @ body.get("reaction_torque") == pytest.approx(-driving, rel=1e-12)


def test_rk4_keeps_order_four_on_an_anchor_whose_motion_the_step_predicts_exactly() -> None:
    end = 0.8
    exact = true_state(SPINNING_UP, end)
    inputs = LOADS | anchor_inputs(SPINNING_UP, 0.0)

    def error(steps: int) -> float:
        end_state = run(SLANTED | {"solver": "rk4"}, end, steps, inputs)
        return math.hypot(end_state["angle"] - exact[0], (end_state["rate"] - exact[1]) / 10)

    assert error(800) < 1e-10
    assert measured_order(error, 40) == pytest.approx(4, abs=0.25)


@pytest.mark.parametrize(("slopes", "order"), [(True, 2), (False, 1)])
def test_wandering_anchor_costs_second_order_with_slopes_and_first_without(slopes: bool, order: int) -> None:
    end = 1.0
    exact = true_state(WANDERING, end)

    def error(steps: int) -> float:
        with hinge(SLANTED | {"solver": "rk4"}) as body:
            apply(body, LOADS)
            for k in range(steps):
                apply(body, anchor_inputs(WANDERING, k * end / steps, slopes))
                body.step(k * end / steps, end / steps)
            return math.hypot(body.get("angle") - exact[0], (body.get("rate") - exact[1]) / 10)

    assert measured_order(error, 100) == pytest.approx(order, abs=0.3)


def test_body_that_flies_freely_asks_nothing_of_a_hinge_carried_along() -> None:
    mass_properties = {name: SLANTED[name] for name in ("mass", "inertia", "gravity")}
    with Slave("RigidBody") as flying:
        start = {"base": np.negative(SLANTED["center_of_mass"]), "initial_angular_velocity": [1.0, 5.0, -2.0]}
        apply(flying, mass_properties | start)
        flying.initialize(start=0.0)
        for k in range(4):
            with hinge(SLANTED | {"stiffness": 0.0, "initial_angle": 0.0, "initial_rate": 0.0}) as body:
                for member in ("position", "velocity", "acceleration"):
                    body.set("anchor_" + member, flying.get("base_" + member))
                for member in ("orientation", "angular_velocity", "angular_acceleration"):
                    body.set("anchor_" + member, flying.get(member))
                # round-off of accelerations of size 30 on 1.3 kg
                np.testing.assert_allclose(body.get("reaction_force"), 0, atol=1e-13)
                np.testing.assert_allclose(body.get("reaction_torque"), 0, atol=1e-13)
                assert body.get("der(rate)") == pytest.approx(0, abs=1e-11)
            flying.step(k * 0.25, 0.25)


def test_orientation_is_a_unit_quaternion_on_an_anchor_whose_quaternion_is_not() -> None:
    with hinge(SLANTED) as body:
        body.set("anchor_orientation", [1.2, 0.3, -0.4, 0.5])
        assert np.linalg.norm(body.get("orientation")) == pytest.approx(1, abs=1e-15)


@pytest.mark.parametrize(
    ("name", "value"),
    [("axis", [0.0, 0.0, 0.0]), ("axis", [0.0, -1.0, 1e-4]), ("inertia", [1.0, 2.0, 3.1])],
)
def test_impossible_geometry_is_refused_with_its_name(name: str, value: list[float]) -> None:
    with Slave("HingedBody") as body, pytest.raises(UnitError, match=name):
        body.set(name, value)
        body.initialize(start=0.0)
