"""What may be connected to what: ends, frames, and the checks on every connection."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .description import Variable

if TYPE_CHECKING:
    from .scene import SceneUnit

# Numbers connect within a kind, whatever their width.
KINDS = {"Float32": "float", "Float64": "float", "Boolean": "Boolean", "Enumeration": "enumeration"}
NO_NUMBERS = ("Clock", "String", "Binary")


@dataclass(frozen=True)
class End:
    """A variable of a unit in a scene: what `ball.position` is."""

    unit: "SceneUnit"
    variable: Variable

    @property
    def name(self) -> str:
        """Unit and variable, with a point between."""
        return f"{self.unit.name}.{self.variable.name}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Present shape of the variable; () for a scalar."""
        return self.unit.slave.shape(self.variable)

    @property
    def sized(self) -> bool:
        """Whether a structural parameter rules its size: an array that may be large."""
        return any(isinstance(size, str) for size in self.variable.dimensions)

    @property
    def kind(self) -> str:
        """What its values are, whatever their width: float, integer, Boolean or enumeration."""
        return KINDS.get(self.variable.type, "integer")

    def __str__(self) -> str:
        """What messages say of it: name, causality, type, size and unit."""
        sizes = "".join(f"[{size}]" for size in self.shape)
        return f"{self.name} ({self.variable.causality}, {self.variable.type}{sizes}, unit {self.variable.unit})"


@dataclass(frozen=True)
class Frame:
    """A terminal of a unit in a scene: variables that are connected together, by the names of its members."""

    unit: "SceneUnit"
    terminal: str
    members: dict[str, End]

    def __str__(self) -> str:
        """What messages say of it: name, and the causality of each member."""
        members = ", ".join(f"{name}: {end.variable.causality}" for name, end in self.members.items())
        return f"{self.unit.name}.{self.terminal} (frame of {members})"


@dataclass(frozen=True)
class Connection:
    """target = factor * source + offset."""

    source: End
    target: End
    factor: float = 1.0
    offset: float = 0.0

    @property
    def scaled(self) -> bool:
        """Whether the value changes on the way."""
        return (self.factor, self.offset) != (1.0, 0.0)

    @property
    def once(self) -> bool:
        """Whether the source keeps its value after initialization."""
        return self.source.variable.variability in ("constant", "fixed")

    @property
    def whole(self) -> bool:
        """Whether it is moved by itself, not with the other values of a unit."""
        return self.once or self.source.sized or self.target.sized

    def __str__(self) -> str:
        """`a.position -> b.position`."""
        return f"{self.source.name} -> {self.target.name}"


@dataclass(frozen=True)
class Bond:
    """A frame connected to a frame: one gives its motion, the other a wrench, and energy passes."""

    members: tuple[tuple[Connection, Connection], ...]
    """Force with velocity, torque with angular velocity: each wrench, and the motion that it works on."""


# Wrench -> the motion that it works on, by the names of members.
CONJUGATE = {"force": "velocity", "torque": "angular_velocity"}


@dataclass(frozen=True)
class Signal:
    """An input that follows a function of time, in seconds."""

    target: End
    function: Callable[[float], Any]


def connect_ends(source: End, target: End, factor: float | None, offset: float | None) -> Connection:
    """The checked connection of two variables.

    A factor converts: it is in the target's unit per unit of the source, so the units may then differ. Without one,
    also with an offset, both ends must have the same unit: the same powers of the SI base units and the same scale.
    Raises ValueError, with both ends in the message.
    """
    both = f"{source} to {target}"
    if source.variable.causality != "output" and not (source.variable.causality == "local" and source.sized):
        hint = "; connect them the other way round" if target.variable.causality == "output" else ""
        raise ValueError(f"cannot connect {both}: the source is no output{hint}")
    if target.variable.causality != "input":
        raise ValueError(f"cannot connect {both}: the target is no input")
    for end in (source, target):
        if end.variable.type in NO_NUMBERS:
            raise ValueError(f"cannot connect {both}: {end.name} is a {end.variable.type}, which holds no numbers")
    if source.kind != target.kind or source.variable.entries != target.variable.entries:
        raise ValueError(f"cannot connect {both}: their types differ")
    check_sizes(source, target)
    if factor is None and not source.variable.unit.matches(target.variable.unit):
        raise ValueError(f"cannot connect {both}: their units differ; a factor would convert them")
    if (factor, offset) != (None, None) and source.kind != "float":
        raise ValueError(f"cannot connect {both}: a factor or an offset needs floating-point ends")
    return Connection(source, target, 1.0 if factor is None else float(factor), float(offset or 0.0))


def check_sizes(source: End, target: End) -> None:
    """Raises ValueError, with both ends in the message, unless they have the same shape now."""
    if source.shape != target.shape:
        sizes = [(end.unit.name, size) for end in (source, target) for size in end.variable.dimensions]
        rulers = " and ".join(f"{unit}.{size}" for unit, size in sizes if isinstance(size, str))
        hint = f"; set {rulers}" if rulers else ""
        raise ValueError(f"cannot connect {source} to {target}: their sizes differ{hint}")


def connect_frames(first: Frame, second: Frame) -> tuple[list[Connection], list[Bond]]:
    """Connects the members that both frames have, each from its output to its input, whichever side that is on.

    Motion so goes one way and the wrench comes back. Members that only one side has are left as they are; a member
    that both sides put out is a contradiction that no explicit connection can settle. Where motion and wrench pass
    each other there is a bond as well.
    """
    connections: dict[str, Connection] = {}
    for name in [name for name in first.members if name in second.members]:
        ends = [first.members[name], second.members[name]]
        outputs = [end for end in ends if end.variable.causality == "output"]
        if len(outputs) == 2:
            raise ValueError(f"cannot connect {first} to {second}: both put out {name}; one side must take it")
        if len(outputs) == 1:
            ends.sort(key=lambda end: end.variable.causality != "output")
            connections[name] = connect_ends(*ends, None, None)
    if not connections:
        raise ValueError(f"cannot connect {first} to {second}: no member of one is an input of the other")
    members = tuple(
        (connections[wrench], connections[motion])
        for wrench, motion in CONJUGATE.items()
        if wrench in connections
        and motion in connections
        and connections[wrench].source.unit is connections[motion].target.unit
    )
    return list(connections.values()), [Bond(members)] if members else []
