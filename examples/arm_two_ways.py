"""The same arm twice in one scene: its bones held by rigid joints, and by springs and dampers (CompliantJoint).

Any importer can run the springs; their step must be short and their stiffness is part of the answer. The rigid joints
need a master that can repeat a step. With the springs at 1e5 N/m the two forearms part slowly: `ulna run arm_two_ways
--set elbow.stiffness=1e4 --set shoulder.stiffness=1e4` shows it at once.
"""

import numpy as np

from ulna import Scene

UNTIL = 3.0
STEP = 0.0005

LENGTH = 0.30  # m, of the upper arm
UPPER = {"mass": 1.9, "inertia": [0.004, 0.012, 0.013], "base": [-0.17, 0.0, 0.0], "tip": [LENGTH - 0.17, 0.0, 0.0]}
FOREARM = {"mass": 1.56, "inertia": [0.002, 0.020, 0.021], "base": [-0.18, 0.0, 0.0], "tip": [0.17, 0.0, 0.0]}
AXIS = [0.0, -1.0, 0.0]
FORWARD, UPWARD = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
UP = [0.5**0.5, 0.0, -(0.5**0.5), 0.0]  # the forearm's x axis along the world's z
ASIDE = np.array([0.0, 0.25, 0.0])  # m, from the one arm to the other


def bones(scene: Scene, name: str, shoulder: np.ndarray) -> tuple:
    """An upper arm, level, and a forearm, upright, at rest."""
    upper = scene.add("RigidBody", f"{name}_upper", initial_position=shoulder + 0.17 * FORWARD, **UPPER)
    elbow = shoulder + LENGTH * FORWARD
    start = {"initial_position": elbow + 0.18 * UPWARD, "initial_orientation": UP}
    return upper, scene.add("RigidBody", f"{name}_forearm", **start, **FOREARM)


def scene() -> Scene:
    """Four bodies, two rigid joints, two compliant ones."""
    both = Scene("arm_two_ways")
    upper, forearm = bones(both, "rigid", np.zeros(3))
    both.join("world", upper.base, axis=AXIS)
    both.join(upper.tip, forearm.base, axis=AXIS)

    soft_upper, soft_forearm = bones(both, "soft", ASIDE)
    shoulder = both.add("CompliantJoint", "shoulder", axis=AXIS, first_position=ASIDE)
    elbow = both.add("CompliantJoint", "elbow", axis=AXIS)
    both.connect(soft_upper.base, shoulder.second)
    both.connect(soft_upper.tip, elbow.first)
    both.connect(soft_forearm.base, elbow.second)

    for body in (upper, forearm, soft_upper, soft_forearm):
        both.record(body.position, body.orientation, body.kinetic_energy, body.potential_energy)
    both.record(forearm.tip_position, soft_forearm.tip_position, elbow.displacement)
    return both
