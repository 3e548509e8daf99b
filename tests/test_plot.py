"""The pictures of a run show what was recorded."""

import numpy as np
import pytest
from matplotlib.image import imread

from ulna import Scene, gallery
from ulna.plot import MOST_PANELS, filmstrip, panels, plot
from ulna.targets import true_distance


@pytest.fixture(scope="module")
def follow():
    example = gallery.load("follow")
    with example.build() as scene:
        yield scene, scene.run(example.until, 0.005)


def by_title(chosen):
    return {panel.title: panel for panel in chosen}


def test_follow_shows_true_and_measured_distance(follow):
    scene, results = follow
    panel = by_title(panels(results, scene))["sensor: distance"]
    (_, true), (_, times, measured), (_, _, silent) = *panel.curves, *panel.dots
    assert len(measured) + len(silent) == results["sensor.sequence"][-1]
    np.testing.assert_array_equal(silent, scene["sensor"].slave.get("maximum_range"))
    # a ping tells of the past: 9 ms of flight and a row, at up to 2 m/s
    assert np.abs(measured - np.interp(times, results.time, true)).max() < 0.04


def test_angles_are_in_degrees_with_their_target(follow):
    scene, results = follow
    panel = by_title(panels(results, scene))["forearm: elbow"]
    curves = dict(panel.curves)
    assert panel.unit == "degrees"
    np.testing.assert_allclose(curves["angle"], np.degrees(results["forearm.angle"]))
    np.testing.assert_allclose(curves["target"], np.degrees(results["forearm.target_angle"]))


def test_energies_add_up(follow):
    scene, results = follow
    curves = dict(by_title(panels(results, scene))["ball: energy"].curves)
    np.testing.assert_allclose(curves["sum"], curves["kinetic"] + curves["potential"])


def test_what_does_not_change_has_no_panel():
    with Scene("still") as scene:
        scene.add("RigidBody", "body", gravity=[0.0, 0.0, 0.0], initial_velocity=[1.0, 0.0, 0.0])
        titles = by_title(panels(scene.run(1.0, 0.1), scene))
    assert "body: position" in titles
    assert "body: velocity" not in titles
    assert "body: energy" not in titles


def test_every_output_of_a_scene_that_chose_nothing_fits_in_nine_panels():
    with Scene("all") as scene:
        scene.add("RigidBody", "body", initial_angular_velocity=[1.0, 2.0, 3.0])
        chosen = panels(scene.run(1.0, 0.1), scene)
    assert len(chosen) == MOST_PANELS
    assert chosen[0].title == "body: energy"


@pytest.mark.parametrize("with_scene", [True, False])
def test_plot_writes_a_small_png(follow, tmp_path, with_scene):
    scene, results = follow
    plot(results, tmp_path / "plot.png", scene if with_scene else None)
    assert imread(tmp_path / "plot.png").std() > 0.01
    assert (tmp_path / "plot.png").stat().st_size < 200_000


def test_plot_of_nothing_that_changes_is_written_all_the_same(tmp_path):
    with Scene("still") as scene:
        scene.add("RigidBody", "body", gravity=[0.0, 0.0, 0.0])
        plot(scene.run(0.1, 0.1), tmp_path / "plot.png", scene)
    assert (tmp_path / "plot.png").exists()


def test_filmstrip_shows_the_skin_and_the_ball_where_they_are(follow, tmp_path):
    scene, results = follow
    filmstrip(results, scene, tmp_path / "picture.png", [1.0, 5.0])
    image = imread(tmp_path / "picture.png")[..., :3]
    half = image.shape[1] // 2
    orange = (image[..., 0] > 0.5) & (image[..., 2] < 0.2)
    heights = [np.flatnonzero(orange[:, part].any(axis=1)).mean() for part in (slice(0, half), slice(half, None))]
    # at 5 s the ball is high, in the upper part of the picture; at 1 s low
    assert results["ball.position"][200, 2] < results["ball.position"][1000, 2]
    assert heights[0] > heights[1] + 20


def test_filmstrip_hides_the_far_side_of_a_box(tmp_path):
    """Seen from above, the orange top shows and the blue bottom does not."""
    with Scene("still") as scene:
        scene.add("RigidBody", "box", gravity=[0.0, 0.0, 0.0], inertia=[1.0, 1.0, 1.0])
        filmstrip(scene.run(0.1, 0.1), scene, tmp_path / "picture.png", [0.0])
    red, _, blue = np.moveaxis(imread(tmp_path / "picture.png")[..., :3], -1, 0)
    assert np.count_nonzero(red > blue + 0.3) > 1000
    assert np.count_nonzero(blue > red + 0.2) == 0


def test_sensors_on_one_hand_share_a_wide_panel(tmp_path):
    example = gallery.load("range")
    with example.build() as scene:
        results = scene.run(1.0, 0.005, master=example.master)
        first, *rest = panels(results, scene)
        plot(results, tmp_path / "plot.png", scene)
    assert first.wide and not any(panel.wide for panel in rest)
    curves = dict(first.curves)
    assert list(curves)[:4] == ["true", "ray", "cone", "specular"]
    names, hand = example.build.__globals__, results["forearm.tip_position"]
    wall, ball = names["WALL"] - hand[:, 0], np.linalg.norm(names["BALL"] - hand, axis=1) - names["BALL_RADIUS"]
    np.testing.assert_allclose(curves["true"], np.minimum(wall, ball), rtol=1e-12)
    assert imread(tmp_path / "plot.png").std() > 0.01


def test_true_distance_is_that_of_the_nearest_surface():
    """Of a box askew and a capsule, from their closed forms; and none before nothing."""
    turn = [np.cos(np.pi / 8), 0.0, 0.0, np.sin(np.pi / 8)]
    box = {"box_center": [1.0, 0.0, 0.0], "box_size": [0.2, 0.2, 0.2], "box_orientation": turn}
    rod = {"capsule_1_start": [2.0, 0.5, 0.0], "capsule_1_end": [2.0, 1.5, 0.0], "capsule_1_radius": 0.1}
    with Scene("three") as scene:
        for name, targets in (("boxed", box), ("barred", rod), ("free", {})):
            scene.add("UltrasonicSensor", name, **targets)
        results = scene.run(0.1, 0.1)
        found = [true_distance(results, scene, scene[name])[0] for name in ("boxed", "barred", "free")]
    np.testing.assert_allclose(found, [1.0 - 0.1 * np.sqrt(2.0), np.hypot(2.0, 0.5) - 0.1, np.nan], rtol=1e-12)
