"""Points at which an FMU is compared: random ones, and those at which formulas tend to fail."""

import random
from collections.abc import Callable, Iterator, Mapping, Sequence

import casadi
import numpy as np
from casadi import SX

from .built import Built, Point, RefusedError
from .identity import RANGE, Samples, range_of

RANDOM_POINTS = 4
DRAWS = 200
HUGE = 1e75
"""Its fourth power is still a number: a damper's power has a rate and a length, both squared."""

Draw = Callable[[random.Random], dict[str, np.ndarray]]


def ranges_of(built: Built, names: Sequence[str], samples: Samples) -> dict[str, tuple[float, float]]:
    """`samples`, and for names that it lacks a range within the FMU's own limits."""
    ranges = dict(samples)
    for name in names:
        low, high = built.limits(name)
        usual = (0.5, 2.0) if low is not None and low >= 0 else RANGE
        least = usual[0] if low is None else max(usual[0], low)
        ranges.setdefault(name, (least, usual[1] if high is None else max(least, min(usual[1], high))))
    return ranges


def general_point(symbols: Mapping[str, SX], samples: Samples) -> Draw:
    """A function that draws a point: free symbols in their ranges, and what is bound to them computed."""
    free = casadi.symvar(SX(casadi.vertcat(*symbols.values())))
    function = casadi.Function("point", [casadi.vertcat(*free)], list(symbols.values()))
    ranges = [range_of(symbol.name(), samples) for symbol in free]

    def draw(source: random.Random) -> dict[str, np.ndarray]:
        values = function.call([casadi.DM([source.uniform(low, high) for low, high in ranges])])
        return {name: np.array(value).ravel() for name, value in zip(symbols, values, strict=True)}

    return draw


def _scaled(point: Point, names: Sequence[str], factor: float) -> dict[str, np.ndarray]:
    return {name: value * factor if name in names and value.size != 4 else value for name, value in point.items()}


def _nearly_equal(point: Point) -> dict[str, np.ndarray]:
    """Every vector of positive parameters, such as principal moments, with elements equal but for their last bits."""
    return {
        name: value[0] * (1 + 1e-15 * np.arange(value.size)) if value.size == 3 and np.all(value > 0) else value
        for name, value in point.items()
    }


def _of_length(point: Point, names: Sequence[str], length: float) -> dict[str, np.ndarray]:
    return {
        name: length * value / np.linalg.norm(value) if name in names and value.size == 4 else value
        for name, value in point.items()
    }


def points(built: Built, draw: Draw, *, adversarial: bool) -> Iterator[dict[str, np.ndarray]]:
    """Random points, and adversarial ones: huge, tiny, nearly symmetric, quaternions short and long.

    The FMU has taken on each point that is yielded. An adversarial kind that its limits exclude, such as speeds beyond
    that of sound, is left out. Raises RefusedError if it takes none of many random ones.
    """
    source = random.Random(20)
    moving = [*built.states, *(v.name for v in built.numbers("input"))]
    awkward = [
        lambda p: _scaled(p, moving, HUGE),
        lambda p: _scaled(p, moving, 1e-90),
        _nearly_equal,
        lambda p: _of_length(p, moving, 0.51),
        lambda p: _of_length(p, moving, 1.99),
    ]
    for number, shape in enumerate([lambda p: p] * RANDOM_POINTS + (awkward if adversarial else [])):
        for _ in range(DRAWS):
            point = shape(draw(source))
            try:
                built.initialize(point)
                built.move(point)
            except RefusedError:
                continue
            yield point
            break
        else:
            if number >= RANDOM_POINTS:
                continue
            raise RefusedError(f"{built.description.name} takes none of {DRAWS} points drawn for it")
