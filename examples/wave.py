"""A raised arm waves: a target angle scripted in Python, a muscle that follows it, and the skin over the two bones."""

from math import pi, radians, sin

from ulna import Scene

UNTIL = 6.0
STEP = 0.001
MASTER = "gauss_seidel"

ELBOW = [0.30, 0.0, 0.0]  # the upper arm lies along +x from the shoulder, which is the origin


def wave(time: float) -> float:
    """Angle of the elbow to aim at (rad): up within a second, then to and fro."""
    raised = min(time, 1.0)
    return radians(80.0) * raised + radians(45.0) * sin(2.0 * pi * 0.6 * time) * raised


def scene() -> Scene:
    """Forearm and skin."""
    waving = Scene("wave")
    forearm = waving.add("HingedBody", "forearm", stiffness=60.0, damping=6.0, anchor_position=ELBOW)
    arm = waving.add("ArmSkin", "arm")
    waving.signal(forearm.target_angle, wave)
    waving.connect(forearm.hinge, arm.forearm)
    waving.record(forearm.angle, forearm.target_angle, forearm.kinetic_energy, forearm.potential_energy, forearm.hinge)
    waving.record(arm.blend_volume_ratio, arm.minimum_section_ratio, arm.elbow_gap, arm.fold_fraction)
    return waving
