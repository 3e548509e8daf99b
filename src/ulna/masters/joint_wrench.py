"""The wrenches of rigid joints over a step: lines in time that do no work about the axis of a hinge, and damping."""

import numpy as np

from .joint_state import JointState, cross

_NODES = 0.5 + np.array([-0.5, 0.0, 0.5]) * np.sqrt(0.6)
"""Gauss points of the step from 0 to 1: exact to degree 5."""
_MOMENTS = np.array([5.0, 8.0, 5.0]) / 18.0 * _NODES ** np.arange(3)[:, None]
"""Integrals of a function times 1, s, s^2 by its values there."""
_LINE = np.stack([1.0 - _NODES, _NODES], axis=1)
_CUBIC = np.stack(
    [
        (1.0 + 2.0 * _NODES) * (1.0 - _NODES) ** 2,
        _NODES * (1.0 - _NODES) ** 2,
        _NODES**2 * (3.0 - 2.0 * _NODES),
        -(_NODES**2) * (1.0 - _NODES),
    ],
    axis=1,
)
"""Values there by those at begin and end; and by value and slope at begin, value and slope at end."""
UNKNOWNS = 8
"""Of each joint at begin and at end of a step: see `wrench_lines`."""
STILL = 1e-14
"""Turn of an axis in a step that is none."""


class Start:
    """What the wrenches of a step need to know of its start."""

    def __init__(self, state: JointState, step: float):
        """Takes the frames as they are."""
        self.step = step
        self.triad = state.triad()
        self.orientation = state.orientation.copy()
        self.angular_velocity = state.angular_velocity.copy()


def wrench_lines(state: JointState, start: Start, unknowns: np.ndarray) -> np.ndarray:
    """Force and torque on the second frames at begin and end of a step, in the world, shape (2, n, 6).

    `unknowns`, shape (2, n, 8), are force (world), torque in the two directions across the axis at the start, and
    torque of damping (world). The axis turns within the step; what a line of torque then has along it is taken away in
    the mean and in the first moment, so that to order 4 a hinge does no work about its axis.
    """
    wrenches = unknowns[:, :, [0, 1, 2, 5, 6, 7]]
    if np.any(state.hinged):
        torques = np.matmul(start.triad[:, :, :2], unknowns[:, :, 3:5, None])[:, :, :, 0]
        turned = state.triad()[:, :, 2]
        if np.any(np.abs(turned - start.triad[:, :, 2]) > STILL):
            torques += _along(state, start, turned, torques)[:, :, None] * start.triad[:, :, 2]
        wrenches[:, :, 3:] += torques
    return wrenches


def residual(state: JointState, start: Start, unknowns: np.ndarray) -> np.ndarray:
    """What must be zero, shape (2, n, 8), in m and rad: gaps in place, then step times gaps in velocity.

    The last three of each joint are step times what the torque of damping is off the relative angular velocity at
    begin and end, over the damping.
    """
    found = np.zeros(unknowns.shape)
    found[:, :, :5] = state.gaps()
    found[1] *= start.step
    if np.any(state.damping):
        some = np.where(state.damping > 0.0, state.damping, 1.0)
        found[:, :, 5:] = start.step * (unknowns[:, :, 5:] / some + _relative_rates(state, start))
    return found


def _along(state: JointState, start: Start, turned: np.ndarray, torques: np.ndarray) -> np.ndarray:
    """Components along the axis at the start, shape (2, n), that take away what lines of torque do about the axis.

    The path of the axis is the cubic through its ends with its velocities there.
    """
    axis = start.triad[:, :, 2]
    leaving = start.step * cross(start.angular_velocity[state.first], axis)
    arriving = start.step * cross(state.angular_velocity[state.first], turned)
    path = (_CUBIC @ np.stack([axis, leaving, turned, arriving]).reshape(4, -1)).reshape(3, *axis.shape)
    along = (_LINE @ torques.reshape(2, -1)).reshape(path.shape)
    b0, b1 = _MOMENTS[:2] @ (along * path).sum(axis=2)
    m0, m1, m2 = _MOMENTS @ (path * axis).sum(axis=2)
    # (m0 - m1) x + m1 y = -b0, (m1 - m2) x + m2 y = -b1
    determinant = (m0 - m1) * m2 - m1 * (m1 - m2)
    return np.stack([m1 * b1 - m2 * b0, (m1 - m2) * b0 - (m0 - m1) * b1]) / determinant * state.hinged


def _relative_rates(state: JointState, start: Start) -> np.ndarray:
    """Relative angular velocities as lines, shape (2, n, 3): from end to end, moved to the mean over the step.

    The mean follows from the turn: by Magnus' series the integral of w is the rotation vector of the turn and
    step^2 / 12 w0 x w1, to order 5 (Iserles, Munthe-Kaas, Norsett and Zanna, Acta Numerica 9 (2000) 215).
    """
    w0, w1 = start.angular_velocity, state.angular_velocity
    turn = rotation_vectors(state.orientation, start.orientation) + start.step**2 / 12.0 * cross(w0, w1)
    shift = turn / start.step - 0.5 * (w0 + w1)
    lines = np.stack([w0 + shift, w1 + shift])
    return lines[:, state.second] - lines[:, state.first]


def rotation_vectors(after: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Rotation vectors in the world that take orientations `before` to `after`, shapes (n, 4) to (n, 3)."""
    a, b = after[:, :1], before[:, :1]
    u, v = after[:, 1:], before[:, 1:]
    real = a * b + np.sum(u * v, axis=1, keepdims=True)
    vector = np.where(real < 0.0, -1.0, 1.0) * (b * u - a * v - cross(u, v))
    size = np.linalg.norm(vector, axis=1, keepdims=True)
    some = np.where(size > 0.0, size, 1.0)
    return vector * np.where(size > 0.0, 2.0 * np.arctan2(size, np.abs(real)) / some, 2.0)
