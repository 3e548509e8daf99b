"""libcosim (through libcosimpy; FMI 2 only): loads every unit, and steps coupled units as our own master does.

Its fixed-step algorithm is a Jacobi master. In initialization mode it passes all outputs to the inputs once for each
slave, which settles a chain of two. A step then runs doStep of all slaves, each on its own thread, then reads all
outputs, and sets them as inputs at the beginning of the next step. Its time is a whole number of nanoseconds.
"""

import numpy as np
import pytest
from coupled_scenes import HINGED, STEPS, each_coupled
from importer_cases import each_unit, needs

import ulna
from ulna.description import Description, read_description

NANOSECONDS = 1_000_000_000
STEP = HINGED.step


@pytest.fixture
def libcosim():
    """The classes of libcosimpy, quiet."""
    needs("libcosimpy", "libcosimpy")
    from types import SimpleNamespace

    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)
    return SimpleNamespace(execution=CosimExecution, observer=CosimObserver, slave=CosimLocalSlave)


def description_of(name: str) -> Description:
    return read_description(ulna.fmu(name, "2.0"))


@each_unit
def test_every_unit_loads_and_steps(libcosim, name):
    variables = description_of(name).variables.values()
    execution = libcosim.execution.from_step_size(STEP * NANOSECONDS)
    index = execution.add_local_slave(libcosim.slave(str(ulna.fmu(name, "2.0")), "one"))
    observer = libcosim.observer.create_last_value()
    execution.add_observer(observer)
    # enumerations are skipped by libcosim
    assert execution.num_slave_variables(index) == sum(len(v.references) for v in variables if v.type != "Enumeration")
    assert execution.step(STEPS)
    with ulna.Slave(name, version="2.0") as unit:
        unit.initialize()
        for n in range(STEPS):
            unit.step(n * STEP, STEP)
        for v in variables:
            if v.type == "Float64" and v.causality == "output":
                theirs = observer.last_real_values(index, list(v.references))
                np.testing.assert_array_equal(theirs, np.ravel(unit.get(v.name)), err_msg=v.name)


@each_coupled
def test_coupled_units_move_as_under_our_own_master_to_the_bit(libcosim, coupled):
    described = {unit: description_of(name).variables for unit, (name, _) in coupled.units.items()}
    execution = libcosim.execution.from_step_size(coupled.step * NANOSECONDS)
    slave = {
        unit: execution.add_local_slave(libcosim.slave(str(ulna.fmu(name, "2.0")), unit))
        for unit, (name, _) in coupled.units.items()
    }
    observer = libcosim.observer.create_last_value()
    execution.add_observer(observer)
    for unit, (_, values) in coupled.units.items():
        for variable, value in values.items():
            for reference, x in zip(described[unit][variable].references, np.ravel(value), strict=True):
                assert execution.real_initial_value(slave[unit], reference, x)
    for source, output, target, taker in coupled.pairs():
        ends = zip(described[source][output].references, described[target][taker].references, strict=True)
        for one, other in ends:
            assert execution.connect_real_variables(slave[source], one, slave[target], other) == 0
    rows = []
    for _ in range(STEPS):
        assert execution.step()
        row = [execution.status().current_time / NANOSECONDS]
        for unit, names in coupled.watched.items():
            for name in names:
                row += observer.last_real_values(slave[unit], list(described[unit][name].references))
        rows.append(row)
    expected = coupled.rows()
    np.testing.assert_array_equal(rows, expected[1:])
    assert np.ptp(expected[:, 1:], axis=0).min() > 1e-6
