"""Cells of two numbers in the colours of their verdicts, as the maps of couplings, skins and sensors draw them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap


def draw_cells(
    ax: Axes, cells: Sequence[Mapping[str, Any]], across: str, up: str, colors: Mapping[str, str], log: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Draws cells by "verdict"; the numbers `across` and `up`, evenly spaced, or their logarithms, are returned."""
    xs, ys = (np.unique([cell[key] for cell in cells]) for key in (across, up))
    kinds = list(colors)
    numbers = np.full((len(ys), len(xs)), np.nan)
    for cell in cells:
        numbers[np.searchsorted(ys, cell[up]), np.searchsorted(xs, cell[across])] = kinds.index(cell["verdict"])
    edges = [np.exp(_edges(np.log(middles))) if log else _edges(middles) for middles in (xs, ys)]
    shades = ListedColormap(list(colors.values()))
    ax.pcolormesh(*edges, numbers, cmap=shades, vmin=-0.5, vmax=len(kinds) - 0.5, linewidth=0)
    return xs, ys


def _edges(middles: np.ndarray) -> np.ndarray:
    """Of cells on a linear axis."""
    half = 0.5 * (middles[1] - middles[0])
    return np.append(middles - half, middles[-1] + half)
