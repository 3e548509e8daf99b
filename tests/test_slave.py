"""Slave: one view of any FMU, FMI 2.0 and 3.0; values to the bit; errors in the unit's own words."""

import pickle
import subprocess
import sys
import tracemalloc
from pathlib import Path

import fmpy
import numpy as np
import pytest

from toy_fmu import toy
from ulna.description import read_description
from ulna.slave import Slave, UnitError

VERSIONS = ("2.0", "3.0")


@pytest.fixture(params=VERSIONS)
def slave(request):
    with Slave(toy(request.param), "toy") as instance:
        yield instance


def test_values_come_back_as_they_were_set(slave):
    slave.set("gain", 0.1)
    slave.set("u", [1.5, -2.0, 1e-300])
    slave.set("count", -7)
    slave.set("flag", True)
    slave.initialize()
    assert slave.get("gain") == 0.1
    np.testing.assert_array_equal(slave.get("u"), [1.5, -2.0, 1e-300])
    assert (slave.get("count"), slave.get("next_count")) == (-7, -6)
    assert (slave.get("flag"), slave.get("not_flag")) == (True, False)


def test_enumerations_are_set_and_read_by_the_names_of_their_entries(slave):
    assert slave.get("mode") == "plain"
    slave.set("mode", "doubled")
    assert slave.get("mode") == "doubled"
    with pytest.raises(ValueError, match=r"toy\.mode has no entry 'dubled': did you mean doubled\?"):
        slave.set("mode", "dubled")


@pytest.mark.parametrize("fmu", ["toy", "RigidBody"])
def test_both_versions_give_one_view(fmu):
    views = []
    for version in VERSIONS:
        with Slave(toy(version) if fmu == "toy" else fmu, version=version) as instance:
            shown = {
                v.name: (v.type, v.dimensions, v.causality, v.unit.name)
                for v in instance.description.variables.values()
                if v.name not in ("time", "size", "ramp")
            }
            views.append((shown, instance.description.terminals, instance.description.dependencies))
    assert views[0] == views[1]


def test_an_array_with_a_missing_element_stays_scalars(tmp_path):
    text = (read_description(toy("2.0")).folder / "modelDescription.xml").read_text()
    assert set(read_description(toy("2.0")).variables) >= {"u", "x", "y"}
    fmu = tmp_path / "Gap.fmu"
    import zipfile

    with zipfile.ZipFile(toy("2.0")) as source, zipfile.ZipFile(fmu, "w") as target:
        for item in source.namelist():
            data = text.replace('"u[2]"', '"u[4]"').encode() if item == "modelDescription.xml" else source.read(item)
            target.writestr(item, data)
    assert {"u[1]", "u[3]", "u[4]"} <= set(read_description(fmu).variables)


def test_a_structural_parameter_sets_the_shape_of_what_depends_on_it():
    with Slave(toy("3.0")) as instance:
        assert instance.get("ramp").shape == (2,)
        instance.set("size", 5)
        instance.initialize()
        np.testing.assert_array_equal(instance.get("ramp"), [0, 1, 2, 3, 4])
        instance.reset()
        assert instance.get("ramp").shape == (2,)
        with pytest.raises(UnitError):
            instance.set("size", 9)


def test_a_port_moves_several_variables_through_one_buffer(slave):
    slave.initialize()
    buffer = np.zeros(6)
    inputs, outputs = slave.setter(["u"]), slave.getter(["y", "x"], buffer)
    inputs.values[:] = [1.0, 2.0, 3.0]
    inputs()
    slave.step(0.0, 0.5)
    assert outputs() is buffer
    np.testing.assert_array_equal(buffer[outputs.slices["x"]], [0.5, 1.0, 1.5])
    np.testing.assert_array_equal(buffer[outputs.slices["y"]], [1.0, 2.0, 3.0])


def test_a_port_refuses_mixed_types_and_buffers_that_do_not_fit(slave):
    with pytest.raises(ValueError, match="one port moves one type"):
        slave.getter(["x", "next_count"])
    for buffer in (np.zeros(4), np.zeros(3, np.float32), np.zeros(6)[::2]):
        with pytest.raises(ValueError, match="contiguous array of 3 float64"):
            slave.getter(["x"], buffer)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("u", [1.0, 2.0], r"toy\.u: the shape is \(3,\), not \(2,\)"),
        ("u", 1.0, r"toy\.u: the shape is \(3,\), not that of a scalar"),
        ("count", 1.5, r"toy\.count: 1\.5 is no Int32"),
    ],
)
def test_values_that_do_not_fit_are_refused(slave, name, value, message):
    with pytest.raises(ValueError, match=message):
        slave.set(name, value)


def test_a_wrong_name_gets_the_nearest_right_one(slave):
    with pytest.raises(KeyError, match=r"toy has no variable 'gian': did you mean gain\?"):
        slave.set("gian", 1.0)


def test_restored_and_serialized_states_step_to_the_same_bits(slave):
    slave.set("gain", 0.3)
    slave.initialize()
    slave.set("u", [0.1, 0.2, 0.3])
    slave.step(0.0, 0.1)
    state, data = slave.save(), slave.serialize()
    slave.step(0.1, 0.1)
    after = slave.get("x")
    slave.restore(state)
    slave.step(0.1, 0.1)
    np.testing.assert_array_equal(slave.get("x"), after)
    slave.free(state)
    with Slave(toy(slave.version)) as other:
        other.initialize()
        other.deserialize(data)
        other.step(0.1, 0.1)
        np.testing.assert_array_equal(other.get("x"), after)


def test_a_failing_call_raises_the_units_own_words(slave):
    slave.initialize()
    slave.set("u", [0.0, np.nan, 0.0])
    with pytest.raises(UnitError) as caught:
        slave.step(2.5, 0.5)
    error = pickle.loads(pickle.dumps(caught.value))
    assert (error.unit, error.time) == ("toy", 2.5)
    assert error.call == f"fmi{slave.version[0]}DoStep"
    # The FMI 2 toy logs with printf arguments: a string, an integer and a double.
    assert error.message == {"2.0": "u is not finite at 100 of 2.5 s", "3.0": "u is not finite"}[slave.version]
    assert str(error) == f"toy at t = 2.5 s: {error.call} returned error: {error.message}"


@pytest.mark.parametrize("version", VERSIONS)
def test_instances_do_not_mix_their_messages(version):
    with Slave(toy(version), "good") as good, Slave(toy(version), "bad") as bad:
        for instance in (good, bad):
            instance.initialize()
        bad.set("u", [np.inf, 0.0, 0.0])
        with pytest.raises(UnitError):
            bad.step(0.0, 0.1)
        assert len(bad.messages.latest) == 1
        assert not good.messages.latest


def test_fmpy_keeps_its_own_logger_beside_ours():
    ours = Slave(toy("2.0"))
    ours.initialize()
    logged = []
    fmpy.simulate_fmu(str(toy("2.0")), stop_time=0.1, logger=lambda *arguments: logged.append(arguments))
    ours.set("u", [np.nan, 0.0, 0.0])
    with pytest.raises(UnitError, match="u is not finite at 100"):
        ours.step(0.0, 0.1)
    ours.close()
    assert not logged


def test_reset_returns_to_the_start_values(slave):
    slave.set("gain", 3.0)
    slave.initialize()
    slave.set("u", [1.0, 1.0, 1.0])
    slave.step(0.0, 1.0)
    slave.reset()
    assert slave.get("gain") == 1.0
    np.testing.assert_array_equal(slave.get("x"), np.zeros(3))


def test_steps_and_ports_keep_no_memory(slave):
    slave.initialize()
    port = slave.getter(["x", "y"])

    def work() -> int:
        for _ in range(2000):
            slave.step(0.0, 1e-9)
            port()
            slave.get("x")
            slave.free(slave.save())
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        first, second = work(), work()
    finally:
        tracemalloc.stop()
    # One byte kept in each of the 2000 rounds would show.
    assert second - first < 2000


def test_the_extracted_files_go_when_the_process_ends():
    program = "import sys; from ulna.slave import Slave; print(Slave(sys.argv[1]).description.folder)"
    command = [sys.executable, "-c", program, str(toy("3.0"))]
    folder = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
    assert folder
    assert not Path(folder).exists()


def test_an_fmu_that_is_not_there_is_reported_by_name():
    with pytest.raises(FileNotFoundError, match=r"Nowhere\.fmu"):
        Slave("Nowhere.fmu")
    with pytest.raises(FileNotFoundError, match="RigidBody"):
        Slave("RigidBdy")
