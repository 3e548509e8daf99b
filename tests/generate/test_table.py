"""The compiled table of variables against the declaration: every element has its own place, type, start and limits."""

import numpy as np
import pytest
from generated import declaration, each_unit

from ulna import Slave, UnitError
from ulna.generate.declaration import Variable

each_version = pytest.mark.parametrize("version", ["2.0", "3.0"])


def settable(name: str, version: str) -> list[Variable]:
    """What an importer sets before initialization; structural parameters are set in a mode of their own."""
    variables = [v for v in declaration(name).variables if v.causality in ("parameter", "input")]
    return [v for v in variables if int(version[0]) in v.fmi and v.type != "Clock"]


def other_values(v: Variable, first: int, entries: int) -> np.ndarray:
    """Values within the limits that differ from the start, and from those of every other variable where they can."""
    start = np.array(v.start, float)
    if v.type == "Boolean":
        return 1.0 - start
    if v.enumeration:
        return start % entries + 1
    if v.type != "Float64":
        return start + first
    low = -np.inf if v.min is None else v.min
    high = np.inf if v.max is None else v.max
    small = 1e-3 * (first + np.arange(v.count)) / 1024
    return np.where(start + small <= high, start + small, np.maximum(start - small, low))


def read(unit: Slave, v: Variable) -> np.ndarray:
    """All elements, entries of an enumeration by their numbers."""
    values = unit.getter([v.name])()
    return np.asarray(values, float).ravel()


@each_unit
@each_version
def test_start_values_are_those_declared(name, version):
    with Slave(name, version=version) as unit:
        for v in declaration(name).variables:
            if v.settable and int(version[0]) in v.fmi and v.type != "Clock":
                np.testing.assert_array_equal(read(unit, v), np.array(v.start, float), err_msg=v.name)


@each_unit
@each_version
def test_every_element_has_a_place_of_its_own(name, version):
    """All are set, then all are read: two that shared memory would show the same value."""
    variables = settable(name, version)
    enumerations = declaration(name).enumerations
    wanted = {v.name: other_values(v, 1 + i, len(enumerations.get(v.enumeration, ()))) for i, v in enumerate(variables)}
    with Slave(name, version=version) as unit:
        for v in variables:
            port = unit.setter([v.name])
            port.values[:] = wanted[v.name]
            port()
        for v in variables:
            np.testing.assert_array_equal(read(unit, v), wanted[v.name], err_msg=v.name)
            assert v.type == "Boolean" or np.all(wanted[v.name] != v.start) or v.enumeration
        unit.reset()
        for v in variables:
            np.testing.assert_array_equal(read(unit, v), np.array(v.start, float), err_msg=v.name)


@each_unit
@each_version
def test_limits_are_those_declared(name, version):
    """The limit itself is taken, the next number beyond it is not."""
    with Slave(name, version=version) as unit:
        for v in settable(name, version):
            if v.type != "Float64" or v.quaternion:
                continue
            for limit, beyond in ((v.min, -np.inf), (v.max, np.inf)):
                port = unit.setter([v.name])
                port.values[:] = v.start
                port.values[-1] = np.inf if limit is None else np.nextafter(limit, beyond)
                message = rf"{v.name}.*allowed range"
                with pytest.raises(UnitError, match=message):
                    port()
                if limit is not None:
                    port.values[-1] = limit
                    port()
                    assert read(unit, v)[-1] == limit
            port.values[:] = v.start
            port()


@each_unit
def test_both_versions_compute_the_same(name):
    """Start values and inputs alike, every output has the same bits after some steps."""
    ends = []
    for version in ("2.0", "3.0"):
        with Slave(name, version=version) as unit:
            unit.initialize()
            for n in range(16):
                unit.step(n / 128, 1 / 128)
            outputs = [v.name for v in declaration(name).variables if v.causality == "output" and 2 in v.fmi]
            ends.append({output: np.asarray(unit.get(output)).tobytes() for output in outputs})
    assert ends[0] == ends[1]


@each_unit
def test_initialization_starts_from_the_parameters_in_both_versions(name):
    starts = []
    for version in ("2.0", "3.0"):
        with Slave(name, version=version) as unit:
            for v in settable(name, version):
                if v.name.startswith("initial_") and not v.quaternion:
                    unit.set(v.name, np.arange(1.0, v.count + 1) if v.size else 0.5)
            unit.initialize()
            outputs = [v.name for v in declaration(name).variables if v.causality == "output" and 2 in v.fmi]
            starts.append({output: np.asarray(unit.get(output)).tobytes() for output in outputs})
    assert starts[0] == starts[1]
