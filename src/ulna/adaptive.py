"""The macro step chosen by the coupling error: steps that err too much are taken back and made shorter.

A proportional-integral controller (Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533) on the error of the inputs that
`watch` estimates. Steps end at the times of the rows, so that no row is interpolated.
"""

import math
from collections.abc import Callable

import numpy as np

from .coupling import Coupling, CouplingError
from .slave import UnitError
from .watch import FLOAT64, Watch

Step = Callable[[float, float, float], None]

SAFETY, LEAST, LARGEST = 0.9, 0.2, 3.0
"""Of the change of the step from one to the next."""
PROPORTIONAL, INTEGRAL = 0.4, 0.3
FIRST = 0.01
"""The first step, over the distance of the rows."""
STUBBORN = 0.5
"""Share of an error that is left by a shorter step, where it is not that step's."""
NEGLIGIBLE = 1e-4
"""Error over the tolerance below which it says nothing of the next step."""
SHORTEST = 1e-9
"""Of a step, over the distance of the rows."""


class Controlled:
    """A master's step as a step from row to row, in as many pieces as the tolerance asks for."""

    def __init__(self, coupling: Coupling, advance: Step, watch: Watch, tolerance: float, order: int):
        """`order` is that of the master. Raises ValueError if a unit cannot save its state."""
        self._coupling, self._advance, self._watch = coupling, advance, watch
        self._tolerance, self._order = tolerance, order
        self._saves, self._restores = coupling.rollbacks(coupling.units)
        self._length, self._error = 0.0, 1.0
        self._failure: Exception | None = None
        self._rows, self._probes = [self._row()], [self._probe()]
        self._times = [coupling.time.value]
        self._new = 1
        """How many of these the watch has not seen."""
        coupling.figures |= {"macro_steps": 0, "repeated_steps": 0, "shortest_step": np.inf}

    def __call__(self, begin: float, step: float, end: float) -> None:
        """From one row to the next; raises CouplingError where the step that the tolerance asks for is too short."""
        figures, now, rejected = self._coupling.figures, begin, np.inf
        self._length = min(self._length or FIRST * step, step)
        while now < end:
            left = end - now
            pieces = max(1, math.ceil(left / self._length * (1.0 - 1e-9)))
            after = end if pieces == 1 else now + left / pieces
            length, kept = after - now, self._save()
            error = self._try(now, after)
            # what a shorter step hardly makes smaller is a jump, or the fault of the step before
            if error <= 1.0 or STUBBORN * rejected < error < np.inf:
                self._keep(after)
                figures["macro_steps"] += 1
                figures["shortest_step"] = min(figures["shortest_step"], length)
                # a step that was cut to meet a row stands for the longer one, with the error of that
                longer = max(self._length / length, 1.0)
                self._length = length * longer * self._change(error * longer**self._order)
                now, rejected = after, np.inf
                continue
            figures["repeated_steps"] += 1
            self._restore(kept)
            self._length, rejected = length * max(LEAST, SAFETY * error ** (-1.0 / self._order)), error
            if self._length < SHORTEST * step:
                raise CouplingError(
                    f"at t = {now:.9g} s no step above {SHORTEST * step:.3g} s can be taken: {self._failure}"
                ) from self._failure
        self._report()

    def _try(self, now: float, after: float) -> float:
        """Takes a step and returns its error over the tolerance."""
        try:
            self._advance(now, after - now, after)
        except (CouplingError, UnitError) as error:
            if isinstance(error, UnitError) and error.status == "fatal":
                raise
            self._failure = error
            return np.inf
        rows, times = np.array([*self._rows[-2:], self._row()]), np.array([*self._times[-2:], after])
        return max(self._watch.step_error(rows, times), self._coupling.own_error) / self._tolerance

    def _keep(self, time: float) -> None:
        """Remembers the row of a step that counts."""
        self._rows.append(self._row())
        self._probes.append(self._probe())
        self._times.append(time)
        self._new += 1

    def _change(self, error: float) -> float:
        """Factor of the step for the next one."""
        error, before = max(error, NEGLIGIBLE), self._error
        self._error = error
        change = SAFETY * error ** (-(PROPORTIONAL + INTEGRAL) / self._order)
        return min(LARGEST, max(LEAST, change * before ** (PROPORTIONAL / self._order)))

    def _report(self) -> None:
        """Shows the watch the rows of the steps that count."""
        new = slice(len(self._rows) - self._new, None)
        self._watch.review(np.array(self._rows[new]), np.array(self._probes[new]), np.array(self._times[new]))
        self._new = 0
        del self._rows[:-2], self._probes[:-2], self._times[:-2]

    def _row(self) -> np.ndarray:
        return self._coupling.outputs.get(FLOAT64, np.zeros(0)).copy()

    def _probe(self) -> np.ndarray:
        return self._coupling.probed.get(FLOAT64, np.zeros(0)).copy()

    def _save(self) -> list[np.ndarray]:
        self._coupling.call(self._saves)
        return [array.copy() for array in self._arrays()]

    def _restore(self, kept: list[np.ndarray]) -> None:
        self._coupling.call(self._restores)
        for array, value in zip(self._arrays(), kept, strict=True):
            array[:] = value

    def _arrays(self) -> list[np.ndarray]:
        coupling = self._coupling
        return [*coupling.outputs.values(), *coupling.inputs.values(), *coupling.arrays.buffers, *coupling.memory]
