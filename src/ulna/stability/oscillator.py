"""Two RigidBody units held by one CompliantJoint, run by the masters: what each makes of the swing between them.

Only two numbers matter, z = w H with w = sqrt(k / m), m the reduced mass, and the damping ratio
zeta = c / (2 sqrt(k m)): `parameters` turns them into k and c for the step H.
"""

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..coupling import CouplingError
from ..results import Results
from ..scene import Scene
from ..slave import UnitError
from ..watch import CouplingWarning
from .coupling_theory import reduced_mass, true_rates

Array = NDArray[np.float64]
Complexes = NDArray[np.complex128]

MASSES = (0.80, 0.35)
"""kg: an upper arm and a forearm as their elbow feels them."""
STEP = 1e-3
"""s, wherever a step is given by z."""
SWING = 0.01
"""m, at the start, with as much speed as it has at its fastest: both parts of the motion are there."""
MASTERS = {
    "jacobi_order_0": ("jacobi", 0),
    "jacobi_order_1": ("jacobi", 1),
    "gauss_seidel_order_0": ("gauss_seidel", 0),
    "gauss_seidel_order_1": ("gauss_seidel", 1),
    "iterated": ("iterated", 0),
    "newton": ("newton", 0),
}
"""Master and extrapolation, by the names of `coupling_theory` where it has them."""
DELAYS = 3
"""A step is a matrix for the motion and as many numbers more as a master holds: up to 5, from as many rows and more."""
LEAST = 1e-8
"""Singular value, over the largest, of what is round-off, or the error at which an iteration ends, in the rows."""
FAR = 1e8
"""Growth after which a run has been seen enough."""


def theory_of(master: str) -> str:
    """What `coupling_theory` calls the step of a master."""
    return "converged" if master in ("iterated", "newton") else master


def parameters(z: float, zeta: float, H: float = STEP) -> tuple[float, float, float, float]:
    """m1, m2 (kg), k (N/m) and c (N s/m) of the oscillator with w H = z and this damping ratio, for a step H (s)."""
    m = reduced_mass(*MASSES)
    w = z / H
    return (*MASSES, m * w**2, 2 * zeta * m * w)


class Oscillator:
    """The scene; it is built once and run with other springs and dampers."""

    def __init__(self) -> None:
        """Two bodies on a line, without weight, and the joint after them."""
        self.scene = Scene("oscillator")
        common: dict[str, Any] = {"gravity": [0.0, 0.0, 0.0], "solver": "rk4", "solver_step": 1.0}
        self._first, self._second = (
            self.scene.add("RigidBody", name, mass=mass, **common)
            for name, mass in zip(("first", "second"), MASSES, strict=True)
        )
        self._joint = self.scene.add("CompliantJoint", "joint", angular_stiffness=0.0, angular_damping=0.0)
        for body in (self._first, self._second):
            self.scene.connect(body.center, self._joint[body.name])
            self.scene.record(body.position, body.velocity, body.kinetic_energy)

    def __enter__(self) -> "Oscillator":
        """For `with`: the units are freed at its end."""
        return self

    def __exit__(self, *_: object) -> None:
        """Frees the units."""
        self.scene.close()

    def run(self, master: str, k: float, c: float, H: float, count: int) -> "Run":
        """`count` steps of H (s) by one of MASTERS; a run that fails has the rows before that and says why."""
        self._joint.set("stiffness", k)
        self._joint.set("damping", c)
        self._second.set("initial_position", [SWING, 0.0, 0.0])
        self._second.set("initial_velocity", [SWING * math.sqrt(k / reduced_mass(*MASSES)), 0.0, 0.0])
        name, extrapolation = MASTERS[master]
        failure, warned = "", False
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                results = self.scene.run(count * H, H, master=name, extrapolation=extrapolation)
            except (CouplingError, UnitError) as error:
                results, failure = error.results, "loop" if isinstance(error, CouplingError) else "unit"
        warned = any(issubclass(w.category, CouplingWarning) for w in caught)
        return Run(results, failure, warned)


@dataclass(frozen=True)
class Run:
    """What a run has recorded."""

    results: Results
    failure: str
    """Empty, "loop" if the loop did not settle, "unit" if a unit refused to go on."""
    warned: bool
    """Whether it was said that the coupling makes the run wrong."""

    def distance(self) -> Array:
        """Distance (m) and its rate (m/s) at every row, shape (n, 2)."""
        columns = [self.results[f"second.{x}"] - self.results[f"first.{x}"] for x in ("position", "velocity")]
        return np.stack([column[:, 0] for column in columns], axis=1)


def factors(rows: Array) -> Complexes:
    """Eigenvalues of the linear step that takes rows (n, 2) from one to the next, whatever else that step remembers.

    Realization of Ho and Kalman by a singular value decomposition (Juang and Pappa, J. Guidance 8 (1985) 620): with a
    few rows stacked into one column, the columns of a run span a space that the step maps onto itself. What has died
    out to LEAST of the rest has no eigenvalue here.
    """
    scaled = rows / np.abs(rows).max(axis=0)
    depth = min(2 * DELAYS, len(rows) // 2)
    columns = np.stack([scaled[i : len(rows) - depth + i] for i in range(depth + 1)])
    columns = columns.transpose(0, 2, 1).reshape(2 * (depth + 1), -1)
    # a motion that grows must not hide, in its last rows, what the first ones show
    heights = np.abs(columns).max(axis=0)
    columns = columns / np.maximum(heights, heights[0])
    space, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    space = space[:, : min(np.count_nonzero(sizes > LEAST * sizes[0]), 5)]
    return np.linalg.eigvals(np.linalg.lstsq(space[:-2], space[2:], rcond=None)[0]).astype(complex)


def seen(rows: Array) -> Array:
    """The rows until they have grown by FAR."""
    sizes = np.abs(rows / np.abs(rows[0])).max(axis=1)
    return rows[: np.argmax(sizes > FAR) + 1] if sizes.max() > FAR else rows


def rate_error(rows: Array, k: float, c: float, H: float) -> float:
    """As `coupling_theory.rate_error`, from the rows of a run."""
    found, true = factors(rows), true_rates(*MASSES, k, c)
    nearest = np.array([found[np.argmin(np.abs(found - factor))] or math.ulp(0.0) for factor in np.exp(true * H)])
    return float(np.max(np.abs(np.log(nearest) / H - true) / np.abs(true)))
