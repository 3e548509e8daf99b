"""Ecos (through ecospy): loads every unit, and steps coupled units as our own master does.

Its master is Jacobi: connections are passed on in initialization and after the step of all instances. What it is asked
for it reads then, after the exchange: an output that depends directly on inputs is a step ahead of our rows, so states
and what follows from them are compared. Errors do not show in what its calls return: only values are worth comparing.
Of FMI 3 it takes scalars, and reads arrays as zero.
"""

import ctypes
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from coupled_scenes import HINGED, STEPS, each_coupled, elements
from importer_cases import each_unit, each_version, needs

import ulna
from ulna.description import read_description

STEP = HINGED.step


@pytest.fixture
def ecos():
    """The module ecospy. Its library wants TBB: the system's, or that of PyPI's `tbb`, where no loader looks."""
    with suppress(OSError):
        ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)
    module = needs("ecospy", "ecospy", "pip install ecospy tbb (or, for the second, Debian's libtbb12)")
    module.EcosLib.set_log_level("off")
    return module


@each_unit
@each_version
def test_every_unit_loads_and_steps(ecos, name, version):
    scalar = [
        v
        for v in read_description(ulna.fmu(name, version)).variables.values()
        if v.causality == "output" and v.type == "Float64" and (version == "2.0" or not v.dimensions)
    ]
    with ecos.EcosSimulationStructure() as structure:
        structure.add_model("one", str(ulna.fmu(name, version)))
        with ecos.EcosSimulation(STEP, structure=structure) as simulation, ulna.Slave(name, version=version) as unit:
            assert simulation.init()
            unit.initialize()
            for n in range(STEPS):
                simulation.step()
                unit.step(n * STEP, STEP)
            for v in scalar:
                theirs = [simulation.get_real(f"one::{element}") for element in elements(v)]
                np.testing.assert_array_equal(theirs, np.ravel(unit.get(v.name)), err_msg=v.name)
    assert scalar


@each_coupled
def test_coupled_units_move_as_under_our_own_master_to_the_bit(ecos, coupled):
    described = {unit: read_description(ulna.fmu(name, "2.0")).variables for unit, (name, _) in coupled.units.items()}

    def names(unit: str, variable: str) -> list[str]:
        return [f"{unit}::{element}" for element in elements(described[unit][variable])]

    parameters = {
        name: float(x)
        for unit, (_, values) in coupled.units.items()
        for variable, value in values.items()
        for name, x in zip(names(unit, variable), np.ravel(value), strict=True)
    }
    rows = []
    with ecos.EcosSimulationStructure() as structure:
        for unit, (name, _) in coupled.units.items():
            structure.add_model(unit, str(ulna.fmu(name, "2.0")))
        structure.add_parameter_set("start", parameters)
        for source, output, target, taker in coupled.pairs():
            for one, other in zip(names(source, output), names(target, taker), strict=True):
                structure.make_real_connection(one, other)
        with ecos.EcosSimulation(coupled.step, structure=structure) as simulation:
            assert simulation.init(0, "start")
            for _ in range(STEPS):
                row = [simulation.step()]
                for unit, variables in coupled.watched.items():
                    row += [simulation.get_real(name) for variable in variables for name in names(unit, variable)]
                rows.append(row)
    np.testing.assert_array_equal(rows, coupled.rows()[1:])
