"""Units in a loop that repeat a step until what they put out is what they took: shared by `iterated` and `newton`.

The unknowns are the ends of those lines that go against the order of the units. A sweep through the block, in order,
turns a guess of them into what is delivered; the residual is the difference.
"""

from collections.abc import Callable, Sequence

import numpy as np

from ..coupling import Coupling, CouplingError
from ..lines import Lines, Part
from ..ordering import step_blocks

ACCURACY = 1e-10
"""Residual that counts as none, over the sum of a variable's nominal and its largest value so far."""
MOST_SWEEPS = 60


class Block:
    """A loop of units, or a single unit without one."""

    def __init__(self, lines: Lines, parts: Sequence[Part]):
        """Takes the parts of the lines that belong to the block, one unit each; raises ValueError if one of a loop
        cannot save its state."""
        self.lines, self.parts = lines, list(parts)
        self.units = [unit for part in parts for unit in part.units]
        inside = lines.coupling.gather(self.units)[0]
        self.late = np.intersect1d(lines.late, inside)
        """Places of the unknowns in the lines."""
        self.saves, self.restores = lines.coupling.rollbacks(self.units) if self.late.size else ([], [])
        self.scale = _Scale(lines, self.late)

    def sweep(self) -> None:
        """All units once, in order."""
        for part in self.parts:
            part.take()
            part.advance()

    def residual(self, guess: np.ndarray) -> np.ndarray:
        """What is delivered for a guess of the unknowns, less the guess; the units are then at the end of the step."""
        self.lines.end[self.late] = guess
        self.sweep()
        return self.lines.delivered()[self.late] - guess

    def solve(self, improve: Callable[[np.ndarray, np.ndarray], np.ndarray], advice: str) -> int:
        """Sweeps until the residual is none; `improve(guess, residual)` gives the next guess.

        Returns the number of sweeps; raises CouplingError.
        """
        call = self.lines.coupling.call
        if not self.late.size:
            self.sweep()
            return 1
        call(self.saves)
        guess = self.lines.end[self.late]
        allowed = ACCURACY * self.scale.updated()
        for sweeps in range(1, MOST_SWEEPS + 1):
            residual = self.residual(guess)
            if np.all(np.abs(residual) <= allowed):
                return sweeps
            if not np.all(np.isfinite(residual)):
                break
            guess = improve(guess, residual)
            call(self.restores)
        raise not_settled(self.units, self.lines, sweeps, advice)


def not_settled(units: Sequence[str], lines: Lines, sweeps: int, advice: str) -> CouplingError:
    """The error of a loop that does not settle."""
    return CouplingError(
        f"{', '.join(units)} do not settle in {sweeps} sweeps at t = {lines.coupling.time.value:.9g} s with a step of "
        f"{lines.step:.3g} s: {advice}"
    )


class _Scale:
    """The size of each unknown: the nominal of its variable plus the largest value that any element of it had."""

    def __init__(self, lines: Lines, places: np.ndarray):
        ends = [(end, place) for end, place in lines.coupling.float_inputs(lines.coupling.units)]
        kept = [(end, place) for end, place in ends if np.isin(place.start, places)]
        self._places, self._lines = places, lines
        self._firsts = np.searchsorted(places, [place.start for _, place in kept])
        self._sizes = [place.stop - place.start for _, place in kept]
        self._nominals = np.array([end.variable.nominal for end, _ in kept])
        self._largest = np.zeros(len(kept))

    def updated(self) -> np.ndarray:
        """One number for each unknown, with the values at the start of this step taken in."""
        values = np.maximum.reduceat(np.abs(self._lines.start[self._places]), self._firsts)
        np.maximum(self._largest, values, out=self._largest)
        return np.repeat(self._nominals + self._largest, self._sizes)


def blocks_of(coupling: Coupling) -> tuple[Lines, list[Block]]:
    """The lines of a scene, and its blocks in the order in which they are stepped."""
    groups = step_blocks(coupling.units, coupling.connections)
    lines = Lines(coupling, [[unit] for group in groups for unit in group])
    coupling.late = frozenset()
    parts = iter(lines.parts)
    return lines, [Block(lines, [next(parts) for _ in group]) for group in groups]
