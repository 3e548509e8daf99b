"""An arm reaches for a wall, a ball beside its way: the same sensor on the hand at every fidelity, side by side.

While the hand hangs, the wall's echo goes elsewhere: only rays, which know no beam, see it, along their axis and so too
far. From 40 degrees on `specular` hears it, at its true distance; at the end it hears the ball, which rays pass by.
"""

from math import cos, pi, sqrt
from typing import Any

import numpy as np

from ulna import Scene, fmu
from ulna.description import read_description
from ulna.drawing import ellipsoid

UNTIL = 8.0
STEP = 0.002
MASTER = "newton"

UPPER_ARM, HAND = 0.30, 0.41  # m: the elbow from the shoulder, which is the origin, and the sensor from the elbow
DOWN = [sqrt(0.5), 0.0, sqrt(0.5), 0.0]
HANGING = np.radians([-10.0, 25.0])  # of shoulder and elbow
REACHING = np.radians([50.0, 40.0])

WALL = 1.0  # m, where it begins
WALL_SIZE = np.array([0.05, 0.8, 1.0])
BALL, BALL_RADIUS = np.array([0.86, -0.15, -0.20]), 0.06
REACH = 2.0  # m, the sensors' range


def reach(time: float) -> np.ndarray:
    """Angles of shoulder and elbow to aim at (rad): out within three seconds, held for two, and back."""
    share = 0.5 - 0.5 * cos(pi * np.clip(min(time - 0.5, 7.5 - time) / 2.5, 0.0, 1.0))
    return HANGING + share * (REACHING - HANGING)


def ball_mesh() -> dict[str, Any]:
    """The ball as `surface` takes it: vertices, their normals, and two rows of triangles a vertex, spare ones zero."""
    shape = ellipsoid((BALL_RADIUS,) * 3)
    count = len(shape.vertices)
    triangles = np.zeros((2 * count, 3), np.int32)
    triangles[: len(shape.triangles)] = shape.triangles
    return {
        "surface_vertex_count": count,
        "surface_vertices": (BALL + shape.vertices).T,
        "surface_normals": shape.normals.T,
        "surface_triangles": triangles.reshape(2, count, 3),
    }


def levels() -> list[str]:
    """The sensor's fidelities, in the order of their cost."""
    return [entry for entry, _ in read_description(fmu("UltrasonicSensor")).variables["fidelity"].entries]


def scene() -> Scene:
    """Upper arm, forearm and skin, a ball and a wall that stay where they are, and a sensor of each fidelity."""
    reaching = Scene("range")
    upper = reaching.add(
        "HingedBody",
        "upper",
        mass=1.9,
        inertia=[0.004, 0.012, 0.013],
        center_of_mass=[0.17, 0.0, 0.0],
        tip=[UPPER_ARM, 0.0, 0.0],
        stiffness=300.0,
        damping=20.0,
        anchor_orientation=DOWN,
        initial_angle=HANGING[0],
    )
    forearm = reaching.add(
        "HingedBody", "forearm", tip=[HAND, 0.0, 0.0], stiffness=100.0, damping=6.0, initial_angle=HANGING[1]
    )
    arm = reaching.add("ArmSkin", "arm", upper_arm_length=UPPER_ARM)
    still = {"gravity": np.zeros(3)}
    ball = reaching.add("RigidBody", "ball", initial_position=BALL, **still)
    squares = WALL_SIZE**2
    slab = {"mass": 12.0, "inertia": squares.sum() - squares}
    wall = reaching.add("RigidBody", "wall", initial_position=[WALL + WALL_SIZE[0] / 2, 0.0, 0.0], **slab, **still)

    reaching.signal(upper.target_angle, lambda time: reach(time)[0])
    reaching.signal(forearm.target_angle, lambda time: reach(time)[1])
    reaching.connect(upper.tip, forearm.anchor)
    reaching.connect(upper.hinge, arm.upper_arm)
    reaching.connect(forearm.hinge, arm.forearm)

    ahead = {"plane_point": [WALL, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 0.0], "maximum_range": REACH}
    for level in levels():
        body = ball_mesh() if level == "surface" else {"sphere_radius": BALL_RADIUS}
        sensor = reaching.add("UltrasonicSensor", level, **body, **ahead, fidelity=level)
        reaching.connect(forearm.tip, sensor.sensor)
        reaching.connect(ball.center, sensor.target)
        reaching.record(sensor)

    reaching.record(upper.hinge)
    reaching.record(forearm.angle, forearm.target_angle, forearm.hinge, forearm.tip_position, forearm.tip_orientation)
    for body in (ball, wall):
        reaching.record(body.position, body.orientation)
    return reaching
