"""The life of an instance, its log, and its steps, as an importer meets them."""

import re

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from raw import DECLARATIONS, KINDS, MODEL_EXCHANGE, UNITS, VERSIONS, WITH_STATES, Raw, set_random_inputs

ERROR = 3

TUMBLE = {
    "inertia": [1.0, 2.0, 2.5],
    "initial_angular_velocity": [1.0, 2.0, -1.0],
    "initial_velocity": [1.0, 0.0, 3.0],
    "base": [0.5, 0.1, 0.2],
    "base_force": [1.0, 2.0, 3.0],
}
SWING = {"initial_angle": 1.0, "initial_rate": 2.0, "damping": 0.1, "stiffness": 5.0, "tip_force": [1.0, 2.0, 3.0]}
MOTION = {"RigidBody": TUMBLE, "HingedBody": SWING}
PLACE = {"RigidBody": "orientation", "HingedBody": "angle"}
ORDERS = [
    (name, number, int(order[1]))
    for name in WITH_STATES
    for number, text in enumerate(DECLARATIONS[name]["enumeration"]["Solver"].values(), 1)
    if (order := re.search(r"order (\d+)", text))
]


def refusal(call, *arguments) -> None:
    """The call must fail with the status error."""
    with pytest.raises(FMICallException) as caught:
        call(*arguments)
    assert caught.value.status == ERROR


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(("name", "kind"), KINDS)
def test_an_instance_lives_twice_with_the_same_result(name, kind, version):
    lives = []
    with Raw(name, version, kind) as unit:
        for _ in range(2):
            unit.start()
            set_random_inputs(unit, np.random.default_rng(1))
            if kind == MODEL_EXCHANGE:
                unit.setTime(0.01)
                unit.completedIntegratorStep()
            else:
                unit.doStep(0.0, 0.01)
            lives.append(unit.outputs())
            unit.terminate()
            assert unit.outputs() == lives[-1]
            unit.reset()
        assert unit.log == []
    assert lives[0] == lives[1]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_a_call_in_the_wrong_state_is_logged_with_call_and_state_even_where_logging_is_off(name, version):
    with Raw(name, version) as unit:
        refusal(unit.doStep, 0.0, 0.01)
        (status, category, text) = unit.log[-1]
        assert (status, category) == (ERROR, "logStatusError")
        assert f"fmi{version[0]}DoStep" in text
        assert "Instantiated" in text
        assert "Step Mode" in text


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_a_wrong_step_is_refused_with_its_number_and_leaves_no_trace(name, version):
    with Raw(name, version) as unit, Raw(name, version) as twin:
        unit.start(stop=1.0)
        twin.start(stop=1.0)
        for point, size, said in [
            (0.0, 0.0, "communicationStepSize = 0"),
            (0.0, -0.5, "communicationStepSize = -0.5"),
            (0.0, np.nan, "communicationStepSize = nan"),
            (0.5, 0.1, "the unit is at 0 s"),
            (0.0, 1.5, "stopTime = 1 s"),
        ]:
            refusal(unit.doStep, point, size)
            assert said in unit.log[-1][2]
        unit.doStep(0.0, 0.01)
        twin.doStep(0.0, 0.01)
        assert unit.outputs() == twin.outputs()


@pytest.mark.parametrize("version", VERSIONS)
def test_events_are_logged_where_their_category_is_on(version):
    def lines_with(**choice) -> set[str]:
        with Raw("UltrasonicSensor", version, logging=choice.pop("at_start", False)) as unit:
            if choice:
                unit.setDebugLogging(*choice.values())
            unit.start().doStep(0.0, 0.2)
            return {category for _, category, _ in unit.log}

    assert lines_with() == set()
    assert lines_with(at_start=True) == {"logEvents"}
    assert lines_with(on=True, categories=["logEvents"]) == {"logEvents"}
    assert lines_with(on=True, categories=["logStatusError"]) == set()
    assert lines_with(at_start=True, on=False, categories=[]) == set()


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_an_unknown_log_category_is_refused_with_the_known_ones(name, version):
    with Raw(name, version) as unit:
        refusal(unit.setDebugLogging, True, ["logNonsense"])
        assert "logNonsense" in unit.log[-1][2]
        assert "logStatusError" in unit.log[-1][2]


# Variable communication steps


def place_after(name: str, version: str, solver: int, steps: list[float]) -> np.ndarray:
    """Where the unit is after these steps [s], each one step of its solver."""
    with Raw(name, version) as unit:
        unit.set("solver", solver)
        unit.set("solver_step", 1.0)
        for variable, values in MOTION[name].items():
            unit.set(variable, values)
        unit.start()
        time = 0.0
        for step in steps:
            unit.doStep(time, step)
            time += step
        return unit.get(PLACE[name])


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(("name", "solver", "order"), ORDERS)
def test_two_steps_and_one_of_their_length_differ_by_the_local_error(name, solver, order, version):
    def difference(h: float) -> float:
        two_and_one = place_after(name, version, solver, [h, 2 * h])
        return np.linalg.norm(two_and_one - place_after(name, version, solver, [3 * h]))

    # the local error of a method of order p is h^(p+1) (1 + O(h)): 0.35 is the O(h) at these h
    assert np.log2(difference(0.01) / difference(0.005)) == pytest.approx(order + 1, abs=0.35)


@pytest.mark.parametrize("version", VERSIONS)
def test_outputs_of_a_unit_without_states_do_not_depend_on_the_steps_before(version):
    with Raw("ArmSkin", version) as once, Raw("ArmSkin", version) as often:
        for unit, steps in ((once, [0.04]), (often, [0.01, 0.02, 0.01])):
            unit.start()
            unit.set("forearm_orientation", [0.9, 0.0, 0.3, 0.0])
            for time, step in zip(np.cumsum([0.0, *steps[:-1]]), steps, strict=True):
                unit.doStep(time, step)
        assert once.outputs() == often.outputs()


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", WITH_STATES)
def test_a_step_that_would_never_end_is_refused_at_once(name, version):
    """Counted in doubles, its internal steps would stall at 2^53."""
    with Raw(name, version) as unit:
        unit.set("solver", 1 + list(DECLARATIONS[name]["enumeration"]["Solver"]).index("rk4"))
        unit.start()
        refusal(unit.doStep, 0.0, 1e300)
        assert "solver_step" in unit.log[-1][-1]
