"""RigidBody from the textbook."""

from .equations import SAMPLES, STATES, equations, symbols
from .identities import identities
from .solvers import CASES, KINDS, SOLVERS
from .steps import QUANTITIES, motion, point, poisson_residual, start, step_failures, step_identities

__all__ = [
    "CASES",
    "KINDS",
    "QUANTITIES",
    "SAMPLES",
    "SOLVERS",
    "STATES",
    "equations",
    "identities",
    "motion",
    "point",
    "poisson_residual",
    "start",
    "step_failures",
    "step_identities",
    "symbols",
]
