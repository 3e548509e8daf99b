"""RigidBody from the textbook."""

from .equations import SAMPLES, equations, symbols
from .identities import identities
from .steps import poisson_residual, step_failures, step_identities

__all__ = ["SAMPLES", "equations", "identities", "poisson_residual", "step_failures", "step_identities", "symbols"]
