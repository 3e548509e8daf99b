"""One co-simulation instance of any FMU, FMI 2.0 or 3.0.

FMPy loads the library and leads the life cycle. Values move through its pointers to the C functions, with
arguments that are built once and NumPy buffers that stay where they are: see `port`.
"""

import weakref
from collections.abc import Callable, Sequence
from ctypes import byref, c_bool, c_double, c_int, c_size_t, c_uint32, c_void_p, string_at
from os import PathLike
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from .description import ACCESS, Description, Variable, count_of, read_description, shape_of
from .messages import STATUS_NAMES, WARNING, Messages, fmi2_callbacks
from .names import unknown
from .port import Invocation, Port

# FMPy changes the working directory while it loads a library.
_load_lock = Lock()


# What is asked of a unit that sorts its messages so; all that it has of any other.
CATEGORIES = ["logStatusError", "logStatusWarning"]


class UnitError(RuntimeError):
    """A unit failed: its name, the time, the call, and what it logged. `results` holds what a run recorded before."""

    def __init__(self, unit: str, call: str, status: str, time: float, message: str):
        """`status` is the word for what the call returned, `time` in seconds."""
        super().__init__(
            f"{unit} at t = {time:.9g} s: {call} returned {status}: {message or 'the unit gave no reason'}"
        )
        self.unit = unit
        self.call = call
        self.status = status
        self.time = time
        self.message = message
        self.results = None

    def __reduce__(self) -> tuple:
        """Lets a worker process send the error home."""
        return UnitError, (self.unit, self.call, self.status, self.time, self.message), {"results": self.results}


class Slave:
    """One instance of an FMU: `fmu` is a unit's name (then `version` chooses the build) or the path of any FMU."""

    def __init__(self, fmu: str | PathLike, name: str | None = None, *, version: str = "3.0"):
        """Raises FileNotFoundError, ValueError for an FMU that cannot be co-simulated, UnitError if it refuses."""
        self.description: Description = read_description(_path_of(fmu, version))
        self.version = self.description.version
        self.name = name or self.description.name
        self.time = 0.0
        self.messages = Messages()
        self._ports: dict[tuple[str, str], Port] = {}
        self._states: list[c_void_p] = []
        self._rollback: c_void_p | None = None
        self._initialized = False
        self._sizes = self._default_sizes()
        with _load_lock:
            self._fmu = (FMU2Slave if self.version == "2.0" else FMU3Slave)(
                guid=self.description.token,
                modelIdentifier=self.description.identifier,
                unzipDirectory=str(self.description.folder),
                instanceName=self.name,
            )
        self._instantiate()
        self.component: int = self._fmu.component
        self._close = weakref.finalize(self, _free, self._fmu, self._states)
        self._time = c_double()
        self._step_size = c_double()
        self._final = c_bool(True) if self.version == "3.0" else c_int(1)
        self.end_requested = c_bool(False)
        """Whether an FMI 3 unit asked, in its last step, to end the simulation."""
        self._step, self._step_arguments = self.step_call(self._time, self._step_size)

    def _instantiate(self) -> None:
        try:
            if self.version == "2.0":
                self._fmu.instantiate(callbacks=fmi2_callbacks(self.messages), loggingOn=True)
            else:
                self._fmu.instantiate(loggingOn=True, logMessage=self.messages.add)
        except Exception as error:
            raise UnitError(self.name, "instantiate", "no instance", 0.0, self.messages.take_errors()) from error
        # a line of log for every event, formatted and brought to Python, costs more than the event
        if set(CATEGORIES) <= self.description.log_categories:
            self._call("setDebugLogging", True, CATEGORIES)

    def __enter__(self) -> "Slave":
        """For `with`: the instance is freed at its end."""
        return self

    def __exit__(self, *_: object) -> None:
        """Frees the instance."""
        self.close()

    def __repr__(self) -> str:
        """Its name, the FMU's and the version."""
        return f"<Slave {self.name}: {self.description.name}, FMI {self.version}>"

    # What the unit has

    def variable(self, name: str) -> Variable:
        """The variable of that name; raises KeyError with the nearest right names."""
        try:
            return self.description.variables[name]
        except KeyError:
            raise KeyError(unknown(self.name, "variable", name, self.description.variables)) from None

    def shape(self, variable: Variable) -> tuple[int, ...]:
        """Its shape, with the present values of the structural parameters."""
        return shape_of(variable, self._sizes)

    def count(self, variable: Variable) -> int:
        """Number of its elements."""
        return count_of(variable, self._sizes)

    def access(self, variable: Variable) -> tuple[str, type]:
        """Suffix of the C functions that move it, and the dtype of its values; raises TypeError for other types."""
        try:
            return ACCESS[self.version][variable.type]
        except KeyError:
            raise TypeError(f"{self.name}.{variable.name}: {variable.type} cannot be moved as numbers") from None

    def function(self, name: str) -> Callable[..., int]:
        """The C function of that name. It takes ready ctypes objects: without a conversion a call costs half."""
        return self._fmu.dll[name]

    def getter(self, names: Sequence[str], values: np.ndarray | None = None) -> Port:
        """A port that reads these variables of one type into `values` (its own, or the buffer given)."""
        return Port(self, "Get", names, values)

    def setter(self, names: Sequence[str], values: np.ndarray | None = None) -> Port:
        """A port that writes `values` to these variables of one type."""
        return Port(self, "Set", names, values)

    # Values by name

    def get(self, name: str) -> Any:
        """Value of a variable: an array of its shape; if it is a scalar a number, bool, entry name, string or bytes."""
        variable = self.variable(name)
        if variable.type == "String":
            return self._call("getString", list(variable.references))[0]
        if variable.type == "Binary":
            return self._get_binary(variable)
        values = self._port("Get", name)()
        if variable.type == "Boolean":
            values = values.astype(bool)
        if self.shape(variable):
            return values.reshape(self.shape(variable)).copy()
        value = values[0].item()
        return {number: entry for entry, number in variable.entries}.get(value, value)

    def _get_binary(self, variable: Variable) -> bytes:
        """The unit's own memory, copied: what a pointer points to lasts until the next read only."""
        reference, size, place, one = c_uint32(variable.references[0]), c_size_t(), c_void_p(), c_size_t(1)
        component = c_void_p(self.component)
        call = self.function("fmi3GetBinary")
        status = call(component, byref(reference), one, byref(size), byref(place), one)
        if status > WARNING:
            self.fail("fmi3GetBinary", status)
        return string_at(place, size.value)

    def set(self, name: str, value: Any) -> None:
        """Sets a variable: a number, an array of its shape, or for enumerations the name of an entry.

        A structural parameter is set in configuration mode, and changes the shapes that it rules.
        Raises KeyError and ValueError for names, ValueError for shapes, UnitError for values the unit refuses.
        """
        variable = self.variable(name)
        if variable.type == "String":
            self._call("setString", list(variable.references), [value])
            return
        port = self._port("Set", name)
        port.values[:] = self._checked(variable, value).reshape(-1)
        if variable.causality != "structuralParameter" or self._initialized:
            port()
            return
        self._call("enterConfigurationMode")
        try:
            port()
        finally:
            self._call("exitConfigurationMode")
        self._sizes[name] = int(port.values[0])
        self._ports.clear()

    def _checked(self, variable: Variable, value: Any) -> np.ndarray:
        if variable.type == "Enumeration" and isinstance(value, str):
            entries = dict(variable.entries)
            if value not in entries:
                raise ValueError(unknown(f"{self.name}.{variable.name}", "entry", value, entries))
            value = entries[value]
        values = np.asarray(value)
        if values.shape != self.shape(variable):
            raise ValueError(
                f"{self.name}.{variable.name}: the shape is {self.shape(variable) or 'that of a scalar'}, "
                f"not {values.shape or 'that of a scalar'}"
            )
        if not np.can_cast(values.dtype, self.access(variable)[1], "same_kind") and np.any(values != np.trunc(values)):
            raise ValueError(f"{self.name}.{variable.name}: {value!r} is no {variable.type}")
        return values

    def _port(self, verb: str, name: str) -> Port:
        key = (verb, name)
        if key not in self._ports:
            self._ports[key] = Port(self, verb, [name])
        return self._ports[key]

    def _default_sizes(self) -> dict[str, int]:
        variables = self.description.variables.values()
        return {v.name: int(v.start[0]) for v in variables if v.causality == "structuralParameter" and v.start}

    # Life cycle

    def initialize(self, start: float = 0.0, stop: float | None = None, tolerance: float | None = None) -> None:
        """Goes through initialization mode, with the parameters and inputs set so far."""
        self.enter_initialization(start, stop, tolerance)
        self.exit_initialization()

    def enter_initialization(
        self, start: float = 0.0, stop: float | None = None, tolerance: float | None = None
    ) -> None:
        """Enters initialization mode, where inputs may be set and outputs read."""
        self.time = start
        self._initialized = True
        if self.version == "2.0":
            self._call("setupExperiment", tolerance=tolerance, startTime=start, stopTime=stop)
            self._call("enterInitializationMode")
        else:
            self._call("enterInitializationMode", tolerance=tolerance, startTime=start, stopTime=stop)

    def exit_initialization(self) -> None:
        """Ends initialization mode; steps may follow."""
        self._call("exitInitializationMode")

    def step_call(self, time: c_double, step: c_double) -> Invocation:
        """The C function of a step and its arguments; it reads the numbers when it is called."""
        component = c_void_p(self.component)
        if self.version == "2.0":
            return self.function("fmi2DoStep"), (component, time, step, self._final)
        unused = (byref(c_bool()), byref(c_double()))
        flags = (unused[0], byref(self.end_requested), unused[0], unused[1])
        return self.function("fmi3DoStep"), (component, time, step, self._final, *flags)

    def step(self, time: float, step: float) -> None:
        """Steps from `time` to `time + step`, seconds."""
        self.time = time
        self._time.value = time
        self._step_size.value = step
        status = self._step(*self._step_arguments)
        if status > WARNING:
            self.fail(f"fmi{self.version[0]}DoStep", status)
        self.time = time + step

    def terminate(self) -> None:
        """Ends the simulation; values may still be read."""
        self._call("terminate")

    def reset(self) -> None:
        """Back to where it was after loading: parameters at their start values, not initialized."""
        self._call("reset")
        self._initialized = False
        self._sizes = self._default_sizes()
        self._ports.clear()

    def close(self) -> None:
        """Frees the instance and unloads its library; a second call does nothing."""
        self._close()

    # Derivatives

    def directional_derivative(self, unknowns: Sequence[str], knowns: Sequence[str], seed: np.ndarray) -> np.ndarray:
        """Change of the outputs `unknowns` (all elements, flat) for the change `seed` of the inputs `knowns`.

        At the present state and inputs, without a step. Raises UnitError if the unit gives none.
        """
        references = [[r for name in names for r in self.variable(name).references] for names in (unknowns, knowns)]
        size = sum(self.count(self.variable(name)) for name in unknowns)
        arguments = (*references, seed.tolist(), *(() if self.version == "2.0" else (size,)))
        return np.array(self._call("getDirectionalDerivative", *arguments))

    # State

    def save(self) -> c_void_p:
        """The whole state, held by the unit until `free` or `close`."""
        state = self._call("getFMUState")
        self._keep(state)
        return state

    def restore(self, state: c_void_p) -> None:
        """Back to a saved state, which stays valid."""
        self._call("setFMUState", state)
        if self._sizes:
            self._sizes = {name: int(self.get(name)) for name in self._sizes}
            self._ports.clear()

    def rollback_calls(self) -> tuple[Invocation, Invocation]:
        """The call that saves the state, always into one place, and the call that goes back there.

        Raises ValueError for a unit that cannot, UnitError if it refuses.
        """
        if not self.description.saves_state:
            raise ValueError(
                f"{self.name}: {self.description.name} cannot save its state, so no step of it is repeated"
            )
        if self._rollback is None:
            self._rollback = self.save()
        component, state = c_void_p(self.component), self._rollback
        verb = "FMUstate" if self.version == "2.0" else "FMUState"
        save, restore = (self.function(f"fmi{self.version[0]}{way}{verb}") for way in ("Get", "Set"))
        return (save, (component, byref(state))), (restore, (component, state))

    def free(self, state: c_void_p) -> None:
        """Gives up a saved state."""
        self._states[:] = [kept for kept in self._states if kept is not state]
        self._final.value = not self._states
        self._call("freeFMUState", state)

    def serialize(self) -> bytes:
        """The whole state as bytes, for another instance of the same FMU."""
        state = self.save()
        try:
            return self._call("serializeFMUState", state)
        finally:
            self.free(state)

    def deserialize(self, data: bytes) -> None:
        """Takes on a state from `serialize`."""
        state = self._call("deserializeFMUState", data)
        self._keep(state)
        try:
            self.restore(state)
        finally:
            self.free(state)

    def _keep(self, state: c_void_p) -> None:
        # A unit may forget what precedes a step only if no saved state can take it back there.
        self._states.append(state)
        self._final.value = False

    # Errors

    def fail(self, call: str, status: int) -> None:
        """Raises the UnitError of a call that returned a bad status; after a fatal one no call is allowed any more."""
        if STATUS_NAMES[status] == "fatal":
            self._close.detach()
        raise UnitError(self.name, call, STATUS_NAMES[status], self.time, self.messages.take_errors())

    def _call(self, method: str, *arguments: Any, **keywords: Any) -> Any:
        try:
            return getattr(self._fmu, method)(*arguments, **keywords)
        except FMICallException as error:
            self.fail(error.function, error.status)


def _path_of(fmu: str | PathLike, version: str) -> Path:
    path = Path(fmu)
    if path.suffix == ".fmu" or path.exists():
        return path
    from .paths import fmu as built

    return built(str(fmu), version=version)


def _free(fmu: FMU2Slave | FMU3Slave, states: list[c_void_p]) -> None:
    for state in states:
        fmu.freeFMUState(state)
    fmu.freeInstance()
