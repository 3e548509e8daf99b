"""What an FMU says about itself, in one form for FMI 2.0 and 3.0."""

import atexit
import re
import shutil
import tempfile
from dataclasses import dataclass
from itertools import product
from math import prod
from os import PathLike
from pathlib import Path
from threading import Lock
from xml.etree import ElementTree

import fmpy
import numpy as np
from fmpy.model_description import ModelDescription, ModelVariable

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
DIMENSIONLESS = (0,) * len(BASE_UNITS)

# How a type is moved: FMI version -> type -> (suffix of the C functions, layout in memory).
ACCESS = {
    "2.0": {
        "Float64": ("Real", np.float64),
        "Int32": ("Integer", np.int32),
        "Enumeration": ("Integer", np.int32),
        "Boolean": ("Boolean", np.int32),
    },
    "3.0": {
        "Float64": ("Float64", np.float64),
        "Float32": ("Float32", np.float32),
        "Int8": ("Int8", np.int8),
        "UInt8": ("UInt8", np.uint8),
        "Int16": ("Int16", np.int16),
        "UInt16": ("UInt16", np.uint16),
        "Int32": ("Int32", np.int32),
        "UInt32": ("UInt32", np.uint32),
        "Int64": ("Int64", np.int64),
        "UInt64": ("UInt64", np.uint64),
        "Enumeration": ("Int64", np.int64),
        "Boolean": ("Boolean", np.bool_),
    },
}
FMI3_TYPES = {"Real": "Float64", "Integer": "Int32"}


@dataclass(frozen=True)
class PhysicalUnit:
    """A physical unit: value in SI = factor * value + offset, in the product of the base units to their exponents."""

    name: str
    exponents: tuple[int, ...] | None = None
    factor: float = 1.0
    offset: float = 0.0

    def __str__(self) -> str:
        """Its name, as the FMU writes it."""
        return self.name

    def matches(self, other: "PhysicalUnit") -> bool:
        """Whether a number means the same in both; units without a definition match by their names."""
        if self.exponents is None or other.exponents is None:
            return self.name == other.name
        return (self.exponents, self.factor, self.offset) == (other.exponents, other.factor, other.offset)


ONE = PhysicalUnit("1", DIMENSIONLESS)


@dataclass(frozen=True)
class Variable:
    """One variable; in FMI 2, one array gathered from its elements name[1], name[2] ..."""

    name: str
    type: str
    """As FMI 3 names it: Float64, Int32, Boolean, Enumeration, String ..."""
    references: tuple[int, ...]
    """One for a scalar or an FMI 3 array, one for each element in FMI 2."""
    dimensions: tuple[int | str, ...]
    """Sizes; a name is that of the structural parameter that holds the size."""
    causality: str
    variability: str
    unit: PhysicalUnit
    start: tuple[str, ...]
    entries: tuple[tuple[str, int], ...]
    """Names and values of an enumeration."""
    description: str
    nominal: float = 1.0


@dataclass(frozen=True)
class Description:
    """What the master needs of an FMU. `folder` holds the extracted files until the process ends."""

    name: str
    version: str
    token: str
    identifier: str
    folder: Path
    variables: dict[str, Variable]
    terminals: dict[str, dict[str, str]]
    """Terminal -> member -> variable."""
    dependencies: dict[str, frozenset[str]]
    """Output -> the inputs that it depends on directly."""
    log_categories: frozenset[str]
    saves_state: bool
    serializes_state: bool
    directional_derivatives: bool
    interpolates_inputs: bool
    """FMI 2: whether it takes slopes of inputs through fmi2SetRealInputDerivatives."""
    variable_step: bool
    """Whether it takes steps of any length."""
    has_states: bool
    """Whether it declares continuous states."""

    @property
    def stateless(self) -> bool:
        """Whether its derivatives say that its outputs follow from its inputs alone."""
        return self.directional_derivatives and not self.has_states

    def inputs_of(self, name: str) -> frozenset[str]:
        """The inputs that an output or a local variable may depend on directly: of the latter nothing is declared."""
        if self.variables[name].variability in ("constant", "fixed"):
            return frozenset()
        inputs = (variable.name for variable in self.variables.values() if variable.causality == "input")
        return self.dependencies[name] if name in self.dependencies else frozenset(inputs)

    @property
    def sampled(self) -> bool:
        """Whether its outputs change at events only: then what it is told counts when it is told."""
        outputs = [variable for variable in self.variables.values() if variable.causality == "output"]
        return all(variable.variability == "discrete" for variable in outputs)


_cache: dict[tuple, Description] = {}
_cache_lock = Lock()


def read_description(path: str | PathLike) -> Description:
    """Extracts an FMU and reads its description, once per process and file.

    Raises FileNotFoundError, and ValueError for an FMU that cannot be co-simulated.
    """
    path = Path(path).resolve()
    status = path.stat()
    key = (path, status.st_mtime_ns, status.st_size)
    with _cache_lock:
        if key not in _cache:
            _cache[key] = _extract(path)
        return _cache[key]


def _extract(path: Path) -> Description:
    folder = Path(tempfile.mkdtemp(prefix=f"ulna-{path.stem}-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    fmpy.extract(str(path), unzipdir=str(folder))
    model = fmpy.read_model_description(str(folder))
    version = f"{model.fmiVersion[0]}.0"
    if version not in ACCESS:
        raise ValueError(f"{path}: FMI {model.fmiVersion} is not supported, only 2.0 and 3.0")
    if model.coSimulation is None:
        raise ValueError(f"{path}: {model.modelName} has no co-simulation interface")
    groups = _gather(model)
    variables = {name: _variable(name, group, model) for name, group in groups.items()}
    owner = {id(element): name for name, group in groups.items() for element in group}
    return Description(
        name=model.modelName,
        version=version,
        token=model.guid,
        identifier=model.coSimulation.modelIdentifier,
        folder=folder,
        variables=variables,
        terminals=_terminals(folder, owner_by_name={e.name: n for n, g in groups.items() for e in g}),
        dependencies=_dependencies(model, owner, variables),
        log_categories=frozenset(category.name for category in model.logCategories),
        saves_state=model.coSimulation.canGetAndSetFMUstate,
        serializes_state=model.coSimulation.canSerializeFMUstate,
        directional_derivatives=_gives_directional_derivatives(folder),
        interpolates_inputs=version == "2.0" and bool(model.coSimulation.canInterpolateInputs),
        variable_step=bool(model.coSimulation.canHandleVariableCommunicationStepSize),
        has_states=bool(model.derivatives),
    )


def _gives_directional_derivatives(folder: Path) -> bool:
    """FMPy knows the attribute by its name in FMI 2 only."""
    interface = ElementTree.parse(folder / "modelDescription.xml").getroot().find("CoSimulation")
    names = ("providesDirectionalDerivative", "providesDirectionalDerivatives")
    return any(interface.get(name) in ("true", "1") for name in names)


def _gather(model: ModelDescription) -> dict[str, list[ModelVariable]]:
    """Variables by name; in FMI 2 the elements name[1], name[2] ... of a whole array become one."""
    if model.fmiMajorVersion == 3:
        return {variable.name: [variable] for variable in model.modelVariables}
    arrays: dict[str, dict[tuple[int, ...], ModelVariable]] = {}
    for variable in model.modelVariables:
        stem, index = split_index(variable.name)
        arrays.setdefault(stem, {})[index] = variable
    groups: dict[str, list[ModelVariable]] = {}
    for stem, elements in arrays.items():
        if _is_whole(elements):
            groups[stem] = [elements[index] for index in sorted(elements)]
        else:
            groups.update({variable.name: [variable] for variable in elements.values()})
    return groups


def split_index(name: str) -> tuple[str, tuple[int, ...]]:
    """ "der(x[2,3])" -> ("der(x)", (2, 3)); a name without an index has the index ()."""
    match = re.fullmatch(r"(.+)\[(\d+(?:,\d+)*)\](\)*)", name)
    if not match:
        return name, ()
    return match[1] + match[3], tuple(int(number) for number in match[2].split(","))


def _is_whole(elements: dict[tuple[int, ...], ModelVariable]) -> bool:
    if len({(v.type, v.causality, v.variability, v.unit) for v in elements.values()}) > 1:
        return False
    if len({len(index) for index in elements}) > 1:
        return False
    return set(elements) == set(product(*(range(1, size + 1) for size in _extent(elements))))


def _extent(indices) -> tuple[int, ...]:
    return tuple(max(numbers) for numbers in zip(*indices, strict=True))


def _variable(name: str, elements: list[ModelVariable], model: ModelDescription) -> Variable:
    first = elements[0]
    declared = first.declaredType
    if first.dimensions:
        dimensions = tuple(d.start if d.start is not None else d.variable.name for d in first.dimensions)
    else:
        dimensions = _extent([split_index(e.name)[1] for e in elements]) if name != first.name else ()
    starts = [first.start or ""] if first.type == "String" else " ".join(e.start or "" for e in elements).split()
    return Variable(
        name=name,
        type=FMI3_TYPES.get(first.type, first.type),
        references=tuple(element.valueReference for element in elements),
        dimensions=dimensions,
        causality=first.causality,
        variability=first.variability,
        unit=_unit(first.unit or (declared.unit if declared else None), model),
        start=tuple(starts),
        entries=tuple((item.name, int(item.value)) for item in declared.items) if declared else (),
        description=first.description or "",
        nominal=float(first.nominal or 1.0),
    )


def _unit(name: str | None, model: ModelDescription) -> PhysicalUnit:
    if name in (None, "", "1"):
        return ONE
    base = next((unit.baseUnit for unit in model.unitDefinitions if unit.name == name), None)
    if base is None:
        return PhysicalUnit(name)
    return PhysicalUnit(name, tuple(getattr(base, symbol) for symbol in BASE_UNITS), base.factor, base.offset)


def _dependencies(
    model: ModelDescription, owner: dict[int, str], variables: dict[str, Variable]
) -> dict[str, frozenset[str]]:
    """A missing list of dependencies means, in both standards, that the output may depend on every input."""
    inputs = frozenset(name for name, variable in variables.items() if variable.causality == "input")
    dependencies: dict[str, frozenset[str]] = {}
    for unknown in model.outputs:
        known = inputs if unknown.dependencies is None else {owner[id(v)] for v in unknown.dependencies} & inputs
        name = owner[id(unknown.variable)]
        dependencies[name] = dependencies.get(name, frozenset()) | known
    return dependencies


def _terminals(folder: Path, owner_by_name: dict[str, str]) -> dict[str, dict[str, str]]:
    """Terminals of the FMU; in FMI 2 the same file may list arrays whole or by element."""
    terminals = {}
    for path in sorted(folder.rglob("terminalsAndIcons.xml"))[:1]:
        for terminal in ElementTree.parse(path).getroot().iterfind("Terminals/Terminal"):
            members = {}
            for member in terminal.iterfind("TerminalMemberVariable"):
                name = member.get("variableName", "")
                label = split_index(member.get("memberName", name))[0]
                members[label] = owner_by_name.get(name, name)
            terminals[terminal.get("name", "")] = members
    return terminals


def shape_of(variable: Variable, sizes: dict[str, int]) -> tuple[int, ...]:
    """Shape of a variable for the given values of the structural parameters."""
    return tuple(sizes[size] if isinstance(size, str) else size for size in variable.dimensions)


def count_of(variable: Variable, sizes: dict[str, int]) -> int:
    """Number of elements of a variable."""
    return prod(shape_of(variable, sizes))
