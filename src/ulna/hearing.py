"""Sensors that hear each other: each one's terminal `burst` goes to a free terminal `foreign_N` of each other."""

from collections.abc import Iterable, Sequence
from itertools import permutations
from typing import TYPE_CHECKING

from .connections import Connection, Frame

if TYPE_CHECKING:
    from .scene import SceneUnit

BURST = "burst"
FOREIGN = ("foreign_1", "foreign_2", "foreign_3")


def pairs_of_bursts(units: Sequence["SceneUnit"], connections: Iterable[Connection]) -> list[tuple[Frame, Frame]]:
    """Which frames to connect so that all `units` hear each other, given the connections that there are.

    Raises ValueError for fewer than two units, one named twice, one without these terminals, and where a unit has no
    free terminal left.
    """
    names = [unit.name for unit in units]
    if len(set(names)) < len(names) or len(names) < 2:
        raise ValueError(
            f"cannot let {', '.join(names) or 'nobody'} hear each other: name at least two different units"
        )
    for unit in units:
        missing = [name for name in (BURST, *FOREIGN) if name not in unit.slave.description.terminals]
        if missing:
            raise ValueError(f"cannot let {unit.name} hear others: it has no terminal {', '.join(missing)}")
    taken = {(connection.target.unit.name, connection.target.variable.name) for connection in connections}
    free = {unit.name: [unit[name] for name in FOREIGN if not _is_taken(unit[name], taken)] for unit in units}
    pairs = []
    for source, listener in permutations(units, 2):
        if not free[listener.name]:
            raise ValueError(
                f"cannot let {listener.name} hear {source.name}: it hears {len(FOREIGN)} others already, which is most"
            )
        pairs.append((source[BURST], free[listener.name].pop(0)))
    return pairs


def _is_taken(frame: Frame, taken: set[tuple[str, str]]) -> bool:
    return any((frame.unit.name, end.variable.name) in taken for end in frame.members.values())
