"""Watches a run for what the coupling itself does wrong, from the rows that are recorded anyway.

Two estimates, both after the fact. Inputs: how far what a unit was told its input would be lies from what the source
put out in the end. Energy: over each bond, a frame that gives its motion and takes a wrench, the work of the wrench as
it was held, less the work of the wrench as it should have been, at both ends. A stable run may be wrong: the energy
tells.

The second goes back to Sadjina, Kyllingstad, Skjong and Pedersen, Eng. with Computers 33 (2017) 607, who take the
difference of the powers that both sides are told of. A wrench that follows directly from the motion, as a spring's
does, is read once more when the step begins: its delay is what makes a stiff coupling gain or lose energy.
"""

import warnings

import numpy as np

from .connections import Bond, Connection, End
from .coupling import Coupling

SHARE = 0.01
"""Of the energy of the system: what the coupling may gain or lose before the run is called wrong."""
CHORD = 1.0 / 12.0
"""Mean distance of a parabola from its chord over a step, over its second difference."""
REMEMBERED = 3
"""Rows that go before the next ones: two that make a line, and one for a delay."""
FLOAT64 = np.dtype(np.float64)


class CouplingWarning(UserWarning):
    """The coupling, not the units, makes this run wrong."""


class Watch:
    """Sums up over the rows of a run; `review` takes each row once, when it and its successors are there."""

    def __init__(self, coupling: Coupling):
        """For a coupling that a master has made ready."""
        self._coupling, self._lines = coupling, coupling.lines
        watched = [c for c in coupling.connections if not c.whole and _is_float64(coupling, c)]
        self._names = [str(connection) for connection in watched]
        columns = [np.arange(*coupling.place(c.source)[1:]) for c in watched]
        self._columns = np.concatenate([np.zeros(0, int), *columns])
        factors = [np.full(len(k), c.factor) for k, c in zip(columns, watched, strict=True)]
        self._factors = np.concatenate([np.zeros(0), *factors])
        self._firsts = np.cumsum([0, *(len(k) for k in columns)])[:-1]
        self._nominals = np.array([c.target.variable.nominal for c in watched])
        certain = CHORD if self._lines else 1.0
        self._weights = np.array([1.0 if c in coupling.late else certain for c in watched])
        self._sizes = self._nominals.copy()
        self._bonds = [_Bond(coupling, bond) for bond in coupling.bonds]
        self._rows, self._times = np.zeros((0, _size(coupling.outputs))), np.zeros(0)
        self._probes = np.zeros((0, _size(coupling.probed)))
        self.energy = 0.0
        """J that the coupling has put into the units it joins."""
        self._throughput = 0.0
        self._kinetic, self._potential = 0.0, np.array([np.inf, -np.inf])
        self._warned = False
        self.worst = 0.0, "", 0.0
        """Largest error of an input, over its nominal plus its largest value; the connection; the time."""

    def step_error(self, rows: np.ndarray, times: np.ndarray) -> float:
        """The largest error of an input in the last step of these rows, up to three, as `worst` has it.

        `rows` has shape (k, n), outputs at `times`, shape (k,).
        """
        errors = self._input_errors(rows, times)
        return float(errors[-1].max()) if errors.size else 0.0

    def review(self, rows: np.ndarray, probes: np.ndarray, times: np.ndarray) -> None:
        """Takes the next rows of a run, shapes (k, n), (k, p) and (k,); warns once if the energy says that it is wrong.

        `probes` are the wrenches at the begin of the step to each row.
        """
        known = len(self._times)
        rows, times = np.vstack([self._rows, rows]), np.append(self._times, times)
        probes = np.vstack([self._probes, probes])
        if len(times) > 1:
            errors = self._input_errors(rows, times)[max(known - 1, 0) :]
            if errors.size and (largest := float(errors.max())) > self.worst[0]:
                step, connection = np.unravel_index(np.argmax(errors), errors.shape)
                time = times[max(known - 1, 0) + 1 + step]
                self.worst = largest, self._names[connection], float(time)
            self._review_energy(rows, probes, times, known)
        self._rows, self._probes = rows[-REMEMBERED:].copy(), probes[-REMEMBERED:].copy()
        self._times = times[-REMEMBERED:].copy()

    def _input_errors(self, rows: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Shape (steps, connections)."""
        if not self._firsts.size:
            return np.zeros((0, 0))
        values = rows[:, self._columns] * self._factors
        sizes = np.maximum.reduceat(np.abs(values).max(axis=0), self._firsts)
        np.maximum(self._sizes, self._nominals + sizes, out=self._sizes)
        changes = np.diff(values, axis=0)
        if self._lines:
            ratios = np.diff(times)[1:] / np.diff(times)[:-1]
            changes[1:] -= ratios[:, None] * (values[1:-1] - values[:-2])
        errors = np.maximum.reduceat(np.abs(changes), self._firsts, axis=1)
        return errors * self._weights / self._sizes

    def _review_energy(self, rows: np.ndarray, probes: np.ndarray, times: np.ndarray, known: int) -> None:
        if not self._bonds:
            return
        for bond in self._bonds:
            gained, through = bond.review(rows, probes, times, known)
            self.energy += gained
            self._throughput += through
        new = rows[known:]
        if self._coupling.kinetic:
            self._kinetic = max(self._kinetic, float(_sum(self._coupling, self._coupling.kinetic, new).max()))
        if self._coupling.potential:
            potential = _sum(self._coupling, self._coupling.potential, new)
            self._potential[:] = min(self._potential[0], potential.min()), max(self._potential[1], potential.max())
        if not self._warned and self.wrong:
            self._warned = True
            what = "gained" if self.energy > 0.0 else "lost"
            warnings.warn(
                f"by t = {times[-1]:.4g} s the coupling has {what} {abs(self.energy):.3g} J, more than {SHARE:.0%} of "
                f"the {self.system_energy:.3g} J of the system: the run is wrong, stable or not; take a shorter step, "
                "or the master newton, or a rigid joint",
                CouplingWarning,
                stacklevel=2,
            )

    @property
    def system_energy(self) -> float:
        """J: the largest kinetic energy and the range of the potential one; without these, what went over the bonds."""
        known = self._kinetic + max(0.0, float(self._potential[1] - self._potential[0]))
        return known if known > 0.0 else self._throughput

    @property
    def wrong(self) -> bool:
        """Whether the coupling has changed the energy by more than its share at any time."""
        return self._warned or abs(self.energy) > SHARE * self.system_energy > 0.0

    def figures(self) -> dict[str, float | str | bool]:
        """For the summary."""
        found: dict[str, float | str | bool] = {}
        if self._names:
            found |= {"input_error": self.worst[0], "input_error_at": self.worst[1]}
        if self._bonds:
            found |= {"coupling_energy": self.energy, "system_energy": self.system_energy, "wrong": self.wrong}
        return found


class _Bond:
    """The energy of one bond, step by step, from the wrench F as it is read at the ends of steps.

    The unit that gives the motion is told of F as `held`. The one that gives the wrench feels, over the step, what goes
    from its wrench when the step begins to F at the end, and should feel what goes from one right wrench to the next.
    """

    def __init__(self, coupling: Coupling, bond: Bond):
        """`coupling` as a master has made it ready."""
        self._lines = coupling.lines
        self._members = [
            (
                slice(*coupling.place(wrench.source)[1:]),
                wrench in coupling.late,
                coupling.probe(wrench.source),
                slice(*coupling.place(motion.source)[1:]),
            )
            for wrench, motion in bond.members
        ]
        # inputs that come late make F at the end of a step one of the motion at its begin
        self._stale = any(motion in coupling.late for _, motion in bond.members)
        self._reacts = bond.members[0][0].source.unit.slave.description.has_states

    def review(self, rows: np.ndarray, probes: np.ndarray, times: np.ndarray, known: int) -> tuple[float, float]:
        """Energy gained, and energy passed on, in the steps that are complete now; of the rows `known` are not new.

        A step is complete when the next one has begun.
        """
        begin, end = max(known - 2, 0), len(times) - 2
        if end <= begin:
            return 0.0, 0.0
        first = max(begin - 1, 0)
        lengths = np.diff(times)[first : end + 1, None]
        done = lengths[:-1]
        gained = through = 0.0
        for columns, late, probe, motion in self._members:
            read, v = rows[first : end + 2, columns], rows[first : end + 2, motion]
            begun = read if probe is None else _continued(probes[first + 1 : end + 2, probe])
            right = begun if self._stale else read
            # motion is a parabola in a step where forces are lines
            speed = _mean(v, lengths)[:-1] if self._lines else _chord(v)[:-1]
            held, rise = self._held(read[:-1], late, done)
            work = held * speed + CHORD * rise * np.diff(v, axis=0)[:-1]
            due = _mean(right, lengths)[:-1] * speed + CHORD * (np.diff(right, axis=0) * np.diff(v, axis=0))[:-1]
            error = work - due
            if self._reacts and not self._lines:
                error -= 0.5 * ((begun - right)[:-2] + (read - right)[1:-1]) * speed
            gained += float((error * done)[begin - first :].sum())
            through += float(np.abs((work * done)[begin - first :].sum(axis=1)).sum())
        return gained, through

    def _held(self, values: np.ndarray, late: bool, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What a unit was told of these values over each step: mean, and rise from begin to end."""
        change = np.diff(values, axis=0)
        if not self._lines:
            return values[:-1] if late else values[1:], np.zeros_like(change)
        if not late:
            return _chord(values), change
        rise = np.zeros_like(change)
        rise[1:] = lengths[1:] / lengths[:-1] * change[:-1]
        return values[:-1] + 0.5 * rise, rise


def _continued(values: np.ndarray) -> np.ndarray:
    """With one row more, on the line through the last two."""
    return np.vstack([values, 2.0 * values[-1] - values[max(len(values) - 2, 0)]])


def _chord(values: np.ndarray) -> np.ndarray:
    """Means over steps of what is a line in each."""
    return 0.5 * (values[1:] + values[:-1])


def _mean(values: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Means over steps of what is smooth from step to step: the chord, less what the curvature at both ends says."""
    slopes = np.diff(values, axis=0) / lengths
    curvature = np.zeros_like(values)
    curvature[1:-1] = 2.0 * np.diff(slopes, axis=0) / (lengths[1:] + lengths[:-1])
    if len(values) > 2:
        curvature[0], curvature[-1] = curvature[1], curvature[-2]
    return _chord(values) - CHORD * lengths**2 * _chord(curvature)


def _size(arrays: dict[np.dtype, np.ndarray]) -> int:
    return arrays[FLOAT64].size if FLOAT64 in arrays else 0


def _sum(coupling: Coupling, ends: list[End], rows: np.ndarray) -> np.ndarray:
    return sum(rows[:, coupling.place(end)[1]] for end in ends)


def _is_float64(coupling: Coupling, connection: Connection) -> bool:
    return coupling.place(connection.source)[0] == FLOAT64 == coupling.input(connection.target).dtype
