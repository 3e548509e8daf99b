"""Coupled units that other masters step: a body that carries a forearm on a hinge, and two bodies on a compliant joint.

Motion goes from the bodies to what they carry, wrenches come back. Acceleration is left out: it would close an
algebraic loop, which each master opens its own way. So the bodies' outputs depend on their states alone, two passes
through initialization settle all values, and every Jacobi master must give the same numbers: all step from t with the
values at t, then exchange. Steps are powers of two and whole numbers of nanoseconds, so that n * step is the
same in any arithmetic.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from ulna import Scene

STEPS = 64


@dataclass(frozen=True)
class Coupled:
    """Units by the name of the instance, with their values; what goes where; what is compared."""

    step: float
    units: dict[str, tuple[str, dict]]
    connections: dict[tuple[str, str], dict[str, str]]
    """(source, target) -> output: input."""
    watched: dict[str, tuple[str, ...]]
    """States: also a master that reads outputs after the exchange gives the same numbers."""

    def pairs(self) -> Iterator[tuple[str, str, str, str]]:
        """Source, output, target and input of each connection."""
        for (source, target), ends in self.connections.items():
            for output, taker in ends.items():
                yield source, output, target, taker

    def scene(self, version: str = "2.0") -> Scene:
        """As a scene of our own master."""
        scene = Scene("coupled")
        for name, (unit, values) in self.units.items():
            scene.add(unit, name, version=version, **values)
        for source, output, target, taker in self.pairs():
            scene.connect(scene[source][output], scene[target][taker])
        scene.record(*(scene[unit][variable] for unit, variables in self.watched.items() for variable in variables))
        return scene

    def rows(self) -> np.ndarray:
        """Rows of what is watched, time first, by the master `jacobi`."""
        with self.scene() as scene:
            results = scene.run(STEPS * self.step, self.step, master="jacobi")
        names = [f"{unit}.{variable}" for unit, variables in self.watched.items() for variable in variables]
        values = [np.asarray(results[name]).reshape(STEPS + 1, -1) for name in names]
        return np.column_stack([results.time, *values])


def motion(frame: str, taker: str) -> dict[str, str]:
    """Of a frame of RigidBody, "" for its centre, to the inputs of a terminal."""
    place = f"{frame}_" if frame else ""
    return {
        f"{place}position": f"{taker}_position",
        "orientation": f"{taker}_orientation",
        f"{place}velocity": f"{taker}_velocity",
        "angular_velocity": f"{taker}_angular_velocity",
    }


BODY = {"initial_angular_velocity": (0.6, 1.0, 0.4), "mass": 5.0, "gravity": (0.0, 0.0, -1.0)}
HINGED = Coupled(
    step=1 / 128,
    units={
        "body": ("RigidBody", BODY),
        "arm": ("HingedBody", {"initial_angle": 0.3, "target_angle": 1.0, "damping": 2.0}),
    },
    connections={
        ("body", "arm"): motion("", "anchor"),
        ("arm", "body"): {"reaction_force": "force", "reaction_torque": "torque"},
    },
    watched={"body": ("position", "orientation", "angular_momentum"), "arm": ("angle", "rate")},
)
UPPER = {"mass": 1.9, "inertia": (0.0038, 0.0135, 0.0145), "tip": (0.15, 0.0, 0.0)}
FORE = {"mass": 1.561, "inertia": (0.001664, 0.020226, 0.021105), "base": (-0.179, 0.0, 0.0)}
SOFT = {"stiffness": 5e3, "damping": 50.0, "angular_stiffness": 25.0, "angular_damping": 0.25, "friction": 0.1}
COMPLIANT = Coupled(
    step=1 / 512,
    units={
        "upper": ("RigidBody", UPPER | {"initial_angular_velocity": (0.5, -2.0, 0.7)}),
        "fore": ("RigidBody", FORE | {"initial_position": (0.329, 0.0, 0.0), "initial_velocity": (0.0, 0.2, 0.4)}),
        "elbow": ("CompliantJoint", SOFT),
    },
    connections={
        ("upper", "elbow"): motion("tip", "first"),
        ("fore", "elbow"): motion("base", "second"),
        ("elbow", "upper"): {"first_force": "tip_force", "first_torque": "tip_torque"},
        ("elbow", "fore"): {"second_force": "base_force", "second_torque": "base_torque"},
    },
    watched=dict.fromkeys(("upper", "fore"), ("position", "orientation", "angular_momentum")),
)

each_coupled = pytest.mark.parametrize("coupled", [HINGED, COMPLIANT], ids=["hinged", "compliant"])


def elements(variable) -> list[str]:
    """Names of the scalars of a variable, as FMI 2 writes an array out."""
    if not variable.dimensions:
        return [variable.name]
    return [f"{variable.name}[{k + 1}]" for k in range(len(variable.references))]
