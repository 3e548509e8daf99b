"""A rigid body written by a stranger with pythonfmu3: no rates, no terminals, names of his own, wrench held in a step.

Its moments of inertia are equal, so that the spin under a held torque is a closed form.
"""

import numpy as np
from pythonfmu3 import Dimension, Float64, Fmi3Causality, Fmi3Slave, Fmi3Variability

MASS = 1.5  # kg
MOMENT = 0.02  # kg m2
GRAVITY = np.array([0.0, 0.0, -9.80665])  # m/s2
SUBSTEPS = 8


def spinning(q: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Rate of a quaternion w, x, y, z for an angular velocity in the world."""
    return 0.5 * np.append(-w @ q[1:], q[0] * w + np.cross(w, q[1:]))


class Stranger(Fmi3Slave):
    """Takes push and twist, gives place, speed, attitude and spin."""

    def __init__(self, **settings):
        """Declares the variables."""
        super().__init__(**settings)
        self.time = 0.0
        self.place, self.speed, self.spin, self.push, self.twist = (np.zeros(3) for _ in range(5))
        self.attitude = np.array([1.0, 0.0, 0.0, 0.0])
        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous)
        )
        for name in ("push", "twist"):
            self._declare(name, Fmi3Causality.input)
        for name in ("place", "speed", "attitude", "spin"):
            self._declare(name, Fmi3Causality.output)

    def _declare(self, name: str, causality: Fmi3Causality) -> None:
        self.register_variable(
            Float64(
                name,
                causality=causality,
                variability=Fmi3Variability.continuous,
                dimensions=[Dimension(start=str(getattr(self, name).size))],
                # the default one calls numpy by an argument that numpy 2.4 has no more
                setter=lambda values: setattr(self, name, np.array(values)),
            )
        )

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Runge-Kutta for the attitude, the rest exactly."""
        h = step_size / SUBSTEPS
        pull, turn = np.asarray(self.push) / MASS + GRAVITY, np.asarray(self.twist) / MOMENT
        place, speed, q, w = (np.array(x, float) for x in (self.place, self.speed, self.attitude, self.spin))
        for _ in range(SUBSTEPS):
            middle = w + 0.5 * h * turn
            k1 = spinning(q, w)
            k2 = spinning(q + 0.5 * h * k1, middle)
            k3 = spinning(q + 0.5 * h * k2, middle)
            w = w + h * turn
            q = q + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + spinning(q + h * k3, w))
        self.place = place + step_size * (speed + 0.5 * step_size * pull)
        self.speed, self.attitude, self.spin = speed + step_size * pull, q / np.linalg.norm(q), w
        return True
