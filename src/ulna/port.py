"""One get or set of fixed variables of one type, ready to be called again and again."""

from collections.abc import Callable, Sequence
from ctypes import c_size_t, c_void_p
from typing import TYPE_CHECKING

import numpy as np

from .messages import WARNING

if TYPE_CHECKING:
    from .slave import Slave

Invocation = tuple[Callable[..., int], tuple]
"""A C function and its arguments."""


class Port:
    """One get or set of fixed variables of one type: calling it moves `values`, a contiguous array, in or out."""

    def __init__(self, slave: "Slave", verb: str, names: Sequence[str], values: np.ndarray | None = None):
        """`verb` is Get or Set; raises ValueError for mixed types and for a buffer that does not fit."""
        variables = [slave.variable(name) for name in names]
        accesses = {slave.access(variable) for variable in variables}
        if len(accesses) != 1:
            kinds = ", ".join(f"{variable.name} {variable.type}" for variable in variables)
            raise ValueError(f"{slave.name}: one port moves one type, not {kinds}")
        suffix, dtype = accesses.pop()
        sizes = [slave.count(variable) for variable in variables]
        stops = np.cumsum(sizes).tolist()
        self.slices = {
            variable.name: slice(stop - size, stop)
            for variable, size, stop in zip(variables, sizes, stops, strict=True)
        }
        self.values = np.zeros(stops[-1], dtype) if values is None else values
        if self.values.shape != (stops[-1],) or self.values.dtype != dtype or not self.values.flags.c_contiguous:
            raise ValueError(f"{slave.name}: the buffer must be a contiguous array of {stops[-1]} {np.dtype(dtype)}")
        self.name = f"fmi{slave.version[0]}{verb}{suffix}"
        self.function = slave.function(self.name)
        # Kept here, because ctypes does not keep alive what a bare pointer points to.
        self._references = np.array([r for variable in variables for r in variable.references], np.uint32)
        count = () if slave.version == "2.0" else (c_size_t(self.values.size),)
        self.arguments = (
            c_void_p(slave.component),
            c_void_p(self._references.ctypes.data),
            c_size_t(self._references.size),
            c_void_p(self.values.ctypes.data),
            *count,
        )
        self.slave = slave

    def __call__(self) -> np.ndarray:
        """Moves the values and returns them; raises UnitError if the unit refuses."""
        status = self.function(*self.arguments)
        if status > WARNING:
            self.slave.fail(self.name, status)
        return self.values
