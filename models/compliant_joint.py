"""CompliantJoint from a potential and a dissipation function: the wrenches are their gradients.

Forces and torques come by virtual shifts and turns of each body, rates by automatic derivatives along the motion.
Source: Goldstein, Poole and Safko, *Classical Mechanics*, 1.4 and 1.5 (d'Alembert, Rayleigh's dissipation function).
"""

from collections.abc import Mapping
from functools import cache

import casadi as ca
from casadi import SX

from .algebra import (
    Equations,
    Values,
    along,
    in_other_units,
    left,
    pure,
    rotation_matrix,
    unit_vector,
)

PARAMETERS = {
    "stiffness": "N/m",
    "damping": "N.s/m",
    "angular_stiffness": "N.m/rad",
    "angular_damping": "N.m.s/rad",
    "friction": "N.m.s/rad",
    "axis": "1",
}
BODIES = ("first", "second")
MOTION = {"position": "m", "orientation": "1", "velocity": "m/s", "angular_velocity": "rad/s"}
WRENCH = {"force": "N", "torque": "N.m"}
FRAMES = {f"{body}_{name}": unit for body in BODIES for name, unit in MOTION.items()}
WRENCHES = {f"{body}_{name}": unit for body in BODIES for name, unit in WRENCH.items()}
STRAINS = {"displacement": "m", "misalignment": "1"}
SCALARS = {"potential_energy": "J", "dissipation": "W"}
RESULTS = WRENCHES | STRAINS | SCALARS
UNITS = PARAMETERS | FRAMES | RESULTS
SIZES = dict.fromkeys((name for name in PARAMETERS if name != "axis"), 1) | {
    f"{body}_orientation": 4 for body in BODIES
}

SAMPLES = dict.fromkeys(("metre", "kilogram", "second"), (0.5, 2.0))


def free_symbols() -> Values:
    """A free symbol for every parameter and input; the axis has any length."""
    return {name: SX.sym(name, SIZES.get(name, 3)) for name in PARAMETERS | FRAMES}


def symbols() -> Values:
    """The same with an axis of length 1, as the equations want it; the quaternions have any length."""
    return free_symbols() | {"axis": unit_vector("axis_slope")}


def equations(values: Values) -> Values:
    """Wrenches on both bodies, what is out of place, energy and dissipation, in SI units."""
    function = _derived()
    results = function(*[values[name] for name in function.name_in()])
    return dict(zip(RESULTS, results, strict=True))


@cache
def _derived() -> ca.Function:
    """The results on free symbols, where they can be differentiated."""
    values = free_symbols()
    results = _derive(values)
    places = [f"result_{i}" for i, _ in enumerate(RESULTS)]
    return ca.Function("compliant_joint", [*values.values()], [results[name] for name in RESULTS], [*values], places)


def _derive(values: Values) -> Values:
    turns = [rotation_matrix(values[f"{body}_orientation"]) for body in BODIES]
    places = [values[f"{body}_position"] for body in BODIES]
    spins = [values[f"{body}_angular_velocity"] for body in BODIES]
    axes = [turn @ values["axis"] for turn in turns]
    apart = places[1] - places[0]
    potential = values["stiffness"] * ca.dot(apart, apart) / 2
    potential += values["angular_stiffness"] * (1 - ca.dot(*axes))
    dissipation = _rayleigh(values, places, spins, axes)
    results = {
        "displacement": turns[0].T @ apart,
        "misalignment": turns[0].T @ ca.cross(*axes),
        "potential_energy": potential,
        "dissipation": 2 * dissipation,
    }
    for body in BODIES:
        force, torque = virtual_wrench(potential, values, body)
        results[f"{body}_force"] = force - ca.gradient(dissipation, values[f"{body}_velocity"])
        results[f"{body}_torque"] = torque - ca.gradient(dissipation, values[f"{body}_angular_velocity"])
    return results


def _rayleigh(values: Values, places: list[SX], spins: list[SX], axes: list[SX]) -> SX:
    """Half the dissipated power: of the bodies' points half way, and of each axis seen from the other body."""
    middle = (places[0] + places[1]) / 2
    points = [
        values[f"{body}_velocity"] + ca.cross(spin, middle - place)
        for body, spin, place in zip(BODIES, spins, places, strict=True)
    ]
    slide, spin = points[1] - points[0], spins[1] - spins[0]
    total = values["damping"] * ca.dot(slide, slide)
    for axis in axes:
        about = ca.dot(axis, spin) * axis
        across = spin - about
        total += values["angular_damping"] / 2 * ca.dot(across, across) + values["friction"] / 2 * ca.dot(about, about)
    return total / 2


def virtual_wrench(potential: SX, values: Values, body: str) -> tuple[SX, SX]:
    """Force and torque of a potential on a body: what it loses by a shift of the frame, and by a turn about it."""
    q = values[f"{body}_orientation"]
    turned = ca.horzcat(*[left(pure(SX.eye(3)[:, i])) @ q / 2 for i in range(3)])
    return -ca.gradient(potential, values[f"{body}_position"]), -turned.T @ ca.gradient(potential, q)


def identities(f: Equations) -> dict[str, SX]:
    """Claims by their words, expressions that vanish."""
    values = symbols()
    results = f(values)
    return {
        **_balance(values, results),
        **_gradients(values, results),
        **_strains(values, results),
        **_axes(f, values),
        **_symmetries(f, values),
        "every equation is right in its units": in_other_units(f, values, UNITS, RESULTS),
    }


def _balance(values: Values, results: Mapping[str, SX]) -> dict[str, SX]:
    """Newton's third law, and the power that goes in, is stored and is lost."""
    force = results["first_force"] + results["second_force"]
    moment, power = SX.zeros(3), results["dissipation"]
    motion = []
    for body in BODIES:
        place, q, velocity, spin = (values[f"{body}_{name}"] for name in MOTION)
        moment += ca.cross(place, results[f"{body}_force"]) + results[f"{body}_torque"]
        power += ca.dot(results[f"{body}_force"], velocity) + ca.dot(results[f"{body}_torque"], spin)
        motion += [(place, velocity), (q, left(pure(spin)) @ q / 2)]
    return {
        "the two forces are opposite": force,
        "the two wrenches have no moment about the origin": moment,
        "the bodies give what the springs store and the dampers take": along(results["potential_energy"], motion)
        + power,
    }


def _gradients(values: Values, results: Mapping[str, SX]) -> dict[str, SX]:
    """The wrenches follow from energy and dissipation, which is quadratic in the velocities."""
    claims = {}
    for body in BODIES:
        force, torque = virtual_wrench(results["potential_energy"], values, body)
        force -= ca.gradient(results["dissipation"], values[f"{body}_velocity"]) / 2
        torque -= ca.gradient(results["dissipation"], values[f"{body}_angular_velocity"]) / 2
        claims[f"{body}: the wrench is minus the gradients of energy and dissipation"] = ca.vertcat(
            results[f"{body}_force"] - force, results[f"{body}_torque"] - torque
        )
    return claims


def _strains(values: Values, results: Mapping[str, SX]) -> dict[str, SX]:
    """What is out of place, and the energy of that."""
    turns = [rotation_matrix(values[f"{body}_orientation"]) for body in BODIES]
    axes = [turn @ values["axis"] for turn in turns]
    apart, chord = values["second_position"] - values["first_position"], axes[1] - axes[0]
    energy = values["stiffness"] * ca.dot(apart, apart) / 2 + values["angular_stiffness"] * ca.dot(chord, chord) / 2
    return {
        "displacement leads from frame to frame": turns[0] @ results["displacement"] - apart,
        "misalignment stands on both axes, as long as the sine between them": turns[0] @ results["misalignment"]
        - ca.cross(*axes),
        "the springs stretch from frame to frame, and from the end of one axis to that of the other": results[
            "potential_energy"
        ]
        - energy,
    }


def _axes(f: Equations, values: Values) -> dict[str, SX]:
    """In place, turned about the axis by any angle at any rate; and the joints that a hinge becomes."""
    angle = SX.sym("angle")
    bend = ca.vertcat(ca.cos(angle / 2), ca.sin(angle / 2) * values["axis"])
    met = values | {"second_position": values["first_position"]}
    closed = f(met | {"second_orientation": left(values["first_orientation"]) @ bend})
    spin = values["second_angular_velocity"] - values["first_angular_velocity"]
    axis = rotation_matrix(values["first_orientation"]) @ values["axis"]
    about = ca.dot(axis, spin) * axis
    even = f(met | {"angular_stiffness": SX(0), "angular_damping": values["friction"]})
    return {
        "a hinge in place resists by friction about its axis, by damping across it": closed["second_torque"]
        + values["friction"] * about
        + values["angular_damping"] * (spin - about),
        "a hinge in place stores nothing": ca.vertcat(closed["potential_energy"], closed["misalignment"]),
        "a ball joint with even damping has no axis": even["second_torque"] + values["friction"] * spin,
    }


def _symmetries(f: Equations, values: Values) -> dict[str, SX]:
    """No direction, place, speed or spin of the observer is special, nor either of the frames, nor a quaternion."""
    turn, offset, spin = SX.sym("turn", 4), SX.sym("offset", 3), SX.sym("spin", 3)
    matrix, length = rotation_matrix(turn), SX.sym("length", 2)
    turned, carried, longer, exchanged = {}, {}, {}, {}
    for body, other, factor in zip(BODIES, reversed(BODIES), ca.vertsplit(length), strict=True):
        place, q, velocity, rate = (f"{body}_{name}" for name in MOTION)
        turned |= {name: matrix @ values[name] for name in (place, velocity, rate)} | {q: left(turn) @ values[q]}
        carried |= {place: values[place] + offset, rate: values[rate] + spin}
        carried[velocity] = values[velocity] + ca.cross(spin, values[place]) - offset
        longer[q] = factor**2 * values[q]
        exchanged |= {f"{body}_{name}": values[f"{other}_{name}"] for name in MOTION}
    here, there, elsewhere, same, swapped = (f(values | new) for new in ({}, turned, carried, longer, exchanged))
    first, second = (rotation_matrix(values[f"{body}_orientation"]) for body in BODIES)
    return {
        "in turned axes everything is turned": ca.vertcat(
            *[there[name] - matrix @ here[name] for name in WRENCHES],
            *[there[name] - here[name] for name in STRAINS | SCALARS],
        ),
        "an observer elsewhere, who moves and spins, sees the same joint": ca.vertcat(
            *[elsewhere[name] - here[name] for name in RESULTS]
        ),
        "frames exchanged, wrenches exchanged": ca.vertcat(
            *[swapped[f"first_{name}"] - here[f"second_{name}"] for name in WRENCH],
            *[swapped[f"second_{name}"] - here[f"first_{name}"] for name in WRENCH],
            *[second @ swapped[name] + first @ here[name] for name in STRAINS],
            *[swapped[name] - here[name] for name in SCALARS],
        ),
        "the lengths of the quaternions do not matter": ca.vertcat(*[same[name] - here[name] for name in RESULTS]),
    }
