"""HingedBody: what holds for every body on a hinge, whatever computes it.

The energies stand for the body: Lagrange's equation and the reaction follow from them by d'Alembert's principle, with
virtual displacements of the angle and, for the reaction, of the anchor.
"""

from collections.abc import Mapping

import casadi as ca
from casadi import SX

from ..algebra import Equations, Values, along, in_other_units, left, pure, rodrigues, rotation_matrix, skew
from .equations import ANCHOR, ORIENTATIONS, PLACES, RESULTS, SCALARS, STATES, UNITS, VECTORS, anchor_motion, symbols


def identities(f: Equations) -> dict[str, SX]:
    """Claims by their words, expressions that vanish."""
    values = symbols()
    results = f(values)
    target_rate = SX.sym("target_rate")
    motion = [
        (values["angle"], results["der(angle)"]),
        (values["rate"], results["der(rate)"]),
        *anchor_motion(values),
        (values["target_angle"], target_rate),
    ]
    return {
        **_mechanics(values, results, motion),
        "power of tip, anchor, muscle and friction is the gain in energy": _power(values, results, motion, target_rate),
        **_kinematics(values, results, motion),
        **_symmetries(f, values),
        "every equation is right in its units": in_other_units(f, values, UNITS, RESULTS),
        "the states start as the parameters say": ca.vertcat(
            *[results[f"initial({name})"] - values[f"initial_{name}"] for name in STATES]
        ),
    }


def _along_axis(values: Values) -> SX:
    """What muscle, friction and torque give the body about the axis."""
    stretch = values["target_angle"] - values["angle"]
    braking = (values["damping"] + values["friction"]) * values["rate"]
    return values["stiffness"] * stretch - braking + values["torque"]


def _mechanics(values: Values, results: Mapping[str, SX], motion: list) -> dict[str, SX]:
    """Lagrange's equation, and the reaction by virtual work of the anchor."""
    kinetic, potential = results["kinetic_energy"], results["potential_energy"]
    angle, rate = values["angle"], values["rate"]
    still = [pair for pair in motion if pair[0] is not values["target_angle"]]
    lever = results["tip_position"] - values["anchor_position"]
    axis = rotation_matrix(values["anchor_orientation"]) @ values["axis"]
    loads = ca.dot(values["tip_force"], results["tip_velocity"])
    loads += ca.dot(values["tip_torque"], results["tip_angular_velocity"])
    generalized = values["torque"] + ca.gradient(loads, rate) - (values["damping"] + values["friction"]) * rate
    lagrange = along(ca.gradient(kinetic, rate), still) - ca.gradient(kinetic - potential, angle) - generalized

    # momenta of a virtual shift and turn of the anchor, which takes the body along
    linear = ca.gradient(kinetic, values["anchor_velocity"])
    angular = ca.gradient(kinetic, values["anchor_angular_velocity"])
    weight = -ca.gradient(potential, values["anchor_position"])
    turned = ca.horzcat(*[left(pure(SX.eye(3)[:, i])) @ values["anchor_orientation"] / 2 for i in range(3)])
    weight_torque = -turned.T @ ca.gradient(potential, values["anchor_orientation"])
    tip_torque = values["tip_torque"] + ca.cross(lever, values["tip_force"])
    return {
        "Lagrange's equation of the angle": lagrange,
        "the reaction is minus the force that the momentum needs": along(linear, still)
        - weight
        - values["tip_force"]
        + results["reaction_force"],
        "the reaction is minus the torque that the angular momentum needs": along(angular, still)
        + ca.cross(values["anchor_velocity"], linear)
        - weight_torque
        - tip_torque
        + results["reaction_torque"],
        "about the axis the reaction is minus what muscle, friction and torque give": ca.dot(
            axis, results["reaction_torque"]
        )
        + _along_axis(values),
        "the weight acts on the whole mass": weight - values["mass"] * values["gravity"],
    }


def _power(values: Values, results: Mapping[str, SX], motion: list, target_rate: SX) -> SX:
    """Gain in energy less what anchor, tip, motor and the moving target put in, friction takes out."""
    energy = results["kinetic_energy"] + results["potential_energy"]
    stretch, rate = values["target_angle"] - values["angle"], values["rate"]
    power = ca.dot(values["tip_force"], results["tip_velocity"])
    power += ca.dot(values["tip_torque"], results["tip_angular_velocity"])
    power -= ca.dot(results["reaction_force"], values["anchor_velocity"])
    power -= ca.dot(results["reaction_torque"], values["anchor_angular_velocity"])
    power += values["torque"] * rate - (values["damping"] + values["friction"]) * rate**2
    power += values["stiffness"] * stretch * target_rate
    return along(energy, motion) - power


def _kinematics(values: Values, results: Mapping[str, SX], motion: list) -> dict[str, SX]:
    """Frames lie where the anchor and the angle put them, and move accordingly."""
    q, spin = results["orientation"], results["tip_angular_velocity"]
    attitude = rotation_matrix(values["anchor_orientation"]) @ rodrigues(values["axis"], values["angle"])
    lever = results["tip_position"] - values["anchor_position"]
    return {
        "the angle's rate is the rate": results["der(angle)"] - values["rate"],
        "the body is the anchor turned by the angle about the axis": ca.vec(rotation_matrix(q) - attitude),
        "orientation has length 1, and is that of the tip": ca.vertcat(
            ca.dot(q, q) - 1, results["tip_orientation"] - q
        ),
        "the hinge is at the anchor": results["position"] - values["anchor_position"],
        "tip stays where it is fixed in the body": attitude.T @ lever - values["tip"],
        "the orientation turns with the angular velocity": along(q, motion) - left(pure(spin)) @ q / 2,
        "tip_velocity is the rate of tip_position": results["tip_velocity"] - along(results["tip_position"], motion),
        "tip_acceleration is the rate of tip_velocity": results["tip_acceleration"]
        - along(results["tip_velocity"], motion),
        "tip_angular_acceleration is the rate of tip_angular_velocity": results["tip_angular_acceleration"]
        - along(spin, motion),
        "energy of turning is that of R I R^T": _turning_energy(values, results, attitude),
    }


def _turning_energy(values: Values, results: Mapping[str, SX], attitude: SX) -> SX:
    """Kinetic energy less that of the mass at its centre and of the turn about it."""
    spin = results["tip_angular_velocity"]
    velocity = values["anchor_velocity"] + skew(spin) @ attitude @ values["center_of_mass"]
    world_inertia = attitude @ ca.diag(values["inertia"]) @ attitude.T
    energy = values["mass"] * ca.dot(velocity, velocity) / 2 + spin.T @ world_inertia @ spin / 2
    return results["kinetic_energy"] - energy


def _symmetries(f: Equations, values: Values) -> dict[str, SX]:
    """No direction, place, speed or free fall of the observer is special; nor is the length of the quaternion."""
    here, turn, offset, length = f(values), SX.sym("turn", 4), SX.sym("offset", 3), SX.sym("length")
    matrix = rotation_matrix(turn)
    world = [name for name in ANCHOR if name != "anchor_orientation"] + ["gravity", "tip_force", "tip_torque"]
    orientation = {"anchor_orientation": left(turn) @ values["anchor_orientation"]}
    turned = f(values | {name: matrix @ values[name] for name in world} | orientation)
    longer = f(values | {"anchor_orientation": length**2 * values["anchor_orientation"]})

    def raised(*names: str) -> Mapping[str, SX]:
        return f(values | {name: values[name] + offset for name in names})

    moved, boosted = raised("anchor_position"), raised("anchor_velocity")
    falling = raised("anchor_acceleration", "gravity")
    unmoved = [name for name in RESULTS if name not in PLACES and name != "potential_energy"]
    unboosted = [name for name in unmoved if name not in ("tip_velocity", "kinetic_energy")]
    weighed = ["der(rate)", "reaction_force", "reaction_torque", "tip_angular_acceleration"]
    return {
        "in turned axes everything is turned": ca.vertcat(
            *[turned[name] - matrix @ here[name] for name in VECTORS | PLACES],
            *[turned[name] - left(turn) @ here[name] / ca.norm_2(turn) for name in ORIENTATIONS],
            *[turned[name] - here[name] for name in SCALARS],
        ),
        "a shift of the origin changes places only": ca.vertcat(
            *[moved[name] - here[name] for name in unmoved], *[moved[name] - here[name] - offset for name in PLACES]
        ),
        "a moving observer sees other velocities only": ca.vertcat(
            *[boosted[name] - here[name] for name in unboosted], boosted["tip_velocity"] - here["tip_velocity"] - offset
        ),
        "an anchor that accelerates upwards is as good as weight": ca.vertcat(
            *[falling[name] - here[name] for name in weighed],
            falling["tip_acceleration"] - here["tip_acceleration"] - offset,
        ),
        "the length of the anchor's quaternion does not matter": ca.vertcat(
            *[longer[name] - here[name] for name in RESULTS]
        ),
    }
