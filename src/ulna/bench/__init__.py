"""Speed and accuracy, side by side in one run: `ulna bench NAME`, or `python -m ulna.bench NAME`.

Everything goes through the FMUs as a master would use them; each table prints ratios, since times belong to a machine.
"""

from collections.abc import Callable, Sequence
from importlib import import_module

from ..names import unknown
from .tables import Table, show

__all__ = ["ROUNDS", "SUBJECTS", "Table", "run", "show"]

ROUNDS = 101
"""Repeats of which the median counts."""

SUBJECTS = {
    "RigidBody": "rigid_body",
    "HingedBody": "hinged_body",
    "CompliantJoint": "compliant_joint",
    "ArmSkin": "arm_skin",
    "UltrasonicSensor": "ultrasonic_sensor",
    "masters": "masters",
}
"""Units, and the masters that step them, with the module that measures each."""


def run(names: Sequence[str] = (), rounds: int = ROUNDS) -> list[Table]:
    """The tables of these subjects, or of all.

    Raises KeyError with the nearest right names for a wrong one, FileNotFoundError where the FMUs are not built or a C
    compiler is missing, and ModuleNotFoundError, with the command that installs it, without SciPy.
    """
    tables = []
    for name in names or SUBJECTS:
        if name not in SUBJECTS:
            raise KeyError(unknown("ulna bench", "subject", name, SUBJECTS))
        bench: Callable[[int], list[Table]] = import_module(f".{SUBJECTS[name]}", __name__).bench
        tables += bench(rounds)
    return tables
