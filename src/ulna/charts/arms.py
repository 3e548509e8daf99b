"""Arms on which couplings are judged, as plain data: for the units, and for the references in `models/jointed_arm`.

Bodies' x axes lie along them, from the shoulder on, which is the world's origin. At angle 0 they point forward along
the world's x; a hinge's axis is -y, so that a positive angle raises.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..skeleton import multiply, rotate

GRAVITY = (0.0, 0.0, -9.80665)  # m/s2
HINGE = (0.0, -1.0, 0.0)
CARRYING = (0.0, -0.96, 0.28)
"""An elbow's axis 16 degrees off the transverse one, of length 1 to the last bit."""

UPPER_ARM = {
    "mass": 1.897,
    "inertia": (0.003654, 0.010592, 0.011890),
    "base": (-0.16034, 0.0, 0.0),
    "tip": (0.11745, 0.0, 0.0),
}
"""kg, kg m2, m: de Leva (1996), table 4, male, scaled from 73 to 70 kg as HingedBody's forearm: length .2817 m times
(70/73)^(1/3) = .27779 m, 2.71 % of the mass, centre at .5772, gyration radii .158, .269, .285 of the length."""

FOREARM = {
    "mass": 1.561,
    "inertia": (0.001664, 0.020226, 0.021105),
    "base": (-0.17901, 0.0, 0.0),
    "tip": (0.17116, 0.0, 0.0),
}
"""kg, kg m2, m: forearm and hand, the start values of HingedBody."""


@dataclass(frozen=True)
class JointedArm:
    """A chain of bodies with the joints at their bases, and how it starts."""

    name: str
    bodies: tuple[dict[str, Any], ...]
    """Parameters of RigidBody: `mass`, `inertia`, `base`, `tip`."""
    joints: tuple[dict[str, Any], ...]
    """`kind` "hinge" or "ball", `axis` of a hinge in the axes of both bodies, `friction` (N m s/rad)."""
    places: tuple[Any, ...]
    """Of each joint at the start: angle to the body before (rad), or quaternion w, x, y, z."""
    speeds: tuple[Any, ...]
    """Rate (rad/s) to the body before, or angular velocity to it [3] in the axes of the body carried."""
    end: float
    """s: until then the reference is good for 2e-11 (rad, rad/s), and errors at the start grow less than 300-fold."""

    @property
    def planar(self) -> bool:
        """Whether all joints are hinges about one axis: then the reference's angles are those to the world."""
        return all(joint.get("axis") == HINGE for joint in self.joints)

    @cached_property
    def state(self) -> NDArray[np.float64]:
        """Start of the reference in `models/jointed_arm`: places of all joints, then speeds of all, flat."""
        if self.planar:
            return np.concatenate([np.cumsum(self.places), np.cumsum(self.speeds)])
        return np.concatenate([np.ravel(value) for value in (*self.places, *self.speeds)])

    @cached_property
    def rigid_bodies(self) -> list[dict[str, Any]]:
        """Parameters of RigidBody for each body, with those of the start: `initial_position`, `initial_orientation`,
        `initial_velocity`, `initial_angular_velocity`, which fit at the joints to round-off."""
        q, spin = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
        place, velocity = np.zeros(3), np.zeros(3)
        found = []
        for body, joint, turn, rate in zip(self.bodies, self.joints, self.places, self.speeds, strict=True):
            if joint["kind"] == "hinge":
                axis = np.array(joint["axis"])
                turn, rate = np.array([cos(turn / 2), *(sin(turn / 2) * axis)]), rate * axis
            q = multiply(q, np.array(turn))
            spin = spin + rotate(q, np.array(rate))
            to_center, to_tip = rotate(q, -np.array(body["base"])), rotate(q, np.subtract(body["tip"], body["base"]))
            start = {
                "initial_position": place + to_center,
                "initial_orientation": q,
                "initial_velocity": velocity + np.cross(spin, to_center),
                "initial_angular_velocity": spin,
            }
            found.append({**body, "gravity": GRAVITY, **start})
            place, velocity = place + to_tip, velocity + np.cross(spin, to_tip)
        return found

    def hinged_body(self, index: int) -> dict[str, Any]:
        """Parameters of HingedBody for a body on a hinge; its muscle is off."""
        body, joint = self.bodies[index], self.joints[index]
        return {
            "mass": body["mass"],
            "inertia": body["inertia"],
            "center_of_mass": np.negative(body["base"]),
            "tip": np.subtract(body["tip"], body["base"]),
            "axis": joint["axis"],
            "friction": joint["friction"],
            "stiffness": 0.0,
            "damping": 0.0,
            "gravity": GRAVITY,
            "initial_angle": self.places[index],
            "initial_rate": self.speeds[index],
        }


def hinge(friction: float = 0.0, axis: Sequence[float] = HINGE) -> dict[str, Any]:
    """A hinge's data."""
    return {"kind": "hinge", "axis": tuple(axis), "friction": friction}


def planar_arm() -> JointedArm:
    """Upper arm and forearm on hinges without friction, let go with the upper arm raised and the elbow bent; 5 s."""
    return JointedArm("planar_arm", (UPPER_ARM, FOREARM), (hinge(), hinge()), (-pi / 2 + 0.8, 0.5), (0.0, 0.0), 5.0)


def ball_arm() -> JointedArm:
    """Upper arm on a ball joint, forearm on an oblique hinge, damped (N m s/rad: .1 and .05), set swinging; 5 s."""
    raised = (cos(0.35), 0.0, sin(0.35), 0.0)
    return JointedArm(
        "ball_arm",
        (UPPER_ARM, FOREARM),
        ({"kind": "ball", "friction": 0.1}, hinge(0.05, CARRYING)),
        (raised, 0.9),
        ((0.5, -0.4, 2.0), -1.0),
        5.0,
    )


def chain(count: int = 10, friction: float = 0.0) -> JointedArm:
    """Equal uniform rods on hinges, together 1 kg and 1 m long, hanging straight but for the first hinge; 2 s."""
    length, mass = 1.0 / count, 1.0 / count
    moment = mass * length**2 / 12
    rod = {
        "mass": mass,
        "inertia": (moment / 100, moment, moment),
        "base": (-length / 2, 0.0, 0.0),
        "tip": (length / 2, 0.0, 0.0),
    }
    places = (-pi / 2 + 0.6, *[0.0] * (count - 1))
    return JointedArm(f"chain_{count}", (rod,) * count, (hinge(friction),) * count, places, (0.0,) * count, 2.0)
