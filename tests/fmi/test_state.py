"""Saved states: every unit, both versions and kinds; what is restored goes on to the bit."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from raw import KINDS, MODEL_EXCHANGE, UNITS, VERSIONS, WITH_STATES, Raw, set_random_inputs

STEPS = (0.01, 0.03, 0.02)  # s; together over one period of the sensor's pings


def advance(unit: Raw, time: float, seed: int) -> list[dict[str, bytes]]:
    """Outputs after each of a few steps on random inputs, in model exchange of explicit Euler."""
    random = np.random.default_rng(seed)
    seen = []
    for step in STEPS:
        if unit.kind == MODEL_EXCHANGE:
            states = unit.get_states() + step * unit.get_derivatives()
            unit.setTime(time + step)
            unit.set_states(states)
        set_random_inputs(unit, random)
        if unit.kind != MODEL_EXCHANGE:
            unit.doStep(time, step)
        time += step
        seen.append(unit.outputs())
    return seen


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(("name", "kind"), KINDS)
def test_a_restored_state_goes_on_to_the_bit(name, kind, version):
    with Raw(name, version, kind) as unit:
        unit.start()
        before = advance(unit, 0.0, 1)
        state = unit.save()
        first = advance(unit, sum(STEPS), 2)
        assert first != before
        for _ in range(2):
            unit.setFMUState(state)
            assert unit.outputs() == before[-1]
            assert advance(unit, sum(STEPS), 2) == first
        unit.freeFMUState(state)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", sorted(set(UNITS) - {"UltrasonicSensor"}))  # whose outputs change in events only
def test_outputs_first_read_after_a_restore_are_not_those_read_before_it(name, version):
    random = np.random.default_rng(3)
    with Raw(name, version) as unit:
        unit.start()
        set_random_inputs(unit, random)
        unit.doStep(0.0, 0.01)
        state = unit.save()  # before anything is read, so that the outputs in it are not yet computed
        first = unit.outputs()
        set_random_inputs(unit, random)
        unit.doStep(0.01, 0.01)
        assert unit.outputs() != first
        unit.setFMUState(state)
        assert unit.outputs() == first
        unit.freeFMUState(state)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(("name", "kind"), KINDS)
def test_a_serialized_state_goes_on_in_another_instance_to_the_bit(name, kind, version):
    with Raw(name, version, kind) as unit:
        unit.start()
        advance(unit, 0.0, 1)
        state = unit.save()
        data = unit.serializeFMUState(state)
        assert unit.serializeFMUState(state) == data
        unit.freeFMUState(state)
        first = advance(unit, sum(STEPS), 2)
    with Raw(name, version, kind) as other:
        state = other.deserializeFMUState(data)
        other.setFMUState(state)
        other.freeFMUState(state)
        assert advance(other, sum(STEPS), 2) == first


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_a_state_carries_the_parameters(name, version):
    with Raw(name, version) as unit, Raw(name, version) as other:
        parameters = unit.of("parameter", "Real", "Float64")
        changed = {
            p.name: np.minimum(1.25 * p.start, np.inf if p.maximum is None else p.maximum)
            for p in parameters
            if p.name not in ("axis", "initial_orientation")
        }
        for parameter, value in changed.items():
            unit.set(parameter, value)
        data = unit.start().serializeFMUState(state := unit.save())
        unit.freeFMUState(state)
        other.start()
        other.setFMUState(state := other.deserializeFMUState(data))
        other.freeFMUState(state)
        for parameter, value in changed.items():
            np.testing.assert_array_equal(other.get(parameter), value)
        assert advance(other, 0.0, 1) == advance(unit, 0.0, 1)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_a_state_saved_in_initialization_is_restored_there(name, version):
    with Raw(name, version) as unit:
        unit.begin()
        state = unit.save()
        unit.exitInitializationMode()
        first = advance(unit, 0.0, 1)
        unit.setFMUState(state)
        unit.exitInitializationMode()
        assert advance(unit, 0.0, 1) == first
        unit.freeFMUState(state)


def serialized(name: str, version: str, kind: str) -> bytes:
    """A state right after initialization."""
    with Raw(name, version, kind) as unit:
        state = unit.start().save()
        data = unit.serializeFMUState(state)
        unit.freeFMUState(state)
        return data


def assert_refused(unit: Raw, data: bytes) -> None:
    unit.log.clear()
    with pytest.raises(FMICallException):
        unit.deserializeFMUState(data)
    assert "state" in unit.log[-1][2]


@pytest.mark.parametrize("version", VERSIONS)
def test_a_state_of_another_unit_is_refused(version):
    states = {name: serialized(name, version, "co-simulation") for name in UNITS}
    longest = max(map(len, states.values()))
    for name in UNITS:
        with Raw(name, version) as unit:
            unit.start()
            for other in UNITS:
                if other != name:
                    assert_refused(unit, states[other])
                    # nor when its length happens to be right
                    assert_refused(unit, states[other].ljust(longest, b"\0")[: len(states[name])])


@pytest.mark.parametrize("name", UNITS)
def test_a_state_of_the_other_version_is_refused(name):
    for version, other in (VERSIONS, VERSIONS[::-1]):
        with Raw(name, version) as unit:
            assert_refused(unit, serialized(name, other, "co-simulation"))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", WITH_STATES)
def test_a_state_of_the_other_kind_is_refused(name, version):
    with Raw(name, version) as unit:
        assert_refused(unit, serialized(name, version, MODEL_EXCHANGE))


def test_a_state_carries_the_structural_parameter():
    def arm(count: int) -> Raw:
        skin = Raw("ArmSkin", "3.0")
        skin.enterConfigurationMode()
        skin.set("vertex_count", count)
        skin.exitConfigurationMode()
        return skin.start()

    with arm(1024) as small, arm(4096) as large:
        small.set("forearm_orientation", [0.9, 0.0, 0.4, 0.0])
        state = small.save()
        large.setFMUState(state)
        small.freeFMUState(state)
        references = list(large.variables["vertices"].references)
        assert large.get("vertex_count") == 1024
        assert large.getFloat32(references, 3 * 1024) == small.getFloat32(references, 3 * 1024)
        assert large.outputs() == small.outputs()
