"""Rigid joints as arrays: where their frames are, and how far they are apart."""

from collections.abc import Sequence

import numpy as np

from ..connections import Frame
from ..coupling import Coupling
from ..joints import Joint

COLUMNS = {
    "position": slice(0, 3),
    "velocity": slice(3, 6),
    "angular_velocity": slice(6, 9),
    "orientation": slice(9, 13),
}
"""Of the motion of a frame."""


class JointState:
    """n joints between f frames; frames of the world come last, one for each joint that is held there.

    `position`, `velocity`, `angular_velocity` have shape (f, 3), `turn` (f, 3, 3): frame to world.
    """

    def __init__(self, coupling: Coupling, joints: Sequence[Joint]):
        """Reads the frames where the units are now: there the joints are closed."""
        self.joints = list(joints)
        frames = [frame for joint in joints for frame in joint.frames]
        self.frames: list[Frame] = list({_key(frame): frame for frame in frames}.values())
        number = {_key(frame): k for k, frame in enumerate(self.frames)}
        world = iter(range(len(self.frames), len(self.frames) + len(joints)))
        self.first = np.array([next(world) if j.first is None else number[_key(j.first)] for j in joints])
        self.second = np.array([number[_key(j.second)] for j in joints])
        self.motion = np.zeros((len(self.frames) + sum(joint.first is None for joint in joints), 13))
        self.motion[:, COLUMNS["orientation"].start] = 1.0
        self.position, self.velocity, self.angular_velocity, self.orientation = (
            self.motion[:, columns] for columns in COLUMNS.values()
        )
        self._outputs = coupling.outputs[np.dtype(np.float64)]
        self._slots, self._places = _reading(coupling, self.frames)
        self.hinged = np.array([joint.axis is not None for joint in joints])
        self.damping = np.array([[joint.damping] for joint in joints])
        kinds = np.stack([self.hinged | True, self.hinged, self.damping[:, 0] > 0.0], axis=1)
        self.active = np.flatnonzero(np.repeat(kinds, (3, 2, 3), axis=1))
        """Which of the eight unknowns of every joint there are: three forces, two torques across the axis of a hinge,
        three torques of damping."""
        self.signs = np.zeros((len(self.frames), len(joints)))
        """What a wrench on the second frame of a joint is to every frame."""
        for k, joint in enumerate(joints):
            self.signs[number[_key(joint.second)], k] += 1.0
            if joint.first is not None:
                self.signs[number[_key(joint.first)], k] -= 1.0
        self._gaps = np.zeros((2, len(joints), 5))
        self.read()
        fixed = np.flatnonzero(self.first >= len(self.frames))
        self.position[self.first[fixed]] = self.position[self.second[fixed]]
        self._set_axes()

    def _set_axes(self) -> None:
        """In the axes of the first frame two directions across the axis, and the axis; the axis also in the second."""
        axes = np.array([joint.axis or (0.0, 0.0, 1.0) for joint in self.joints])
        across = cross(axes, np.eye(3)[np.argmin(np.abs(axes), axis=1)])
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        self._triad = np.stack([across, cross(axes, across), axes], axis=2)
        world = self.turn[self.first] @ axes[:, :, None]
        self._second_axis = self.turn[self.second].transpose(0, 2, 1) @ world

    def read(self) -> None:
        """Takes the frames from the outputs that were read last."""
        self.motion.reshape(-1)[self._slots] = self._outputs[self._places]
        self.turn = rotations(self.orientation)

    def triad(self) -> np.ndarray:
        """Columns: two directions across the axis, and the axis, in the world by the first frame; shape (n, 3, 3)."""
        return self.turn[self.first] @ self._triad

    def gaps(self) -> np.ndarray:
        """How far the frames of each joint are apart, and how fast they part, shape (2, n, 5).

        Three lengths in the world (m, m/s), then two angles across the axis of a hinge (rad, rad/s).
        """
        gaps = self._gaps
        apart = self.motion[self.second, :9] - self.motion[self.first, :9]
        gaps[0, :, :3] = apart[:, :3]
        gaps[1, :, :3] = apart[:, 3:6]
        if np.any(self.hinged):
            across = self.triad().transpose(0, 2, 1)
            tilted = (across @ (self.turn[self.second] @ self._second_axis))[:, :, 0]
            # the axis times the tilted one, by its components along the two directions across
            gaps[0, :, 3] = -tilted[:, 1]
            gaps[0, :, 4] = tilted[:, 0]
            gaps[1, :, 3:] = (across[:, :2] @ apart[:, 6:, None])[:, :, 0]
        return gaps


# Row-wise matrix of a unit quaternion w, x, y, z, as a linear function of its 16 products.
_PRODUCTS = np.zeros((4, 4, 3, 3))
for _i in range(3):
    for _j in range(3):
        _PRODUCTS[1 + _i, 1 + _j, _i, _j] += 1.0
        _PRODUCTS[1 + _j, 1 + _i, _i, _j] += 1.0
        if _i != _j:
            _sign = 1.0 if (_j - _i) % 3 == 2 else -1.0
            _PRODUCTS[0, 1 + 3 - _i - _j, _i, _j] += 2.0 * _sign
    for _k in range(4):
        _PRODUCTS[_k, _k, _i, _i] += 1.0 if _k == 0 else -1.0
_PRODUCTS = _PRODUCTS.reshape(16, 9)


def rotations(q: np.ndarray) -> np.ndarray:
    """Matrices of quaternions w, x, y, z, not zero, shape (n, 4) to (n, 3, 3)."""
    products = (q[:, :, None] * q[:, None, :]).reshape(-1, 16)
    norms = products[:, 0] + products[:, 5] + products[:, 10] + products[:, 15]
    return ((products @ _PRODUCTS) / norms[:, None]).reshape(-1, 3, 3)


_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross products along the last axis; numpy's own takes several times as long for a few vectors."""
    return a.take(_NEXT, -1) * b.take(_LAST, -1) - a.take(_LAST, -1) * b.take(_NEXT, -1)


def _key(frame: Frame) -> tuple[str, str]:
    return frame.members["force"].name, frame.members["position"].name


def _reading(coupling: Coupling, frames: Sequence[Frame]) -> tuple[np.ndarray, np.ndarray]:
    """Elements of the motion, flat, and where each lies in the outputs, for all that is read of the frames."""
    slots, places = [], []
    for row, frame in enumerate(frames):
        for member, columns in COLUMNS.items():
            if coupling.reads(end := frame.members.get(member)):
                slots += range(13 * row + columns.start, 13 * row + columns.stop)
                places += range(*coupling.place(end)[1:])
    return np.array(slots), np.array(places)
