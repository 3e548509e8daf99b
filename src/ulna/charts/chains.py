"""What a macro step of a chain on rigid joints costs, by its length."""

from dataclasses import dataclass

import numpy as np

from .arms import chain
from .coupled import run
from .ways import Stepping, rigid

STEP = 1e-3  # s
COUNT = 100
"""Macro steps of a run."""


@dataclass(frozen=True)
class ChainCost:
    """Bodies in a row, processor seconds of a macro step, and how often it was swept."""

    length: int
    seconds: float
    sweeps: float


def chain_costs(lengths: tuple[int, ...], rounds: int) -> list[ChainCost]:
    """Median costs of chains of these lengths, run in turn; one round before is not counted."""
    scenes = [rigid(chain(length)) for length in lengths]
    try:
        runs = [
            [run(scene, Stepping("rigid"), STEP, None, COUNT * STEP) for scene in scenes] for _ in range(rounds + 1)
        ]
    finally:
        for scene in scenes:
            scene.close()
    medians = np.median([[seconds for _, seconds in row] for row in runs[1:]], axis=0)
    sweeps = [results.summary["sweeps"] / COUNT for results, _ in runs[0]]
    return [ChainCost(n, float(s) / COUNT, k) for n, s, k in zip(lengths, medians, sweeps, strict=True)]
