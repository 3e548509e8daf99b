"""How a unit is told that an input changes over the coming step: its own `_rate` inputs, or FMI 2 input derivatives."""

from collections.abc import Collection, Mapping, Sequence
from ctypes import c_size_t, c_void_p
from dataclasses import dataclass

import numpy as np

from .connections import End
from .description import Variable
from .port import Invocation
from .slave import Slave

RATE = "_rate"


@dataclass(frozen=True)
class SlopePort:
    """Calls that set slopes: `values` per second, of the driven inputs that lie at `places`."""

    places: np.ndarray
    values: np.ndarray
    calls: list[tuple[*Invocation, Slave, str]]
    """C function, arguments, whose it is and its name."""
    kept: list
    """What the arguments point to."""


def slope_port(inputs: Mapping[Slave, Sequence[tuple[End, slice]]], driven: Collection[End]) -> SlopePort:
    """The port for the slopes of these float64 inputs, as far as their units take them.

    An input of the name X_rate, of the same shape, that nothing else drives, is the slope of X; an FMI 2 unit that
    interpolates its inputs takes their derivatives of order 1.
    """
    names = {end.name for end in driven}
    taken = {slave: _taken(slave, ends, names) for slave, ends in inputs.items()}
    places = np.concatenate([np.zeros(0, int), *(_range(place) for ends in taken.values() for _, place in ends)])
    port = SlopePort(places, np.zeros(places.size), [], [])
    stop = 0
    for slave, ends in taken.items():
        if ends:
            start, stop = stop, stop + sum(place.stop - place.start for _, place in ends)
            _add(port, slave, [end.variable for end, _ in ends], port.values[start:stop])
    return port


def _taken(slave: Slave, inputs: Sequence[tuple[End, slice]], driven: Collection[str]) -> list[tuple[End, slice]]:
    """Those inputs of a unit of which it takes the slope."""
    rated = [(end, place) for end, place in inputs if _has_rate(slave, end, driven)]
    return rated or (list(inputs) if slave.description.interpolates_inputs else [])


def _has_rate(slave: Slave, end: End, driven: Collection[str]) -> bool:
    rate = slave.description.variables.get(end.variable.name + RATE)
    free = rate is not None and rate.causality == "input" and f"{slave.name}.{rate.name}" not in driven
    return free and slave.shape(rate) == end.shape


def _add(port: SlopePort, slave: Slave, variables: Sequence[Variable], values: np.ndarray) -> None:
    if variables[0].name + RATE in slave.description.variables:
        setter = slave.setter([variable.name + RATE for variable in variables], values)
        port.calls.append((setter.function, setter.arguments, slave, setter.name))
        port.kept.append(setter)
        return
    references = np.array([r for variable in variables for r in variable.references], np.uint32)
    orders = np.ones(references.size, np.int32)
    pointers = [c_void_p(array.ctypes.data) for array in (references, orders, values)]
    name = "fmi2SetRealInputDerivatives"
    arguments = (c_void_p(slave.component), pointers[0], c_size_t(references.size), *pointers[1:])
    port.calls.append((slave.function(name), arguments, slave, name))
    port.kept.append((references, orders))


def _range(place: slice) -> np.ndarray:
    return np.arange(place.start, place.stop)
