"""Newton: as `iterated`, but the ends of the inputs are found by Newton's method on the interface.

The Jacobian of a sweep is chained from the units: a unit without states gives it exactly by its directional
derivatives; of the others one step is repeated for each input. It is kept from step to step, corrected by Broyden's
update, and made anew where the residual falls too slowly. Converges where plain iteration does not; the step is then
bounded by accuracy alone.
"""

from collections.abc import Callable

import numpy as np

from ..coupling import Coupling
from .blocks import Block, blocks_of

SLOW = 0.5
"""Fall of the residual in one sweep above which the Jacobian no longer serves."""
CHANGED = 0.2
"""Relative change of the step length that asks for another Jacobian."""
NUDGE = 1e-6
"""Change of an input for a difference, over its scale."""
ADVICE = "take a shorter step"


def prepare(coupling: Coupling, extrapolation: int) -> Callable[[float, float, float], None]:
    """The step of this master; lines go on through the last two steps for a first guess whatever `extrapolation`."""
    lines, blocks = blocks_of(coupling)
    coupling.figures |= {"sweeps": 0, "jacobians": 0}
    solvers = [(block, Quasi(block) if block.late.size else None) for block in blocks]

    def step(time: float, step: float, end: float) -> None:
        lines.begin(time, step, end)
        for block, solver in solvers:
            if solver:
                solver.restart()
            coupling.figures["sweeps"] += block.solve(solver, ADVICE)
        lines.finish()

    return step


class Quasi:
    """The next guess by Newton's method with a Jacobian that is kept while it serves."""

    def __init__(self, block: Block):
        """For one block."""
        self._block = block
        self._inverse: np.ndarray | None = None
        self._step = 0.0
        self.restart()

    def restart(self) -> None:
        """Starts another step; the Jacobian stays."""
        self._last: tuple[np.ndarray, np.ndarray] | None = None
        step = self._block.lines.step
        if abs(step - self._step) > CHANGED * self._step:
            self._inverse, self._step = None, step

    def __call__(self, guess: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Guess and residual, shape (n,), give the next guess."""
        scale = self._block.scale.updated()
        r = residual / scale
        if self._last is not None and self._inverse is not None:
            move, before = self._last
            if np.linalg.norm(r) > SLOW * np.linalg.norm(before):
                self._inverse = None
            else:
                self._update(move, r - before)
        if self._inverse is None:
            self._inverse = np.linalg.inv(np.eye(r.size) - jacobian(self._block) * (scale / scale[:, None]))
            self._block.lines.coupling.figures["jacobians"] += 1
        move = self._inverse @ r
        self._last = move, r
        return guess + scale * move

    def _update(self, move: np.ndarray, change: np.ndarray) -> None:
        """Broyden's first update of the inverse of 1 - J."""
        along = move @ self._inverse
        size = along @ change
        if size != 0.0:
            self._inverse -= np.outer(move + self._inverse @ change, along) / size


def jacobian(block: Block) -> np.ndarray:
    """What is delivered for each unknown of the block by each unknown, shape (n, n), at the sweep just done."""
    lines, coupling = block.lines, block.lines.coupling
    outputs = coupling.outputs[np.dtype(np.float64)]
    targets, sources, factors = coupling.gather(block.units)
    late = np.isin(targets, block.late)
    by_inputs = np.zeros((lines.values.size, block.late.size))
    by_inputs[block.late] = np.eye(block.late.size)
    by_outputs = np.zeros((outputs.size, block.late.size))
    for part in block.parts:
        mine = np.arange(lines.values.size)[part.mine]
        fresh = ~late & np.isin(targets, mine)
        by_inputs[targets[fresh]] = factors[fresh, None] * by_outputs[sources[fresh]]
        taken = np.intersect1d(targets, mine)
        rows, response = sensitivity(block, part.units[0], taken)
        by_outputs[rows] = response @ by_inputs[taken]
    result = np.zeros((block.late.size, block.late.size))
    result[np.searchsorted(block.late, targets[late])] = factors[late, None] * by_outputs[sources[late]]
    return result


def sensitivity(block: Block, unit: str, taken: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places of the float64 outputs of a unit, and their change by the ends of the inputs at `taken`."""
    coupling = block.lines.coupling
    ends = coupling.float_outputs(unit)
    rows = np.concatenate([np.arange(place.start, place.stop) for _, place in ends])
    description = coupling.slaves[unit].description
    if description.stateless:
        return rows, _direct(coupling, unit, [end.variable.name for end, _ in ends], taken)
    return rows, _by_differences(block, unit, rows, taken)


def _direct(coupling: Coupling, unit: str, unknowns: list[str], taken: np.ndarray) -> np.ndarray:
    """By directional derivatives, which say all of a unit without states."""
    columns = []
    for end, place in coupling.float_inputs([unit]):
        for k in np.flatnonzero(np.isin(np.arange(place.start, place.stop), taken)):
            seed = np.zeros(place.stop - place.start)
            seed[k] = 1.0
            columns.append(coupling.slaves[unit].directional_derivative(unknowns, [end.variable.name], seed))
    return np.column_stack(columns)


def _by_differences(block: Block, unit: str, rows: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """By one repeated step for each input."""
    lines, coupling = block.lines, block.lines.coupling
    part = next(part for part in block.parts if part.units == [unit])
    _, restores = coupling.rollbacks([unit])
    outputs = coupling.outputs[np.dtype(np.float64)]
    values, end = outputs[rows].copy(), lines.end.copy()
    response = np.empty((rows.size, taken.size))
    for column, place in enumerate(taken):
        nudge = NUDGE * (1.0 + abs(end[place]))
        lines.end[place] = end[place] + nudge
        coupling.call(restores)
        part.advance()
        response[:, column] = (outputs[rows] - values) / nudge
        lines.end[place] = end[place]
    outputs[rows] = values
    return response
