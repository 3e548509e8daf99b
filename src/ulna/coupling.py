"""A scene compiled for stepping: flat buffers, and lists of ready calls.

All that is read from the units lies in one flat array per number type (`outputs`), all that is written to them in
another (`inputs`). A unit reads and writes a slice of them with one call per type. A connection is a gather from
`outputs` into the slice of the unit that takes it, done for all inputs of a unit at once.
"""

from collections.abc import Callable, Iterable, Sequence
from ctypes import c_double
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .connections import Connection, End, Signal
from .slave import WARNING, Port, Slave

Call = tuple[Callable[..., int], tuple, Slave, str]
"""A C function, its arguments, whose it is and its name."""

Move = tuple[Callable[..., Any], tuple]
"""A function that moves numbers, and its arguments."""

Place = tuple[np.dtype, int, int]
"""Which flat array, first element, and one past the last."""


@dataclass
class Stage:
    """What is done for some units at once: signals, then transfers, then calls."""

    signals: list[tuple[np.ndarray, Callable[[float], Any]]] = field(default_factory=list)
    transfers: list[Move] = field(default_factory=list)
    calls: list[Call] = field(default_factory=list)


class Coupling:
    """The units of a scene with their connections, ready to be stepped by a master.

    `order` is the order of the units that respects their dependencies. `time` and `step` are the numbers that every
    step call reads. `stage` and `run` are all that a master needs beside them.
    """

    def __init__(
        self,
        slaves: dict[str, Slave],
        order: Sequence[str],
        connections: Sequence[Connection],
        signals: Sequence[Signal],
        recorded: Iterable[End],
    ):
        """Lays out the buffers: `recorded` and all sources are read after a step, all targets are written before it."""
        self.slaves = slaves
        self.units = list(slaves)
        self.order = list(order)
        self.time = c_double()
        self.step = c_double()
        read = dict.fromkeys([*recorded, *(connection.source for connection in connections)])
        written = {item.target: item for item in sorted([*connections, *signals], key=_cost)}
        self.outputs, self._output_places, self._getters = _lay_out(slaves, read, Slave.getter)
        self.inputs, self._input_places, self._setters = _lay_out(slaves, written, Slave.setter)
        self._signals = {name: self._watch(signals, name) for name in slaves}
        self._transfers = {name: self._plan([c for c in connections if c.target.unit.name == name]) for name in slaves}

    def output(self, end: End) -> np.ndarray:
        """Where a variable that is read lies, flat."""
        return _view(self.outputs, self._output_places[end])

    def place(self, end: End) -> Place:
        """Array, first element and one past the last of a variable that is read."""
        return self._output_places[end]

    def input(self, end: End) -> np.ndarray:
        """Where a variable that is written lies, flat."""
        return _view(self.inputs, self._input_places[end])

    def stage(self, units: Sequence[str], *, step: bool = True) -> Stage:
        """Takes the inputs of these units from `outputs`, sets them, steps all units (unless `step` is false, as in
        initialization), and reads their outputs."""
        stage = Stage()
        for name in units:
            stage.signals += self._signals[name]
            stage.transfers += self._transfers[name]
        stage.calls += [_call(port) for name in units for port in self._setters[name]]
        if step:
            stage.calls += [self._step_call(self.slaves[name]) for name in units]
        stage.calls += [_call(port) for name in units for port in self._getters[name]]
        return stage

    def reading(self) -> Stage:
        """Reads the outputs of all units."""
        return Stage(calls=[_call(port) for name in self.units for port in self._getters[name]])

    def snapshot(self) -> list[bytes]:
        """All values that are exchanged, for a comparison to the bit."""
        return [values.tobytes() for values in [*self.inputs.values(), *self.outputs.values()]]

    def run(self, stage: Stage, time: float) -> None:
        """Runs a stage, with signals at `time`; raises UnitError for the first call that fails."""
        for values, function in stage.signals:
            values[...] = function(time)
        for move, arguments in stage.transfers:
            move(*arguments)
        for call, arguments, slave, name in stage.calls:
            status = call(*arguments)
            if status > WARNING:
                slave.time = self.time.value
                slave.fail(name, status)

    def _step_call(self, slave: Slave) -> Call:
        return *slave.step_call(self.time, self.step), slave, f"fmi{slave.version[0]}DoStep"

    def _watch(self, signals: Sequence[Signal], unit: str) -> list[tuple[np.ndarray, Callable[[float], Any]]]:
        mine = [signal for signal in signals if signal.target.unit.name == unit]
        return [(self.input(s.target).reshape(s.target.shape), s.function) for s in mine]

    def _plan(self, connections: Sequence[Connection]) -> list[Move]:
        """The transfers into one unit: one gather for each run of adjacent inputs, then their factors and offsets."""
        moves: list[Move] = []
        for run in _runs([(self._input_places[c.target], c) for c in connections if not _casts(c)]):
            values = np.concatenate([np.arange(*self._output_places[c.source][1:]) for c in run])
            target = self._span(run)
            moves.append((self.outputs[target.dtype].take, (values, None, target, "clip")))
        for connection in filter(_casts, connections):
            moves.append((np.copyto, (self.input(connection.target), self.output(connection.source), "unsafe")))
        for run in _runs([(self._input_places[c.target], c) for c in connections if c.scaled]):
            target = self._span(run)
            sizes = [self.input(c.target).size for c in run]
            factors = np.repeat([c.factor for c in run], sizes).astype(target.dtype)
            offsets = np.repeat([c.offset for c in run], sizes).astype(target.dtype)
            moves.append((np.multiply, (target, factors, target)))
            moves.append((np.add, (target, offsets, target)))
        return moves

    def _span(self, run: Sequence[Connection]) -> np.ndarray:
        """The one slice of `inputs` that adjacent targets fill."""
        dtype, start, _ = self._input_places[run[0].target]
        return _view(self.inputs, (dtype, start, self._input_places[run[-1].target][2]))


def _cost(item: Connection | Signal) -> int:
    """Sorts what is written so that one gather, then one product, meets adjacent values."""
    if isinstance(item, Signal) or _casts(item):
        return 2
    return 1 if item.scaled else 0


def _casts(connection: Connection) -> bool:
    source, target = connection.source, connection.target
    return source.unit.slave.access(source.variable)[1] != target.unit.slave.access(target.variable)[1]


def _runs(placed: list[tuple[Place, Connection]]) -> list[list[Connection]]:
    """Groups connections whose targets lie side by side."""
    runs: list[list[Connection]] = []
    end: tuple | None = None
    for (dtype, start, stop), connection in sorted(placed, key=lambda item: (item[0][0].str, item[0][1])):
        if (dtype, start) == end:
            runs[-1].append(connection)
        else:
            runs.append([connection])
        end = (dtype, stop)
    return runs


def _lay_out(
    slaves: dict[str, Slave], ends: Iterable[End], make_port: Callable[..., Port]
) -> tuple[dict[np.dtype, np.ndarray], dict[End, Place], dict[str, list[Port]]]:
    """Flat arrays for these variables, the place of each, and per unit one port for each type."""
    groups: dict[tuple[str, str, np.dtype], list[End]] = {}
    for end in ends:
        suffix, dtype = end.unit.slave.access(end.variable)
        groups.setdefault((end.unit.name, suffix, np.dtype(dtype)), []).append(end)
    lengths: dict[np.dtype, int] = {}
    places: dict[End, Place] = {}
    for (_, _, dtype), group in groups.items():
        for end in group:
            start = lengths.get(dtype, 0)
            lengths[dtype] = start + end.unit.slave.count(end.variable)
            places[end] = (dtype, start, lengths[dtype])
    arrays = {dtype: np.zeros(length, dtype) for dtype, length in lengths.items()}
    ports: dict[str, list[Port]] = {name: [] for name in slaves}
    for (unit, _, dtype), group in groups.items():
        values = arrays[dtype][places[group[0]][1] : places[group[-1]][2]]
        ports[unit].append(make_port(slaves[unit], [end.variable.name for end in group], values))
    return arrays, places, ports


def _view(arrays: dict[np.dtype, np.ndarray], place: Place) -> np.ndarray:
    dtype, start, stop = place
    return arrays[dtype][start:stop]


def _call(port: Port) -> Call:
    return port.function, port.arguments, port.slave, port.name
