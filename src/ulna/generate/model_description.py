"""`modelDescription.xml` for FMI 3.0 (arrays) and FMI 2.0 (arrays written out as scalars)."""

import math
from collections.abc import Iterator
from xml.etree import ElementTree as ET

from .declaration import Declaration, Variable
from .units import exponents

GENERATION_TOOL = "Ulna"
LOG_CATEGORIES = {
    "logStatusError": "What went wrong, and what is allowed",
    "logStatusWarning": "What is doubtful",
    "logEvents": "Events as they are handled",
}
FMI2_TYPES = {
    "Float64": "Real",
    "Int32": "Integer",
    "UInt64": "Integer",
    "Boolean": "Boolean",
    "Enumeration": "Enumeration",
}


CLOCK_RESOLUTION = 2**50
"""Of intervals as fractions, per second; the one that fmi3_clocks.c gives: finer than the rounding of a time."""


def _text(value: float | bool | str) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(value)
    return str(value)


def _add(parent: ET.Element, tag: str, **attributes: object) -> ET.Element:
    """A child with those attributes that are not None."""
    return ET.SubElement(parent, tag, {k: _text(v) for k, v in attributes.items() if v is not None})


def _start_text(variable: Variable, values: tuple[float, ...]) -> str:
    if variable.type == "Boolean":
        return " ".join(_text(bool(x)) for x in values)
    number = float if variable.type in ("Float64", "Float32") else int
    return " ".join(_text(number(x)) for x in values)


def _start_values(unit: Declaration, v: Variable) -> tuple[float, ...]:
    """As many as the start values of the structural parameters ask for."""
    return v.start * math.prod(int(unit.by_name(name).start[0]) for name in v.extents)


def _has_start(variable: Variable) -> bool:
    return variable.settable and variable.type != "Clock"


def _limits(variable: Variable) -> dict[str, object]:
    number = float if variable.type in ("Float64", "Float32") else int
    limits = {"min": variable.min, "max": variable.max}
    return {k: None if x is None else number(x) for k, x in limits.items()}


def to_string(root: ET.Element) -> str:
    """The document as indented text."""
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _head(unit: Declaration, root: ET.Element, visible: list[Variable]) -> None:
    """Units, types, log categories, default experiment: alike in both versions but for the enumerations' tag."""
    fmi2 = root.get("fmiVersion") == "2.0"
    definitions = _add(root, "UnitDefinitions")
    for name in dict.fromkeys(v.unit for v in visible if v.type in ("Float64", "Float32")):
        definition = _add(definitions, "Unit", name=name)
        # the decibel is a logarithm: it has no factor to a base unit
        if name != "dB":
            _add(definition, "BaseUnit", **exponents(name))
    if unit.enumerations:
        types = _add(root, "TypeDefinitions")
        for name, entries in unit.enumerations.items():
            if fmi2:
                parent = _add(_add(types, "SimpleType", name=name), "Enumeration")
            else:
                parent = _add(types, "EnumerationType", name=name)
            for value, (entry, description) in enumerate(entries.items(), 1):
                _add(parent, "Item", name=entry, value=value, description=description)
    categories = _add(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        _add(categories, "Category", name=name, description=description)
    experiment = unit.default_experiment
    _add(
        root,
        "DefaultExperiment",
        startTime=0.0,
        stopTime=experiment.get("stop_time"),
        tolerance=experiment.get("tolerance"),
        stepSize=experiment.get("step_size"),
    )


def _initial_unknowns(visible: list[Variable]) -> list[Variable]:
    return [v for v in visible if v.causality == "output" or v.derivative_of]


def fmi3(unit: Declaration, token: str, version: str) -> str:
    """The model description for FMI 3.0."""
    visible = [v for v in unit.variables if v.visible and 3 in v.fmi]
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=unit.name,
        description=unit.description,
        version=version,
        license="BSD-2-Clause",
        generationTool=GENERATION_TOOL,
        variableNamingConvention="structured",
        instantiationToken=token,
    )
    shared = {
        "modelIdentifier": unit.name,
        "canGetAndSetFMUState": True,
        "canSerializeFMUState": True,
        "providesDirectionalDerivatives": unit.directional_derivatives,
        "providesAdjointDerivatives": unit.directional_derivatives,
    }
    if "model-exchange" in unit.kinds:
        _add(root, "ModelExchange", **shared, needsCompletedIntegratorStep=False)
    if "co-simulation" in unit.kinds:
        _add(root, "CoSimulation", **shared, canHandleVariableCommunicationStepSize=True, hasEventMode=unit.events)
    _head(unit, root, visible)
    variables = _add(root, "ModelVariables")
    for v in visible:
        _fmi3_variable(unit, variables, v)
    structure = _add(root, "ModelStructure")
    for v in visible:
        if v.causality == "output":
            _add(structure, "Output", valueReference=v.reference, dependencies=_fmi3_dependencies(unit, v))
    for v in visible:
        if v.derivative_of:
            dependencies = _fmi3_dependencies(unit, v)
            _add(structure, "ContinuousStateDerivative", valueReference=v.reference, dependencies=dependencies)
    for v in _initial_unknowns(visible):
        _add(structure, "InitialUnknown", valueReference=v.reference)
    return to_string(root)


def _fmi3_variable(unit: Declaration, parent: ET.Element, v: Variable) -> None:
    floating = v.type in ("Float64", "Float32")
    element = _add(
        parent,
        v.type,
        name=v.name,
        valueReference=v.reference,
        description=v.description,
        causality=v.causality,
        variability=v.variability,
        start=_start_text(v, _start_values(unit, v)) if v.start and _has_start(v) else None,
        declaredType=v.enumeration,
        unit=v.unit if floating else None,
        **_limits(v),
        derivative=unit.by_name(v.derivative_of).reference if v.derivative_of else None,
    )
    if v.type == "Clock":
        element.set("intervalVariability", v.interval)
        if v.interval == "countdown":
            element.set("supportsFraction", "true")
            element.set("resolution", str(CLOCK_RESOLUTION))
        return
    if v.type == "Binary":
        # its size in bytes is no dimension: it is given with each value
        element.set("mimeType", v.mime_type)
        return
    for n in v.size:
        if isinstance(n, int):
            _add(element, "Dimension", start=n)
        else:
            _add(element, "Dimension", valueReference=unit.by_name(n).reference)


def _fmi3_dependencies(unit: Declaration, v: Variable) -> str:
    own = (v.name,) if v.state else v.depends
    return " ".join(str(unit.by_name(name.rstrip("@")).reference) for name in own)


def _scalars(variables: list[Variable]) -> Iterator[tuple[Variable, int]]:
    for v in variables:
        for element in range(v.count):
            yield v, element


def scalar_name(v: Variable, element: int) -> str:
    """`position` -> `position[1]`, `der(position)` -> `der(position[1])`, for element 0."""
    if not v.size:
        return v.name
    return f"der({v.derivative_of}[{element + 1}])" if v.derivative_of else f"{v.name}[{element + 1}]"


def fmi2(unit: Declaration, token: str, version: str) -> str:
    """The model description for FMI 2.0."""
    visible = [v for v in unit.variables if v.visible and 2 in v.fmi and v.causality != "independent"]
    index = {(v.name, k): i for i, (v, k) in enumerate(_scalars(visible), 1)}
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=unit.name,
        guid=token,
        description=unit.description,
        version=version,
        license="BSD-2-Clause",
        generationTool=GENERATION_TOOL,
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    shared = {
        "modelIdentifier": unit.name,
        "canNotUseMemoryManagementFunctions": True,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
        "providesDirectionalDerivative": unit.directional_derivatives,
    }
    if "model-exchange" in unit.kinds:
        _sources(unit, _add(root, "ModelExchange", **shared, completedIntegratorStepNotNeeded=True))
    if "co-simulation" in unit.kinds:
        rates = any(v.rate for v in visible)
        kind = _add(
            root, "CoSimulation", **shared, canHandleVariableCommunicationStepSize=True, canInterpolateInputs=rates
        )
        _sources(unit, kind)
    _head(unit, root, visible)
    variables = _add(root, "ModelVariables")
    for v, element in _scalars(visible):
        _fmi2_variable(variables, v, element, index)
    structure = _add(root, "ModelStructure")
    for tag, chosen in (
        ("Outputs", [v for v in visible if v.causality == "output"]),
        ("Derivatives", [v for v in visible if v.derivative_of]),
    ):
        if chosen:
            unknowns = _add(structure, tag)
            for v, element in _scalars(chosen):
                dependencies = _fmi2_dependencies(unit, v, element, index)
                _add(unknowns, "Unknown", index=index[v.name, element], dependencies=dependencies)
    initial = _add(structure, "InitialUnknowns")
    for v, element in _scalars(_initial_unknowns(visible)):
        _add(initial, "Unknown", index=index[v.name, element])
    return to_string(root)


def sources(unit: Declaration) -> list[str]:
    """The C files that an importer compiles."""
    return ["fmu.c"] + (["complex.c"] if unit.directional_derivatives else [])


def _sources(unit: Declaration, kind: ET.Element) -> None:
    parent = _add(kind, "SourceFiles")
    for name in sources(unit):
        _add(parent, "File", name=name)


def _fmi2_variable(parent: ET.Element, v: Variable, element: int, index: dict[tuple[str, int], int]) -> None:
    structural = v.causality == "structuralParameter"
    scalar = _add(
        parent,
        "ScalarVariable",
        name=scalar_name(v, element),
        valueReference=v.reference + element,
        description=v.description,
        causality="local" if structural else v.causality,
        variability="constant" if structural else v.variability,
    )
    kind = FMI2_TYPES[v.type]
    _add(
        scalar,
        kind,
        declaredType=v.enumeration,
        start=_start_text(v, (v.start[element],)) if v.start and _has_start(v) else None,
        unit=v.unit if kind == "Real" else None,
        **({} if structural else _limits(v)),
        derivative=index[v.derivative_of, element] if v.derivative_of else None,
    )


def _fmi2_dependencies(unit: Declaration, v: Variable, element: int, index: dict[tuple[str, int], int]) -> str:
    if v.state:
        return str(index[v.name, element])
    found = []
    for name in v.depends:
        source = unit.by_name(name.rstrip("@"))
        elements = [element] if name.endswith("@") else range(source.count)
        found += [index[source.name, k] for k in elements]
    return " ".join(map(str, sorted(found)))
