"""What importers do differently from each other, and every unit must take: see the tools that do it in each test."""

import ctypes
from collections.abc import Collection

import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE, fmi2CoSimulation
from fmpy.fmi3 import (
    FMU3Slave,
    fmi3InstanceEnvironment,
    fmi3IntermediateUpdateCallback,
    fmi3LogMessageCallback,
    fmi3ValueReference,
)
from importer_cases import MOTION, UNITS, each_unit, each_version

from ulna import Slave, UnitError
from ulna.description import Description, read_description
from ulna.paths import fmu as path_of

# A resource folder as importers pass it: with the trailing separator (FMPy), without (fmi-sim, fmucontainer,
# Maestro), none at all (fmuloader, for an FMU without that folder), and one that is not there.
RESOURCES = {"with separator": "{}/resources/", "without": "{}/resources", "none": None, "nowhere": "/nowhere/at/all/"}


def loaded(description: Description) -> FMU2Slave | FMU3Slave:
    made = FMU2Slave if description.version == "2.0" else FMU3Slave
    return made(guid=description.token, modelIdentifier=description.identifier, unzipDirectory=str(description.folder))


def instantiate(fmu: FMU2Slave | FMU3Slave, token: str, resources: str | None, lines: list[str]) -> int | None:
    """The instance, or None; all that the unit logs goes to `lines`. FMPy chooses path and token itself: not here."""
    path = None if resources is None else resources.encode()
    if isinstance(fmu, FMU2Slave):

        def log(_environment, _instance, _status, _category, _format):
            lines.append("line")

        fmu.callbacks = fmi2CallbackFunctions(logger=fmi2CallbackLoggerTYPE(log))
        uri = None if resources is None else b"file://" + path
        return fmu.fmi2Instantiate(b"one", fmi2CoSimulation, token.encode(), uri, ctypes.byref(fmu.callbacks), 0, 0)
    fmu.log = fmi3LogMessageCallback(lambda _environment, _status, _category, message: lines.append(message.decode()))
    flags = (False, False, False, False)
    none = (fmi3ValueReference * 0)()
    tail = (none, 0, fmi3InstanceEnvironment(), fmu.log, fmi3IntermediateUpdateCallback())
    return fmu.fmi3InstantiateCoSimulation(b"one", token.encode(), path, *flags, *tail)


@each_unit
@each_version
@pytest.mark.parametrize("resources", RESOURCES)
def test_any_resource_path_is_accepted(name, version, resources):
    description = read_description(path_of(name, version))
    fmu, lines = loaded(description), []
    path = RESOURCES[resources]
    fmu.component = instantiate(fmu, description.token, path and path.format(description.folder), lines)
    assert fmu.component
    assert lines == []
    fmu.freeInstance()


@each_unit
@each_version
@pytest.mark.parametrize("wrong", ["{00000000-0000-0000-0000-000000000000}", "", "{}"])
def test_a_wrong_token_is_refused_with_a_line_in_the_log(name, version, wrong):
    description = read_description(path_of(name, version))
    lines = []
    assert not instantiate(loaded(description), wrong, None, lines)
    assert len(lines) == 1
    assert version == "2.0" or description.token in lines[0]


@each_unit
def test_the_two_versions_have_different_tokens(name):
    assert read_description(path_of(name, "2.0")).token != read_description(path_of(name, "3.0")).token


def moving(name: str, version: str) -> Slave:
    unit = Slave(name, version=version)
    for variable, value in MOTION.get(name, {}).items():
        unit.set(variable, value)
    return unit


CLOCK_READINGS = {"burst_start", "burst_times"}
"""Outputs that are points of the run's time, not spans."""


def numbers(unit: Slave, but: Collection[str] = ()) -> np.ndarray:
    """All scalar and array outputs of a unit, one after the other; an entry of an enumeration cannot be an output."""
    outputs = [v.name for v in unit.description.variables.values() if v.causality == "output" and v.name not in but]
    return np.concatenate([np.asarray(unit.get(output), float).ravel() for output in outputs])


@each_unit
@each_version
def test_without_a_stop_time_a_run_has_no_end(name, version):
    with moving(name, version) as unit:
        unit.initialize(start=0.0, stop=None)
        unit.step(0.0, 0.01)
        unit.step(0.01, 20.0)
        assert np.isfinite(numbers(unit)).all()


@each_unit
@each_version
def test_a_run_may_end_short_of_the_stop_time_and_not_beyond_it(name, version):
    with moving(name, version) as unit:
        unit.initialize(start=0.0, stop=1.0)
        unit.step(0.0, 0.1)
        unit.terminate()
        assert np.isfinite(numbers(unit)).all()
    with moving(name, version) as unit:
        unit.initialize(start=0.0, stop=1.0)
        for n in range(3):
            unit.step(n * 0.3, 0.3)
        with pytest.raises(UnitError, match=r"stopTime = 1 s"):
            unit.step(0.9, 0.3)


@each_unit
@each_version
def test_a_run_may_start_at_any_time(name, version):
    results = []
    for start in (0.0, -8.0, 1024.0):
        with moving(name, version) as unit:
            unit.initialize(start=start)
            for n in range(8):
                unit.step(start + n / 64, 1 / 64)
            results.append(numbers(unit, but=CLOCK_READINGS))
    # the size of a step is a power of two, and so exact at each of these times; only a start time may leave a rounding
    np.testing.assert_allclose(results[1:], [results[0]] * 2, rtol=1e-12, atol=1e-12)


@each_unit
@each_version
def test_unusual_step_sizes_lead_to_the_same_place(name, version):
    """1 us, an odd fraction, more than a period: what differs is the error of order 4 of internal steps of at most
    1 ms, some 1e-12 relative, and round-off."""
    ends = []
    for steps in ([0.125] * 2, [1e-6, 0.0337, 0.0003, 0.25 - 1e-6 - 0.0337 - 0.0003]):
        with moving(name, version) as unit:
            unit.initialize()
            time = 0.0
            for step in steps:
                unit.step(time, step)
                time += step
            ends.append(numbers(unit))
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-9, atol=1e-9)


@each_unit
def test_event_mode_works_for_importers_that_never_ask_for_clock_intervals(name):
    """Such an importer enters event mode where it is told to, updates the discrete states and steps on. Pings start
    every 1/64 s, at the end of a step of 1/1024 s: those are its to handle; echoes come back within a step. The last
    step ends where nothing is due."""
    description = read_description(path_of(name, "3.0"))
    results = []
    for event_mode in (False, True):
        fmu, lines = loaded(description), []
        fmu.instantiate(eventModeUsed=event_mode, logMessage=lambda *_, lines=lines: lines.append("line"))
        for variable, value in MOTION.get(name, {}).items():
            fmu.setFloat64([description.variables[variable].references[0]], list(np.ravel(value)))
        fmu.enterInitializationMode(startTime=0.0)
        fmu.exitInitializationMode()
        if event_mode:
            fmu.updateDiscreteStates()
            fmu.enterStepMode()
        handled = 0
        for n in range(129):
            event, *_ = fmu.doStep(currentCommunicationPoint=n / 1024, communicationStepSize=1 / 1024)
            if event:
                fmu.enterEventMode()
                fmu.updateDiscreteStates()
                fmu.enterStepMode()
                handled += 1
        outputs = [v for v in description.variables.values() if v.causality == "output" and v.type == "Float64"]
        rows = [fmu.getFloat64(v.references, int(np.prod(v.dimensions))) for v in outputs]
        results.append(np.concatenate([np.ravel(row) for row in rows]))
        assert (handled > 0) == (event_mode and bool(UNITS[name].get("events")))
        assert lines == []
        fmu.freeInstance()
    np.testing.assert_array_equal(results[1], results[0])
