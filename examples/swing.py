"""An arm of two free bodies swings from a ball joint for a shoulder, with a hinge for an elbow: no springs anywhere.

The joints are rigid: the master finds the wrenches that hold them by repeating each step, so the bones part by no more
than round-off at any step. Both joints are damped a little; the elbow's axis lies askew, so the arm leaves its plane.
"""

import numpy as np

from ulna import Scene

UNTIL = 6.0
STEP = 0.005

# A 70 kg adult's arm, rounded: bones along x, from joint to joint
LENGTH = 0.30  # m, of the upper arm
UPPER = {"mass": 1.9, "inertia": [0.004, 0.012, 0.013], "base": [-0.17, 0.0, 0.0], "tip": [LENGTH - 0.17, 0.0, 0.0]}
FOREARM = {"mass": 1.56, "inertia": [0.002, 0.020, 0.021], "base": [-0.18, 0.0, 0.0], "tip": [0.17, 0.0, 0.0]}
ELBOW_AXIS = [0.0, -0.96, 0.28]
BENT = np.radians(70.0)


def about(axis: list[float], angle: float) -> np.ndarray:
    """Quaternion w, x, y, z of a turn by an angle (rad) about an axis of length 1."""
    return np.append(np.cos(angle / 2.0), np.sin(angle / 2.0) * np.array(axis))


def along(turn: np.ndarray, distance: float) -> np.ndarray:
    """What lies at a distance (m) along x, turned by a quaternion."""
    w, x, y, z = turn
    return distance * np.array([w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)])


def scene() -> Scene:
    """The upper arm level and at rest, the forearm bent up, and the skin over both."""
    swing = Scene("swing")
    turn = about(ELBOW_AXIS, BENT)
    upper = swing.add("RigidBody", "upper", initial_position=[0.17, 0.0, 0.0], **UPPER)
    forearm = swing.add(
        "RigidBody",
        "forearm",
        initial_position=np.array([LENGTH, 0.0, 0.0]) + along(turn, 0.18),
        initial_orientation=turn,
        **FOREARM,
    )
    arm = swing.add("ArmSkin", "arm", upper_arm_length=LENGTH)

    swing.join("world", upper.base, damping=0.05)
    swing.join(upper.tip, forearm.base, axis=ELBOW_AXIS, damping=0.02)
    swing.connect(upper.base, arm.upper_arm)
    swing.connect(forearm.base, arm.forearm)

    for body in (upper, forearm):
        swing.record(body.position, body.orientation, body.kinetic_energy, body.potential_energy)
    swing.record(upper.base, forearm.base_position, forearm.tip_position)
    swing.record(arm.blend_volume_ratio, arm.elbow_gap, arm.fold_fraction)
    return swing
