"""A scene: units, what connects them, what is recorded; and its run."""

from collections.abc import Callable, Sequence
from copy import deepcopy
from os import PathLike
from typing import Any

from .adaptive import Controlled
from .connections import Bond, Connection, End, Frame, Signal, connect_ends, connect_frames
from .coupling import Coupling
from .hearing import pairs_of_bursts
from .joints import Joint, make_joint, wrench_ends
from .masters import MASTERS
from .names import unknown
from .ordering import Loop, find_loops, step_order
from .results import Results
from .running import check_signal, march, time_grid
from .settling import settle
from .slave import Slave
from .watch import Watch

SETTABLE = ("structuralParameter", "parameter", "input")


class SceneUnit:
    """A unit in a scene. `unit.NAME`, or unit["NAME"], is what can be connected: its frames, inputs and outputs."""

    def __init__(self, slave: Slave):
        """Takes a fresh instance."""
        self.slave = slave
        self.name = slave.name
        self._values: dict[str, Any] = {}
        self._used = False

    def set(self, name: str, value: Any) -> None:
        """Sets a parameter, or the start value of an input, for all runs to come; errors as those of `Slave.set`."""
        variable = self.slave.variable(name)
        if variable.causality not in SETTABLE:
            raise ValueError(f"{self.name}.{name} is {variable.causality}: only parameters and inputs can be set")
        self.renew()
        self.slave.set(name, value)
        self._values[name] = deepcopy(value)

    def renew(self) -> None:
        """Back to before initialization, with all that was set, if a run has used the unit."""
        if not self._used:
            return
        self.slave.reset()
        self._used = False
        for name, value in self._values.items():
            self.slave.set(name, value)

    def initialize(self, start: float) -> None:
        """Enters initialization mode, for a run."""
        self.renew()
        self._used = True
        self.slave.enter_initialization(start)

    def outputs(self) -> list[End]:
        """All outputs that are numbers."""
        variables = self.slave.description.variables.values()
        return [
            End(self, v) for v in variables if v.causality == "output" and v.type not in ("String", "Binary", "Clock")
        ]

    def frame(self, name: str, **members: str) -> Frame:
        """A frame of any variables, for a unit without terminals: position="x", force="f", ...

        The members that `Scene.join` asks for are position, velocity, force; with an axis or damping also orientation,
        angular_velocity, torque. Raises KeyError with the nearest right names.
        """
        return Frame(self, name, {member: End(self, self.slave.variable(v)) for member, v in members.items()})

    def __getitem__(self, name: str) -> End | Frame:
        """What can be connected under a name, frames first; raises KeyError with the nearest right names."""
        description = self.slave.description
        if name in description.terminals:
            members = description.terminals[name]
            return Frame(self, name, {member: End(self, self.slave.variable(v)) for member, v in members.items()})
        variable = description.variables.get(name)
        if variable is None:
            known = [v.name for v in description.variables.values() if v.causality in ("input", "output")]
            raise KeyError(unknown(self.name, "input, output or frame", name, [*description.terminals, *known]))
        if variable.causality in ("parameter", "structuralParameter"):
            raise KeyError(f"{self.name}.{name} is a parameter, which is set, not connected")
        return End(self, variable)

    def __getattr__(self, name: str) -> End | Frame:
        """As `unit[name]`; raises AttributeError."""
        if name.startswith("_") or name == "slave":
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError as error:
            raise AttributeError(error.args[0]) from None

    def __repr__(self) -> str:
        """Its name and that of the FMU."""
        return f"<unit {self.name}: {self.slave.description.name}>"


class Scene:
    """Units that are simulated together."""

    def __init__(self, name: str = "scene"):
        """An empty scene."""
        self.name = name
        self.units: dict[str, SceneUnit] = {}
        self.connections: list[Connection] = []
        self.signals: list[Signal] = []
        self.bonds: list[Bond] = []
        self.joints: list[Joint] = []
        self._recorded: dict[End, None] = {}

    def __enter__(self) -> "Scene":
        """For `with`: the units are freed at its end."""
        return self

    def __exit__(self, *_: object) -> None:
        """Frees all units."""
        self.close()

    def close(self) -> None:
        """Frees all units."""
        for unit in self.units.values():
            unit.slave.close()

    def __getitem__(self, name: str) -> SceneUnit:
        """The unit of that name; raises KeyError with the nearest right names."""
        if name not in self.units:
            raise KeyError(unknown(self.name, "unit", name, self.units))
        return self.units[name]

    def add(self, fmu: str | PathLike, name: str, /, *, version: str = "3.0", **values: Any) -> SceneUnit:
        """Adds an instance of an FMU, by the unit's name or by a path, with values of its parameters and inputs.

        Raises KeyError for a name that the unit does not have, ValueError and UnitError for values that do not fit.
        """
        if not name.isidentifier():
            raise ValueError(f"{name!r} cannot name a unit: letters, digits and _ only, no digit first")
        if name in self.units:
            raise ValueError(f"{self.name} already has a unit {name!r}")
        slave = Slave(fmu, name, version=version)
        try:
            unit = SceneUnit(slave)
            structural_first = sorted(values, key=lambda v: slave.variable(v).causality != "structuralParameter")
            for variable in structural_first:
                unit.set(variable, values[variable])
        except Exception:
            slave.close()
            raise
        self.units[name] = unit
        return unit

    def connect(
        self,
        source: End | Frame | str,
        target: End | Frame | str,
        factor: float | None = None,
        offset: float | None = None,
    ) -> None:
        """Connects an output to an input, target = factor * source + offset, or two frames member by member.

        Either may be given as `ball.position` or by its name, "ball.position". An array that a structural parameter
        sizes, as a mesh, may be local to its unit too; it is moved as a whole, and once only if it is fixed.

        A factor is in the target's unit per unit of the source, so it may join different units; an offset is in the
        target's unit. Raises ValueError, naming both ends, if type, size, unit or direction do not fit, or if the
        input is driven already.
        """
        source, target = (self._named(end) if isinstance(end, str) else end for end in (source, target))
        if isinstance(source, Frame) and isinstance(target, Frame):
            if (factor, offset) != (None, None):
                raise ValueError(f"cannot connect {source} to {target} with a factor or an offset: these are frames")
            connections, bonds = connect_frames(source, target)
        elif isinstance(source, End) and isinstance(target, End):
            connections, bonds = [connect_ends(source, target, factor, offset)], []
        else:
            raise ValueError(f"cannot connect {source} to {target}: one is a frame, the other is not")
        for connection in connections:
            self._refuse_second(connection.target, f"connect {connection.source} to {connection.target}")
        self.connections += connections
        self.bonds += bonds

    def _named(self, name: str) -> End | Frame:
        unit, _, variable = name.partition(".")
        return self[unit][variable]

    def hear(self, *names: str) -> None:
        """Lets ultrasonic sensors hear each other's bursts: connects the terminals `burst` and `foreign_N` of them all.

        Raises KeyError for an unknown name, ValueError for a unit that is no such sensor, or that hears three already.
        """
        for source, target in pairs_of_bursts([self[name] for name in names], self.connections):
            self.connect(source, target)

    def signal(self, target: End, function: Callable[[float], Any]) -> None:
        """Lets an input follow a function of time (s), which returns a number, or an array of the input's shape."""
        if not isinstance(target, End) or target.variable.causality != "input":
            raise ValueError(f"cannot drive {target} by a signal: it is no input")
        self._refuse_second(target, f"drive {target} by a signal")
        self.signals.append(Signal(target, function))

    def join(
        self, first: Frame | str, second: Frame, axis: Sequence[float] | None = None, *, damping: float = 0.0
    ) -> None:
        """Joins two frames rigidly, or one to the "world" where it is at the start: a hinge about `axis`, or a ball.

        `axis` is in the axes of the first frame (of the world). `damping` (N.m.s/rad) is torque against the relative
        angular velocity. The frames must meet at the start, at rest to each other but for what the joint leaves free;
        their units must restore their states, and are stepped by the master `rigid`. Raises ValueError for frames that
        lack a member, for values out of range, and for a wrench that is driven already.
        """
        joint = make_joint(first, second, axis, damping)
        for end in wrench_ends(joint):
            self._refuse_second(end, f"join {joint}", jointly=True)
        self.joints.append(joint)

    def _refuse_second(self, target: End, wish: str, *, jointly: bool = False) -> None:
        for connection in self.connections:
            if connection.target == target:
                raise ValueError(f"cannot {wish}: {connection.source} is connected to {target.name} already")
        if any(signal.target == target for signal in self.signals):
            raise ValueError(f"cannot {wish}: a signal drives {target.name} already")
        if not jointly and any(target in wrench_ends(joint) for joint in self.joints):
            raise ValueError(f"cannot {wish}: a joint drives {target.name} already")

    def record(self, *what: SceneUnit | End | Frame) -> None:
        """Chooses what is recorded: variables, or all outputs of a unit or a frame. Without a choice, all outputs."""
        for item in what:
            if isinstance(item, SceneUnit):
                ends = item.outputs()
            elif isinstance(item, Frame):
                ends = [end for end in item.members.values() if end.variable.causality == "output"]
            else:
                ends = [item]
            self._recorded.update(dict.fromkeys(ends))

    def loops(self) -> list[Loop]:
        """The loops of the connections, and where the master `gauss_seidel` opens them."""
        return find_loops(list(self.units), self._moving())

    def _moving(self) -> list[Connection]:
        """The connections whose values change, which make the order of the units."""
        return [connection for connection in self.connections if not connection.once]

    def run(
        self,
        until: float,
        step: float,
        *,
        start: float = 0.0,
        master: str | None = None,
        extrapolation: int = 0,
        tolerance: float | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Results:
        """Simulates from `start` to `until` in steps of `step` (s); times are start + n * step, to the bit.

        `master` is by default `rigid` for a scene with joints, and else `gauss_seidel`. `extrapolation` is the order,
        0 or 1, in which explicit masters continue inputs over a step. With `tolerance`, the error of an input over its
        nominal plus largest value, the units step as far between the rows as it allows; all must restore their states.

        If `until` is no whole number of steps away, the last step is shorter. `progress` is called with the time
        now and then. A unit that fails raises UnitError, a loop that does not settle CouplingError; their `results`
        hold the rows until then. A CouplingWarning says that the coupling makes the run wrong. A unit that asks for
        the end of the simulation ends the run after that step. A scene can be run again, from its start.
        """
        master = master or ("rigid" if self.joints else "gauss_seidel")
        if master not in MASTERS:
            raise ValueError(unknown("ulna", "master", master, MASTERS))
        if self.joints and master != "rigid":
            raise ValueError(f"the master {master} knows no joints; take rigid")
        if extrapolation not in (0, 1):
            raise ValueError(f"extrapolation = {extrapolation}; allowed: 0, 1")
        if tolerance is not None and not 0.0 < tolerance < 1.0:
            raise ValueError(f"tolerance = {tolerance}; allowed range: between 0 and 1")
        grid = time_grid(start, until, step)
        for signal in self.signals:
            check_signal(signal, start)
        for unit in self.units.values():
            unit.initialize(start)
        recorded = list(self._recorded) or [end for unit in self.units.values() for end in unit.outputs()]
        slaves = {name: unit.slave for name, unit in self.units.items()}
        order = step_order(list(self.units), self._moving())
        coupling = Coupling(slaves, order, self.connections, self.signals, recorded, self.bonds, self.joints)
        coupling.step.value = step
        loops = self.loops()
        summary = {"scene": self.name, "master": master, "step": step, "loops": [str(loop) for loop in loops]}
        summary["initial_passes"] = settle(
            coupling, start, [x for x in loops if x.algebraic], newton=MASTERS[master].implicit
        )
        advance = MASTERS[master].prepare(coupling, extrapolation)
        watch = Watch(coupling)
        if tolerance is not None:
            advance = Controlled(coupling, advance, watch, tolerance, MASTERS[master].orders[extrapolation])
        return march(coupling, advance, watch, grid, recorded, summary, progress)
