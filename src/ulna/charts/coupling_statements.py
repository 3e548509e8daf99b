"""What the couplings are held to, from one run."""

from collections.abc import Iterator, Sequence
from math import log

from ..bench.masters import ECOS, GETTERS, master_name, name_of, over_units
from .chains import ChainCost
from .coupled import CoupledPoint
from .statements import Statement
from .ways import ONE_WAY, RIGID, STIFFNESSES, TWO_WAY, compliant_name

FINE, USUAL = 0.0025, 0.01  # s
PYTHON = name_of(master_name("gauss_seidel", 0), "3.0")
"""The default master and version."""


def coupling_statements(
    points: Sequence[CoupledPoint], costs: Sequence[ChainCost], macro: dict[str, float], end: float
) -> list[Statement]:
    """All that points, chains and macro steps say; `end` (s) is how long the arm swings."""
    return [
        *rigid_joints(points, end),
        *two_ways(points),
        *floors(points),
        *chains(costs),
        *macro_step(macro),
    ]


def at(points: Sequence[CoupledPoint], way: str, master: str) -> dict[float, CoupledPoint]:
    """The points of a way and a master by their macro steps."""
    return {p.step: p for p in points if (p.way, p.master) == (way, master) and p.tolerance is None}


def order(claim: str, own: dict[float, CoupledPoint], bound: float) -> Iterator[Statement]:
    """Observed, between the coarsest step and FINE."""
    coarse = max(own, default=FINE)
    if FINE in own and coarse > FINE:
        observed = log(own[coarse].error / own[FINE].error) / log(coarse / FINE)
        yield Statement(f"{claim}: observed order, {_ms(coarse)} to {_ms(FINE)}", observed, bound, False)


def rigid_joints(points: Sequence[CoupledPoint], end: float) -> Iterator[Statement]:
    """Order, gaps and error of the master `rigid`."""
    own = at(points, RIGID, "rigid")
    yield from order(RIGID, own, 3.8)
    if USUAL in own:
        gap = own[USUAL].largest_gap or 0.0
        yield Statement(f"{RIGID}: largest gap at {_ms(USUAL)}, m", gap, 1e-12, True)
        yield Statement(f"{RIGID}: error over {end:g} s at {_ms(USUAL)}, rad", own[USUAL].error, 2e-4, True)


def two_ways(points: Sequence[CoupledPoint]) -> Iterator[Statement]:
    """HingedBody with the loop through acceleration and reaction solved, and with the reaction left out."""
    yield from order(f"{TWO_WAY}, newton", at(points, TWO_WAY, "newton"), 1.8)
    errors = [p.error for p in points if p.way == ONE_WAY]
    if errors:
        yield Statement(f"{ONE_WAY}: least error at any step, rad", min(errors), 1.0, False, "no step mends it")


def floors(points: Sequence[CoupledPoint]) -> Iterator[Statement]:
    """Compliant joints: what stays however short the step goes with the compliance."""
    least = {k: min((p.error for p in points if p.way == compliant_name(k)), default=None) for k in STIFFNESSES}
    found = [(k, error) for k, error in least.items() if error]
    if len(found) > 1:
        (soft, one), (stiff, other) = found[0], found[-1]
        exponent = log(one / other) / log(stiff / soft)
        note = ", ".join(f"{error:.2g} rad at {k:.0e} N/m".replace("e+0", "e") for k, error in found)
        yield Statement("CompliantJoint: order of the floor in the compliance", exponent, 0.9, False, note)


def chains(costs: Sequence[ChainCost]) -> Iterator[Statement]:
    """A macro step of a long chain and of a short one."""
    by_length = {cost.length: cost for cost in costs}
    if {1, 10} <= by_length.keys():
        one, ten = by_length[1], by_length[10]
        note = f"{1e6 * ten.seconds:.0f} and {1e6 * one.seconds:.0f} µs; {ten.sweeps:.2g} and {one.sweeps:.2g} sweeps"
        yield Statement(
            "rigid: a macro step of a chain of ten over one of one", ten.seconds / one.seconds, 10.0, True, note
        )


def macro_step(macro: dict[str, float]) -> Iterator[Statement]:
    """What the master itself costs, beside other tools."""
    others = [name for name in macro if name.startswith((ECOS, GETTERS))]
    note = "; ".join(f"{name}: {1e6 * over_units(macro, name):.2g}" for name in others)
    value = 1e6 * over_units(macro, PYTHON)
    yield Statement(f"{PYTHON}: a macro step of three units over their own time, µs", value, 5.0, True, note)


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:g} ms"
