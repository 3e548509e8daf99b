"""Reading `unit.toml`, the one place where a unit's variables are declared."""

import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from .units import exponents, per_second

SECTIONS = {
    "structural": "structuralParameter",
    "parameter": "parameter",
    "input": "input",
    "output": "output",
    "local": "local",
    "memory": "memory",
}
TYPES = ("Float64", "Float32", "Int32", "UInt64", "Boolean", "Enumeration")
SET_FROM_OUTSIDE = {"structuralParameter", "parameter", "input"}


class DeclarationError(ValueError):
    """A `unit.toml` that cannot be used; the message names the file, the variable and the remedy."""


@dataclass(frozen=True)
class Variable:
    """One variable of a unit. `size` holds numbers and names of structural parameters; () is a scalar."""

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

    def by_name(self, name: str) -> Variable:
        """The variable of that name; KeyError if there is none."""
        return next(v for v in self.variables if v.name == name)


def _tuple(value: object) -> tuple:
    return tuple(value) if isinstance(value, list) else (value,)


def _start(entry: dict, count: int, enumerations: dict[str, dict[str, str]]) -> tuple[float, ...]:
    if entry.get("quaternion"):
        default: object = [1.0, 0.0, 0.0, 0.0]
    else:
        default = False if entry.get("type") == "Boolean" else 0.0
    start = entry.get("start", default)
    if "enumeration" in entry:
        entries = list(enumerations[entry["enumeration"]])
        return (entries.index(start) + 1 if start else 1,)
    return tuple(start) if isinstance(start, list) else (start,) * count


def _variable(section: str, name: str, entry: dict, enumerations: dict[str, dict[str, str]]) -> Variable:
    known = {f for f in Variable.__dataclass_fields__} | {"derivative_depends"}
    unknown = set(entry) - known
    if unknown:
        raise DeclarationError(f"unknown key {', '.join(sorted(unknown))}; known: {', '.join(sorted(known))}")
    causality = SECTIONS[section]
    quaternion = entry.get("quaternion", False)
    size = (4,) if quaternion else _tuple(entry["size"]) if "size" in entry else ()
    kind = "Enumeration" if "enumeration" in entry else entry.get("type", "Float64")
    if kind not in TYPES:
        raise DeclarationError(f"type {kind!r} is none of {', '.join(TYPES)}")
    stream = entry.get("stream", False)
    computed = causality in ("output", "local") and not entry.get("state") and not stream
    group = entry.get("group", "outputs") if computed else None
    floating = kind in ("Float64", "Float32")
    usual = "fixed" if "arameter" in causality else "continuous" if floating else "discrete"
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
        fmi=(3,) if stream else tuple(entry.get("fmi", (2, 3))),
    )
    exponents(variable.unit)
    if not stream and any(isinstance(n, str) for n in size):
        raise DeclarationError("only a stream may have a dimension that is a structural parameter")
    if causality != "memory" and not variable.description:
        raise DeclarationError("has no description")
    if stream:
        return variable
    start = _start(entry, variable.count, enumerations)
    if len(start) != variable.count:
        raise DeclarationError(f"start has {len(start)} values for {variable.count} elements")
    return _replace(variable, start=start)


def _replace(variable: Variable, **changes: object) -> Variable:
    return Variable(**{**variable.__dict__, **changes})


def _with_companions(variable: Variable, entry: dict) -> list[Variable]:
    """A variable followed by what comes with it: its slope, or its derivative."""
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
    with path.open("rb") as file:
        raw = tomllib.load(file)
    enumerations = raw.get("enumeration", {})
    time = Variable(name="time", causality="independent", unit="s", start=(0.0,), description="Time")
    variables = [time]
    for section in SECTIONS:
        for name, entry in raw.get(section, {}).items():
            try:
                variables += _with_companions(_variable(section, name, entry, enumerations), entry)
            except (ValueError, KeyError) as error:
                raise DeclarationError(f"{path}: {section}.{name}: {error}") from error
    reference = 0
    numbered = []
    for variable in variables:
        numbered.append(_replace(variable, reference=reference))
        reference += 1 if variable.stream else variable.count
    declaration = Declaration(
        folder=path.parent,
        name=raw["name"],
        description=raw["description"],
        kinds=tuple(raw["kinds"]),
        sources=tuple(raw["sources"]),
        events=raw.get("events", False),
        workspace=raw.get("workspace"),
        directional_derivatives=raw.get("directional_derivatives", False),
        default_experiment=raw.get("default_experiment", {}),
        enumerations=enumerations,
        terminals=raw.get("terminal", {}),
        variables=tuple(numbered),
    )
    _check(path, declaration)
    return declaration


def _check(path: Path, declaration: Declaration) -> None:
    """Names that one variable uses of another must exist."""
    names = {v.name: v for v in declaration.variables}
    for variable in declaration.variables:
        for used in variable.depends:
            source = names.get(used.rstrip("@"))
            if source is None or not (source.causality == "input" or source.state):
                raise DeclarationError(f"{path}: {variable.name} depends on {used!r}, which is no input and no state")
        for terminal in variable.terminal:
            if terminal.split(".")[0] not in declaration.terminals:
                raise DeclarationError(f"{path}: {variable.name} belongs to {terminal!r}, a terminal not listed")
        for size in variable.size:
            if isinstance(size, str) and names.get(size, variable).causality != "structuralParameter":
                raise DeclarationError(f"{path}: {variable.name} has dimension {size!r}, no structural parameter")
