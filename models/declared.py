"""What a solver is declared to do: the form of the tables that `ulna check` holds each solver to."""

import math
from collections.abc import Mapping, Set
from dataclasses import dataclass

CHOSEN = None
"""An order that follows from the tolerance."""
EVERY = math.inf
"""All orders: the exact flow."""


@dataclass(frozen=True)
class Solver:
    """Order of one step by the kind of case, and the quantities that a step keeps; all others it is known to lose."""

    orders: Mapping[str, float | None]
    keeps: Set[str] = frozenset()
