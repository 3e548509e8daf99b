"""Arms of RigidBody units with rigid joints, and how far they end from the reference of `models/jointed_arm`."""

from functools import cache

import numpy as np

from ulna import Results, Scene
from ulna.charts.arms import JointedArm
from ulna.checks.textbook import load_model


def joined(arm: JointedArm, **values) -> Scene:
    """The arm as a scene; `values` for every body."""
    scene = Scene(arm.name)
    before = "world"
    for number, (body, joint) in enumerate(zip(arm.rigid_bodies, arm.joints, strict=True)):
        unit = scene.add("RigidBody", f"body{number}", **{"tolerance": 1e-12, **body, **values})
        scene.join(before, unit.base, joint.get("axis"), damping=joint["friction"])
        before = unit.tip
    return scene


@cache
def truth(make, *arguments) -> np.ndarray:
    """Orientations at the end, shape (bodies, 4): Lagrangian mechanics in minimal coordinates by DOP853."""
    arm = make(*arguments)
    textbook = load_model("jointed_arm")
    model = textbook.jointed_arm(arm.bodies, arm.joints)
    return model.results(textbook.reference(model, arm.state, [0.0, arm.end]))["orientation"][-1]


def angle_off(results: Results, orientations: np.ndarray) -> float:
    """Largest angle (rad) between the last orientation of a body and the true one."""
    found = np.array([results[f"body{k}.orientation"][-1] for k in range(len(orientations))])
    chords = np.minimum(*(np.linalg.norm(found + sign * orientations, axis=1) for sign in (1, -1)))
    return float(np.max(4.0 * np.arcsin(chords / 2.0)))


def energy(results: Results, bodies: int) -> np.ndarray:
    """Kinetic and potential energy of all bodies, row by row."""
    kinds = ("kinetic_energy", "potential_energy")
    return sum(results[f"body{k}.{kind}"] for k in range(bodies) for kind in kinds)
