"""HingedBody from Lagrange: one angle, an anchor that moves as it is told; the reaction from the balance of momenta.

Every rate is an automatic derivative: of the kinetic energy by angle and rate, of momenta and places along the motion.
Source: Goldstein, Poole and Safko, *Classical Mechanics*, 1.4 to 1.6 (d'Alembert, Lagrange, Rayleigh's dissipation).
"""

from collections.abc import Mapping
from functools import cache

import casadi as ca
from casadi import SX

from ..algebra import Values, along, left, pure, rodrigues, rotation_matrix, unit_vector

PARAMETERS = {
    "mass": "kg",
    "inertia": "kg.m2",
    "center_of_mass": "m",
    "tip": "m",
    "axis": "1",
    "gravity": "m/s2",
    "stiffness": "N.m/rad",
    "damping": "N.m.s/rad",
    "friction": "N.m.s/rad",
    "initial_angle": "rad",
    "initial_rate": "rad/s",
}
ANCHOR = {
    "anchor_position": "m",
    "anchor_orientation": "1",
    "anchor_velocity": "m/s",
    "anchor_angular_velocity": "rad/s",
    "anchor_acceleration": "m/s2",
    "anchor_angular_acceleration": "rad/s2",
}
DRIVES = {"target_angle": "rad", "torque": "N.m", "tip_force": "N", "tip_torque": "N.m"}
STATES = {"angle": "rad", "rate": "rad/s"}
VECTORS = {
    "tip_velocity": "m/s",
    "tip_angular_velocity": "rad/s",
    "tip_acceleration": "m/s2",
    "tip_angular_acceleration": "rad/s2",
    "reaction_force": "N",
    "reaction_torque": "N.m",
}
PLACES = {"position": "m", "tip_position": "m"}
ORIENTATIONS = {"orientation": "1", "tip_orientation": "1"}
SCALARS = {"der(angle)": "rad/s", "der(rate)": "rad/s2", "kinetic_energy": "J", "potential_energy": "J"}
RESULTS = SCALARS | VECTORS | PLACES | ORIENTATIONS
UNITS = PARAMETERS | ANCHOR | DRIVES | STATES | RESULTS
SIZES = {"anchor_orientation": 4} | dict.fromkeys(
    ("mass", "stiffness", "damping", "friction", "initial_angle", "initial_rate", "target_angle", "torque", *STATES), 1
)

SAMPLES = {
    "mass": (0.5, 2.0),
    "inertia": (0.5, 2.0),
    "metre": (0.5, 2.0),
    "kilogram": (0.5, 2.0),
    "second": (0.5, 2.0),
}


def free_symbols() -> Values:
    """A free symbol for every parameter, input and state; the axis has any length."""
    return {name: SX.sym(name, SIZES.get(name, 3)) for name in PARAMETERS | ANCHOR | DRIVES | STATES}


def symbols() -> Values:
    """The same with an axis of length 1, as the equations want it; the anchor's quaternion has any length."""
    return free_symbols() | {"axis": unit_vector("axis_slope")}


def anchor_motion(values: Values) -> list[tuple[SX, SX]]:
    """How the anchor moves: symbols and their rates."""
    turning = left(pure(values["anchor_angular_velocity"])) @ values["anchor_orientation"] / 2
    return [
        (values["anchor_position"], values["anchor_velocity"]),
        (values["anchor_orientation"], turning),
        (values["anchor_velocity"], values["anchor_acceleration"]),
        (values["anchor_angular_velocity"], values["anchor_angular_acceleration"]),
    ]


def equations(values: Values) -> Values:
    """Derivatives of the states, motion of the frames, reaction, energies, and the states at the start, in SI units."""
    function = _derived()
    results = function(*[values[name] for name in function.name_in()])
    return dict(zip(RESULTS, results, strict=True)) | {f"initial({name})": values[f"initial_{name}"] for name in STATES}


@cache
def _derived() -> ca.Function:
    """The results on free symbols, where they can be differentiated."""
    values = free_symbols()
    results = _derive(values)
    # the start does not enter
    used = {name: value for name, value in values.items() if not name.startswith("initial_")}
    return ca.Function("hinged_body", [*used.values()], [results[name] for name in RESULTS], [*used], _names(RESULTS))


def _names(results: Mapping[str, str]) -> list[str]:
    """CasADi wants identifiers that differ from those of the inputs."""
    return [f"result_{i}" for i, _ in enumerate(results)]


def _derive(values: Values) -> Values:
    mass, angle, rate = values["mass"], values["angle"], values["rate"]
    anchor = rotation_matrix(values["anchor_orientation"])
    attitude = anchor @ rodrigues(values["axis"], angle)
    spin = values["anchor_angular_velocity"] + rate * anchor @ values["axis"]
    center = values["anchor_position"] + attitude @ values["center_of_mass"]
    tip = values["anchor_position"] + attitude @ values["tip"]
    weight = mass * values["gravity"]

    given = [(angle, rate), *anchor_motion(values)]
    center_velocity, tip_velocity = along(center, given), along(tip, given)
    body_spin = attitude.T @ spin
    turning_energy = ca.dot(body_spin, values["inertia"] * body_spin) / 2
    kinetic = mass * ca.dot(center_velocity, center_velocity) / 2 + turning_energy
    stretch = values["target_angle"] - angle
    potential = values["stiffness"] * stretch**2 / 2 - ca.dot(weight, center)
    dissipation = (values["damping"] + values["friction"]) * rate**2 / 2

    # d/dt dT/d(rate) - dT/d(angle) + dV/d(angle) + dD/d(rate) = what the loads do per rate
    loads = ca.dot(values["tip_force"], tip_velocity) + ca.dot(values["tip_torque"], spin)
    momentum = ca.gradient(kinetic, rate)
    generalized = values["torque"] + ca.gradient(loads, rate)
    missing = generalized + ca.gradient(kinetic - potential, angle) - ca.gradient(dissipation, rate)
    rate_rate = (missing - along(momentum, given)) / ca.gradient(momentum, rate)

    # the anchor gives what the momenta need beyond weight and tip
    motion = [*given, (rate, rate_rate)]
    linear = mass * center_velocity
    angular = ca.cross(center, linear) + attitude @ (values["inertia"] * body_spin)
    force = along(linear, motion) - weight - values["tip_force"]
    torque = along(angular, motion) - ca.cross(center, weight) - ca.cross(tip, values["tip_force"])
    torque -= values["tip_torque"] + ca.cross(values["anchor_position"], force)

    q = values["anchor_orientation"]
    bend = ca.vertcat(ca.cos(angle / 2), ca.sin(angle / 2) * values["axis"])
    orientation = left(q / ca.norm_2(q)) @ bend
    return {
        "der(angle)": rate,
        "der(rate)": rate_rate,
        "kinetic_energy": kinetic,
        "potential_energy": potential,
        "tip_velocity": tip_velocity,
        "tip_angular_velocity": spin,
        "tip_acceleration": along(tip_velocity, motion),
        "tip_angular_acceleration": along(spin, motion),
        "reaction_force": -force,
        "reaction_torque": -torque,
        "position": values["anchor_position"],
        "tip_position": tip,
        "orientation": orientation,
        "tip_orientation": orientation,
    }
