"""The models' identities: they hold for the textbook's own equations, and each of them can fail."""

import random
from functools import cache

import casadi as ca
import pytest
from casadi import SX

from ulna.checks.identity import range_of, vanishes
from ulna.checks.textbook import load_model

UNITS = ("rigid_body", "hinged_body", "compliant_joint", "arm_skin", "ultrasonic_sensor")


@cache
def model(unit):
    return load_model(unit)


def broken(unit, *, of=None, by=None):
    """The unit's equations with one result replaced, or each off by a hundredth of something that varies."""

    def disturbed(values):
        results = dict(model(unit).equations(values))
        everything = ca.vertcat(*values.values())
        for i, name in enumerate(results):
            size = results[name].numel()
            # each result depends wrongly on all that there is, and on that in a way of its own
            weights = [SX(1 + (7 * i + k) % 5) for k in range(everything.numel())]
            wrong = ca.dot(everything, ca.vertcat(*weights)) ** 2
            results[name] = results[name] + wrong * ca.vertcat(*[SX((i + k) % 3 + 1) for k in range(size)]) / 100
        return results

    def replaced(values):
        results = dict(model(unit).equations(values))
        return results | {of: by(results, values)}

    return replaced if of else disturbed


@pytest.mark.parametrize("unit", UNITS)
def test_the_textbook_obeys_its_own_identities(unit):
    claims = model(unit).identities(model(unit).equations)
    failing = [claim for claim, expression in claims.items() if not vanishes(expression, model(unit).SAMPLES).vanishes]
    assert not failing


@pytest.mark.parametrize("unit", UNITS)
def test_no_identity_holds_whatever_the_equations_say(unit):
    claims = model(unit).identities(broken(unit))
    idle = [claim for claim, expression in claims.items() if vanishes(expression, model(unit).SAMPLES).vanishes]
    assert not idle


def rotation(values):
    w, x, y, z = ca.vertsplit(values["orientation"] / ca.norm_2(values["orientation"]))
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return ca.blockcat(rows)


def with_transposed_inertia(results, values):
    """The notes' R^T I R in place of R I R^T."""
    turn = rotation(values)
    return turn.T @ ca.inv_minor(ca.diag(values["inertia"])) @ turn @ values["angular_momentum"]


def with_body_torque(results, values):
    """The torque taken as if it were in body axes."""
    return results["der(angular_momentum)"] - values["torque"] + rotation(values) @ values["torque"]


WRONG = {
    "the notes' R^T I R": (
        "rigid_body",
        "angular_velocity",
        with_transposed_inertia,
        "the power of forces and torques is the gain in energy",
    ),
    "the missing half of the quaternion's rate": (
        "rigid_body",
        "der(orientation)",
        lambda results, values: 2 * results["der(orientation)"],
        "Jacobi's identity of the bracket of orientation and angular momentum",
    ),
    "a torque in the world taken as in the body": (
        "rigid_body",
        "der(angular_momentum)",
        with_body_torque,
        "in turned axes everything is turned",
    ),
    "a frame's acceleration without its centripetal part": (
        "rigid_body",
        "tip_acceleration",
        lambda results, values: (
            results["acceleration"]
            + ca.cross(results["angular_acceleration"], results["tip_position"] - values["position"])
        ),
        "tip_acceleration is the rate of tip_velocity",
    ),
    "friction that drives": (
        "hinged_body",
        "der(rate)",
        lambda results, values: results["der(rate)"] + values["friction"] * values["rate"] / values["mass"],
        "power of tip, anchor, muscle and friction is the gain in energy",
    ),
    "a reaction that forgets the weight": (
        "hinged_body",
        "reaction_force",
        lambda results, values: results["reaction_force"] - values["mass"] * values["gravity"],
        "an anchor that accelerates upwards is as good as weight",
    ),
    "normals turned with the blend alone": (
        "arm_skin",
        "linear_blend_normal",
        lambda results, values: model("arm_skin").equations(values | {"weight_gradient": SX(3, 1)})[
            "linear_blend_normal"
        ],
        "linear_blend: normals are the cofactors of the deformation's own Jacobian",
    ),
    "the notes' x = v / t": (
        "ultrasonic_sensor",
        "distance_of_time",
        lambda results, values: values["speed"] / values["time_of_flight"],
        "every equation is right in its units, which x = v/t is not",
    ),
    "a time without the way back": (
        "ultrasonic_sensor",
        "time_of_distance",
        lambda results, values: results["time_of_distance"] / 2,
        "distance and time of flight are inverse",
    ),
    "an emitter that is louder than the receiver hears": (
        "ultrasonic_sensor",
        "path_amplitude",
        lambda results, values: results["path_amplitude"] - values["first"],
        "emitter and receiver may be exchanged: the amplitude stays",
    ),
}

COMPARED_ONLY = {
    "ultrasonic_sensor": {
        "vapour_fraction",
        "speed_of_sound_in_air",
        "absorption_of_air",
        "piston_dispersion",
        *(f"initial({name})" for name in ("speed_of_sound", "absorption", "distance", "level")),
        "initial(threshold_amplitude)",
        *(f"initial({name}_time)" for name in ("start", "position", "sphere_center", "nearest", "farthest", "ring")),
        *(f"initial({name})" for name in ("wave_number", "burst_length", "peak_time", "peak", "burst_height")),
        *(f"initial({name})" for name in ("burst_start", "burst_period", "burst_rest")),
        *(f"initial(foreign_{number}_position_time)" for number in (1, 2, 3)),
        "burst_velocity",
    }
}
"""Fits to measurements and copies of inputs and parameters: nothing but the comparison with the textbook holds them."""


@pytest.mark.parametrize("error", WRONG)
def test_a_known_error_breaks_the_identity_that_speaks_of_it(error):
    unit, result, wrong, claim = WRONG[error]
    expression = model(unit).identities(broken(unit, of=result, by=wrong))[claim]
    assert not vanishes(expression, model(unit).SAMPLES).vanishes


@pytest.mark.parametrize("unit", UNITS)
def test_every_result_of_a_textbook_is_in_some_identity(unit):
    """Whatever result is doubled and shifted, some claim fails: none is left unguarded."""
    symbols, samples = model(unit).symbols(), model(unit).SAMPLES
    names = list(model(unit).equations(symbols))
    switches = SX.sym("switch", len(names))

    def doubled(values):
        results = model(unit).equations(values)
        return {name: result * (1 + switches[i]) + switches[i] for i, (name, result) in enumerate(results.items())}

    claims = ca.vertcat(*[ca.vec(expression) for expression in model(unit).identities(doubled).values()])
    free = [symbol for symbol in ca.symvar(claims) if not symbol.name().startswith("switch")]
    residuals = ca.Function("residuals", [ca.vertcat(*free), switches], [claims])
    source = random.Random(3)
    point = [source.uniform(*range_of(symbol.name(), samples)) for symbol in free]
    unguarded = set()
    for i, name in enumerate(names):
        off = residuals(point, [float(i == k) for k in range(len(names))])
        # round-off is some 1e-13; a root of a negative number is as wrong as a number that is not zero
        if all(abs(value) < 1e-6 for value in off.elements()):
            unguarded.add(name)
    assert unguarded == COMPARED_ONLY.get(unit, set())
