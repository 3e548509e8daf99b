"""RigidBody: what holds for every rigid body, whatever computes it.

Source: Goldstein, Poole and Safko, *Classical Mechanics*, chapter 5; the bracket: Marsden and Ratiu, *Introduction to
Mechanics and Symmetry*, chapter 15.
"""

from collections.abc import Mapping

import casadi as ca
from casadi import SX

from ..algebra import (
    Equations,
    Values,
    along,
    conjugate,
    in_other_units,
    inverse,
    left,
    right,
    rotation_matrix,
    skew,
)
from .equations import LOADS, RATES, SCALARS, STATES, UNITS, VECTORS, symbols


def identities(f: Equations) -> dict[str, SX]:
    """What holds for every rigid body, whatever its mass, place and loads."""
    values = symbols()
    results = f(values)
    units = {name: unit for name, unit in UNITS.items() if name in values or name in results}
    return {
        **_balances(values, results),
        **_kinematics(values, results),
        **_symmetries(f, values),
        **_bracket(f, values),
        "every equation is right in its units": in_other_units(f, values, units, RATES | SCALARS | VECTORS),
        **_start(f, values),
    }


def _motion(values: Values, results: Mapping[str, SX]) -> list[tuple[SX, SX]]:
    return [(values[state], results[f"der({state})"]) for state in STATES]


def _balances(values: Values, results: Mapping[str, SX]) -> dict[str, SX]:
    """Energy, momentum, angular momentum, and Euler's equation."""
    motion = _motion(values, results)
    attitude, inertia = rotation_matrix(values["orientation"]), ca.diag(values["inertia"])
    force = values["force"] + values["base_force"] + values["tip_force"]
    free_torque = values["torque"] + values["base_torque"] + values["tip_torque"]
    torque = free_torque
    power = ca.dot(values["force"], results["velocity"]) + ca.dot(free_torque, results["angular_velocity"])
    for frame in ("base", "tip"):
        lever = results[f"{frame}_position"] - values["position"]
        torque += ca.cross(lever, values[f"{frame}_force"])
        power += ca.dot(values[f"{frame}_force"], results[f"{frame}_velocity"])
    body_momentum = inertia @ attitude.T @ results["angular_velocity"]
    body_rate = attitude.T @ results["angular_velocity"]
    energy = results["kinetic_energy"] + results["potential_energy"]
    return {
        "the power of forces and torques is the gain in energy": along(energy, motion) - power,
        "momentum changes by the forces and the weight": results["der(linear_momentum)"]
        - force
        - values["mass"] * values["gravity"],
        "angular momentum changes by the torques and the forces' levers": results["der(angular_momentum)"] - torque,
        "Euler's equation in body axes": along(body_momentum, motion)
        + ca.cross(body_rate, body_momentum)
        - attitude.T @ torque,
        "momentum is mass times velocity": values["linear_momentum"] - values["mass"] * results["velocity"],
        "angular momentum is R I R^T times angular velocity": values["angular_momentum"] - attitude @ body_momentum,
    }


def _kinematics(values: Values, results: Mapping[str, SX]) -> dict[str, SX]:
    """Positions, velocities and accelerations belong together."""
    motion = _motion(values, results)
    q = values["orientation"]
    attitude = rotation_matrix(q)
    turning = skew(results["angular_velocity"]) @ attitude
    claims = {
        "the quaternion keeps its length": along(ca.dot(q, q), motion),
        "the attitude turns with the angular velocity": along(ca.vec(attitude), motion) - ca.vec(turning),
        "velocity is the rate of position": results["velocity"] - results["der(position)"],
        "acceleration is the rate of velocity": results["acceleration"] - along(results["velocity"], motion),
        "angular acceleration is the rate of angular velocity": results["angular_acceleration"]
        - along(results["angular_velocity"], motion),
    }
    for frame in ("base", "tip"):
        position, velocity = results[f"{frame}_position"], results[f"{frame}_velocity"]
        claims |= {
            f"{frame} stays where it is fixed in the body": attitude.T @ (position - values["position"])
            - values[frame],
            f"{frame}_velocity is the rate of {frame}_position": velocity - along(position, motion),
            f"{frame}_acceleration is the rate of {frame}_velocity": results[f"{frame}_acceleration"]
            - along(velocity, motion),
        }
    return claims


def _turned(values: Values, turn: SX) -> Values:
    """The same body seen from axes turned by a quaternion of any length."""
    matrix = rotation_matrix(turn)
    world = [*LOADS, "gravity", "position", "linear_momentum", "angular_momentum"]
    seen = {name: matrix @ values[name] for name in world}
    return values | seen | {"orientation": left(turn) @ values["orientation"]}


def _symmetries(f: Equations, values: Values) -> dict[str, SX]:
    """No direction, place or speed of the observer is special."""
    here, turn, offset = f(values), SX.sym("turn", 4), SX.sym("offset", 3)
    there, moved = f(_turned(values, turn)), f(values | {"position": values["position"] + offset})
    matrix = rotation_matrix(turn)
    vectors = [*VECTORS, "der(position)", "der(linear_momentum)", "der(angular_momentum)"]
    places = {"base_position", "tip_position"}
    boosted = f(values | {"linear_momentum": values["linear_momentum"] + values["mass"] * offset})
    return {
        "in turned axes everything is turned": ca.vertcat(
            *[there[name] - matrix @ here[name] for name in vectors],
            there["der(orientation)"] - left(turn) @ here["der(orientation)"],
            *[there[name] - here[name] for name in SCALARS],
        ),
        "a shift of the origin changes places only": ca.vertcat(
            *[moved[name] - here[name] - (offset if name in places else 0) for name in (RATES | VECTORS)],
        ),
        "a moving observer sees other velocities only": ca.vertcat(
            *[
                boosted[name] - here[name] - (offset if name.endswith("velocity") and "angular" not in name else 0)
                for name in VECTORS
            ]
        ),
    }


def bracket(values: Values, results: Mapping[str, SX]) -> SX:
    """The Poisson matrix of orientation and angular momentum, 7x7, from how the one turns with the other."""
    per_velocity = inverse(ca.jacobian(results["angular_velocity"], values["angular_momentum"]))
    turning = ca.jacobian(results["der(orientation)"], values["angular_momentum"]) @ per_velocity
    return ca.blockcat([[SX(4, 4), turning], [-turning.T, -skew(values["angular_momentum"])]])


def _bracket(f: Equations, values: Values) -> dict[str, SX]:
    """The free body is a Hamiltonian system with the Lie-Poisson bracket of the rotations."""
    results = f(values | {name: SX.zeros(3) for name in LOADS})
    q, momentum = values["orientation"], values["angular_momentum"]
    states = ca.vertcat(q, momentum)
    matrix = bracket(values, results)
    energy = results["kinetic_energy"] + results["potential_energy"]
    slope = ca.gradient(energy, states)
    gradient_x, gradient_p = (ca.gradient(energy, values[name]) for name in ("position", "linear_momentum"))
    body_momentum = ca.diag(values["inertia"]) @ rotation_matrix(q).T @ results["angular_velocity"]
    inner = ca.jacobian(body_momentum, states)
    closed = inner @ matrix @ inner.T
    square = ca.gradient(ca.dot(body_momentum, body_momentum), states)
    return {
        "Jacobi's identity of the bracket of orientation and angular momentum": _jacobi(matrix, states),
        "the free motion is the bracket with the energy": ca.vertcat(
            results["der(position)"] - gradient_p,
            results["der(linear_momentum)"] + gradient_x,
            ca.vertcat(results["der(orientation)"], results["der(angular_momentum)"]) - matrix @ slope,
        ),
        "the quaternion's length is a Casimir of the bracket": matrix @ ca.gradient(ca.dot(q, q), states),
        "the body momenta have the bracket of the rotations": ca.vec(closed - skew(body_momentum)),
        "the length of the angular momentum is a Casimir of the body momenta": inner @ matrix @ square,
    }


def _jacobi(matrix: SX, states: SX) -> SX:
    """Sum over the cyclic permutations of {a, {b, c}}, for every three states."""
    size = states.numel()
    slopes = [[ca.gradient(matrix[i, j], states) for j in range(size)] for i in range(size)]

    def nested(a: int, b: int, c: int) -> SX:
        return matrix[a, :] @ slopes[b][c]

    triples = [(i, j, k) for i in range(size) for j in range(i) for k in range(j)]
    return ca.vertcat(*[nested(i, j, k) + nested(j, k, i) + nested(k, i, j) for i, j, k in triples])


def _start(f: Equations, values: Values) -> dict[str, SX]:
    """The body starts as its parameters say."""
    started = f(values)
    state = {name: started[f"initial({name})"] for name in STATES}
    results = f(values | state)
    q = values["initial_orientation"]
    same_turn = right(conjugate(q)) @ state["orientation"]
    return {
        "the body starts with the velocities of its parameters": ca.vertcat(
            results["velocity"] - values["initial_velocity"],
            results["angular_velocity"] - values["initial_angular_velocity"],
            state["position"] - values["initial_position"],
        ),
        "the orientation at the start is the parameter's, of length 1": ca.vertcat(
            same_turn[1:], ca.dot(state["orientation"], state["orientation"]) - 1
        ),
    }
