"""Reading `unit.toml`, the one place where a unit's variables are declared."""

import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from .units import exponents, per_second
from .validation import check_keys, check_variable, one_of, problems

SECTIONS = {
    "structural": "structuralParameter",
    "parameter": "parameter",
    "input": "input",
    "output": "output",
    "local": "local",
    "memory": "memory",
}
SET_FROM_OUTSIDE = {"structuralParameter", "parameter", "input"}


class DeclarationError(ValueError):
    """A `unit.toml` that cannot be used; the message names the file, the variable and the remedy."""


@dataclass(frozen=True)
class Variable:
    """One variable of a unit.

    `size` holds numbers and names of structural parameters; () is a scalar. Of a Binary it is the number of bytes.
    """

    name: str
    causality: str
    type: str = "Float64"
    enumeration: str | None = None
    size: tuple[int | str, ...] = ()
    unit: str = "1"
    start: tuple[float, ...] | None = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    description: str = ""
    variability: str = "continuous"
    quaternion: bool = False
    state: bool = False
    rate: str | None = None
    group: str | None = None
    stream: bool = False
    mime_type: str = "application/octet-stream"
    interval: str | None = None
    depends: tuple[str, ...] = ()
    terminal: tuple[str, ...] = ()
    fmi: tuple[int, ...] = (2, 3)
    derivative_of: str | None = None
    reference: int = 0

    @property
    def field(self) -> str:
        """Name in the C struct."""
        return f"der_{self.derivative_of}" if self.derivative_of else self.name

    @property
    def count(self) -> int:
        """Elements, those of the fixed dimensions."""
        total = 1
        for n in self.size:
            total *= n if isinstance(n, int) else 1
        return total

    @property
    def extents(self) -> tuple[str, ...]:
        """The structural parameters among its dimensions."""
        return tuple(n for n in self.size if isinstance(n, str))

    @property
    def sized(self) -> bool:
        """True where a structural parameter sizes it and its values are kept: behind the C struct."""
        return bool(self.extents) and not self.stream

    @property
    def scalars(self) -> int:
        """How many value references it takes: one for each element of a fixed size."""
        return 1 if self.stream or self.extents else self.count

    @property
    def settable(self) -> bool:
        """True where an importer sets the value."""
        return self.causality in SET_FROM_OUTSIDE

    @property
    def visible(self) -> bool:
        """True where the model description shows it."""
        return self.causality != "memory"


@dataclass(frozen=True)
class Declaration:
    """A unit: its variables in the order of their value references, and what it can do."""

    folder: Path
    name: str
    description: str
    kinds: tuple[str, ...]
    sources: tuple[str, ...]
    events: bool
    workspace: str | None
    resources: bool
    directional_derivatives: bool
    default_experiment: dict[str, float]
    enumerations: dict[str, dict[str, str]]
    terminals: dict[str, str]
    variables: tuple[Variable, ...] = field(repr=False)

    @property
    def snake(self) -> str:
        """`RigidBody` -> `rigid_body`."""
        return re.sub(r"(?<!^)(?=[A-Z])", "_", self.name).lower()

    @property
    def groups(self) -> list[str]:
        """Groups of computed variables, in the order of first use."""
        return list(dict.fromkeys(v.group for v in self.variables if v.group and not v.stream))

    @property
    def sized(self) -> list[Variable]:
        """The arrays behind the C struct, in their order."""
        return [v for v in self.variables if v.sized]

    def by_name(self, name: str) -> Variable:
        """The variable of that name; KeyError if there is none."""
        return next(v for v in self.variables if v.name == name)


def _tuple(value: object) -> tuple:
    return tuple(value) if isinstance(value, list) else (value,)


def _start(entry: dict, count: int, enumerations: dict[str, dict[str, str]]) -> tuple[float, ...]:
    if entry.get("quaternion"):
        default: object = [1.0, 0.0, 0.0, 0.0]
    else:
        default = False if entry.get("type") in ("Boolean", "Clock") else 0.0
    start = entry.get("start", default)
    if "enumeration" in entry:
        one_of("enumeration", entry["enumeration"], enumerations)
        entries = list(enumerations[entry["enumeration"]])
        one_of("entry", entry.get("start", entries[0]), entries)
        return (entries.index(entry.get("start", entries[0])) + 1,)
    return tuple(start) if isinstance(start, list) else (start,) * count


def _variable(section: str, name: str, entry: dict, enumerations: dict[str, dict[str, str]]) -> Variable:
    known = {f for f in Variable.__dataclass_fields__} | {"derivative_depends"}
    unknown = set(entry) - known
    if unknown:
        raise ValueError(f"unknown key {', '.join(sorted(unknown))}; known: {', '.join(sorted(known))}")
    for derived in ({"quaternion", "size"}, {"enumeration", "type"}):
        if derived <= set(entry):
            raise ValueError(f"{' and '.join(sorted(derived))} exclude each other")
    causality = SECTIONS[section]
    quaternion = entry.get("quaternion", False)
    size = (4,) if quaternion else _tuple(entry["size"]) if "size" in entry else ()
    kind = "Enumeration" if "enumeration" in entry else entry.get("type", "Float64")
    stream = entry.get("stream", False)
    computed = causality in ("output", "local") and not entry.get("state") and not stream
    group = entry.get("group", "outputs") if computed else None
    floating = kind in ("Float64", "Float32")
    usual = "fixed" if "arameter" in causality else "continuous" if floating else "discrete"
    only_3 = stream or kind == "Clock" or any(isinstance(n, str) for n in size)
    variable = Variable(
        name=name,
        causality=causality,
        type=kind,
        enumeration=entry.get("enumeration"),
        size=size,
        unit=entry.get("unit", "1"),
        min=entry.get("min"),
        max=entry.get("max"),
        nominal=entry.get("nominal"),
        description=entry.get("description", ""),
        variability=entry.get("variability", usual),
        quaternion=quaternion,
        state=entry.get("state", False),
        group=None if group == "none" else group,
        stream=stream,
        depends=tuple(entry.get("depends", ())),
        terminal=_tuple(entry.get("terminal", [])),
        interval=entry.get("interval"),
        fmi=(3,) if only_3 else tuple(entry.get("fmi", (2, 3))),
    )
    exponents(variable.unit)
    if not stream:
        start = _start(entry, variable.count, enumerations)
        if len(start) != variable.count:
            raise ValueError(f"start has {len(start)} values for {variable.count} elements")
        variable = _replace(variable, start=start)
    check_variable(variable)
    return variable


def _replace(variable: Variable, **changes: object) -> Variable:
    return Variable(**{**variable.__dict__, **changes})


def _said_of(clock: Variable) -> list[Variable]:
    """What an importer was told of a clock last: when it ticks, and the interval until then, below 0 for nothing."""
    tick = Variable(name=f"{clock.name}_tick", causality="memory", unit="s", start=(-math.inf,))
    return [tick, _replace(tick, name=f"{clock.name}_interval", start=(-1.0,))]


def _with_companions(variable: Variable, entry: dict) -> list[Variable]:
    """A variable followed by what comes with it: its slope, its derivative, or what was said of it."""
    if entry.get("rate"):
        slope = Variable(
            name=f"{variable.name}_rate",
            causality="input",
            size=variable.size,
            unit=per_second(variable.unit),
            start=(0.0,) * variable.count,
            description=f"Slope of {variable.name} over the coming step",
            terminal=tuple(f"{t}_rate" for t in variable.terminal),
        )
        return [_replace(variable, rate=slope.name), slope]
    if variable.interval == "countdown":
        return [variable, *_said_of(variable)]
    if variable.state:
        derivative = Variable(
            name=f"der({variable.name})",
            causality="local",
            size=variable.size,
            unit=per_second(variable.unit),
            start=(0.0,) * variable.count,
            description=f"Time derivative of {variable.name}",
            group="derivatives",
            depends=tuple(entry.get("derivative_depends", ())),
            derivative_of=variable.name,
        )
        return [variable, derivative]
    return [variable]


def load(path: str | Path) -> Declaration:
    """Reads and checks a `unit.toml`.

    Raises DeclarationError, which names the file and the variable, when something does not fit.
    """
    path = Path(path)
    try:
        raw = tomllib.loads(path.read_text(encoding="utf-8"))
        check_keys(raw, SECTIONS)
    except ValueError as error:
        raise DeclarationError(f"{path}: {error}") from error
    enumerations = raw.get("enumeration", {})
    time = Variable(name="time", causality="independent", unit="s", start=(0.0,), description="Time")
    variables = [time]
    for section in SECTIONS:
        for name, entry in raw.get(section, {}).items():
            try:
                variables += _with_companions(_variable(section, name, entry, enumerations), entry)
            except ValueError as error:
                raise DeclarationError(f"{path}: {section}.{name}: {error}") from error
    reference = 0
    numbered = []
    for variable in variables:
        numbered.append(_replace(variable, reference=reference))
        reference += variable.scalars
    declaration = Declaration(
        folder=path.parent,
        name=raw["name"],
        description=raw["description"],
        kinds=tuple(raw["kinds"]),
        sources=tuple(raw["sources"]),
        events=raw.get("events", False),
        workspace=raw.get("workspace"),
        resources=raw.get("resources", False),
        directional_derivatives=raw.get("directional_derivatives", False),
        default_experiment=raw.get("default_experiment", {}),
        enumerations=enumerations,
        terminals=raw.get("terminal", {}),
        variables=tuple(numbered),
    )
    for problem in problems(declaration):
        raise DeclarationError(f"{path}: {problem}")
    return declaration
