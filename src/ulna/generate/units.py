"""SI units as exponents of the base units, read from their spelling.

A unit is spelled as FMI's examples do: symbols joined by dots, exponents as trailing digits, at most
one slash: ``kg.m2``, ``N.m/s``. Every symbol here has factor one and offset zero.
"""

import re

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

_SYMBOLS: dict[str, dict[str, int]] = {
    "1": {},
    "kg": {"kg": 1},
    "m": {"m": 1},
    "s": {"s": 1},
    "K": {"K": 1},
    "rad": {"rad": 1},
    "Hz": {"s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "dB": {},
}


def exponents(unit: str) -> dict[str, int]:
    """Exponents of the SI base units in `unit`, those that are not zero.

    Raises ValueError when a symbol is unknown or the spelling is not `a.b2/c.d`.
    """
    total = dict.fromkeys(BASE, 0)
    parts = unit.split("/")
    if len(parts) > 2:
        raise ValueError(f"unit {unit!r} has more than one slash")
    for sign, part in zip((1, -1), parts, strict=False):
        for factor in part.split("."):
            match = re.fullmatch(r"(1|[A-Za-z]+)(\d*)", factor)
            if not match or match[1] not in _SYMBOLS:
                raise ValueError(f"unit {unit!r}: unknown symbol {factor!r}; known: {', '.join(_SYMBOLS)}")
            for base, power in _SYMBOLS[match[1]].items():
                total[base] += sign * power * int(match[2] or 1)
    return {base: power for base, power in total.items() if power}


_PER_SECOND = {
    "m": "m/s",
    "m/s": "m/s2",
    "m/s2": "m/s3",
    "rad": "rad/s",
    "rad/s": "rad/s2",
    "rad/s2": "rad/s3",
    "1": "1/s",
    "kg.m/s": "N",
    "kg.m2/s": "N.m",
}


def per_second(unit: str) -> str:
    """The unit of the time derivative of a quantity in `unit`."""
    if unit in _PER_SECOND:
        return _PER_SECOND[unit]
    if "/" in unit:
        raise ValueError(f"no spelling known for ({unit})/s: add it to the table")
    return f"{unit}/s"
