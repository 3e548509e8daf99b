"""Initial values: outputs passed to inputs in initialization mode until nothing changes."""

import warnings
from collections.abc import Sequence

import numpy as np

from .coupling import Coupling
from .lines import late_connections
from .ordering import Loop

PASSES = 100
NEWTON_PASSES = 20
NUDGE = 1e-6
"""Change of an input for a difference, over 1 plus its value."""
SETTLED = 1e-13
"""Change of an input that is none, over 1 plus the largest."""


def settle(coupling: Coupling, start: float, algebraic: Sequence[Loop], *, newton: bool) -> int | None:
    """Passes outputs to inputs until nothing changes, then leaves initialization mode.

    Returns the number of passes: at most two without a loop, of which the second finds no change. An algebraic loop is
    solved by Newton's method if `newton`, and else by the passes alone: where those diverge it warns, with the loops at
    fault, and returns None.
    """
    coupling.time.value = start
    coupling.call(coupling.once())
    # Where a loop is opened, the first pass takes what the unit puts out for the start values of its own inputs.
    coupling.run(coupling.reading(), start)
    passes = _solved(coupling, start) if newton and algebraic else _settled_after(coupling, start)
    if passes is None:
        loops = "; ".join(map(str, algebraic))
        advice = "" if newton else "; the master newton solves them"
        warnings.warn(f"the initial values do not settle in {PASSES} passes: {loops}{advice}", stacklevel=4)
    for slave in coupling.slaves.values():
        slave.exit_initialization()
    coupling.run(coupling.reading(), start)
    return passes


def _settled_after(coupling: Coupling, start: float) -> int | None:
    """Number of passes, in the order of the dependencies, until one changes nothing; or at last round-off only."""
    stage = coupling.stage([[unit] for unit in coupling.order], step=False)
    for passes in range(1, PASSES + 1):
        before = coupling.snapshot()
        coupling.run(stage, start)
        if all(np.array_equal(*pair) for pair in zip(before, coupling.snapshot(), strict=True)):
            return passes
    same = all(np.allclose(*pair, rtol=SETTLED, atol=SETTLED) for pair in zip(before, coupling.snapshot(), strict=True))
    return PASSES if same else None


def _solved(coupling: Coupling, start: float) -> int | None:
    """Number of passes of Newton's method on the inputs that go against the order, float64 ones."""
    late = late_connections(coupling, [[unit] for unit in coupling.order])
    places = dict(coupling.float_inputs(coupling.units))
    torn = np.unique(
        np.concatenate([np.arange(places[c.target].start, places[c.target].stop) for c in late if c.target in places])
    )
    values = coupling.inputs[np.dtype(np.float64)]

    def delivered(guess: np.ndarray) -> np.ndarray:
        for unit in coupling.order:
            for move, arguments in coupling.transfers[unit]:
                move(*arguments)
            values[torn] = guess
            coupling.call([*coupling.sets([unit]), *coupling.gets([unit])])
        for unit in coupling.order:
            for move, arguments in coupling.transfers[unit]:
                move(*arguments)
        return values[torn].copy()

    for unit in coupling.order:
        for view, function in coupling.signals[unit]:
            view[...] = function(start)
    guess = delivered(values[torn].copy())
    for passes in range(1, NEWTON_PASSES + 1):
        residual = delivered(guess) - guess
        if not np.all(np.isfinite(residual)):
            return None
        if np.abs(residual).max() <= SETTLED * (1.0 + np.abs(guess).max()):
            return passes
        columns = []
        for k in range(torn.size):
            nudged = guess.copy()
            nudged[k] += NUDGE * (1.0 + abs(guess[k]))
            columns.append((delivered(nudged) - nudged - residual) / (nudged[k] - guess[k]))
        guess = guess - np.linalg.solve(np.column_stack(columns), residual)
    return None
