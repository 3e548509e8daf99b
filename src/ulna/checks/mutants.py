"""Mutants: the units broken on purpose, each in one place, to see that the checks find it: mutants/*.toml."""

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

FOLDER = Path(__file__).parent / "mutants"


@dataclass(frozen=True)
class Mutant:
    """One wrong line: `text` occurs once in `file`, one of the C files that the unit's FMU carries."""

    unit: str
    about: str
    file: str
    text: str
    replacement: str
    undeclared: bool = False
    """The C may be right, but does not depend on what its declaration says: held against itself, as built."""


@cache
def all_mutants() -> tuple[Mutant, ...]:
    """The table: each entry of a file is a mutant of each of its `units`."""
    entries = [
        entry
        for path in sorted(FOLDER.glob("*.toml"))
        for entry in tomllib.loads(path.read_text(encoding="utf-8"))["mutant"]
    ]
    return tuple(Mutant(unit, **entry) for entry in entries for unit in entry.pop("units"))
