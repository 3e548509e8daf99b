"""The units through FMPy's plain FMI classes: what any importer sees, with none of our own Python in between."""

import atexit
import ctypes
import re
import shutil
import tempfile
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model, FMU3Slave

from ulna import fmu

CHECKOUT = Path(__file__).parents[2]
DECLARATIONS = {
    declaration["name"]: declaration
    for path in sorted(CHECKOUT.glob("fmus/*/unit.toml"))
    for declaration in [tomllib.loads(path.read_text())]
}
VERSIONS = ("2.0", "3.0")
UNITS = tuple(DECLARATIONS)
WITH_STATES = tuple(name for name in UNITS if "model-exchange" in DECLARATIONS[name]["kinds"])
DIFFERENTIABLE = tuple(name for name in UNITS if DECLARATIONS[name]["directional_derivatives"])
CO_SIMULATION, MODEL_EXCHANGE = "co-simulation", "model-exchange"
KINDS = tuple((name, kind) for name in UNITS for kind in DECLARATIONS[name]["kinds"])
ROUND_OFF = float(np.finfo(float).eps)

# FMI 2 passes printf's arguments; our units log with the format "%s" and one argument.
_Logger2 = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, *[ctypes.c_char_p] * 3])


@cache
def unpacked(name: str, version: str) -> tuple[Any, str]:
    """Model description and folder of a unit's FMU."""
    folder = tempfile.mkdtemp(prefix="ulna-fmu-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    path = fmu(name, version=version)
    fmpy.extract(path, unzipdir=folder)
    return fmpy.read_model_description(path, validate=False), folder


@dataclass(frozen=True)
class Variable:
    """One variable; in FMI 2, an array gathered from name[1], name[2] ..."""

    name: str
    type: str
    causality: str
    variability: str
    references: tuple[int, ...]
    size: int
    start: np.ndarray | None
    minimum: float | None
    maximum: float | None


def base_name(name: str) -> str:
    """Without the index of FMI 2: position of position[1], der(position) of der(position[1])."""
    return re.sub(r"\[\d+\]", "", name)


@cache
def variables_of(name: str, version: str) -> dict[str, Variable]:
    """The variables that its model description shows, by name."""
    groups: dict[str, list] = {}
    description, _ = unpacked(name, version)
    starts = {v.valueReference: v.start for v in description.modelVariables}
    for variable in description.modelVariables:
        groups.setdefault(base_name(variable.name), []).append(variable)
    found = {}
    for base, members in groups.items():
        first = members[0]
        extents = [int(starts[d.valueReference]) if d.start is None else int(d.start) for d in first.dimensions or ()]
        texts = " ".join(str(member.start) for member in members if member.start is not None).split()
        numbers = [{"true": 1.0, "false": 0.0}.get(text) for text in texts]
        start = [float(t) if n is None else n for t, n in zip(texts, numbers, strict=True)]
        found[base] = Variable(
            base,
            first.type,
            first.causality,
            first.variability,
            tuple(member.valueReference for member in members),
            len(members) * int(np.prod(extents)),
            np.array(start) if start else None,
            *(None if limit is None else float(limit) for limit in (first.min, first.max)),
        )
    return found


class Raw:
    """An instance of a unit; calls that are not here go to FMPy's class. Use it in a `with` statement."""

    def __init__(self, name: str, version: str, kind: str = CO_SIMULATION, logging: bool = False, **options: Any):
        description, folder = unpacked(name, version)
        self.version, self.kind = version, kind
        self.variables = variables_of(name, version)
        self.states = description.numberOfContinuousStates
        self.log: list[tuple[int, str, str]] = []
        """Status, category and text of each line."""
        interface = description.coSimulation if kind == CO_SIMULATION else description.modelExchange
        classes = {"2.0": (FMU2Slave, FMU2Model), "3.0": (FMU3Slave, FMU3Model)}[version]
        self.fmu = classes[kind == MODEL_EXCHANGE](
            guid=description.guid,
            modelIdentifier=interface.modelIdentifier,
            unzipDirectory=folder,
            instanceName=name,
        )
        if version == "2.0":
            self.fmu.instantiate(callbacks=self._callbacks(), loggingOn=logging)
        else:
            self.fmu.instantiate(loggingOn=logging, logMessage=self._receive, **options)

    def _receive(self, _environment: int | None, status: int, category: bytes, message: bytes) -> None:
        self.log.append((status, category.decode(), message.decode()))

    def _callbacks(self) -> fmi2CallbackFunctions:
        def receive(environment, _name, status, category, form, text):
            assert form == b"%s"
            self._receive(environment, status, category, text)

        self._logger = _Logger2(receive)  # ctypes does not keep it alive
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = ctypes.cast(self._logger, fmi2CallbackLoggerTYPE)
        return callbacks

    def __enter__(self) -> "Raw":
        return self

    def __exit__(self, *_: object) -> None:
        self.fmu.freeInstance()

    def __getattr__(self, name: str) -> Callable:
        return getattr(self.fmu, name)

    def _moved(self, verb: str, variable: Variable, *arguments: Any) -> Any:
        suffix = {"Enumeration": {"2.0": "Integer", "3.0": "Int64"}[self.version]}.get(variable.type, variable.type)
        return getattr(self.fmu, verb + suffix)(list(variable.references), *arguments)

    def get(self, name: str) -> np.ndarray:
        """All its elements [size]."""
        variable = self.variables[name]
        count = () if self.version == "2.0" else (variable.size,)
        return np.array(self._moved("get", variable, *count))

    def set(self, name: str, values: Any) -> None:
        """Sets all its elements [size]."""
        kinds = {"Real": float, "Float64": float, "Boolean": bool}
        variable = self.variables[name]
        self._moved("set", variable, [kinds.get(variable.type, int)(value) for value in np.atleast_1d(values)])

    def of(self, causality: str, *types: str) -> list[Variable]:
        """Its variables of a causality, of these types (all but clocks, if none is given); time is none of them."""
        found = [v for v in self.variables.values() if v.causality == causality]
        return [v for v in found if (v.type in types if types else v.type != "Clock")]

    def reals(self, causality: str) -> list[Variable]:
        """Its floating-point variables (64 bit) of a causality."""
        return self.of(causality, "Real", "Float64")

    def outputs(self) -> dict[str, bytes]:
        """The bits of all outputs."""
        return {variable.name: self.get(variable.name).tobytes() for variable in self.of("output")}

    def begin(self, start: float = 0.0, stop: float | None = None) -> None:
        """Enters initialization mode."""
        if self.version == "2.0":
            self.fmu.setupExperiment(startTime=start, stopTime=stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start, stopTime=stop)

    def start(self, start: float = 0.0, stop: float | None = None) -> "Raw":
        """Goes through initialization; in model exchange on to continuous time."""
        self.begin(start, stop)
        self.fmu.exitInitializationMode()
        if self.kind == MODEL_EXCHANGE:
            self.fmu.newDiscreteStates() if self.version == "2.0" else self.fmu.updateDiscreteStates()
            self.fmu.enterContinuousTimeMode()
        return self

    def save(self) -> ctypes.c_void_p:
        """A saved state."""
        return self.fmu.getFMUState()

    def get_states(self) -> np.ndarray:
        """Continuous states [states]."""
        return self._vector("getContinuousStates")

    def get_derivatives(self) -> np.ndarray:
        """Their derivatives [states]."""
        return self._vector("getDerivatives" if self.version == "2.0" else "getContinuousStateDerivatives")

    def get_nominals(self) -> np.ndarray:
        """Their nominal values [states]."""
        return self._vector("getNominalsOfContinuousStates")

    def set_states(self, states: np.ndarray) -> None:
        """Sets the continuous states [states]."""
        self.fmu.setContinuousStates((ctypes.c_double * self.states)(*states), self.states)

    def _vector(self, call: str) -> np.ndarray:
        values = (ctypes.c_double * self.states)()
        getattr(self.fmu, call)(values, self.states)
        return np.array(values)

    def directional(self, unknowns: list[Variable], knowns: list[Variable], seed: np.ndarray) -> np.ndarray:
        """J seed, for the Jacobian J of the unknowns by the knowns, all their elements."""
        size = () if self.version == "2.0" else (sum(v.size for v in unknowns),)
        return np.array(self.fmu.getDirectionalDerivative(_references(unknowns), _references(knowns), seed, *size))

    def adjoint(self, unknowns: list[Variable], knowns: list[Variable], seed: np.ndarray) -> np.ndarray:
        """seed J: FMI 3 only."""
        size = sum(v.size for v in knowns)
        return np.array(self.fmu.getAdjointDerivative(_references(unknowns), _references(knowns), seed, size))


def _references(variables: list[Variable]) -> list[int]:
    return [reference for variable in variables for reference in variable.references]


def random_values(variable: Variable, random: np.random.Generator) -> np.ndarray:
    """Values of a variable within its limits [size]; for quaternions of a norm near one."""
    if "orientation" in variable.name:
        return np.array([1.0, 0.0, 0.0, 0.0]) + 0.2 * random.uniform(-1, 1, 4)
    if variable.name == "surface_triangles":
        return np.zeros(variable.size)  # of one vertex, the only one there is at the start
    if variable.type == "Boolean":
        return random.integers(0, 2, variable.size)
    if variable.type == "Enumeration":
        return random.integers(1, 3, variable.size)
    low = -1.0 if variable.minimum is None else variable.minimum
    high = low + 2.0 if variable.maximum is None else variable.maximum
    values = random.uniform(low, high, variable.size)
    return values if variable.type in ("Real", "Float64") else np.floor(values)


def set_random_inputs(unit: Raw, random: np.random.Generator) -> None:
    """Sets every input to random values."""
    for variable in unit.of("input"):
        unit.set(variable.name, random_values(variable, random))
