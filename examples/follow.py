"""A sensor on the hand ranges a ball, and the arm follows: near ball, bent elbow; no echo, the arm sinks.

The ball comes in, goes to and fro before the hand and leaves. Where it is heard at all depends on where the hand
points, and that on what was heard: a closed loop through a sensor that samples every 60 ms.
"""

from math import cos, exp, log1p, radians, sin, sqrt

import numpy as np

from ulna import Scene

UNTIL = 10.0
STEP = 0.001
MASTER = "gauss_seidel"

DOWN = [sqrt(0.5), 0.0, sqrt(0.5), 0.0]  # the upper arm hangs from the shoulder, which is the origin
ELBOW = np.array([0.0, 0.0, -0.30])
HAND = 0.41  # the sensor, from the elbow
GRAVITY = np.array([0.0, 0.0, -9.80665])
BALL_RADIUS = 0.10
BALL_MASS = 0.25
REACH = 1.5  # what is farther is not waited for

# Elbow angle for a measured distance: bent at 0.3 m, at rest without an echo, which reads REACH.
BENT = radians(115.0)
REST = radians(40.0)
FACTOR = (REST - BENT) / (REACH - 0.3)
OFFSET = REST - FACTOR * REACH


def path(time: float) -> np.ndarray:
    """Where the ball is to be (m): before the hand of an arm that follows at once, and a little to both sides."""
    gap = 0.65 - 0.3 * cos(2.0 * (time - 5.0)) + 0.9 * ((time - 5.0) / 5.0) ** 4
    lift = (OFFSET + FACTOR * gap - REST) / 0.1
    angle = REST + 0.1 * log1p(exp(lift))  # out of reach the arm rests
    reach = HAND + gap + BALL_RADIUS
    return ELBOW + reach * np.array([sin(angle), 0.15 * sin(1.3 * time), -cos(angle)])


def push(time: float, h: float = 1e-3) -> np.ndarray:
    """Force (N) that keeps the ball on its path against its weight: m (x'' - g), x'' by central difference."""
    acceleration = (path(time + h) - 2.0 * path(time) + path(time - h)) / h**2
    return BALL_MASS * (acceleration - GRAVITY)


def scene() -> Scene:
    """Ball, sensor, forearm and skin."""
    follow = Scene("follow")
    ball = follow.add(
        "RigidBody",
        "ball",
        mass=BALL_MASS,
        inertia=np.full(3, 0.4 * BALL_MASS * BALL_RADIUS**2),
        initial_position=path(0.0),
        initial_velocity=(path(1e-4) - path(-1e-4)) / 2e-4,
        initial_angular_velocity=[0.0, 3.0, 1.0],
    )
    sensor = follow.add("UltrasonicSensor", "sensor", maximum_range=REACH, noise=0.002, sphere_radius=BALL_RADIUS)
    forearm = follow.add(
        "HingedBody",
        "forearm",
        tip=[HAND, 0.0, 0.0],
        stiffness=60.0,
        damping=6.0,
        anchor_position=ELBOW,
        anchor_orientation=DOWN,
        initial_angle=REST,
    )
    arm = follow.add("ArmSkin", "arm", upper_arm_orientation=DOWN)

    follow.signal(ball.force, push)
    follow.connect(ball.center, sensor.target)
    follow.connect(forearm.tip, sensor.sensor)
    follow.connect(sensor.distance, forearm.target_angle, factor=FACTOR, offset=OFFSET)
    follow.connect(forearm.hinge, arm.forearm)

    follow.record(ball.position, ball.orientation, ball.kinetic_energy, ball.potential_energy)
    follow.record(sensor)
    follow.record(forearm.angle, forearm.target_angle, forearm.kinetic_energy, forearm.potential_energy)
    follow.record(forearm.hinge, forearm.tip_position, forearm.tip_orientation)
    follow.record(arm.blend_volume_ratio, arm.minimum_section_ratio, arm.elbow_gap, arm.fold_fraction)
    return follow
