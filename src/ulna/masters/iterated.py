"""Iterated: a loop of units repeats each step until its inputs at the end of the step are what the sources put out.

Inputs are lines over the step with both ends right: order 2, and algebraic loops are solved. Plain iteration
contracts as long as the step is short for the stiffest coupling (two masses m1, m2 on a spring k: below
sqrt(6 m / k), m = m1 m2 / (m1 + m2)); where it contracts slowly or not at all it is relaxed by Aitken's rule, which
follows one mode of the error. Units of a loop must restore their state.
"""

from collections.abc import Callable

import numpy as np

from ..coupling import Coupling
from .blocks import Block, blocks_of

SLOW = 0.5
"""Contraction above which the iteration is relaxed."""
LEAST, LARGEST = 0.02, 1.0
"""Bounds of the relaxation: an estimate beyond says nothing of the mode that it follows."""
ADVICE = "take the master newton or a shorter step"


def prepare(coupling: Coupling, extrapolation: int) -> Callable[[float, float, float], None]:
    """The step of this master; lines go on through the last two steps for a first guess whatever `extrapolation`."""
    lines, blocks = blocks_of(coupling)
    coupling.figures["sweeps"] = 0
    relaxed = [(block, Relaxation(block)) for block in blocks]

    def step(time: float, step: float, end: float) -> None:
        lines.begin(time, step, end)
        for block, relaxation in relaxed:
            relaxation.restart()
            coupling.figures["sweeps"] += block.solve(relaxation, ADVICE)
        lines.finish()

    return step


class Relaxation:
    """The next guess of a fixed-point iteration: plain while it contracts, else by Aitken's rule.

    Kuettler and Wall, Comput. Mech. 43 (2008) 61, equation 44.
    """

    def __init__(self, block: Block):
        """For one block."""
        self._block = block
        self.restart()

    def restart(self) -> None:
        """Forgets the step before."""
        self._before: np.ndarray | None = None
        self._share = 1.0

    def __call__(self, guess: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Guess and residual, shape (n,), give the next guess."""
        scaled = residual / self._block.scale.updated()
        if self._before is not None:
            change = scaled - self._before
            if np.linalg.norm(scaled) > SLOW * np.linalg.norm(self._before) or self._share < 1.0:
                share = -self._share * (self._before @ change) / (change @ change)
                self._share = min(max(share, LEAST), LARGEST)
        self._before = scaled
        return guess + self._share * residual
