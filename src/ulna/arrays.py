"""Whole arrays from unit to unit: a mesh. Each has a buffer of its own, into which its source is read and from which
its targets are set, beside the flat arrays that are recorded; what is fixed moves once."""

from collections.abc import Sequence

import numpy as np

from .connections import Connection, End, check_sizes
from .port import Port


class Arrays:
    """The connections of a scene that move whole arrays, ready to be called."""

    def __init__(self, connections: Sequence[Connection]):
        """Raises ValueError for ends whose sizes have come to differ."""
        self.getters: dict[str, list[Port]] = {}
        """By unit: what reads its arrays after a step."""
        self.setters: dict[str, list[Port]] = {}
        """By unit: what sets its arrays before one."""
        self.moves: dict[str, list[tuple]] = {}
        """By unit: functions and arguments that turn what was read into what is set, where that is not the same."""
        self.once: tuple[list[Port], list[tuple], list[Port]] = [], [], []
        """Getters, moves and setters of what is fixed."""
        self.buffers: list[np.ndarray] = []
        """What is exchanged, but for what is fixed."""
        self.sources, self.targets = [c.source for c in connections], [c.target for c in connections]
        sources: dict[End, Port] = {}
        for connection in connections:
            self._add(connection, sources)

    def _add(self, connection: Connection, sources: dict[End, Port]) -> None:
        source, target = connection.source, connection.target
        check_sizes(source, target)
        if source not in sources:
            sources[source] = source.unit.slave.getter([source.variable.name])
            self._keep(connection, 0, source, sources[source])
        values = sources[source].values
        setter = target.unit.slave.setter([target.variable.name], None if converts(connection) else values)
        self._keep(connection, 2, target, setter)
        if converts(connection):
            moves = self.once[1] if connection.once else self.moves.setdefault(target.unit.name, [])
            moves.append((np.copyto, (setter.values, values, "unsafe")))
            if connection.scaled:
                moves.append((np.multiply, (setter.values, setter.values.dtype.type(connection.factor), setter.values)))
                moves.append((np.add, (setter.values, setter.values.dtype.type(connection.offset), setter.values)))

    def _keep(self, connection: Connection, place: int, end: End, port: Port) -> None:
        if connection.once:
            self.once[place].append(port)
            return
        (self.getters, None, self.setters)[place].setdefault(end.unit.name, []).append(port)
        self.buffers.append(port.values)


def converts(connection: Connection) -> bool:
    """Whether what is set is not, bit by bit, what was read."""
    source, target = connection.source, connection.target
    return connection.scaled or source.unit.slave.access(source.variable) != target.unit.slave.access(target.variable)
