"""A chain of rigid bodies from its energies, by Poincare's equations.

    d/dt (dT/du) + [u, dT/du] = X (T - V) - dF/du

T and V are the energies, F is half the power that friction takes (Rayleigh). u are the speeds of the joints: the rate
of a hinge, or the angular velocity of a ball joint in the axes of the body that it carries. X is the rate of change
with the place along the motion of each speed alone; [u, p] is u x p for a ball joint, whose turns do not commute, and
nothing for a hinge, where this is Lagrange's equation. H. Poincare, Sur une forme nouvelle des equations de la
mecanique, C. R. Acad. Sci. 132 (1901) 369; Marsden and Ratiu, *Introduction to Mechanics and Symmetry*, 13.5.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from casadi import SX
from numpy.typing import NDArray

from ..algebra import Values, along, left, pure, rodrigues, rotation_matrix

Array = NDArray[np.float64]

SIZES = {"hinge": (1, 1), "ball": (4, 3)}
"""Places and speeds of a joint: an angle (rad) or a quaternion w, x, y, z; rates in rad/s."""


@dataclass(frozen=True)
class Arm:
    """A chain that hangs from the world's origin. Its state holds the places of all joints, then the speeds of all.

    All angles zero and all quaternions 1, every body's axes are the world's. Angles and rates of a hinge are those to
    the body before; but in a planar chain, hinges about one axis only, those to the world, in which a long chain is
    well conditioned.
    """

    bodies: tuple[Mapping[str, Any], ...]
    """From the origin on, each with `mass` (kg), `inertia` [3] (kg m2, principal, about the centre of mass), and `base`
    and `tip` [3] (m, from the centre of mass, in body axes): where it is held, and where it holds the next."""
    joints: tuple[Mapping[str, Any], ...]
    """At the base of each body: `kind` "hinge" or "ball", `axis` [3] of a hinge (of length 1, the same in the axes of
    both bodies), and `friction` (N m s/rad), viscous."""
    gravity: tuple[float, float, float]
    """m/s2, in the world."""

    @property
    def planar(self) -> bool:
        """Whether all joints are hinges about one axis."""
        return all(joint["kind"] == "hinge" for joint in self.joints) and not np.any(
            np.subtract([joint["axis"] for joint in self.joints], self.joints[0]["axis"])
        )

    @property
    def places(self) -> int:
        """How many numbers of the state are places."""
        return sum(SIZES[joint["kind"]][0] for joint in self.joints)

    @property
    def size(self) -> int:
        """Numbers in the state."""
        return sum(sum(SIZES[joint["kind"]]) for joint in self.joints)

    def slope(self, _: float, state: Array) -> Array:
        """Rate of the state [size]."""
        return np.array(self._slope(state)).ravel()

    def results(self, states: Array) -> dict[str, Array]:
        """What can be seen of the states [..., size], SI units, in the world, quaternions w, x, y, z body to world.

        For each body (second last axis, one element a body for energies): `position`, `velocity`, `acceleration` of the
        centre of mass, `orientation`, `angular_velocity`, `angular_acceleration`, `kinetic_energy`, `potential_energy`
        (zero at the origin), `base_position` and `tip_position`, which is the place of the next joint. For the whole
        chain: `energy`, `linear_momentum` [3], `angular_momentum` [3] about the origin, and the `power` of friction.
        """
        flat = np.reshape(states, (-1, self.size))
        values = self._results.map(len(flat))(flat.T)
        found = {}
        for name, value in zip(self._results.name_out(), values, strict=True):
            rows, columns = self._results.size_out(name)
            by_body = np.array(value).reshape(rows, len(flat), columns).transpose(1, 2, 0)
            bodies, elements = () if name in WHOLE else (columns,), (rows,) if rows > 1 else ()
            found[name] = by_body.reshape((*np.shape(states)[:-1], *bodies, *elements))
        return found

    @cached_property
    def _expressions(self) -> Values:
        return expressions(self)

    @cached_property
    def _slope(self) -> ca.Function:
        values = self._expressions
        return ca.Function("slope", [values["state"]], [values["slope"]], {"cse": True})

    @cached_property
    def _results(self) -> ca.Function:
        values = self._expressions
        names = [name for name in values if name not in ("state", "slope")]
        return ca.Function("results", [values["state"]], [values[name] for name in names], ["state"], names)


LISTS = ("attitude", "joint_rate")
WHOLE = ("energy", "power", "linear_momentum", "angular_momentum")
"""Results that are not one for each body."""


def jointed_arm(
    bodies: Sequence[Mapping[str, Any]],
    joints: Sequence[Mapping[str, Any]],
    gravity: Sequence[float] = (0.0, 0.0, -9.80665),
) -> Arm:
    """The chain of these bodies, see `Arm`; raises ValueError for what is no chain."""
    if not bodies or len(bodies) != len(joints):
        raise ValueError(f"{len(bodies)} bodies cannot hang on {len(joints)} joints: one joint for each body is needed")
    for joint in joints:
        if joint["kind"] not in SIZES:
            raise ValueError(f"kind = {joint['kind']!r} of a joint: allowed are {', '.join(SIZES)}")
        if joint["kind"] == "hinge" and not np.isclose(np.linalg.norm(joint["axis"]), 1.0, rtol=0.0, atol=1e-12):
            raise ValueError(f"axis = {joint['axis']} of a hinge: allowed is a vector of length 1")
    return Arm(tuple(bodies), tuple(joints), tuple(gravity))


def expressions(arm: Arm) -> Values:
    """`state`, a column of symbols, its `slope`, and all results, one column a body."""
    place, speed = SX.sym("place", arm.places), SX.sym("speed", arm.size - arm.places)
    parts = _split(arm, place, speed)
    place_rate = ca.vertcat(*[_rate(q, u) for q, u in parts])
    moved = [(place, place_rate)]
    seen = _kinematics(arm, parts, moved)
    masses, inertias = [SX(body["mass"]) for body in arm.bodies], [SX(ca.DM(body["inertia"])) for body in arm.bodies]
    kinetic, potential = [], []
    for i, (mass, inertia) in enumerate(zip(masses, inertias, strict=True)):
        velocity, rate = seen["velocity"][:, i], seen["body_rate"][:, i]
        kinetic.append((mass * ca.dot(velocity, velocity) + ca.dot(inertia * rate, rate)) / 2)
        potential.append(-mass * ca.dot(SX(ca.DM(arm.gravity)), seen["position"][:, i]))
    braking = sum(joint["friction"] * ca.sumsqr(u) / 2 for joint, u in zip(arm.joints, seen["joint_rate"], strict=True))
    energies = ca.sum1(ca.vertcat(*kinetic)), ca.sum1(ca.vertcat(*potential))
    speed_rate = _poincare(*energies, place, speed, place_rate, arm) - ca.gradient(braking, speed)
    speed_rate = ca.ldl_solve(speed_rate, *ca.ldl(ca.hessian(energies[0], speed)[0]))

    motion = [*moved, (speed, speed_rate)]
    spins = [inertia * seen["body_rate"][:, i] for i, inertia in enumerate(inertias)]
    linear = [mass * seen["velocity"][:, i] for i, mass in enumerate(masses)]
    angular = [
        ca.cross(seen["position"][:, i], linear[i]) + seen["attitude"][i] @ spins[i] for i in range(len(arm.bodies))
    ]
    names = ("position", "velocity", "orientation", "angular_velocity", "base_position", "tip_position")
    return {
        "state": ca.vertcat(place, speed),
        "slope": ca.vertcat(place_rate, speed_rate),
        **{name: seen[name] for name in names},
        "acceleration": ca.reshape(along(ca.vec(seen["velocity"]), motion), 3, -1),
        "angular_acceleration": ca.reshape(along(ca.vec(seen["angular_velocity"]), motion), 3, -1),
        "kinetic_energy": ca.horzcat(*kinetic),
        "potential_energy": ca.horzcat(*potential),
        "energy": energies[0] + energies[1],
        "power": -2 * braking,
        "linear_momentum": sum(linear, SX(3, 1)),
        "angular_momentum": sum(angular, SX(3, 1)),
    }


def _split(arm: Arm, place: SX, speed: SX) -> list[tuple[SX, SX]]:
    """Place and speed of each joint."""
    sizes = [SIZES[joint["kind"]] for joint in arm.joints]
    cuts = [np.cumsum([0, *column]).tolist() for column in zip(*sizes, strict=True)]
    return list(zip(ca.vertsplit(place, cuts[0]), ca.vertsplit(speed, cuts[1]), strict=True))


def _rate(place: SX, speed: SX) -> SX:
    """Rate of a joint's place."""
    return speed if place.numel() == 1 else left(place) @ pure(speed) / 2


def _kinematics(arm: Arm, parts: list[tuple[SX, SX]], moved: list[tuple[SX, SX]]) -> dict[str, Any]:
    """Where the bodies are and how they move, one column a body; of `attitude` and `joint_rate` lists."""
    attitude, orientation = SX.eye(3), SX([1, 0, 0, 0])
    joint_place, spin = SX(3, 1), SX(3, 1)
    columns: dict[str, list[SX]] = {}
    for body, joint, (q, u) in zip(arm.bodies, arm.joints, parts, strict=True):
        if arm.planar:
            attitude, orientation, before, spin = SX.eye(3), SX([1, 0, 0, 0]), spin, SX(3, 1)
        turn, quaternion, rate = _joint(joint, q, u)
        attitude, orientation = attitude @ turn, left(orientation) @ quaternion
        spin = spin + attitude @ rate
        center = joint_place - attitude @ SX(ca.DM(body["base"]))
        values = {
            "attitude": attitude,
            "orientation": orientation,
            "angular_velocity": spin,
            "body_rate": attitude.T @ spin,
            "joint_rate": spin - before if arm.planar else rate,
            "base_position": joint_place,
            "position": center,
            "velocity": along(center, moved),
        }
        joint_place = center + attitude @ SX(ca.DM(body["tip"]))
        for name, value in (values | {"tip_position": joint_place}).items():
            columns.setdefault(name, []).append(value)
    return {name: value if name in LISTS else ca.horzcat(*value) for name, value in columns.items()}


def _joint(joint: Mapping[str, Any], place: SX, speed: SX) -> tuple[SX, SX, SX]:
    """The turn that a joint makes as matrix and as quaternion, and its angular velocity in the axes that it carries."""
    if joint["kind"] == "ball":
        return rotation_matrix(place), place / ca.norm_2(place), speed
    axis = SX(ca.DM(joint["axis"]))
    return rodrigues(axis, place), ca.vertcat(ca.cos(place / 2), ca.sin(place / 2) * axis), axis * speed


def _poincare(kinetic: SX, potential: SX, place: SX, speed: SX, place_rate: SX, arm: Arm) -> SX:
    """What the mass matrix times the rates of the speeds is, without friction."""
    momentum = ca.gradient(kinetic, speed)
    directions = ca.jacobian(place_rate, speed)
    turning = [
        ca.cross(u, p) if joint["kind"] == "ball" else SX(1, 1)
        for joint, (_, u), (_, p) in zip(
            arm.joints, _split(arm, place, speed), _split(arm, place, momentum), strict=True
        )
    ]
    slope = directions.T @ ca.gradient(kinetic - potential, place)
    return slope - ca.vertcat(*turning) - along(momentum, [(place, place_rate)])
