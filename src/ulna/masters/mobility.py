"""What wrenches on the frames of a unit do to their velocities, found by repeating a step."""

import numpy as np

from ..lines import Lines
from .joint_state import JointState, rotations

SMALL, LARGE = 1e-8, 1e6
"""First, careful nudge, and bound of the second: N, N.m."""
AIM = 1e-5
"""Change of velocity that the second nudge aims at, over 1 m/s and rad/s plus the motion there is."""


class Mobility:
    """Response of frame i to frame k of the same unit, shape (pairs, 6, 6): velocity and angular velocity gained per
    second of force and torque, each in the axes of its own frame, where it hardly changes."""

    def __init__(self, lines: Lines, state: JointState, places: np.ndarray):
        """`places`, shape (frames, 6), are those of force and torque in the lines; -1 where there is none."""
        self._lines, self._state, self._places = lines, state, places
        frames = state.frames
        pairs = [(i, k) for i, a in enumerate(frames) for k, b in enumerate(frames) if a.unit is b.unit]
        self.to, self.by = (np.array(column) for column in zip(*pairs, strict=True))
        self.local = np.zeros((len(pairs), 6, 6))

    def measure(self, restores: list) -> None:
        """Measures all units at the start of the step that `restores` goes back to."""
        lines, state = self._lines, self._state
        start, end = lines.start.copy(), lines.end.copy()
        base = self._stepped(restores)
        state.read()
        before = _by_frame(state.turn)
        response = np.zeros((len(state.frames), 6, len(state.frames), 6))
        for column in range(6):
            # the same column of one frame of every unit at once: units do not feel one another within a step
            for group in self._rounds():
                places = self._places[group, column]
                group, places = group[places >= 0], places[places >= 0]
                if not group.size:
                    continue
                nudge = np.full(len(state.frames), SMALL)
                gained = self._strongest(self._changed(restores, start, end, places, nudge[group]), group)
                size = AIM * (1.0 + np.abs(base).max())
                nudge[group] = np.clip(nudge[group] * size / np.maximum(gained, 1e-300), SMALL, LARGE)
                change = self._changed(restores, start, end, places, nudge[group])
                for k in group:
                    response[:, :, k, column] = change / (nudge[k] * lines.step)
        lines.start[:], lines.end[:] = start, end
        blocks = response[self.to, :, self.by, :]
        self.local = before[self.to].transpose(0, 2, 1) @ blocks @ before[self.by]

    def world(self) -> np.ndarray:
        """The responses in world axes for the step from where the frames are now, shape (pairs, 6, 6).

        The wrench acts in the middle of the step, the response is seen at its end.
        """
        middle, end = (_by_frame(self._turned(share)) for share in (0.5, 1.0))
        return end[self.to] @ self.local @ middle[self.by].transpose(0, 2, 1)

    def _turned(self, share: float) -> np.ndarray:
        """Frames to world after a share of the step with the angular velocities of now, shape (frames, 3, 3)."""
        turn = 0.5 * share * self._lines.step * self._state.angular_velocity
        return rotations(np.insert(turn, 0, 1.0, axis=1)) @ self._state.turn

    def _changed(
        self, restores: list, start: np.ndarray, end: np.ndarray, places: np.ndarray, nudge: np.ndarray
    ) -> np.ndarray:
        """Half the difference of the velocities after steps with a wrench and with its opposite added to the lines."""
        results = []
        for sign in (1.0, -1.0):
            self._lines.start[:], self._lines.end[:] = start, end
            self._lines.start[places] += sign * nudge
            self._lines.end[places] += sign * nudge
            results.append(self._stepped(restores))
        return 0.5 * (results[0] - results[1])

    def _stepped(self, restores: list) -> np.ndarray:
        """Velocities of all frames of units after a step, shape (frames, 6)."""
        lines, state = self._lines, self._state
        lines.coupling.call(restores)
        lines.parts[0].advance()
        state.read()
        count = len(state.frames)
        return np.hstack([state.velocity[:count], state.angular_velocity[:count]])

    def _rounds(self) -> list[np.ndarray]:
        """Frames, so that no two of a round belong to one unit."""
        units = [frame.unit.name for frame in self._state.frames]
        turns = [units[:k].count(name) for k, name in enumerate(units)]
        return [np.flatnonzero(np.array(turns) == turn) for turn in range(max(turns) + 1)]

    def _strongest(self, change: np.ndarray, group: np.ndarray) -> np.ndarray:
        """Largest change in the unit of each frame of the group."""
        units = np.array([frame.unit.name for frame in self._state.frames])
        return np.array([np.abs(change[units == units[k]]).max() for k in group])


def _by_frame(turn: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) for pairs of vectors, (n, 6, 6)."""
    both = np.zeros((len(turn), 6, 6))
    both[:, :3, :3] = both[:, 3:, 3:] = turn
    return both
