"""A forearm on a resting upper arm: a pendulum with a muscle, as a model to hold HingedBody's FMU against.

    ulna check build/fmus/3.0/HingedBody.fmu --model examples/check_my_fmu/pendulum.py

The FMU's anchor, axis and gravity keep their start values, as this model does not mention them: at rest, (0, -1, 0),
(0, 0, -9.80665). So the angle lifts the forearm from +x towards +z.
"""

import casadi as ca
from casadi import SX

GRAVITY = 9.80665  # m/s2

# where symbols are drawn: numbers that must be positive, and moments of inertia that a body can have
SAMPLES = {"mass": (0.5, 2.0), "inertia": (0.8, 1.2)}


def equations(values: dict[str, SX]) -> dict[str, SX]:
    """Expressions by the FMU's variable names, from columns by the FMU's variable names; SI units."""
    x, _, z = ca.vertsplit(values["center_of_mass"])
    angle, rate = values["angle"], values["rate"]
    inertia = values["inertia"][1] + values["mass"] * (x**2 + z**2)  # about the hinge: Huygens and Steiner
    lever = x * ca.cos(angle) - z * ca.sin(angle)
    height = x * ca.sin(angle) + z * ca.cos(angle)
    stretch = values["target_angle"] - angle
    muscle = values["stiffness"] * stretch - values["damping"] * rate
    torque = muscle - values["friction"] * rate + values["torque"] - values["mass"] * GRAVITY * lever
    return {
        "der(angle)": rate,
        "der(rate)": torque / inertia,
        "kinetic_energy": inertia * rate**2 / 2,
        "potential_energy": values["mass"] * GRAVITY * height + values["stiffness"] * stretch**2 / 2,
    }


def identities(f) -> dict[str, SX]:
    """Claims in words, each with what must vanish if it holds: they are checked on the model itself."""
    sizes = {"center_of_mass": 3, "inertia": 3}
    scalars = ("mass", "stiffness", "damping", "friction", "target_angle", "torque", "angle", "rate")
    values = {name: SX.sym(name, sizes.get(name, 1)) for name in (*scalars, *sizes)}
    results = f(values)
    states = ca.vertcat(values["angle"], values["rate"])
    rates = ca.vertcat(results["der(angle)"], results["der(rate)"])
    gain = ca.jtimes(results["kinetic_energy"] + results["potential_energy"], states, rates)
    lost = (values["damping"] + values["friction"]) * values["rate"] ** 2
    return {
        "the torque's power, less what damping takes, is the gain in energy": gain
        - values["torque"] * values["rate"]
        + lost
    }
