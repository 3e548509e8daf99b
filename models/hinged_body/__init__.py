"""HingedBody from the textbook."""

from .equations import SAMPLES, equations, symbols
from .identities import identities
from .steps import step_failures, step_identities

__all__ = ["SAMPLES", "equations", "identities", "step_failures", "step_identities", "symbols"]
