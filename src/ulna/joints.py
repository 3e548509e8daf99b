"""Rigid joints between frames of any units: what they join, and what a frame must have for it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .connections import End, Frame

WORLD = "world"
# Member of a frame -> its causality and shape.
MOTION = {"position": ("output", (3,)), "velocity": ("output", (3,)), "force": ("input", (3,))}
TURNING = {"orientation": ("output", (4,)), "angular_velocity": ("output", (3,)), "torque": ("input", (3,))}


@dataclass(frozen=True)
class Joint:
    """`second` is held to `first`, or to the world: at one point, and with an axis only free to turn about it."""

    first: Frame | None
    """None for the world, at the place where `second` is at the start."""
    second: Frame
    axis: tuple[float, float, float] | None
    """Unit vector in the axes of `first` (of the world); None for a ball joint."""
    damping: float
    """Torque against the relative angular velocity, N.m.s/rad."""

    @property
    def turning(self) -> bool:
        """Whether it passes on torque."""
        return self.axis is not None or self.damping > 0.0

    @property
    def frames(self) -> list[Frame]:
        """The frames of units that it joins."""
        return [self.second] if self.first is None else [self.first, self.second]

    def __str__(self) -> str:
        """`upper.tip - forearm.base`."""
        first = WORLD if self.first is None else _name(self.first)
        return f"{first} - {_name(self.second)}"


def make_joint(first: Frame | str, second: Frame, axis: Sequence[float] | None, damping: float) -> Joint:
    """The checked joint; raises ValueError, naming the frame and what it lacks, or the value and its range."""
    if isinstance(first, str) and first != WORLD:
        raise ValueError(f"cannot join {first!r}: a frame, or {WORLD!r}")
    if not (np.isfinite(damping) and damping >= 0.0):
        raise ValueError(f"damping = {damping:g} N.m.s/rad; allowed range: at least 0")
    unit_axis = None
    if axis is not None:
        vector = np.asarray(axis, float)
        length = np.linalg.norm(vector)
        if vector.shape != (3,) or not (np.isfinite(length) and length > 0.0):
            raise ValueError(f"axis = {axis}; allowed: three finite numbers that are not all zero")
        unit_axis = tuple(float(x) for x in vector / length)
    joint = Joint(None if isinstance(first, str) else first, second, unit_axis, float(damping))
    for frame in joint.frames:
        _check(frame, joint)
    if joint.first is not None and joint.first.unit is joint.second.unit:
        raise ValueError(f"cannot join {joint}: both frames belong to one unit")
    return joint


def _check(frame: Frame, joint: Joint) -> None:
    if not isinstance(frame, Frame):
        raise ValueError(f"cannot join {frame}: it is no frame; unit.frame(...) makes one of variables")
    for member, (causality, shape) in (MOTION | TURNING if joint.turning else MOTION).items():
        end = frame.members.get(member)
        if end is None or end.variable.causality != causality or end.shape != shape or end.kind != "float":
            found = end or "nothing"
            raise ValueError(f"cannot join {frame}: its {member} must be an {causality} of shape {shape}, not {found}")


def wrench_ends(joint: Joint) -> list[End]:
    """The inputs that a joint drives."""
    members = ("force", "torque") if joint.turning else ("force",)
    return [frame.members[member] for frame in joint.frames for member in members]


def motion_ends(joint: Joint) -> list[End]:
    """The outputs that it watches."""
    members = ("position", "velocity", "orientation", "angular_velocity") if joint.turning else ("position", "velocity")
    return [frame.members[member] for frame in joint.frames for member in members]


def _name(frame: Frame) -> str:
    return f"{frame.unit.name}.{frame.terminal}"
