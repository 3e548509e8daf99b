"""RigidBody from Newton and Euler: forces and torques in axes that turn with the body, momenta made of velocities.

Source: Goldstein, Poole and Safko, *Classical Mechanics*, chapters 4 and 5.
"""

import casadi as ca
from casadi import SX

from ..algebra import Values, inverse, left, pure, rotation_matrix, skew

LOADS = {
    "force": "N",
    "torque": "N.m",
    "base_force": "N",
    "base_torque": "N.m",
    "tip_force": "N",
    "tip_torque": "N.m",
}
STATES = {"position": "m", "orientation": "1", "linear_momentum": "kg.m/s", "angular_momentum": "kg.m2/s"}
PARAMETERS = {"mass": "kg", "inertia": "kg.m2", "gravity": "m/s2", "base": "m", "tip": "m"}
START = {
    "initial_position": "m",
    "initial_orientation": "1",
    "initial_velocity": "m/s",
    "initial_angular_velocity": "rad/s",
}
RATES = {
    "der(position)": "m/s",
    "der(orientation)": "1/s",
    "der(linear_momentum)": "N",
    "der(angular_momentum)": "N.m",
}
SCALARS = {"kinetic_energy": "J", "potential_energy": "J"}
VECTORS = {
    "velocity": "m/s",
    "angular_velocity": "rad/s",
    "acceleration": "m/s2",
    "angular_acceleration": "rad/s2",
    "base_position": "m",
    "base_velocity": "m/s",
    "base_acceleration": "m/s2",
    "tip_position": "m",
    "tip_velocity": "m/s",
    "tip_acceleration": "m/s2",
}
UNITS = LOADS | STATES | PARAMETERS | START | RATES | SCALARS | VECTORS
SIZES = {"mass": 1, "orientation": 4, "initial_orientation": 4}

SAMPLES = {"mass": (0.5, 2.0), "inertia": (0.5, 2.0), "metre": (0.5, 2.0), "kilogram": (0.5, 2.0), "second": (0.5, 2.0)}


def symbols() -> Values:
    """Free symbols for parameters, loads and states; the quaternion has any length."""
    return {name: SX.sym(name, SIZES.get(name, 3)) for name in PARAMETERS | LOADS | STATES | START}


def equations(values: Values) -> Values:
    """Derivatives of the states, motion of the frames, energies, and the states at the start, in SI units."""
    mass, inertia = values["mass"], ca.diag(values["inertia"])
    attitude = rotation_matrix(values["orientation"])
    frames = {"base": values["base"], "tip": values["tip"]}

    # velocities: those that the momenta m v and R I R^T w are made of; then everything in body axes
    velocity = attitude.T @ values["linear_momentum"] / mass
    rate = attitude.T @ (inverse(attitude @ inertia @ attitude.T) @ values["angular_momentum"])
    force = attitude.T @ (values["force"] + mass * values["gravity"])
    torque = attitude.T @ values["torque"]
    for name, place in frames.items():
        force += attitude.T @ values[f"{name}_force"]
        torque += attitude.T @ values[f"{name}_torque"] + skew(place) @ attitude.T @ values[f"{name}_force"]

    # Newton and Euler, in axes that turn
    velocity_rate = force / mass - skew(rate) @ velocity
    rate_rate = inverse(inertia) @ (torque - skew(rate) @ inertia @ rate)

    results = {
        "der(position)": attitude @ velocity,
        "der(orientation)": left(values["orientation"]) @ pure(rate) / 2,
        "der(linear_momentum)": attitude @ (mass * (velocity_rate + skew(rate) @ velocity)),
        "der(angular_momentum)": attitude @ (inertia @ rate_rate + skew(rate) @ inertia @ rate),
        "velocity": attitude @ velocity,
        "angular_velocity": attitude @ rate,
        "acceleration": attitude @ (velocity_rate + skew(rate) @ velocity),
        "angular_acceleration": attitude @ rate_rate,
        "kinetic_energy": (mass * ca.dot(velocity, velocity) + rate.T @ inertia @ rate) / 2,
        "potential_energy": -mass * ca.dot(values["gravity"], values["position"]),
    }
    spin = skew(rate_rate) + skew(rate) @ skew(rate)
    for name, place in frames.items():
        results[f"{name}_position"] = values["position"] + attitude @ place
        results[f"{name}_velocity"] = attitude @ (velocity + skew(rate) @ place)
        results[f"{name}_acceleration"] = results["acceleration"] + attitude @ spin @ place
    return results | initial(values)


def initial(values: Values) -> Values:
    """The states at the start, from the velocities there; the orientation is brought to length 1."""
    start = values["initial_orientation"]
    attitude = rotation_matrix(start)
    world_inertia = attitude @ ca.diag(values["inertia"]) @ attitude.T
    return {
        "initial(position)": values["initial_position"],
        "initial(orientation)": start / ca.norm_2(start),
        "initial(linear_momentum)": values["mass"] * values["initial_velocity"],
        "initial(angular_momentum)": world_inertia @ values["initial_angular_velocity"],
    }
