"""The pair that other masters step: a free body that carries a forearm and takes its reaction.

Motion goes from the body to the anchor of the forearm, the reaction comes back. Acceleration is left out: it would
close an algebraic loop, which each master opens its own way. So the body's outputs depend on its state alone, two
passes through initialization settle all values, and every Jacobi master must give the same numbers: all step from t
with the values at t, then exchange. The step is a power of two, so that n * step is the same in any arithmetic.
"""

import numpy as np

from ulna import Scene

STEP = 1 / 128
STEPS = 64
BODY = {"initial_angular_velocity": (0.6, 1.0, 0.4), "mass": 5.0, "gravity": (0.0, 0.0, -1.0)}
ARM = {"initial_angle": 0.3, "target_angle": 1.0, "damping": 2.0}
TO_ARM = {
    "position": "anchor_position",
    "orientation": "anchor_orientation",
    "velocity": "anchor_velocity",
    "angular_velocity": "anchor_angular_velocity",
}
TO_BODY = {"reaction_force": "force", "reaction_torque": "torque"}
WATCHED = {"body": ("position", "orientation", "angular_momentum"), "arm": ("angle", "rate")}
"""States: also a master that reads outputs after the exchange gives the same numbers."""


def scene(version: str = "2.0") -> Scene:
    """The pair as a scene of our own master."""
    pair = Scene("pair")
    body = pair.add("RigidBody", "body", version=version, **BODY)
    arm = pair.add("HingedBody", "arm", version=version, **ARM)
    for source, target in TO_ARM.items():
        pair.connect(body[source], arm[target])
    for source, target in TO_BODY.items():
        pair.connect(arm[source], body[target])
    pair.record(*(pair[unit][variable] for unit, variables in WATCHED.items() for variable in variables))
    return pair


def our_rows(pair: Scene) -> np.ndarray:
    """Rows of what is watched, time first, by the master `jacobi`."""
    with pair:
        results = pair.run(STEPS * STEP, STEP, master="jacobi")
    names = [f"{unit}.{variable}" for unit, variables in WATCHED.items() for variable in variables]
    values = [np.asarray(results[name]).reshape(STEPS + 1, -1) for name in names]
    return np.column_stack([results.time, *values])


def elements(variable) -> list[str]:
    """Names of the scalars of a variable, as FMI 2 writes an array out."""
    if not variable.dimensions:
        return [variable.name]
    return [f"{variable.name}[{k + 1}]" for k in range(len(variable.references))]
