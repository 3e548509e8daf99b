"""The glTF file of a run: valid, and its skin, played as the standard says, is what ArmSkin computes."""

import json
import os
import shutil
import subprocess
from math import cos, sin

import numpy as np
import pytest

from glb_player import Player, z_up
from ulna import Scene, Slave, gallery
from ulna.drawing import box, cylinder, ellipsoid
from ulna.gltf import FRAME_RATE, frames, write_glb
from ulna.paths import CHECKOUT
from ulna.skeleton import continuous

VALIDATOR = "gltf-validator@2.0.0-dev.3.10"
LENGTH = 0.3


def about(axis, angle):
    return np.concatenate([[cos(angle / 2)], sin(angle / 2) * np.array(axis) / np.linalg.norm(axis)])


def shoulder_turn(time):
    return about([1.0, 2.0, -1.0], 0.7 * time)


def elbow_place(time):
    q = shoulder_turn(time)
    v = 2.0 * np.cross(q[1:], [LENGTH, 0.0, 0.0])
    return np.array([0.1 * time, 0.0, 1.0]) + [LENGTH, 0.0, 0.0] + q[0] * v + np.cross(q[1:], v)


def product(p, q):
    scalar = p[0] * q[0] - p[1:] @ q[1:]
    return np.concatenate([[scalar], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


def flexed(time):
    """150 degrees after a second, with 30 degrees of twist."""
    return product(shoulder_turn(time), product(about([0, -1, 0], 2.618 * time), about([1, 0, 0], 0.524 * time)))


def arm_scene(method):
    scene = Scene("arm")
    arm = scene.add("ArmSkin", "arm", vertex_count=1024, method=method)
    scene.signal(arm.upper_arm_position, lambda time: np.array([0.1 * time, 0.0, 1.0]))
    scene.signal(arm.upper_arm_orientation, shoulder_turn)
    scene.signal(arm.forearm_position, elbow_place)
    # the opposite quaternion is the same pose
    scene.signal(arm.forearm_orientation, lambda time: -flexed(time))
    return scene


# linear: float32 keys of positions up to 1.5 m, rounded at 6e-8 each; the others: 21 joints, as `skeleton` says;
# a spread twist of 30 degrees bends the chord of a twentieth of it, 0.4 um of a 40 mm radius
@pytest.mark.parametrize(
    ("method", "twist_share", "bound"),
    [
        ("rigid", 0.0, 1e-6),
        ("linear_blend", 0.0, 1e-6),
        ("linear_blend", 1.0, 8e-6),
        *[
            (method, share, 3e-4)
            for method in ("hinge", "dual_quaternion", "center_of_rotation", "compensated")
            for share in (0.0, 1.0)
        ],
    ],
)
def test_a_player_shows_what_arm_skin_computes(tmp_path, method, twist_share, bound):
    with arm_scene(method) as scene:
        scene["arm"].set("twist_share", twist_share)
        write_glb(tmp_path / "arm.glb", scene.run(1.0, 0.01), scene)
    player = Player(tmp_path / "arm.glb")
    assert len(player.time) == 31
    worst = 0.0
    with Slave("ArmSkin") as skin:
        skin.set("vertex_count", 1024)
        skin.set("method", method)
        skin.set("twist_share", twist_share)
        skin.initialize()
        for frame in (0, 7, 19, 30):
            time = float(player.time[frame])
            skin.set("upper_arm_position", [0.1 * time, 0.0, 1.0])
            skin.set("upper_arm_orientation", shoulder_turn(time))
            skin.set("forearm_position", elbow_place(time))
            skin.set("forearm_orientation", flexed(time))
            worst = max(worst, np.abs(z_up(player.skinned("arm", frame)) - skin.get("vertices").T).max())
    assert worst < bound


def test_a_player_shows_a_forearm_wound_beyond_half_a_turn(tmp_path):
    scene = Scene("wound")
    arm = scene.add("ArmSkin", "arm", vertex_count=1024, method="hinge", twist_share=0.5)
    scene.signal(arm.forearm_orientation, lambda time: about([1, 0.2, 0], 5.0 * time))
    with scene:
        results = scene.run(1.0, 0.01)
        write_glb(tmp_path / "arm.glb", results, scene)
        player = Player(tmp_path / "arm.glb")
        shown = z_up(player.skinned("arm", -1))
        # 143 degrees in the zone and along the forearm each; helper joints as above
        assert np.abs(shown - arm.slave.get("vertices").T).max() < 6e-4


def test_two_joints_do_not_show_dual_quaternions(tmp_path, monkeypatch):
    """Without the helper joints a viewer shows the linear blend, centimetres away at the elbow."""
    monkeypatch.setattr("ulna.skeleton.HELPER_JOINTS", 2)
    with arm_scene("dual_quaternion") as scene:
        write_glb(tmp_path / "arm.glb", scene.run(1.0, 0.01), scene)
    last = Player(tmp_path / "arm.glb").skinned("arm", -1)
    monkeypatch.undo()
    with arm_scene("dual_quaternion") as scene:
        write_glb(tmp_path / "arm.glb", scene.run(1.0, 0.01), scene)
    assert np.abs(Player(tmp_path / "arm.glb").skinned("arm", -1) - last).max() > 0.01


def test_the_ball_and_the_sensor_move_as_recorded(tmp_path):
    example = gallery.load("follow")
    with example.build() as scene:
        results = scene.run(0.5, example.step)
        write_glb(tmp_path / "arm.glb", results, scene)
    player = Player(tmp_path / "arm.glb")
    rows = np.searchsorted(results.time, player.time - 1e-6)
    for name, column in (("ball", "ball.position"), ("sensor", "forearm.tip_position")):
        shown = [player.world(player.node(name), frame)[:3, 3] for frame in range(len(player.time))]
        # float32 keys, up to 3 m away
        np.testing.assert_allclose(z_up(np.array(shown)), results[column][rows], atol=1e-6)


@pytest.mark.parametrize("step", [0.001, 0.004, 0.1])
def test_frames_keep_first_and_last_row_and_are_no_denser_than_the_frame_rate(step):
    time = np.arange(round(1.0 / step) + 1) * step
    rows = frames(time)
    assert rows[0] == 0
    assert rows[-1] == len(time) - 1
    assert np.all(np.diff(rows) > 0)
    assert len(rows) == min(len(time), round(FRAME_RATE) + 1)


def test_neighbouring_quaternions_have_the_same_sign():
    turns = np.array([about([0, 0, 1], angle) * (-1) ** k for k, angle in enumerate(np.linspace(0, 12, 40))])
    aligned = continuous(turns)
    assert np.all(np.sum(aligned[1:] * aligned[:-1], axis=1) > 0)
    np.testing.assert_array_equal(np.abs(aligned), np.abs(turns))


@pytest.mark.parametrize(
    ("shape", "volume", "share"),
    [
        (box((1.0, 2.0, 3.0), (1, 1, 1)), 6.0, 1e-6),
        # inscribed: of a polygon with 32 sides the area is 0.6 % short, of a grid of 7.5 degrees the volume 1 %
        (cylinder(0.5, 2.0, (1, 1, 1)), np.pi / 2, 0.007),
        (cylinder(0.5, 2.0, (1, 1, 1)).turned(np.array([0.0, -1.0, 2.0])), np.pi / 2, 0.007),
        (ellipsoid((1.0, 2.0, 0.5)), 4 / 3 * np.pi, 0.011),
    ],
    ids=["box", "cylinder", "turned cylinder", "ellipsoid"],
)
def test_shapes_are_closed_and_face_outward(shape, volume, share):
    a, b, c = np.moveaxis(shape.vertices[shape.triangles].astype(float), 1, 0)
    area = np.cross(b - a, c - a)
    assert np.sum(a * area) / 6 == pytest.approx(volume, rel=share)
    assert np.abs(area.sum(axis=0)).max() < 1e-6
    np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1.0, atol=1e-6)
    # the normals of its corners and the side that a triangle faces agree
    assert np.all(np.sum(area * shape.normals[shape.triangles].mean(axis=1), axis=1) > 0)


def test_a_pose_that_was_not_recorded_is_named(tmp_path):
    with Scene("one") as scene:
        body = scene.add("RigidBody", "body")
        scene.record(body.position)
        results = scene.run(0.1, 0.01)
        with pytest.raises(KeyError, match=r"body\.orientation"):
            write_glb(tmp_path / "arm.glb", results, scene)


@pytest.fixture(scope="session")
def node_modules():
    """A folder with Khronos' validator, installed once."""
    if not (shutil.which("node") and shutil.which("npm")):
        pytest.skip("Khronos' glTF validator needs node and npm: apt-get install nodejs npm")
    folder = CHECKOUT / "build" / "gltf-validator"
    if not (folder / VALIDATOR).exists():
        folder.mkdir(parents=True, exist_ok=True)
        command = ["npm", "install", "--silent", "--no-audit", "--no-fund", "--prefix", str(folder), VALIDATOR]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.skip(f"npm could not install {VALIDATOR}; connect to its registry once: {done.stderr.strip()}")
        (folder / VALIDATOR).touch()
    return folder / "node_modules"


@pytest.mark.parametrize("name", ["follow", "wave", "tumble"])
def test_khronos_validator_finds_nothing(tmp_path, node_modules, name):
    example = gallery.load(name)
    with example.build() as scene:
        write_glb(tmp_path / "arm.glb", scene.run(1.0, 0.01), scene)
    script = CHECKOUT / "tests" / "validate_gltf.js"
    environment = os.environ | {"NODE_PATH": str(node_modules)}
    report = subprocess.check_output(["node", script, tmp_path / "arm.glb"], env=environment, text=True)
    issues = json.loads(report)["issues"]
    assert (issues["numErrors"], issues["numWarnings"], issues["messages"]) == (0, 0, [])
