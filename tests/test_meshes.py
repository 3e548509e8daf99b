"""Meshes from unit to unit: moved whole, checked for size, type and unit, and not recorded."""

import numpy as np
import pytest

import ulna
from ulna.masters import MASTERS
from ulna.port import Port

COUNT = 512


def turned(time: float) -> list[float]:
    return [np.cos(time / 2), 0.0, -np.sin(time / 2), 0.0]


@pytest.fixture
def scene():
    """A skin whose forearm turns at 1 rad/s, and a sensor that is given its mesh."""
    with ulna.Scene("mesh") as scene:
        skin = scene.add("ArmSkin", "skin", vertex_count=COUNT)
        sensor = scene.add("UltrasonicSensor", "sensor", surface_vertex_count=COUNT)
        scene.signal(skin.forearm_orientation, turned)
        scene.connect("skin.vertices", "sensor.surface_vertices")
        scene.connect(skin.triangles, sensor.surface_triangles)
        yield scene


def vertices_at(time: float) -> np.ndarray:
    with ulna.Slave("ArmSkin") as skin:
        skin.set("vertex_count", COUNT)
        skin.set("forearm_orientation", turned(time))
        skin.initialize()
        return skin.get("vertices")


@pytest.mark.parametrize("master", ["jacobi", "gauss_seidel", "iterated", "newton"])
def test_the_sensor_is_told_the_mesh_of_the_right_time(scene, master):
    """Of the end of the step, or with jacobi what the skin put out at its begin, for the input of the step before."""
    told = {"jacobi": 0.02 - 2 * 0.005}.get(master, 0.02)
    for _ in range(2):  # again, after a reset
        scene.run(until=0.02, step=0.005, master=master)
        sensor, skin = scene["sensor"].slave, scene["skin"].slave
        np.testing.assert_array_equal(sensor.get("surface_vertices"), vertices_at(told))
        np.testing.assert_array_equal(sensor.get("surface_triangles"), skin.get("triangles"))


def test_meshes_are_not_recorded(scene):
    results = scene.run(until=0.02, step=0.005)
    assert all(values.size <= 3 * len(results) for values in results.columns.values())
    assert not [name for name in results if "vertices" in name or "triangles" in name]


def test_a_mesh_is_recorded_where_that_is_asked_for(scene):
    scene.record(scene["skin"].vertices)
    results = scene.run(until=0.02, step=0.01)
    assert results["skin.vertices"].shape == (3, 3, COUNT)
    np.testing.assert_array_equal(results["skin.vertices"][-1], vertices_at(0.02))


@pytest.fixture
def moved(monkeypatch):
    """The calls that move a mesh, in their order: name, and the bytes that lie in the buffer."""
    calls = []
    original = Port.__init__

    def watched(self, *arguments):
        original(self, *arguments)
        name, function, values = self.name, self.function, self.values

        def called(*arguments):
            if values.size >= 3 * COUNT:
                calls.append((name, values.tobytes()))
            return function(*arguments)

        self.function = called

    monkeypatch.setattr(Port, "__init__", watched)
    return calls


@pytest.mark.parametrize("master", sorted(set(MASTERS) - {"rigid"}))
def test_what_is_fixed_moves_once_and_what_is_not_each_step(scene, master, moved):
    """Counted where the calls are made, since what is fixed has the same values each time."""
    steps = 10
    for _ in range(2):  # again, after a reset
        moved.clear()
        scene.run(until=steps * 0.001, step=0.001, master=master)
        names = [name for name, _ in moved]
        assert names.count("fmi3GetInt32") == names.count("fmi3SetInt32") == 1
        assert names.count("fmi3GetFloat32") >= steps
        assert names.count("fmi3SetFloat32") >= steps


def test_a_repeated_step_begins_with_the_mesh_that_it_began_with(moved):
    """The sensor stands before the skin in a loop: it is told one mesh, of their begin, for all tries of a step.

    And one while the initial values settle, before the arm has told its angle.
    """
    with ulna.Scene("loop") as scene:
        sensor = scene.add("UltrasonicSensor", "sensor", surface_vertex_count=COUNT)
        arm = scene.add("HingedBody", "arm", initial_angle=0.5)
        skin = scene.add("ArmSkin", "skin", vertex_count=COUNT)
        scene.connect(sensor.distance, arm.target_angle, factor=1.0)
        scene.connect(arm.orientation, skin.forearm_orientation)
        scene.connect(skin.vertices, sensor.surface_vertices)
        figures = scene.run(until=0.02, step=0.01, tolerance=1e-5).summary
    assert figures["repeated_steps"] > 0
    assert len({values for name, values in moved if name == "fmi3SetFloat32"}) == figures["macro_steps"] + 1


def test_the_order_of_the_units_follows_the_mesh():
    with ulna.Scene("order") as scene:
        scene.add("UltrasonicSensor", "sensor", surface_vertex_count=COUNT)
        skin = scene.add("ArmSkin", "skin", vertex_count=COUNT)
        scene.signal(skin.forearm_orientation, turned)
        scene.connect("skin.vertices", "sensor.surface_vertices")
        scene.run(until=0.02, step=0.01)
        np.testing.assert_array_equal(scene["sensor"].slave.get("surface_vertices"), vertices_at(0.02))


def test_a_factor_and_an_offset_turn_the_mesh():
    with ulna.Scene("scaled") as scene:
        skin = scene.add("ArmSkin", "skin", vertex_count=COUNT)
        sensor = scene.add("UltrasonicSensor", "sensor", surface_vertex_count=COUNT)
        scene.signal(skin.forearm_orientation, turned)
        scene.connect(skin.vertices, sensor.surface_vertices, factor=2.0, offset=0.5)
        scene.run(until=0.02, step=0.01)
        expected = np.float32(2.0) * vertices_at(0.02) + np.float32(0.5)
        np.testing.assert_array_equal(sensor.slave.get("surface_vertices"), expected)


def test_a_signal_may_drive_a_mesh():
    with ulna.Scene("signal") as scene:
        sensor = scene.add("UltrasonicSensor", "sensor", surface_vertex_count=4)
        scene.signal(sensor.surface_vertices, lambda time: np.full((3, 4), time))
        scene.run(until=0.5, step=0.25)
        assert np.all(sensor.slave.get("surface_vertices") == 0.5)


def test_sizes_types_and_units_are_checked():
    with ulna.Scene("wrong") as scene:
        skin = scene.add("ArmSkin", "skin", vertex_count=COUNT)
        sensor = scene.add("UltrasonicSensor", "sensor", surface_vertex_count=COUNT - 1)
        cases = {
            ("skin.vertices", "sensor.surface_vertices"): r"skin\.vertices .*\[3\]\[512\].*sensor\.surface_vertices "
            r".*\[3\]\[511\].*sizes differ; set skin\.vertex_count and sensor\.surface_vertex_count",
            ("skin.triangles", "sensor.surface_vertices"): r"skin\.triangles .*sensor\.surface_vertices .*types differ",
            ("skin.normals", "sensor.surface_vertices"): r"normals .*sizes differ",
            ("skin.fold_fraction", "sensor.surface_vertices"): r"sizes differ; set sensor\.surface_vertex_count",
            ("sensor.surface_vertices", "skin.vertices"): r"the source is no output",
            ("sensor.speed_of_sound", "skin.forearm_position"): r"the source is no output",
        }
        for (source, target), message in cases.items():
            with pytest.raises(ValueError, match=message):
                scene.connect(source, target)
        sensor.set("surface_vertex_count", COUNT)
        with pytest.raises(ValueError, match=r"normals .*units differ"):
            scene.connect(skin.normals, sensor.surface_vertices)
        with pytest.raises(ValueError, match=r"factor or an offset needs floating-point"):
            scene.connect(skin.triangles, sensor.surface_triangles, factor=2.0)
        with pytest.raises(
            ValueError, match=r"sequence .* to sensor\.trigger_clock .*is a Clock, which holds no numbers"
        ):
            scene.connect(sensor.sequence, sensor.trigger_clock)
        with pytest.raises(KeyError, match=r"surface_vertices"):
            scene.connect("skin.vertices", "sensor.surface_vertex")
        with pytest.raises(KeyError, match=r"no unit 'skim'.*skin"):
            scene.connect("skim.vertices", "sensor.surface_vertices")


def test_a_size_that_changes_after_the_connection_is_found(scene):
    scene["sensor"].set("surface_vertex_count", COUNT + 1)
    with pytest.raises(ValueError, match=r"sensor\.surface_vertices .*\[513\].*sizes differ; set skin\.vertex_count"):
        scene.run(until=0.01, step=0.01)


def test_a_restored_state_brings_its_sizes():
    with ulna.Slave("UltrasonicSensor") as sensor, ulna.Slave("UltrasonicSensor") as other:
        sensor.set("surface_vertex_count", 3)
        sensor.set("surface_vertices", np.arange(9.0).reshape(3, 3))
        other.deserialize(sensor.serialize())
        np.testing.assert_array_equal(other.get("surface_vertices"), np.arange(9.0).reshape(3, 3))
