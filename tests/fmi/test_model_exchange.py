"""Model exchange: the right-hand side against closed forms, another integrator, and co-simulation."""

import numpy as np
import pytest
from raw import DECLARATIONS, MODEL_EXCHANGE, ROUND_OFF, UNITS, VERSIONS, WITH_STATES, Raw, base_name, unpacked
from scipy.integrate import solve_ivp

GRAVITY = np.array([0.0, 0.0, -9.80665])
START = {
    "RigidBody": {
        "inertia": [1.0, 2.0, 2.5],
        "initial_angular_velocity": [1.0, 2.0, -1.0],
        "base": [0.5, 0.1, 0.2],
        "base_force": [1.0, 2.0, 3.0],
    },
    "HingedBody": {"initial_angle": 1.0, "damping": 0.1, "stiffness": 5.0, "tip_force": [1.0, 2.0, 3.0]},
}
RK4 = {name: 1 + list(DECLARATIONS[name]["enumeration"]["Solver"]).index("rk4") for name in WITH_STATES}
STATES = {
    "RigidBody": ("position", "orientation", "linear_momentum", "angular_momentum"),
    "HingedBody": ("angle", "rate"),
}


def slope_of(unit: Raw):
    """The right-hand side f(t, x) of a unit in continuous time."""

    def slope(time: float, states: np.ndarray) -> np.ndarray:
        unit.setTime(time)
        unit.set_states(states)
        return unit.get_derivatives()

    return slope


def runge_kutta(slope, time: float, states: np.ndarray, h: float) -> np.ndarray:
    """One classical step."""
    k1 = slope(time, states)
    k2 = slope(time + h / 2, states + h / 2 * k1)
    k3 = slope(time + h / 2, states + h / 2 * k2)
    k4 = slope(time + h, states + h * k3)
    return states + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


@pytest.mark.parametrize("version", VERSIONS)
def test_free_flight_is_the_parabola_to_round_off(version):
    position, velocity, steps, h = np.array([1.0, 2.0, 3.0]), np.array([4.0, -5.0, 6.0]), 20, 0.05
    with Raw("RigidBody", version, MODEL_EXCHANGE) as body:
        body.set("mass", 2.0)
        body.set("initial_position", position)
        body.set("initial_velocity", velocity)
        slope, states = slope_of(body.start()), body.get_states()
        for i in range(steps):
            states = runge_kutta(slope, i * h, states, h)
            body.completedIntegratorStep()
        body.setTime(steps * h)
        body.set_states(states)
        t = steps * h
        # exact for a polynomial of degree 4; ten roundings a step of numbers below 40
        np.testing.assert_allclose(
            body.get("position"), position + velocity * t + GRAVITY * t**2 / 2, rtol=0, atol=steps * 10 * 40 * ROUND_OFF
        )
        np.testing.assert_allclose(
            body.get("velocity"), velocity + GRAVITY * t, rtol=0, atol=steps * 10 * 40 * ROUND_OFF
        )


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", WITH_STATES)
def test_co_simulation_tends_to_what_another_integrator_makes_of_model_exchange(name, version):
    end = 0.5
    with Raw(name, version, MODEL_EXCHANGE) as unit:
        for variable, value in START[name].items():
            unit.set(variable, value)
        unit.start()
        exact = solve_ivp(slope_of(unit), (0, end), unit.get_states(), method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]

    def error(steps: int) -> float:
        with Raw(name, version) as unit:
            for variable, value in {**START[name], "solver": RK4[name], "solver_step": 1.0}.items():
                unit.set(variable, value)
            unit.start()
            for i in range(steps):
                unit.doStep(i * end / steps, end / steps)
            return np.linalg.norm(np.concatenate([unit.get(state) for state in STATES[name]]) - exact)

    # rk4 is of order 4; half an order for the terms beyond it at these steps
    assert np.log2(error(80) / error(160)) == pytest.approx(4.0, abs=0.5)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", WITH_STATES)
def test_states_and_derivatives_are_those_that_the_model_description_names(name, version):
    description, _ = unpacked(name, version)
    states = STATES[name]
    with Raw(name, version, MODEL_EXCHANGE) as unit:
        for variable, value in START[name].items():
            unit.set(variable, value)
        unit.start()
        listed = [unknown.variable for unknown in description.derivatives]
        assert [base_name(v.derivative.name) for v in listed] == [
            state for state in states for _ in range(unit.variables[state].size if version == "2.0" else 1)
        ]
        np.testing.assert_array_equal(np.concatenate([unit.get(state) for state in states]), unit.get_states())
        np.testing.assert_array_equal(np.concatenate([unit.get(f"der({s})") for s in states]), unit.get_derivatives())
        nominals = [
            float(v.derivative.nominal or 1.0)
            for v in listed
            for _ in range(v.derivative.shape[0] if v.derivative.shape else 1)
        ]
        np.testing.assert_array_equal(unit.get_nominals(), nominals)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", WITH_STATES)
def test_a_smooth_unit_asks_for_no_event(name, version):
    with Raw(name, version, MODEL_EXCHANGE) as unit:
        unit.start()
        assert unit.completedIntegratorStep() in ((0, 0), (False, False))
        unit.enterEventMode()
        news = unit.newDiscreteStates() if version == "2.0" else unit.updateDiscreteStates()
        assert not any(news[:5])
        unit.enterContinuousTimeMode()
        assert unit.get_states().shape == (unit.states,)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_unit_without_states_offers_no_model_exchange(version):
    for name in set(UNITS) - set(WITH_STATES):
        assert unpacked(name, version)[0].modelExchange is None
