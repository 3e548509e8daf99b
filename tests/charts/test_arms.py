"""The arms' data: for the units what it is for the reference."""

import numpy as np
import pytest

from ulna.bench.measuring import started
from ulna.charts.arms import ball_arm, chain, planar_arm
from ulna.checks.textbook import load_model

MODEL = load_model("jointed_arm")
ARMS = {arm.name: arm for arm in (planar_arm(), ball_arm(), chain())}
NAMED = pytest.mark.parametrize("name", ARMS)


@NAMED
def test_the_units_start_where_the_reference_does(name):
    arm = ARMS[name]
    found = MODEL.jointed_arm(arm.bodies, arm.joints).results(arm.state)
    for i, values in enumerate(arm.rigid_bodies):
        with started("RigidBody", **values) as body:
            for seen in ("position", "velocity", "angular_velocity", "orientation", "base_position", "tip_position"):
                if seen in found:
                    assert body.get(seen) == pytest.approx(found[seen][i], abs=2e-15)


@NAMED
def test_what_is_joined_starts_together(name):
    """Both sides of a joint in one place with one velocity, the first at rest in the origin."""
    place, velocity = np.zeros(3), np.zeros(3)
    for values in ARMS[name].rigid_bodies:
        with started("RigidBody", **values) as body:
            assert body.get("base_position") == pytest.approx(place, abs=2e-15)
            assert body.get("base_velocity") == pytest.approx(velocity, abs=2e-15)
            place, velocity = body.get("tip_position"), body.get("tip_velocity")


@pytest.mark.parametrize(("name", "index"), [("planar_arm", 0), ("chain_10", 0), ("ball_arm", 1)])
def test_a_hinged_body_swings_as_the_reference_does(name, index):
    """A body of the chain alone, its hinge in the origin of a level world, for one second."""
    arm = ARMS[name]
    angle, rate = arm.places[index], arm.speeds[index]
    model = MODEL.jointed_arm([arm.bodies[index]], [arm.joints[index]])
    truth = MODEL.reference(model, [angle, rate], [0.0, 1.0])[-1]
    with started("HingedBody", **arm.hinged_body(index)) as body:
        body.step(0.0, 1.0)
        found = [body.get("angle"), body.get("rate")]
    # the unit's tolerance, 1e-9 rad/s for a second; a rate is some ten times the angle here
    assert found == pytest.approx(truth, abs=1e-8)


def test_a_chain_weighs_a_kilogram_and_is_a_metre_long():
    for count in (1, 3, 10):
        arm = chain(count)
        assert sum(body["mass"] for body in arm.bodies) == pytest.approx(1.0, rel=1e-15)
        assert np.linalg.norm(arm.rigid_bodies[-1]["initial_position"]) == pytest.approx(1 - 0.5 / count, rel=1e-14)
