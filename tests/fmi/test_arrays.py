"""Inputs that a structural parameter sizes, through FMPy's plain classes: the sensor's surface, FMI 3 only."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from raw import Raw, variables_of

SENSOR = "UltrasonicSensor"
COUNT = 4
VERTICES = np.arange(3.0 * COUNT, dtype=np.float32)
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2], *[[0, 0, 0]] * 4], np.int32).ravel()


def references(*names: str) -> list[int]:
    return [variables_of(SENSOR, "3.0")[name].references[0] for name in names]


def configure(unit: Raw, count: int) -> None:
    unit.enterConfigurationMode()
    unit.setUInt64(references("surface_vertex_count"), [count])
    unit.exitConfigurationMode()


def set_surface(unit: Raw, vertices=VERTICES, triangles=TRIANGLES) -> None:
    unit.setFloat32(references("surface_vertices"), vertices.tolist())
    unit.setInt32(references("surface_triangles"), triangles.tolist())


def surface(unit: Raw, count: int) -> tuple[np.ndarray, np.ndarray]:
    vertices = unit.getFloat32(references("surface_vertices"), 3 * count)
    return np.array(vertices), np.array(unit.getInt32(references("surface_triangles"), 6 * count))


def refused(unit: Raw, *words: str):
    class Refused:
        def __enter__(self):
            self.lines = len(unit.log)

        def __exit__(self, kind, *_):
            assert kind is FMICallException
            assert all(word in unit.log[-1][2] for word in words), unit.log[-1]
            assert len(unit.log) == self.lines + 1
            return True

    return Refused()


@pytest.fixture
def sensor():
    with Raw(SENSOR, "3.0") as unit:
        yield unit


def test_fmi_2_leaves_them_out():
    shown = variables_of(SENSOR, "2.0")
    assert not [name for name in shown if "surface" in name]


def test_at_the_start_there_is_one_vertex_and_no_triangle_with_an_area(sensor):
    vertices, triangles = surface(sensor, 1)
    assert not vertices.any()
    assert not triangles.any()
    sensor.start()
    sensor.doStep(0.0, 0.1)


def test_what_is_set_is_read_until_the_size_changes(sensor):
    configure(sensor, COUNT)
    set_surface(sensor)
    for _ in range(2):
        vertices, triangles = surface(sensor, COUNT)
        np.testing.assert_array_equal(vertices, VERTICES)
        np.testing.assert_array_equal(triangles, TRIANGLES)
        configure(sensor, COUNT)  # the same size is no change
    configure(sensor, COUNT - 1)
    assert not any(array.any() for array in surface(sensor, COUNT - 1))
    sensor.reset()
    assert not any(array.any() for array in surface(sensor, 1))


@pytest.mark.parametrize("index", [-1, COUNT, -(2**31), 2**31 - 1])
def test_a_triangle_of_a_vertex_that_is_not_there_is_refused(sensor, index):
    configure(sensor, COUNT)
    wrong = TRIANGLES.copy()
    wrong[7] = index
    sensor.begin()
    words = ("surface_triangles[8]", str(index), "allowed range")
    if index < 0:  # a limit of the variable itself
        with refused(sensor, *words):
            set_surface(sensor, triangles=wrong)
        return
    set_surface(sensor, triangles=wrong)
    with refused(sensor, *words, f"({COUNT - 1})"):
        sensor.exitInitializationMode()
    set_surface(sensor)
    sensor.exitInitializationMode()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", [0, 7, 3 * COUNT - 1])
def test_a_vertex_that_is_not_finite_is_refused_and_nothing_is_set(sensor, value, place):
    configure(sensor, COUNT)
    set_surface(sensor)
    sensor.start()
    wrong = VERTICES.copy()
    wrong[place] = value
    with refused(sensor, f"surface_vertices[{place + 1}]", " m;", "allowed range"):
        set_surface(sensor, vertices=wrong)
    np.testing.assert_array_equal(surface(sensor, COUNT)[0], VERTICES)


def test_arrays_of_another_size_are_refused(sensor):
    configure(sensor, COUNT)
    with refused(sensor, "surface_vertices has 12 elements", "11 values"):
        set_surface(sensor, vertices=VERTICES[:-1])
    with refused(sensor, "1 values more"):
        set_surface(sensor, vertices=np.append(VERTICES, np.float32(0.0)))
    with refused(sensor, "surface_vertex_count", "allowed range: 1 to 4194304"):
        configure(sensor, 0)
    sensor.exitConfigurationMode()
    with refused(sensor, "surface_vertex_count", "4194305"):
        configure(sensor, 4194305)


def test_the_size_changes_in_configuration_mode_only(sensor):
    with refused(sensor, "surface_vertex_count cannot be set in Instantiated", "Configuration Mode"):
        sensor.setUInt64(references("surface_vertex_count"), [COUNT])


def test_a_saved_state_holds_the_surface_and_its_size(sensor):
    configure(sensor, COUNT)
    set_surface(sensor)
    sensor.start()
    state = sensor.save()
    data = sensor.serializeFMUState(state)
    set_surface(sensor, vertices=-VERTICES)
    sensor.setFMUState(state)
    sensor.freeFMUState(state)
    np.testing.assert_array_equal(surface(sensor, COUNT)[0], VERTICES)
    with Raw(SENSOR, "3.0") as other:
        state = other.deserializeFMUState(data)
        other.setFMUState(state)
        other.freeFMUState(state)
        assert other.getUInt64(references("surface_vertex_count")) == [COUNT]
        np.testing.assert_array_equal(surface(other, COUNT)[0], VERTICES)
        np.testing.assert_array_equal(surface(other, COUNT)[1], TRIANGLES)
        for length in (len(data) - 1, len(data) - 4 * TRIANGLES.size, len(data) // 2, 8):
            with refused(other, "the state is refused", f"{length} bytes", "needed"):
                other.deserializeFMUState(data[:length])
