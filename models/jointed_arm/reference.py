"""Motions of a jointed arm to round-off."""

from collections.abc import Sequence

import numpy as np

from .mechanics import Arm, Array

TOLERANCE = 3e-14
"""SciPy takes no less than 2.2e-14."""


def reference(arm: Arm, state: Sequence[float], times: Sequence[float], tolerance: float = TOLERANCE) -> Array:
    """States [m, size] at `times` (s, rising), from `state` at the first of them.

    Dormand and Prince's method of order 8 (DOP853), stopped at each time, as its interpolant has order 7 only. Raises
    ValueError for times that do not rise, RuntimeError where the method gives up.
    """
    from scipy.integrate import DOP853

    times = np.asarray(times, float)
    if not np.all(np.diff(times) > 0.0):
        raise ValueError("times do not rise: allowed are times each later than the one before")
    states = np.empty((len(times), arm.size))
    states[0] = state
    usual = None
    for row in range(1, len(times)):
        length = times[row] - times[row - 1]
        first = None if usual is None else min(usual, length)
        solver = DOP853(
            arm.slope, 0.0, states[row - 1], length, rtol=tolerance, atol=0.01 * tolerance, first_step=first
        )
        usual = 0.0
        while solver.status == "running":
            message = solver.step()
            usual = max(usual, solver.step_size or 0.0)
        if solver.status != "finished":
            raise RuntimeError(f"the reference ends at {times[row - 1] + solver.t} s: {message}")
        states[row] = solver.y
    return states
