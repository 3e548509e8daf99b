"""Ways to build one planar arm of two units, and ways to step it."""

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import Any

from ..scene import Scene
from .arms import JointedArm

MOTION = ("position", "orientation", "velocity", "angular_velocity", "acceleration", "angular_acceleration")
STIFFNESSES = (1e4, 1e5, 1e6)
"""N/m."""
# Of CompliantJoint at 1e5 N/m, its default: N.s/m, N.m/rad, N.m.s/rad. Dampers grow as the root of the springs, so that
# oscillations die out within as many periods; the joints start without any.
DAMPING, ANGULAR_STIFFNESS, ANGULAR_DAMPING = 200.0, 500.0, 1.0

NAMES = ("upper", "forearm")
RIGID = "rigid joints"
ONE_WAY, TWO_WAY = "HingedBody, one-way", "HingedBody, two-way"


@dataclass(frozen=True)
class Stepping:
    """A master with its extrapolation, at macro steps that are given, or chosen by a tolerance."""

    master: str
    extrapolation: int = 0
    chosen: bool = False

    @property
    def name(self) -> str:
        """In charts."""
        return self.master + ", extrapolated" * self.extrapolation + ", by tolerance" * self.chosen


STEPPINGS = (
    Stepping("jacobi"),
    Stepping("gauss_seidel"),
    Stepping("jacobi", 1),
    Stepping("gauss_seidel", 1),
    Stepping("iterated"),
    Stepping("newton"),
    Stepping("newton", chosen=True),
)
WITH_JOINTS = (Stepping("rigid"), Stepping("rigid", chosen=True))


@dataclass(frozen=True)
class Way:
    """How the arm is cut into units and what holds these together."""

    name: str
    build: Callable[[JointedArm], Scene]
    """Records the orientation of each body, in order, and nothing else."""
    steppings: tuple[Stepping, ...] = STEPPINGS


def compliant_name(stiffness: float) -> str:
    """Of a way with CompliantJoint: 1e4 N/m."""
    return f"CompliantJoint, {stiffness:.0e} N/m".replace("e+0", "e")


def one_way(arm: JointedArm) -> Scene:
    """The forearm hangs on the upper arm, which does not feel it."""
    scene = _bodies("HingedBody", [arm.hinged_body(0), arm.hinged_body(1)])
    tip, anchor = scene["upper"].tip, scene["forearm"].anchor
    for member in MOTION:
        scene.connect(tip.members[member], anchor.members[member])
    return scene


def two_way(arm: JointedArm) -> Scene:
    """The upper arm feels the reaction, which depends on its acceleration at once."""
    scene = _bodies("HingedBody", [arm.hinged_body(0), arm.hinged_body(1)])
    scene.connect(scene["upper"].tip, scene["forearm"].anchor)
    return scene


def compliant(stiffness: float) -> Way:
    """Springs and dampers (N/m) hold two bodies, the joints after both."""

    def build(arm: JointedArm) -> Scene:
        scene = _bodies("RigidBody", arm.rigid_bodies)
        share = stiffness / 1e5
        values = {
            "stiffness": stiffness,
            "damping": DAMPING * sqrt(share),
            "angular_stiffness": ANGULAR_STIFFNESS * share,
            "angular_damping": ANGULAR_DAMPING * sqrt(share),
        }
        shoulder, elbow = (scene.add("CompliantJoint", name, **values) for name in ("shoulder", "elbow"))
        scene.connect(shoulder.second, scene["upper"].base)
        scene.connect(scene["upper"].tip, elbow.first)
        scene.connect(elbow.second, scene["forearm"].base)
        return scene

    return Way(compliant_name(stiffness), build)


def rigid(arm: JointedArm) -> Scene:
    """Joints without stiffness hold the bodies of an arm of hinges, however many."""
    scene = _bodies("RigidBody", arm.rigid_bodies)
    bodies = list(scene.units.values())
    for frame, body, joint in zip(["world", *(body.tip for body in bodies[:-1])], bodies, arm.joints, strict=True):
        scene.join(frame, body.base, axis=joint["axis"], damping=joint["friction"])
    return scene


def _bodies(unit: str, values: list[dict[str, Any]]) -> Scene:
    scene = Scene("arm")
    for number, start in enumerate(values):
        scene.record(scene.add(unit, NAMES[number] if number < len(NAMES) else f"body_{number}", **start).orientation)
    return scene


WAYS = (
    Way(ONE_WAY, one_way),
    Way(TWO_WAY, two_way),
    *(compliant(stiffness) for stiffness in STIFFNESSES),
    Way(RIGID, rigid, WITH_JOINTS),
)
