"""An FMU at any point: parameters, inputs and states set through FMI, results and derivatives read."""

from collections.abc import Mapping, Sequence
from ctypes import c_double
from os import PathLike
from types import TracebackType
from xml.etree import ElementTree

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave

from ..description import Variable, count_of, read_description
from ..messages import Messages, fmi2_callbacks

Point = Mapping[str, np.ndarray]


class RefusedError(ValueError):
    """The FMU does not take a value; the message is its own."""


class Built:
    """One instance of an FMU of either version: model exchange where it has states and offers it, else a slave."""

    def __init__(self, path: str | PathLike):
        """Loads it; raises what `ulna.description.read_description` raises."""
        self.description = read_description(path)
        self.version = self.description.version
        self.model = fmpy.read_model_description(str(self.description.folder))
        self._owner = {
            reference: (variable.name, element)
            for variable in reversed(self.description.variables.values())
            for element, reference in enumerate(variable.references)
        }
        derivatives = [unknown.variable for unknown in self.model.derivatives]
        elements = [self._owner[derivative.derivative.valueReference] for derivative in derivatives]
        self.states = list(dict.fromkeys(name for name, _ in elements))
        """Names of the continuous states, in the order of the FMU's vector of them."""
        self._elements = elements
        self._exchange = bool(self.states) and self.model.modelExchange is not None
        self._messages = Messages()
        self._fmu = self._instantiate()

    def _instantiate(self) -> FMU2Model | FMU2Slave | FMU3Model | FMU3Slave:
        two = self.version == "2.0"
        interface = self.model.modelExchange if self._exchange else self.model.coSimulation
        kind = (FMU2Model if two else FMU3Model) if self._exchange else (FMU2Slave if two else FMU3Slave)
        fmu = kind(
            guid=self.model.guid,
            modelIdentifier=interface.modelIdentifier,
            unzipDirectory=str(self.description.folder),
            instanceName=self.description.name,
        )
        if two:
            fmu.instantiate(callbacks=fmi2_callbacks(self._messages), loggingOn=True)
        else:
            fmu.instantiate(loggingOn=True, logMessage=self._messages.add)
        return fmu

    def __enter__(self) -> "Built":
        """For `with`: the instance is freed at its end."""
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        """Frees the instance."""
        self._fmu.freeInstance()

    def provides(self, capability: str) -> bool:
        """Whether the interface in use offers DirectionalDerivative or AdjointDerivative (plural in FMI 3)."""
        # FMPy reads the singular only
        root = ElementTree.parse(self.description.folder / "modelDescription.xml").getroot()
        interface = root.find("ModelExchange" if self._exchange else "CoSimulation")
        return any(interface.get(f"provides{capability}{plural}") in ("true", "1") for plural in ("", "s"))

    def numbers(self, *causalities: str) -> list[Variable]:
        """The Float64 variables of some causalities."""
        variables = self.description.variables.values()
        return [v for v in variables if v.causality in causalities and v.type == "Float64"]

    def count(self, name: str) -> int:
        """Elements of a variable."""
        variables = self.description.variables
        sizes = {v.name: int(v.start[0]) for v in variables.values() if v.causality == "structuralParameter"}
        return count_of(variables[name], sizes)

    def start(self, name: str) -> np.ndarray:
        """Start value of a variable."""
        starts = [float(value) for value in self.description.variables[name].start]
        return np.array(starts * (self.count(name) if len(starts) == 1 else 1))

    def limits(self, name: str) -> tuple[float | None, float | None]:
        """Least and greatest value, each None where there is no limit."""
        reference = self.description.variables[name].references[0]
        variable = next(v for v in self.model.modelVariables if v.valueReference == reference)
        return tuple(None if x is None else float(x) for x in (variable.min, variable.max))

    def initialize(self, point: Point) -> None:
        """From the beginning, with the parameters and inputs of a point; all else at its start value.

        Raises RefusedError.
        """
        self._call("reset")
        self._set(point, "parameter", "input")
        if self.version == "2.0":
            self._call("setupExperiment")
        self._call("enterInitializationMode")
        self._call("exitInitializationMode")

    def move(self, point: Point) -> None:
        """Sets the states of a point, where it has some, and the inputs again; raises RefusedError."""
        if self._exchange:
            self._call("newDiscreteStates" if self.version == "2.0" else "updateDiscreteStates")
            self._call("enterContinuousTimeMode")
            states = self._state_vector(point)
            self._call("setContinuousStates", (c_double * len(states))(*states), len(states))
        self._set(point, "input")

    def _state_vector(self, point: Point) -> list[float]:
        if self.version == "3.0":
            return [float(x) for name in self.states for x in self._value(point, name)]
        return [float(self._value(point, name)[element]) for name, element in self._elements]

    def _value(self, point: Point, name: str) -> np.ndarray:
        return np.atleast_1d(point[name]) if name in point else self.read(name)

    def _set(self, point: Point, *causalities: str) -> None:
        names = [v.name for v in self.numbers(*causalities) if v.name in point and v.variability != "constant"]
        references = self.references(names)
        if references:
            values = [float(x) for name in names for x in np.atleast_1d(point[name])]
            self._call("setReal" if self.version == "2.0" else "setFloat64", references, values)

    def references(self, names: Sequence[str]) -> list[int]:
        """Value references of some variables."""
        return [reference for name in names for reference in self.description.variables[name].references]

    def read(self, name: str) -> np.ndarray:
        """Value of a Float64 variable, its elements in a row."""
        references = self.references([name])
        if self.version == "2.0":
            return np.array(self._call("getReal", references))
        return np.array(self._call("getFloat64", references, self.count(name)))

    def derivative(self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        """The directional derivative of `unknowns` as `knowns` move along `seed`."""
        arguments = (self.references(unknowns), self.references(knowns), [float(x) for x in seed])
        if self.version == "2.0":
            return np.array(self._call("getDirectionalDerivative", *arguments))
        size = sum(self.count(name) for name in unknowns)
        return np.array(self._call("getDirectionalDerivative", *arguments, size))

    def adjoint_derivative(self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        """The transposed Jacobian of `unknowns` by `knowns`, times `seed`."""
        size = sum(self.count(name) for name in knowns)
        arguments = (self.references(unknowns), self.references(knowns), [float(x) for x in seed], size)
        return np.array(self._call("getAdjointDerivative", *arguments))

    def dependencies(self) -> dict[str, set[tuple[str, int]] | None]:
        """For each scalar of FMI 2 or array of FMI 3 among outputs and derivatives, what ModelStructure says it depends
        on, as (name, element), element 0 for a whole array; None where it says nothing. Keys: `name`, `name[element]`.
        """
        declared = {}
        for unknown in [*self.model.outputs, *self.model.derivatives]:
            name, element = self._owner[unknown.variable.valueReference]
            known = unknown.dependencies
            key = f"{name}[{element}]" if self.version == "2.0" else name
            declared[key] = None if known is None else {self._owner[v.valueReference] for v in known}
        return declared

    def _call(self, method: str, *arguments: object) -> object:
        try:
            return getattr(self._fmu, method)(*arguments)
        except FMICallException as error:
            message = self._messages.take_errors() or f"status {error.status} without a reason"
            raise RefusedError(f"{self.description.name}: {error.function}: {message}") from error
