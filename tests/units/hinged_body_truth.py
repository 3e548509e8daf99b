"""The truth for HingedBody in three dimensions: six point masses on a hinge moved by a function of time.

Only the positions of the points are written down; velocities, accelerations and Lagrange's equation
follow by automatic differentiation, so no formula of the unit is used twice.
"""

from dataclasses import dataclass

import casadi
import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

# A body without symmetry on a slanted axis: every term of the equations takes part.
SLANTED = {
    "mass": 1.3,
    "inertia": [0.011, 0.017, 0.023],
    "center_of_mass": [0.12, -0.05, 0.07],
    "tip": [0.31, 0.04, -0.02],
    "axis": [2 / 7, -6 / 7, 3 / 7],
    "gravity": [0.3, -0.2, -9.7],
    "stiffness": 3.0,
    "damping": 0.11,
    "friction": 0.05,
    "initial_angle": 0.4,
    "initial_rate": -2.5,
}
LOADS = {
    "target_angle": 0.9,
    "torque": 0.35,
    "tip_force": np.array([1.2, -0.7, 2.1]),
    "tip_torque": np.array([-0.2, 0.4, 0.1]),
}


@dataclass(frozen=True)
class Truth:
    """The body of SLANTED as point masses, its hinge moved by a function of time; world axes, SI."""

    anchor: casadi.Function  # t -> position, rotation, velocity, w, acceleration, dw, jerk, d2w
    rate_rate: casadi.Function  # t, angle, rate -> second derivative of the angle
    motion: casadi.Function  # t, angle, rate, rate_rate -> the outputs of the unit, in the order of OUTPUTS


OUTPUTS = (
    "tip_position",
    "tip_velocity",
    "tip_acceleration",
    "tip_angular_velocity",
    "tip_angular_acceleration",
    "reaction_force",
    "reaction_torque",
    "kinetic_energy",
    "potential_energy",
)


def turn(axis: list[float], angle: casadi.SX) -> casadi.SX:
    """Rodrigues' rotation matrix [3, 3]."""
    k = casadi.skew(casadi.SX(axis))
    return casadi.SX.eye(3) + casadi.sin(angle) * k + (1 - casadi.cos(angle)) * k @ k


def wandering(t: casadi.SX) -> tuple[casadi.SX, casadi.SX]:
    """An anchor that accelerates and tumbles with no fixed axis."""
    position = casadi.vertcat(0.1 * casadi.sin(3 * t), 0.2 * t**2 - 0.1 * t, 0.3 + 0.05 * casadi.cos(5 * t))
    return position, turn([0, 0, 1], 0.7 * casadi.sin(2 * t)) @ turn([1, 0, 0], 1.3 * t + 0.2 * t**2)


def spinning_up(t: casadi.SX) -> tuple[casadi.SX, casadi.SX]:
    """An anchor whose acceleration changes linearly, and its angular acceleration too, about a fixed axis."""
    position = casadi.vertcat(0.4 * t, 0.6 * t**2, 0.5 * t**3 - 0.3 * t**2)
    return position, turn([0.6, 0.0, 0.8], 2.0 * t + 0.75 * t**2 - 0.9 * t**3)


def truth(anchor_motion) -> Truth:
    """Lagrange's equation and the sums of Newton's law over six points, for SLANTED under LOADS.

    The points lie on the principal axes at +-a_i from the centre of mass, m/6 each, with
    m/3 a_i^2 = (I_j + I_k - I_i) / 2, which gives the three principal moments.
    """
    t, angle, rate, rate_rate = (casadi.SX.sym(name) for name in ("t", "angle", "rate", "rate_rate"))
    mass, gravity, axis = SLANTED["mass"], casadi.SX(SLANTED["gravity"]), SLANTED["axis"]
    inertia = np.array(SLANTED["inertia"])
    arms = np.sqrt((inertia.sum() / 2 - inertia) * 3 / mass)
    position, anchor_rotation = anchor_motion(t)
    rotation = anchor_rotation @ turn(axis, angle)

    def dot(value: casadi.SX) -> casadi.SX:
        """The time derivative along the motion."""
        return casadi.jtimes(value, t, 1) + casadi.jtimes(value, angle, rate) + casadi.jtimes(value, rate, rate_rate)

    def spin(matrix: casadi.SX) -> casadi.SX:
        return casadi.inv_skew(dot(matrix) @ matrix.T)

    center = casadi.SX(SLANTED["center_of_mass"])
    offsets = [casadi.SX(sign * arms[i] * np.eye(3)[i]) for i in range(3) for sign in (-1, 1)]
    points = [position + rotation @ (center + offset) for offset in offsets]
    tip = position + rotation @ casadi.SX(SLANTED["tip"])
    force, couple = casadi.SX(LOADS["tip_force"]), casadi.SX(LOADS["tip_torque"])

    kinetic = sum(mass / 12 * casadi.sumsqr(dot(point)) for point in points)
    weight = -sum(mass / 6 * casadi.dot(gravity, point) for point in points)
    stretch = LOADS["target_angle"] - angle
    potential = weight + SLANTED["stiffness"] / 2 * stretch**2
    push = LOADS["torque"] - (SLANTED["damping"] + SLANTED["friction"]) * rate
    push += casadi.dot(force, casadi.jacobian(tip, angle))
    push += casadi.dot(couple, anchor_rotation @ casadi.SX(axis))
    momentum = casadi.jacobian(kinetic, rate)
    missing = casadi.jacobian(kinetic - potential, angle) + push - dot(momentum)
    solution = -casadi.substitute(missing, rate_rate, 0) / casadi.jacobian(missing, rate_rate)

    pulls = [mass / 6 * (dot(dot(point)) - gravity) for point in points]
    lever_sum = sum(casadi.cross(point - position, pull) for point, pull in zip(points, pulls, strict=True))
    outputs = [
        tip,
        dot(tip),
        dot(dot(tip)),
        spin(rotation),
        dot(spin(rotation)),
        force - sum(pulls),
        couple + casadi.cross(tip - position, force) - lever_sum,
        kinetic,
        potential,
    ]
    anchor = [
        position,
        anchor_rotation,
        dot(position),
        spin(anchor_rotation),
        dot(dot(position)),
        dot(spin(anchor_rotation)),
        dot(dot(dot(position))),
        dot(dot(spin(anchor_rotation))),
    ]
    return Truth(
        anchor=casadi.Function("anchor", [t], anchor),
        rate_rate=casadi.Function("rate_rate", [t, angle, rate], [solution]),
        motion=casadi.Function("motion", [t, angle, rate, rate_rate], outputs),
    )


WANDERING, SPINNING_UP = truth(wandering), truth(spinning_up)


def anchor_inputs(true: Truth, t: float, slopes: bool = True) -> dict:
    """The inputs that move the anchor at `t`, with the slopes of its accelerations or with none."""
    position, rotation, velocity, spin, acceleration, angular_acceleration, jerk, angular_jerk = (
        np.array(value).squeeze() for value in true.anchor(t)
    )
    return {
        "anchor_position": position,
        "anchor_orientation": np.roll(Rotation.from_matrix(rotation).as_quat(), 1),
        "anchor_velocity": velocity,
        "anchor_angular_velocity": spin,
        "anchor_acceleration": acceleration,
        "anchor_angular_acceleration": angular_acceleration,
        "anchor_acceleration_rate": slopes * jerk,
        "anchor_angular_acceleration_rate": slopes * angular_jerk,
    }


def true_state(true: Truth, end: float) -> np.ndarray:
    """Angle and rate at `end`, by DOP853 on Lagrange's equation."""

    def slope(t: float, y: np.ndarray) -> list[float]:
        return [y[1], float(true.rate_rate(t, y[0], y[1]))]

    start = [SLANTED["initial_angle"], SLANTED["initial_rate"]]
    return solve_ivp(slope, (0, end), start, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
