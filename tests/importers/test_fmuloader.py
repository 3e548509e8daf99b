"""fmuloader: an independent loader that binds every function, so that a missing one fails the load."""

from ctypes import c_double, c_uint32

import numpy as np
from importer_cases import each_unit, needs

import ulna
from ulna import Slave
from ulna.description import read_description

STEP = 1 / 64


def first_output(unit: Slave):
    return next(v for v in unit.description.variables.values() if v.causality == "output" and v.type == "Float64")


def ours(name: str, version: str) -> tuple[str, tuple[int, ...], int, np.ndarray]:
    """Token, value references, elements and end value of the first output, by our own loader."""
    with Slave(name, version=version) as unit:
        output = first_output(unit)
        unit.initialize()
        for n in range(8):
            unit.step(n * STEP, STEP)
        return unit.description.token, output.references, unit.count(output), np.ravel(unit.get(output.name))


@each_unit
def test_loads_and_steps_fmi_2(name):
    loader = needs("fmuloader", "fmuloader.fmi2")
    token, references, _, expected = ours(name, "2.0")
    unit = loader.Fmi2Slave(ulna.fmu(name, "2.0"), model_identifier=name)
    unit.instantiate("one", loader.Fmi2Type.CO_SIMULATION, guid=token)
    unit.setup_experiment(start_time=0.0)
    unit.enter_initialization_mode()
    unit.exit_initialization_mode()
    for n in range(8):
        unit.do_step(n * STEP, STEP)
    np.testing.assert_array_equal(unit.get_real(references), expected)
    unit.terminate()
    unit.free_instance()


@each_unit
def test_loads_and_steps_fmi_3(name):
    loader = needs("fmuloader", "fmuloader.fmi3")
    token, references, count, expected = ours(name, "3.0")
    unit = loader.Fmi3Slave(ulna.fmu(name, "3.0"), model_identifier=name)
    unit.instantiate_co_simulation("one", instantiation_token=token)
    unit.enter_initialization_mode(start_time=0.0)
    unit.exit_initialization_mode()
    for n in range(8):
        unit.do_step(n * STEP, STEP)
    # the loader's own get has no place for the size of an array; the function that it has bound has
    values = (c_double * count)()
    assert unit._fmi3GetFloat64(unit._instance, (c_uint32 * 1)(*references), 1, values, count) == 0
    np.testing.assert_array_equal(values, expected)
    unit.terminate()
    unit.free_instance()


def test_takes_a_mesh_and_counts_down_the_clock_of_an_echo():
    """By its own calls; an array it sets whole, but reads no more than one element of it."""
    loader = needs("fmuloader", "fmuloader.fmi3")
    description = read_description(ulna.fmu("UltrasonicSensor", "3.0"))
    names = ("surface_vertex_count", "surface_vertices", "surface_triangles", "trigger_clock", "echo_clock", "sequence")
    count, vertices, triangles, trigger, echo, sequence = (description.variables[name].references for name in names)
    unit = loader.Fmi3Slave(ulna.fmu("UltrasonicSensor", "3.0"), model_identifier="UltrasonicSensor")
    unit.instantiate_co_simulation("one", instantiation_token=description.token, event_mode_used=True)
    unit.enter_configuration_mode()
    unit.set_uint64(count, [4])
    unit.exit_configuration_mode()
    unit.set_float32(vertices, [0.1 * k for k in range(12)])
    unit.set_int32(triangles, [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2] + [0] * 12)
    unit.set_float64(description.variables["period"].references, [0.0])
    unit.enter_initialization_mode(start_time=0.0)
    unit.exit_initialization_mode()
    assert unit.get_interval_decimal(echo)[1] == [loader.Fmi3IntervalQualifier.INTERVAL_NOT_YET_KNOWN]
    unit.set_clock(trigger, [True])
    unit.update_discrete_states()
    (interval,), qualifiers = unit.get_interval_decimal(echo)
    assert qualifiers == [loader.Fmi3IntervalQualifier.INTERVAL_CHANGED]
    unit.enter_step_mode()
    unit.do_step(0.0, interval)
    unit.enter_event_mode()
    unit.set_clock(echo, [True])
    unit.update_discrete_states()
    assert unit.get_int32(sequence) == [1]
    unit.terminate()
    unit.free_instance()
