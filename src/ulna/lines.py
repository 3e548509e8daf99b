"""Inputs as straight lines over a step: what all masters share that look ahead or repeat steps.

A line starts at what the sources put out at the begin of the step. It ends at what they put out at the end where that
is known already, at the signal's value there, or else at a guess: the line through the last two steps, which a master
may improve. Units take the slope through `slopes`. One that takes it of some inputs only is given the others as they
are at the begin: it continues them by those, as HingedBody its anchor's motion; so is one that samples at events, or
has no states. Any other that takes no slope makes two half steps, each with a constant; if it cannot, it is given the
mean.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from .connections import Connection
from .coupling import Coupling

EARLY = (5.0 / 6.0, 1.0 / 6.0)
"""Shares of begin and end in the first of two constants that have the line's mean and its first moment."""


class Part:
    """Units that take a step at the same time, each with its lines."""

    def __init__(self, lines: "Lines", units: Sequence[str]):
        """Its units in the order of their calls."""
        coupling = lines.coupling
        self.lines, self.units = lines, list(units)
        self.transfers = [move for name in units for move in coupling.transfers[name]]
        mine = _indices(place for _, place in coupling.float_inputs(units))
        self.mine = as_slice(mine)
        self.fresh = np.intersect1d(np.setdiff1d(lines.connected, lines.late), mine)
        told = [name for name in units if coupling.float_inputs([name])]
        known = {name: coupling.slaves[name].description for name in told}
        told = [name for name in told if not (known[name].sampled or known[name].stateless)]
        slopeless = [name for name in told if not coupling.slopes([name]).calls]
        halved = [name for name in slopeless if known[name].variable_step]
        whole = [name for name in units if name not in halved]
        self.slopes = coupling.slopes(whole)
        self.held = _indices(place for _, place in coupling.float_inputs([n for n in slopeless if n not in halved]))
        self.sets, self.steps = coupling.sets(whole), coupling.steps(whole)
        self.halves = [(coupling.sets([name]), coupling.steps([name])) for name in units if name in halved]
        self.probes = coupling.probes(units)
        self.settings = coupling.sets([name for name in units if coupling.feeds_through(name)])
        self.gets = coupling.gets(units)

    def take(self) -> None:
        """Ends the lines at what the units before have put out."""
        for move, arguments in self.transfers:
            move(*arguments)
        if self.fresh.size:
            self.lines.end[self.fresh] = self.lines.values[self.fresh]

    def advance(self) -> None:
        """Takes the step along the lines and leaves the outputs at its end in the coupling."""
        lines, call = self.lines, self.lines.coupling.call
        values, start, end = lines.values, lines.start, lines.end
        values[self.mine] = start[self.mine]
        if self.held.size:
            values[self.held] = 0.5 * (start[self.held] + end[self.held])
        slopes = self.slopes
        if slopes.values.size:
            np.divide((end - start)[slopes.places], lines.step, out=slopes.values)
        call(self.sets)
        call(slopes.calls)
        call(self.probes)
        call(self.steps)
        if self.halves:
            self._halve()
        values[self.mine] = end[self.mine]
        call(self.settings)
        call(self.gets)

    def _halve(self) -> None:
        lines, coupling = self.lines, self.lines.coupling
        time, step = coupling.time.value, coupling.step.value
        coupling.step.value = 0.5 * step
        for half, (first, last) in enumerate((EARLY, EARLY[::-1])):
            coupling.time.value = time + 0.5 * half * step
            lines.values[self.mine] = first * lines.start[self.mine] + last * lines.end[self.mine]
            for sets, steps in self.halves:
                coupling.call(sets)
                coupling.call(steps)
        coupling.time.value, coupling.step.value = time, step


class Lines:
    """The float64 inputs of a scene as lines, flat, in the order of `coupling.inputs`."""

    def __init__(self, coupling: Coupling, groups: Sequence[Sequence[str]]):
        """`groups` of units are stepped one after the other, the units of a group at once."""
        self.coupling = coupling
        self.values = coupling.inputs.get(np.dtype(np.float64), np.zeros(0))
        self.start, self.end, self.before = (np.zeros_like(self.values) for _ in range(3))
        self.step = 0.0
        self.steps_before = np.zeros(1)
        """Length of the step before, s; 0 when there was none."""
        coupling.late, coupling.lines = late_connections(coupling, groups), True
        places = dict(coupling.float_inputs(coupling.units))
        connected = [(c, places[c.target]) for c in coupling.connections if c.target in places]
        self.connected = _indices(place for _, place in connected)
        self.late = _indices(place for c, place in connected if c in coupling.late)
        """Inputs that connections drive, and those among them whose source is not stepped before their unit."""
        self.parts = [Part(self, group) for group in groups]
        coupling.memory += [self.before, self.steps_before, self.values]
        self._moves = [move for name in coupling.units for move in coupling.transfers[name]]
        watched = [pair for name in coupling.units for pair in coupling.signals[name]]
        self._signals = [(_same_place(view, self), view, function) for view, function in watched]

    def begin(self, time: float, step: float, end: float) -> None:
        """Starts a step: the lines' starts, and their ends as far as they are known or guessed."""
        self.coupling.time.value, self.coupling.step.value, self.step = time, step, step
        for _, view, function in self._signals:
            view[...] = function(time)
        for move, arguments in self._moves:
            move(*arguments)
        self.start[:] = self.values
        ratio = step / self.steps_before[0] if self.steps_before[0] else 0.0
        np.multiply(self.start - self.before, ratio, out=self.end)
        self.end += self.start
        for ending, _, function in self._signals:
            if ending is not None:
                ending[...] = function(end)

    def sweep(self) -> None:
        """Steps all units, group by group."""
        for part in self.parts:
            part.take()
            part.advance()

    def delivered(self) -> np.ndarray:
        """What the sources put out now for all inputs, in place of the guesses, shape of `values`."""
        for move, arguments in self._moves:
            move(*arguments)
        return self.values

    def finish(self) -> None:
        """Ends a step that counts."""
        self.before[:] = self.start
        self.steps_before[0] = self.step


def late_connections(coupling: Coupling, groups: Sequence[Sequence[str]]) -> frozenset[Connection]:
    """Those whose source is not stepped before the unit that takes them."""
    number = {name: k for k, group in enumerate(groups) for name in group}
    return frozenset(c for c in coupling.connections if number[c.source.unit.name] >= number[c.target.unit.name])


def as_slice(indices: np.ndarray) -> np.ndarray | slice:
    """A slice where the indices are a run: it costs a fifth."""
    run = indices.size and np.array_equal(indices, np.arange(indices[0], indices[0] + indices.size))
    return slice(int(indices[0]), int(indices[-1]) + 1) if run else indices


def _same_place(view: np.ndarray, lines: Lines) -> np.ndarray | None:
    """The part of `lines.end` where a view of `lines.values` lies; None for a view of another array."""
    if view.dtype != np.float64:
        return None
    first = (view.__array_interface__["data"][0] - lines.values.__array_interface__["data"][0]) // view.itemsize
    return lines.end[first : first + view.size].reshape(view.shape)


def _indices(places: Iterable[slice | np.ndarray]) -> np.ndarray:
    parts = [np.arange(p.start, p.stop) if isinstance(p, slice) else p for p in places]
    return np.concatenate(parts) if parts else np.zeros(0, int)
