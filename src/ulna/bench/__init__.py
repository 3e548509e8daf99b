"""Speed and accuracy of the units, side by side in one run: `ulna bench UNIT`, or `python -m ulna.bench UNIT`.

Everything goes through the FMUs as a master would use them; each table prints ratios, since times belong to a machine.
"""

from collections.abc import Callable, Sequence
from importlib import import_module

from ..names import unknown
from .tables import Table, show

__all__ = ["ROUNDS", "UNITS", "Table", "run", "show"]

ROUNDS = 101
"""Repeats of which the median counts."""

UNITS = {
    "RigidBody": "rigid_body",
    "HingedBody": "hinged_body",
    "CompliantJoint": "compliant_joint",
    "ArmSkin": "arm_skin",
    "UltrasonicSensor": "ultrasonic_sensor",
}


def run(unit_names: Sequence[str] = (), rounds: int = ROUNDS) -> list[Table]:
    """The tables of these units, or of all.

    Raises KeyError with the nearest right names for a wrong one, FileNotFoundError where the FMUs are not built, and
    ModuleNotFoundError, with the command that installs it, without SciPy.
    """
    tables = []
    for name in unit_names or UNITS:
        if name not in UNITS:
            raise KeyError(unknown("ulna bench", "unit", name, UNITS))
        bench: Callable[[int], list[Table]] = import_module(f".{UNITS[name]}", __name__).bench
        tables += bench(rounds)
    return tables
