"""What may be joined: frames of any FMU that takes a wrench, and what is refused by name."""

import subprocess
import sys
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest
from jointed import joined

from toy_fmu import toy
from ulna import Scene, UnitError
from ulna.charts.arms import planar_arm

STRANGER = {
    "position": "place",
    "velocity": "speed",
    "orientation": "attitude",
    "angular_velocity": "spin",
    "force": "push",
    "torque": "twist",
}


@cache
def stranger() -> Path:
    """An FMU of FMI 3 that pythonfmu3 makes of foreign/stranger.py."""
    pytest.importorskip("pythonfmu3", reason="install it with: pip install pythonfmu3==0.3.4")
    folder = Path(mkdtemp(prefix="stranger-"))
    source = Path(__file__).parents[1] / "foreign" / "stranger.py"
    command = [sys.executable, "-m", "pythonfmu3", "build", "-f", str(source), "-d", str(folder), "--handle-state"]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "Stranger.fmu"


def carried(fmu: str | Path, step: float) -> tuple[np.ndarray, float]:
    """A rod hinged to the world carries a ball by an oblique, damped hinge: where the ball is, and the largest gap."""
    with Scene() as scene:
        common = {"tolerance": 1e-12}
        rod = scene.add("RigidBody", "rod", mass=2.0, inertia=[0.01, 0.02, 0.02], base=[-0.15, 0, 0], **common)
        rod.set("tip", [0.15, 0.0, 0.0])
        rod.set("initial_position", [-0.15, 0.0, 0.0])
        if fmu == "RigidBody":
            ball = scene.add(fmu, "ball", mass=1.5, inertia=[0.02] * 3, **common)
            held = ball.center
        else:
            ball = scene.add(fmu, "ball")
            held = ball.frame("handle", **STRANGER)
        scene.join("world", rod.base, [0, 1, 0])
        scene.join(rod.tip, held, [0.6, 0.0, 0.8], damping=0.05)
        results = scene.run(0.5, step)
    place = "ball.position" if fmu == "RigidBody" else "ball.place"
    return results[place][-1], results.summary["largest_gap"]


def test_an_fmu_of_a_stranger_is_joined_as_well_as_our_own():
    """Its wrench is held within a step: two half steps with the mean and first moment of the line keep order 4."""
    truth, _ = carried("RigidBody", 1e-3)
    errors = []
    for step in (0.02, 0.01):
        place, gap = carried(stranger(), step)
        errors.append(np.linalg.norm(place - truth))
        assert gap <= 1e-12
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.1)


def test_other_units_take_the_motion_of_a_joined_arm_and_give_it_forces():
    """Skin on the arm, and a muscle of the world's: a signal on the elbow from both sides."""
    arm = planar_arm()
    with joined(arm) as scene:
        skin = scene.add("ArmSkin", "skin")
        scene.connect(scene["body0"].base, skin.upper_arm)
        scene.connect(scene["body1"].base, skin.forearm)
        for body, sign in (("body0", -1.0), ("body1", 1.0)):
            scene.signal(scene[body].torque, lambda t, sign=sign: [0.0, sign * 2.0 * t, 0.0])
        results = scene.run(0.4, 0.01)
    assert np.all(np.isfinite(results["skin.elbow_gap"]))
    power = np.sum((results["body1.angular_velocity"] - results["body0.angular_velocity"])[:, 1] * 2.0 * results.time)
    gained = sum(results[f"body{k}.{kind}_energy"] for k in range(2) for kind in ("kinetic", "potential"))
    # work of the muscle by the trapezium of rows 10 ms apart
    assert gained[-1] - gained[0] == pytest.approx(0.01 * power, rel=0.05)


def pair(scene: Scene, **values):
    """Two bodies whose tip and base meet."""
    first = scene.add("RigidBody", "first", tip=[0.2, 0, 0])
    second = scene.add("RigidBody", "second", **{"base": [-0.1, 0, 0], "initial_position": [0.3, 0, 0], **values})
    return first, second


@pytest.mark.parametrize(
    ("values", "axis", "message"),
    [
        ({"initial_position": [0.31, 0, 0]}, None, r"first\.tip - second\.base are 0\.01 m apart at the start"),
        ({"initial_velocity": [0, 0.5, 0]}, None, r"are 0\.5 m/s apart at the start; allowed: 1e-09"),
        (
            {"initial_angular_velocity": [0, 1, 0], "initial_velocity": [0, 0, -0.1]},
            [0, 0, 1],
            r"are 1 rad/s apart at the start",
        ),
    ],
)
def test_frames_that_do_not_meet_at_the_start_are_refused(values, axis, message):
    with Scene() as scene:
        first, second = pair(scene, **values)
        scene.join(first.tip, second.base, axis)
        with pytest.raises(ValueError, match=message):
            scene.run(1.0, 0.01)


def test_what_cannot_be_joined_is_refused_by_name():
    with Scene() as scene:
        first, second = pair(scene)
        skin = scene.add("ArmSkin", "skin")
        stranger_to_force = scene.add(toy(), "toy")
        with pytest.raises(ValueError, match=r"cannot join 'wall': a frame, or 'world'"):
            scene.join("wall", second.base)
        with pytest.raises(ValueError, match=r"axis = \[0, 0, 0\]; allowed: three finite numbers"):
            scene.join(first.tip, second.base, [0, 0, 0])
        with pytest.raises(ValueError, match=r"damping = -1 N\.m\.s/rad; allowed range: at least 0"):
            scene.join(first.tip, second.base, damping=-1.0)
        with pytest.raises(ValueError, match="both frames belong to one unit"):
            scene.join(first.tip, first.base)
        with pytest.raises(ValueError, match=r"skin\.forearm .*: its position must be an output of shape \(3,\)"):
            scene.join(first.tip, skin.forearm)
        with pytest.raises(ValueError, match=r"toy\.plug .*: its velocity must be an output .* not nothing"):
            scene.join(first.tip, stranger_to_force.plug)
        with pytest.raises(KeyError, match="first has no variable 'positoin': did you mean position"):
            first.frame("handle", position="positoin")
        with pytest.raises(ValueError, match="is no frame"):
            scene.join(first.tip, second.position)
        assert not scene.joints


def test_a_wrench_has_one_driver():
    with Scene() as scene:
        first, second = pair(scene)
        scene.signal(second.base_force, lambda t: [0.0, 0.0, 0.0])
        with pytest.raises(ValueError, match=r"join first\.tip - second\.base: a signal drives second\.base_force"):
            scene.join(first.tip, second.base)
    with Scene() as scene:
        first, second = pair(scene)
        scene.join(first.tip, second.base)
        with pytest.raises(ValueError, match=r"a joint drives first\.tip_force already"):
            scene.signal(first.tip_force, lambda t: [0.0, 0.0, 0.0])


def test_the_master_must_suit_the_scene():
    with Scene() as scene:
        first, second = pair(scene)
        with pytest.raises(ValueError, match="the master rigid is for scenes with joints"):
            scene.run(1.0, 0.1, master="rigid")
        scene.join(first.tip, second.base)
        with pytest.raises(ValueError, match="the master jacobi knows no joints; take rigid"):
            scene.run(1.0, 0.1, master="jacobi")
        with pytest.raises(ValueError, match="extrapolation = 2; allowed: 0, 1"):
            scene.run(1.0, 0.1, extrapolation=2)
        with pytest.raises(ValueError, match="tolerance = 0; allowed range: between 0 and 1"):
            scene.run(1.0, 0.1, tolerance=0)


def test_a_unit_that_cannot_go_back_is_named():
    """The same stranger, built without state."""
    pytest.importorskip("pythonfmu3", reason="install it with: pip install pythonfmu3==0.3.4")
    folder = Path(mkdtemp(prefix="stranger-"))
    source = Path(__file__).parents[1] / "foreign" / "stranger.py"
    command = [sys.executable, "-m", "pythonfmu3", "build", "-f", str(source), "-d", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    with Scene() as scene:
        ball = scene.add(folder / "Stranger.fmu", "ball")
        scene.join("world", ball.frame("handle", **STRANGER))
        with pytest.raises(ValueError, match="ball: Stranger cannot save its state, so no step of it is repeated"):
            scene.run(1.0, 0.1)


def test_a_body_that_fails_within_a_joined_step_is_named():
    with Scene() as scene:
        first, second = pair(scene)
        scene.join(first.tip, second.base)
        scene.signal(second.force, lambda t: [0.0, 0.0, 1e200 if t > 0.5 else 0.0])
        with pytest.raises((UnitError, RuntimeError)) as caught:
            scene.run(1.0, 0.1)
    assert "is not finite at 0.6 s" in str(caught.value)
    assert 4 <= len(caught.value.results) <= 7
