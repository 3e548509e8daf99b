"""The rigid joint: its order, its gaps and its energy, against Lagrangian mechanics in minimal coordinates."""

import numpy as np
import pytest
from jointed import angle_off, energy, joined, truth

from ulna import Scene
from ulna.charts.arms import ball_arm, chain, planar_arm

G = 9.80665


@pytest.mark.parametrize("make", [planar_arm, ball_arm])
def test_the_attitude_is_of_order_four_and_the_joints_stay_closed(make):
    """The three-dimensional arm has a ball, an oblique hinge, and damping in both."""
    arm = make()
    errors = []
    for step in (0.02, 0.01, 0.005):
        with joined(arm) as scene:
            results = scene.run(arm.end, step)
        errors.append(angle_off(results, truth(make)))
        assert results.summary["largest_gap"] <= 1e-12
        assert results.summary["master"] == "rigid"
    # the next terms of the error, some thousandths of it at the coarsest step, move the order by as much
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / np.array(errors[1:])), 4.0, atol=0.05)
    assert errors[1] <= 2e-4


def test_a_chain_of_ten_swings_as_it_should():
    arm = chain(10)
    errors = []
    for step in (0.005, 0.0025):
        with joined(arm) as scene:
            results = scene.run(arm.end, step)
        errors.append(angle_off(results, truth(chain, 10)))
        assert results.summary["largest_gap"] <= 1e-12
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.05)


def test_fmi_2_gives_the_same_arm_to_the_bit():
    arm = planar_arm()
    ends = []
    for version in ("2.0", "3.0"):
        scene = Scene()
        upper, forearm = (
            scene.add("RigidBody", f"body{k}", version=version, **v) for k, v in enumerate(arm.rigid_bodies)
        )
        scene.join("world", upper.base, arm.joints[0]["axis"])
        scene.join(upper.tip, forearm.base, arm.joints[1]["axis"])
        with scene:
            ends.append(scene.run(1.0, 0.01)["body1.orientation"])
    np.testing.assert_array_equal(*ends)


def test_a_second_run_is_the_first_to_the_bit():
    with joined(ball_arm()) as scene:
        first, second = (scene.run(0.3, 0.01) for _ in range(2))
    for name in first:
        np.testing.assert_array_equal(first[name], second[name])


def test_the_energy_of_an_undamped_swing_is_bounded_over_a_thousand_seconds():
    """The step is its own inverse with time turned round: what is off swings, and does not add up.

    The motion is chaotic beyond some seconds, so no reference but the energy reaches so far.
    """
    arm = planar_arm()
    with joined(arm, tolerance=1e-10) as scene:
        scene.record(*(scene[f"body{k}"][f"{kind}_energy"] for k in range(2) for kind in ("kinetic", "potential")))
        results = scene.run(1000.0, 0.02)
    off = np.abs(energy(results, 2) - energy(results, 2)[0])
    first, last = off[:5000].max(), off[-5000:].max()
    # a tenth of the run at either end: larger and smaller swings alike, by chance, but no trend
    assert last < 1.5 * first
    assert off.max() < 1e-4


def test_damping_takes_from_the_energy_what_the_textbook_says():
    """At rest in the end: all of the potential energy that there was is gone."""
    arm = ball_arm()
    with joined(arm) as scene:
        lost = energy(scene.run(arm.end, 0.01), 2)
    assert np.all(np.diff(lost) < 1e-7)
    with Scene() as scene:
        # one compound pendulum about a damped hinge: J a'' = -c a' - m g l sin(a)
        rod = scene.add("RigidBody", "rod", mass=1.0, inertia=[0.001, 0.01, 0.01], base=[-0.2, 0, 0], tolerance=1e-13)
        rod.set("initial_position", [0.0, 0.0, -0.2])
        rod.set("initial_orientation", [0.5**0.5, 0.0, 0.5**0.5, 0.0])
        rod.set("initial_angular_velocity", [0.0, 1e-4, 0.0])
        rod.set("initial_velocity", [-2e-5, 0.0, 0.0])
        scene.join("world", rod.base, [0, 1, 0], damping=0.1)
        results = scene.run(3.0, 0.01)
    moment, decay = 0.01 + 1.0 * 0.2**2, 0.1 / (2 * 0.05)
    rate = np.sqrt(1.0 * G * 0.2 / moment - decay**2)
    swing = (
        1e-4
        * np.exp(-decay * results.time)
        * (np.cos(rate * results.time) - decay / rate * np.sin(rate * results.time))
    )
    # order 4 in the step: (rate h)^4 / 720 and the cubic term of the sine, 1e-10
    np.testing.assert_allclose(results["rod.angular_velocity"][:, 1], swing, atol=1e-4 * (rate * 0.01) ** 4)


def test_the_first_row_holds_the_wrench_of_the_joint():
    """A rod let go level about its end: the acceleration of its tip is 3/2 g, and not that of free fall."""
    length, mass = 0.4, 2.0
    with Scene() as scene:
        inertia = [1e-3, mass * length**2 / 12, mass * length**2 / 12]
        rod = scene.add(
            "RigidBody", "rod", mass=mass, inertia=inertia, base=[-length / 2, 0, 0], tip=[length / 2, 0, 0]
        )
        rod.set("initial_position", [length / 2, 0.0, 0.0])
        scene.join("world", rod.base, [0, 1, 0])
        results = scene.run(0.05, 0.01)
    # the wrench is a line over a short step of h, which misses its true value at the start by some (w h)^2 of it
    np.testing.assert_allclose(results["rod.tip_acceleration"][0], [0.0, 0.0, -1.5 * G], atol=1.5 * G * 1e-4)
    np.testing.assert_allclose(results["rod.base_acceleration"][0], 0.0, atol=1.5 * G * 1e-4)


def test_a_body_between_two_joints_of_the_world_stays_at_rest():
    """Redundant: a rod held by balls at both ends; along the rod the two forces are not determined."""
    with Scene() as scene:
        rod = scene.add("RigidBody", "rod", base=[-0.2, 0, 0], tip=[0.2, 0, 0], inertia=[0.1, 1, 1])
        scene.join("world", rod.base)
        scene.join("world", rod.tip)
        results = scene.run(0.5, 0.01)
    np.testing.assert_allclose(results["rod.position"], 0.0, atol=1e-12)
