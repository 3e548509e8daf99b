"""Ecos (through ecospy): loads every unit, and steps coupled units as our own master does.

Its master is Jacobi: connections are passed on in initialization and after the step of all instances. What it is asked
for it reads then, after the exchange: an output that depends directly on inputs is a step ahead of our rows, so states
and what follows from them are compared. Errors do not show in what its calls return: only values are worth comparing.
Of FMI 3 it takes scalars, and reads arrays as zero. An FMU with a clock it runs, and aborts when it frees it: that one
runs in a process of its own, which ends without.
"""

import ctypes
import json
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from coupled_scenes import HINGED, STEPS, each_coupled, elements
from importer_cases import each_unit, each_version, needs

import ulna
from toy_fmu import DESCRIPTION, SOURCE, TERMINALS, build
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


ALONE = """
import ctypes, json, os, sys
path, tbb, names, step, steps = json.loads(sys.argv[1])
if os.path.exists(tbb):
    ctypes.CDLL(tbb, mode=ctypes.RTLD_GLOBAL)
import ecospy
ecospy.EcosLib.set_log_level("off")
structure = ecospy.EcosSimulationStructure()
structure.add_model("one", path)
if names:
    simulation = ecospy.EcosSimulation(step, structure=structure)
    assert simulation.init()
    for _ in range(steps):
        simulation.step()
    print(json.dumps([simulation.get_real("one::" + name) for name in names]), flush=True)
    os._exit(0)
structure.free()
"""
"""Ecos in a process of its own: the values of an FMU's variables after some steps; without any, it frees the FMU."""


def alone(path: Path, names: list[str]) -> subprocess.CompletedProcess:
    tbb = str(Path(sys.prefix) / "lib" / "libtbb.so.12")
    case = json.dumps([str(path), tbb, names, STEP, STEPS])
    return subprocess.run([sys.executable, "-c", ALONE, case], capture_output=True, text=True, check=False)


def values_of(ecos, path: Path, names: list[str], clocked: bool) -> list[float]:
    if clocked:
        found = alone(path, names)
        assert found.returncode == 0, found.stderr
        return json.loads(found.stdout.splitlines()[-1])
    with ecos.EcosSimulationStructure() as structure:
        structure.add_model("one", str(path))
        with ecos.EcosSimulation(STEP, structure=structure) as simulation:
            assert simulation.init()
            for _ in range(STEPS):
                simulation.step()
            return [simulation.get_real(f"one::{name}") for name in names]


@each_unit
@each_version
def test_every_unit_loads_and_steps(ecos, name, version):
    variables = read_description(ulna.fmu(name, version)).variables.values()
    scalar = [
        v
        for v in variables
        if v.causality == "output" and v.type == "Float64" and (version == "2.0" or not v.dimensions)
    ]
    names = [element for v in scalar for element in elements(v)]
    theirs = values_of(ecos, ulna.fmu(name, version), names, any(v.type == "Clock" for v in variables))
    with ulna.Slave(name, version=version) as unit:
        unit.initialize()
        for n in range(STEPS):
            unit.step(n * STEP, STEP)
        ours = np.concatenate([np.ravel(unit.get(v.name)) for v in scalar])
    np.testing.assert_array_equal(theirs, ours, err_msg=str(names))


def test_it_aborts_when_it_frees_a_clock_of_anyone(ecos):
    """A defect of Ecos 0.7.2: here of an FMU in which nothing is ours."""
    clock = '<Clock name="tick" valueReference="50" causality="input" intervalVariability="triggered"/>'
    for clocks, ends in (("", 0), (clock, -signal.SIGABRT)):
        text = DESCRIPTION["3.0"].replace("<ModelVariables>", f"<ModelVariables>{clocks}")
        assert alone(build("Toy", SOURCE, text, TERMINALS, "3.0"), []).returncode == ends


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
