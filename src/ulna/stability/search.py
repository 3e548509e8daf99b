"""The largest step at which something holds."""

import math
from collections.abc import Callable


def largest(holds: Callable[[float], bool], low: float, high: float, ratio: float = 1.01) -> float:
    """Largest step, within `ratio`, up to which `holds`; inf if it holds at `high`, 0 if not even at `low`.

    Goes down from `high` by factors of sqrt(2), and takes nothing for a limit that does not hold at two of them: a
    wrong attitude may be right by chance. Between the last that failed and the first that held it bisects.
    """
    fails, step, held = math.inf, high, 0
    while step >= low and held < 2:
        if holds(step):
            held += 1
        else:
            fails, held = step, 0
        step /= math.sqrt(2)
    if held == 0:
        return 0.0
    if fails == math.inf:
        return math.inf
    good = fails / math.sqrt(2)
    while fails > ratio * good:
        middle = math.sqrt(fails * good)
        good, fails = (middle, fails) if holds(middle) else (good, middle)
    return good
