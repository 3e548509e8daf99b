"""A scene compiled for stepping: flat buffers, and lists of ready calls.

All that is read from the units lies in one flat array per number type (`outputs`), all that is written to them in
another (`inputs`). A unit reads and writes a slice of them with one call per type. A connection is a gather from
`outputs` into the slice of the unit that takes it, done for all inputs of a unit at once. Whole arrays, as of a mesh,
go beside both: see `arrays`.
"""

from collections.abc import Callable, Iterable, Sequence
from ctypes import c_double
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .arrays import Arrays
from .connections import Bond, Connection, End, Signal
from .joints import Joint, motion_ends, wrench_ends
from .messages import WARNING
from .port import Port
from .slave import Slave
from .slopes import SlopePort, slope_port

Call = tuple[Callable[..., Any], tuple, Slave | None, str]
"""A C function, its arguments, whose it is and its name; or, of no unit, a function that moves numbers."""

Move = tuple[Callable[..., Any], tuple]
"""A function that moves numbers, and its arguments."""

Place = tuple[np.dtype, int, int]
"""Which flat array, first element, and one past the last."""


@dataclass
class Stage:
    """What is done in one go: signals, then calls."""

    signals: list[tuple[np.ndarray, Callable[[float], Any]]] = field(default_factory=list)
    calls: list[Call] = field(default_factory=list)


class CouplingError(RuntimeError):
    """The units cannot be stepped together as asked; `results` holds what a run recorded before."""

    results: Any = None


class Coupling:
    """The units of a scene with their connections, ready to be stepped by a master.

    `order` is the order of the units that respects their dependencies. `time` and `step` are the numbers that every
    step call reads. `stage` and `run` are all that a master of order 0 needs beside them; those that draw lines through
    the inputs, or repeat steps, take the calls of each unit one by one.
    """

    def __init__(
        self,
        slaves: dict[str, Slave],
        order: Sequence[str],
        connections: Sequence[Connection],
        signals: Sequence[Signal],
        recorded: Iterable[End],
        bonds: Sequence[Bond] = (),
        joints: Sequence[Joint] = (),
    ):
        """Lays out the buffers: `recorded` and all sources are read after a step, all targets are written before it."""
        self.slaves = slaves
        self.units = list(slaves)
        self.order = list(order)
        self.time = c_double()
        self.step = c_double()
        self.figures: dict[str, float] = {}
        """What a master counts, for the summary."""
        self.late: frozenset[Connection] = frozenset()
        """Connections whose value at the end of a step is not known when the step begins, by the master."""
        self.lines = False
        """Whether inputs are straight lines over a step; else they are held."""
        self.memory: list[np.ndarray] = []
        """What a master remembers of the steps before: taken back with the units when a step is."""
        self.own_error = 0.0
        """Of the last step, what a master knows besides the connections, over its size."""
        self.bonds, self.joints = list(bonds), list(joints)
        self.kinetic, self.potential = (_energies(bonds, name) for name in ("kinetic_energy", "potential_energy"))
        """Energies of the units that bonds join, as far as they put them out."""
        self.arrays = Arrays([c for c in connections if c.whole])
        gathered = [c for c in connections if not c.whole]
        watched = [*self.kinetic, *self.potential, *(end for joint in joints for end in motion_ends(joint))]
        read = dict.fromkeys([*recorded, *(connection.source for connection in gathered), *watched])
        written = dict.fromkeys(item.target for item in sorted([*gathered, *signals], key=_cost))
        written |= dict.fromkeys(end for joint in joints for end in wrench_ends(joint))
        self.outputs, self._output_places, self._getters = _lay_out(slaves, read, Slave.getter)
        self.inputs, self._input_places, self._setters = _lay_out(slaves, written, Slave.setter)
        self.probed, self._probe_places, self._probes = _lay_out(slaves, _direct_wrenches(bonds), Slave.getter)
        """Wrenches that depend directly on the motion that they work on, as they are when a step begins."""
        for ports, whole in ((self._getters, self.arrays.getters), (self._setters, self.arrays.setters)):
            for name in whole:
                ports[name] += whole[name]
        self.connections = [c for c in connections if not c.once]
        self._driven = frozenset(written)
        self.signals = {name: self._watch(signals, name) for name in slaves}
        self.transfers = {
            name: self._plan([c for c in gathered if c.target.unit.name == name]) + self.arrays.moves.get(name, [])
            for name in slaves
        }

    def output(self, end: End) -> np.ndarray:
        """Where a variable that is read lies, flat."""
        return _view(self.outputs, self._output_places[end])

    def reads(self, end: End | None) -> bool:
        """Whether a variable is read."""
        return end in self._output_places

    def probe(self, end: End) -> slice | None:
        """Where the wrench of a bond lies in `probed`, if it is read there."""
        place = self._probe_places.get(end)
        return slice(*place[1:]) if place else None

    def place(self, end: End) -> Place:
        """Array, first element and one past the last of a variable that is read."""
        return self._output_places[end]

    def input(self, end: End) -> np.ndarray:
        """Where a variable that is written lies, flat."""
        return _view(self.inputs, self._input_places[end])

    def stage(self, groups: Sequence[Sequence[str]], *, step: bool = True) -> Stage:
        """All signals of these units; then, group by group: takes the inputs of the units from `outputs`, sets them,
        steps all (unless `step` is false, as in initialization), and reads their outputs."""
        stage = Stage()
        for units in groups:
            for name in units:
                stage.signals += self.signals[name]
                stage.calls += [(*move, None, "") for move in self.transfers[name]]
            stage.calls += self.sets(units)
            if step:
                stage.calls += self.probes(units)
                stage.calls += self.steps(units)
            stage.calls += self.gets(units)
        return stage

    def sets(self, units: Sequence[str]) -> list[Call]:
        """Calls that set the inputs of these units."""
        return [_call(port) for name in units for port in self._setters[name]]

    def probes(self, units: Sequence[str]) -> list[Call]:
        """Calls that read the wrenches of bonds once more, with the inputs of the begin of a step."""
        return [_call(port) for name in units for port in self._probes[name]]

    def gets(self, units: Sequence[str]) -> list[Call]:
        """Calls that read their outputs."""
        return [_call(port) for name in units for port in self._getters[name]]

    def steps(self, units: Sequence[str]) -> list[Call]:
        """Calls that step them."""
        slaves = [self.slaves[name] for name in units]
        return [(*slave.step_call(self.time, self.step), slave, f"fmi{slave.version[0]}DoStep") for slave in slaves]

    def rollbacks(self, units: Sequence[str]) -> tuple[list[Call], list[Call]]:
        """Calls that save their states, and that go back to them; raises ValueError for a unit that cannot."""
        calls: tuple[list[Call], list[Call]] = ([], [])
        for slave in (self.slaves[name] for name in units):
            for way, ways, invocation in zip(("Get", "Set"), calls, slave.rollback_calls(), strict=True):
                ways.append((*invocation, slave, f"fmi{slave.version[0]}{way}FMUState"))
        return calls

    def once(self) -> list[Call]:
        """Calls that move what is fixed; in initialization mode."""
        getters, moves, setters = self.arrays.once
        return [*map(_call, getters), *((*move, None, "") for move in moves), *map(_call, setters)]

    def reading(self) -> Stage:
        """Reads the outputs of all units."""
        return Stage(calls=self.gets(self.units))

    def float_inputs(self, units: Sequence[str]) -> list[tuple[End, slice]]:
        """The float64 inputs of these units that are driven, and the place of each in `inputs`."""
        places = [(end, place) for end, place in self._input_places.items() if end.unit.name in units]
        return [(end, slice(*place[1:])) for end, place in places if place[0] == np.float64]

    def float_outputs(self, unit: str) -> list[tuple[End, slice]]:
        """The float64 outputs of a unit that are read, and the place of each in `outputs`."""
        places = [(end, place) for end, place in self._output_places.items() if end.unit.name == unit]
        return [(end, slice(*place[1:])) for end, place in places if place[0] == np.float64]

    def feeds_through(self, unit: str) -> bool:
        """Whether what is read of a unit depends directly on what is written to it."""
        inputs_of = self.slaves[unit].description.inputs_of
        targets, sources = [*self._input_places, *self.arrays.targets], [*self._output_places, *self.arrays.sources]
        written = {end.variable.name for end in targets if end.unit.name == unit}
        return any(inputs_of(end.variable.name) & written for end in sources if end.unit.name == unit)

    def gather(self, units: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The float64 connections between these units, by element: place of the target, of the source, and factor."""
        inside = [c for c in self.connections if c.source.unit.name in units and c.target.unit.name in units]
        inside = [c for c in inside if not (c.whole or _casts(c)) and self._input_places[c.target][0] == np.float64]
        columns = [
            (
                np.arange(*self._input_places[c.target][1:]),
                np.arange(*self._output_places[c.source][1:]),
                np.full(self.input(c.target).size, c.factor),
            )
            for c in inside
        ]
        if not columns:
            return np.zeros(0, int), np.zeros(0, int), np.zeros(0)
        targets, sources, factors = (np.concatenate(column) for column in zip(*columns, strict=True))
        return targets, sources, factors

    def slopes(self, units: Sequence[str]) -> SlopePort:
        """The port for the slopes of the float64 inputs of these units, as far as they take them."""
        return slope_port({self.slaves[name]: self.float_inputs([name]) for name in units}, self._driven)

    def snapshot(self) -> list[np.ndarray]:
        """All values that are exchanged."""
        return [values.copy() for values in [*self.inputs.values(), *self.outputs.values(), *self.arrays.buffers]]

    def run(self, stage: Stage, time: float) -> None:
        """Runs a stage, with signals at `time`; raises UnitError for the first call that fails."""
        for values, function in stage.signals:
            values[...] = function(time)
        self.call(stage.calls)

    def call(self, calls: Sequence[Call]) -> None:
        """Makes these calls; raises UnitError for the first that fails."""
        for function, arguments, slave, name in calls:
            status = function(*arguments)
            if slave is not None and status > WARNING:
                self._fail(slave, name, status)

    def _fail(self, slave: Slave, name: str, status: int) -> None:
        slave.time = self.time.value
        slave.fail(name, status)

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


def _energies(bonds: Sequence[Bond], name: str) -> list[End]:
    units = dict.fromkeys(end.unit for bond in bonds for end in (bond.members[0][0].source, bond.members[0][0].target))
    found = [(unit, unit.slave.description.variables.get(name)) for unit in units]
    return [End(unit, variable) for unit, variable in found if variable and variable.causality == "output"]


def _direct_wrenches(bonds: Sequence[Bond]) -> list[End]:
    """The wrenches that depend directly on a motion of their bond."""
    found = []
    for bond in bonds:
        motions = {motion.target.variable.name for _, motion in bond.members}
        wrenches = [wrench.source for wrench, _ in bond.members]
        known = wrenches[0].unit.slave.description.dependencies
        if any(known.get(end.variable.name, motions) & motions for end in wrenches):
            found += wrenches
    return found


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
