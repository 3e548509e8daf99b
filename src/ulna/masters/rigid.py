"""Rigid: joints without stiffness between units that take a wrench and give a frame.

The wrench of a joint is a line in time over the step. Its two ends close the gaps of position and of velocity at the
end of the step, by Newton's method with repeated steps: order 4 in the step, and gaps at round-off. The response of a
frame to a wrench is measured once, in the axes of the frame, and then turned with it.

The joined units step first, and the others after them, as in Gauss-Seidel with extrapolation.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from ..coupling import Coupling
from ..lines import Lines
from ..ordering import step_order
from .blocks import not_settled
from .joint_state import JointState
from .joint_wrench import UNKNOWNS, Start, residual, wrench_lines
from .mobility import Mobility

MEETING = 1e-9
"""m, rad, m/s, rad/s that frames may be apart at the start."""
CLOSED = 1e-13
"""Gap that counts as none, over 1 m (or rad) plus the distance from the origin; and the same of velocities."""
MOST_SWEEPS = 30
TRIAL = 0.1
"""Length of the step that finds the first wrenches, over that of the run's."""
SLOW = 12
"""Sweeps of a step after which the mobility is measured again: it has changed, as that of a hinged body may."""
REMEMBERED = 5
"""Steps from which the next wrenches are guessed."""
OF_GAPS = np.array([[[1 / 3], [1 / 6]], [[1 / 2], [1 / 2]]])
"""Of the accelerations at begin and end in the gaps in place and in velocity, over step^2."""
OF_RATES = np.array([[[1 / 12], [-1 / 12]], [[7 / 12], [5 / 12]]])
"""The same in the lines of the relative rates, at begin and at end."""
SINGULAR = 1e-8
"""Ratio of singular values below which joints are redundant: the mobility is known to some 1e-10."""
FAR = 1.5
"""Distance of a guess, over that of the steps, beyond which it is a line."""
NOISE, STALLED = 5.0, 0.5
"""Gaps of that many times CLOSED count as none where a sweep leaves more than that share of them: it is round-off."""
ADVICE = "take a shorter step"


def prepare(coupling: Coupling, extrapolation: int) -> Callable[[float, float, float], None]:
    """The step of this master; lines go on through the last two steps whatever `extrapolation`.

    Leaves in the coupling the outputs with the joints' first wrenches. Raises ValueError for a scene without joints,
    for frames that do not meet, and for units that cannot restore their states.
    """
    if not coupling.joints:
        raise ValueError("the master rigid is for scenes with joints: scene.join(upper.tip, forearm.base, axis=...)")
    joined = list(dict.fromkeys(frame.unit.name for joint in coupling.joints for frame in joint.frames))
    others = [c for c in coupling.connections if {c.source.unit.name, c.target.unit.name}.isdisjoint(joined)]
    order = [name for name in step_order(coupling.units, others) if name not in joined]
    lines = Lines(coupling, [joined, *([name] for name in order)])
    solver = Joined(lines, JointState(coupling, coupling.joints))
    solver.begin()

    def step(time: float, step: float, end: float) -> None:
        lines.begin(time, step, end)
        solver.step()
        for part in lines.parts[1:]:
            part.take()
            part.advance()
        lines.finish()

    return step


class Joined:
    """The joined units of a scene, stepped so that their joints hold."""

    def __init__(self, lines: Lines, state: JointState):
        """Raises ValueError if the frames of a joint do not meet, or if a unit cannot save its state."""
        self._lines, self._state, self._coupling = lines, state, lines.coupling
        self._saves, self._restores = self._coupling.rollbacks(lines.parts[0].units)
        self._check_meeting()
        places = {end: place for end, place in self._coupling.float_inputs(lines.parts[0].units)}
        self._places = np.full((len(state.frames), 6), -1)
        for k, frame in enumerate(state.frames):
            for first, member in ((0, "force"), (3, "torque")):
                place = places.get(frame.members.get(member))
                if place:
                    self._places[k, first : first + 3] = range(place.start, place.stop)
        self._driven = self._places >= 0
        self._which = np.flatnonzero(self._driven)
        self._mobility = Mobility(lines, state, self._places)
        self._measured = False
        self._redundant: bool | None = None
        """Whether joints hold what others hold already: then the least wrenches that do it are taken."""
        self.memory = np.zeros((REMEMBERED, 2, len(state.joints), 9))
        """At begin and end of the steps done last, the latest first: force, torque and torque of damping on the second
        frames, in the world."""
        self.times, self.count = np.zeros(REMEMBERED), np.zeros(1)
        self._coupling.memory += [self.memory, self.times, self.count]
        self._coupling.figures |= {"sweeps": 0, "largest_gap": 0.0}
        self._pairs = self._pairs_of_joints()

    def _check_meeting(self) -> None:
        joined = zip(self._state.joints, *self._state.gaps(), strict=True)
        for joint, apart, parting in joined:
            for unit, gaps in (("m", apart[:3]), ("m/s", parting[:3]), ("rad/s", parting[3:] * bool(joint.axis))):
                if np.abs(gaps).max() > MEETING:
                    raise ValueError(
                        f"the frames of {joint} are {np.linalg.norm(gaps):.3g} {unit} apart at the start; allowed: "
                        f"{MEETING:g}: they must meet, and move together but for the freedom of the joint"
                    )

    def begin(self) -> None:
        """Finds the wrenches at the start, by a short step that is taken back, and reads the outputs with them."""
        lines, coupling = self._lines, self._coupling
        time, step = coupling.time.value, TRIAL * coupling.step.value
        lines.begin(time, step, time + step)
        self.step()
        coupling.call(self._restores)
        lines.values[:] = lines.start
        coupling.call(coupling.sets(lines.parts[0].units))
        coupling.call(coupling.gets(lines.parts[0].units))
        self._state.read()
        self.count[0] = 0
        coupling.figures |= {"sweeps": 0, "largest_gap": 0.0}

    def step(self) -> None:
        """One step of the joined units, from the start of the lines to their end; raises CouplingError."""
        state, coupling, step = self._state, self._coupling, self._lines.step
        coupling.call(self._saves)
        state.read()
        if not self._measured:
            self._measure()
        start = Start(state, step)
        unknowns, sweeps, noise = self._solve(start)
        self._measured = sweeps <= SLOW
        figures = coupling.figures
        figures["sweeps"] += sweeps
        figures["largest_gap"] = max(figures["largest_gap"], float(np.abs(state.gaps()[0, :, :3]).max()))
        self._remember(start, unknowns, noise)

    def _measure(self) -> None:
        """Measures the mobility at the start of the step, with no wrench from the joints."""
        units = self._lines.parts[0].units
        self._write(Start(self._state, self._lines.step), np.zeros((2, UNKNOWNS * len(self._state.joints))))
        self._mobility.measure(self._restores)
        self._redundant = None
        self._coupling.call([*self._restores, *self._coupling.gets(units)])
        self._state.read()

    def _solve(self, start: Start) -> tuple[np.ndarray, int, float]:
        """The unknowns that close the gaps at the end of the step, shape (2, 8 n), the number of sweeps, and how far
        the unknowns are open, as gaps below CLOSED count as none."""
        lines, state = self._lines, self._state
        unknowns, inverse = self._guess(start), self._inverse(start)
        allowed = CLOSED * (1.0 + np.abs(state.motion[:, :6]).max())
        move = before = None
        for sweeps in range(1, MOST_SWEEPS + 1):
            self._write(start, unknowns)
            lines.parts[0].advance()
            state.read()
            gaps = residual(state, start, unknowns.reshape(2, -1, UNKNOWNS)).reshape(2, -1)[:, state.active].reshape(-1)
            size = np.abs(gaps).max()
            if size <= allowed or (before is not None and NOISE * allowed > size > STALLED * np.abs(before).max()):
                return unknowns, sweeps, float(2.0 * max(size, allowed) * np.abs(inverse).sum(axis=1).max())
            if not np.isfinite(size):
                break
            if before is not None:
                broyden(inverse, move, gaps - before)
            move, before = -(inverse @ gaps), gaps
            unknowns[:, state.active] += move.reshape(2, -1)
            self._coupling.call(self._restores)
        raise not_settled(lines.parts[0].units, lines, sweeps, ADVICE)

    def _guess(self, start: Start) -> np.ndarray:
        """The wrenches of the steps before, carried on by the polynomial through them."""
        known = int(self.count[0])
        since = (self._coupling.time.value - self.times[:known]) / self._lines.step
        if known > 2 and since[0] > FAR * (since[1] - since[0]):
            known, since = 2, since[:2]
        wrenches = np.tensordot(extrapolation_weights(*since.round(6).tolist()), self.memory[:known], 1)
        torques = (wrenches[:, :, None, 3:6] @ start.triad[:, :, :2])[:, :, 0]
        return np.concatenate([wrenches[:, :, :3], torques, wrenches[:, :, 6:]], axis=2).reshape(2, -1)

    def _remember(self, start: Start, unknowns: np.ndarray, noise: float) -> None:
        """Keeps the wrenches; their jump from the step before, as far as it is no noise, tells the error."""
        across, unknowns = start.triad[:, :, :2], unknowns.reshape(2, -1, UNKNOWNS)
        last = self.memory[0, 1].copy()
        self.memory[1:] = self.memory[:-1]
        self.times[1:] = self.times[:-1]
        self.memory[0, :, :, :3] = unknowns[:, :, :3]
        self.memory[0, :, :, 3:6] = (across @ unknowns[:, :, 3:5, None])[:, :, :, 0]
        self.memory[0, :, :, 6:] = unknowns[:, :, 5:]
        self.times[0] = self._coupling.time.value
        if self.count[0]:
            jump = np.abs(self.memory[0, 0] - last).max()
            size = 1.0 + np.abs(self.memory[:, 1]).max()
            # the lines miss their wrenches by some H^2, and with that the motion by the square of it
            self._coupling.own_error = float(max(jump - noise, 0.0) / size) ** 2
        self.count[0] = min(self.count[0] + 1, REMEMBERED)

    def _write(self, start: Start, unknowns: np.ndarray) -> None:
        """Puts the wrenches into the lines of the frames' inputs."""
        lines = self._lines
        wrenches = wrench_lines(self._state, start, unknowns.reshape(2, -1, UNKNOWNS))
        on_frames = (self._state.signs @ wrenches).reshape(2, -1)
        lines.start[self._places[self._driven]], lines.end[self._places[self._driven]] = on_frames[:, self._which]

    def _pairs_of_joints(self) -> tuple[np.ndarray, ...]:
        """For each pair of frames of one unit and each two joints that they belong to: joint, joint, pair, sign."""
        signs = self._state.signs
        rows = [
            (j, k, n, signs[a, j] * signs[b, k])
            for n, (a, b) in enumerate(zip(self._mobility.to, self._mobility.by, strict=True))
            for j in np.flatnonzero(signs[a])
            for k in np.flatnonzero(signs[b])
        ]
        one, other, pair, sign = (np.array(column) for column in zip(*rows, strict=True))
        return one, other, pair, sign[:, None, None]

    def _inverse(self, start: Start) -> np.ndarray:
        """Inverse of the residual by the unknowns at begin and end of the step.

        Accelerations across the joints that are linear in time, from a0 to a1, make gaps of step^2 (a0 / 3 + a1 / 6) in
        place and step (a0 + a1) / 2 in velocity, and lines of the relative rate that begin at step (a0 - a1) / 12 and
        end at step (7 a0 + 5 a1) / 12: see `joint_wrench`.
        """
        count, step, state = len(self._state.joints), start.step, self._state
        basis = np.zeros((count, 6, UNKNOWNS))
        basis[:, :3, :3] = basis[:, 3:, 5:] = np.eye(3)
        basis[:, 3:, 3:5] = start.triad[:, :, :2]
        one, other, pair, sign = self._pairs
        blocks = np.zeros((count, count, UNKNOWNS, UNKNOWNS))
        np.add.at(
            blocks, (one, other), sign * (basis[one].transpose(0, 2, 1) @ self._mobility.world()[pair] @ basis[other])
        )
        response = blocks.transpose(0, 2, 1, 3).reshape(UNKNOWNS * count, -1)[np.ix_(state.active, state.active)]
        damped = state.active % UNKNOWNS >= 5
        if self._redundant is None:
            values = np.linalg.svd(response[np.ix_(~damped, ~damped)], compute_uv=False)
            self._redundant = bool(values[-1] < SINGULAR * values[0])
        if not np.any(damped):
            # of half the size; the other factor is the inverse of OF_GAPS
            return np.kron([[6.0, -2.0], [-6.0, 4.0]], self._inverted(response) / step**2)
        matrix = step**2 * np.where(damped, OF_RATES, OF_GAPS)[:, :, :, None] * response
        rows = np.flatnonzero(damped)
        for time in range(2):
            matrix[time, time, rows, rows] += step / np.repeat(state.damping, UNKNOWNS)[state.active[rows]]
        return self._inverted(matrix.transpose(0, 2, 1, 3).reshape(2 * len(response), -1))

    def _inverted(self, matrix: np.ndarray) -> np.ndarray:
        return np.linalg.pinv(matrix, rcond=SINGULAR) if self._redundant else np.linalg.inv(matrix)


@lru_cache
def extrapolation_weights(*since: float) -> np.ndarray:
    """Of the values at these times before now, in the value that the polynomial through them has now (Lagrange)."""
    times = np.array(since)
    rest = [np.delete(times, k) for k in range(times.size)]
    return np.array([np.prod(other / (other - time)) for time, other in zip(times, rest, strict=True)])


def broyden(inverse: np.ndarray, move: np.ndarray, change: np.ndarray) -> None:
    """Broyden's first update, in place, of the inverse of a Jacobian: `move` of the unknowns made this `change`."""
    along = move @ inverse
    size = along @ change
    if size != 0.0:
        inverse += np.outer(move - inverse @ change, along / size)
