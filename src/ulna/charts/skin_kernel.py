"""The skin's kernels without the FMI around them, in every instruction set that the FMU's binary carries."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import CDLL, c_bool, c_char_p, c_double, c_int, c_long, c_void_p
from functools import cache
from os import fspath
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..bench.skinning import Pose
from ..slave import Slave
from .driver import compile_library

LEVELS = ("baseline", "AVX2", "AVX-512")
"""Instruction sets, in the order of the driver's: the first `Kernel.levels` are the processor's own."""
ARGUMENTS = {
    "kernel_open": (c_void_p, (c_char_p, c_long, c_long, c_double, c_void_p)),
    "kernel_close": (None, (c_void_p,)),
    "kernel_levels": (c_int, ()),
    "kernel_vertices": (c_long, (c_void_p,)),
    "kernel_deform": (None, (c_void_p, c_int, c_void_p)),
    "kernel_seconds": (c_double, (c_void_p, c_int, c_bool, c_void_p, c_long)),
    "move_seconds": (c_double, (c_void_p, c_int, c_int, c_void_p, c_long)),
}


@cache
def library() -> CDLL:
    """The driver, compiled with the sources of the FMU; raises FileNotFoundError without a C compiler."""
    with tempfile.TemporaryDirectory(prefix="ulna-") as folder, Slave("ArmSkin") as skin:
        target = Path(folder) / "skin_kernel.so"
        compile_library("skin_kernel", target, skin.description.folder / "sources", ["-ftree-slp-vectorize"])
        loaded = CDLL(str(target))
    for name, (result, arguments) in ARGUMENTS.items():
        function = getattr(loaded, name)
        function.restype, function.argtypes = result, arguments
    return loaded


def levels() -> tuple[str, ...]:
    """The instruction sets that binary and processor have."""
    return LEVELS[: library().kernel_levels()]


class Kernel:
    """A skin in a pose, ready to be deformed; its results go to one and the same memory."""

    def __init__(self, handle: int):
        """Of the driver's handle, which stays open."""
        self._handle = handle
        self.vertex_count: int = library().kernel_vertices(handle)
        self._out = np.zeros((2, 3, self.vertex_count), np.float32)

    def deformed(self, level: str) -> NDArray[np.float32]:
        """Vertices, m, and normals [2, 3, n] by the code for an instruction set."""
        library().kernel_deform(self._handle, LEVELS.index(level), self._out.ctypes.data)
        return self._out.copy()

    def seconds(self, level: str, count: int, normals: bool = True) -> float:
        """Of vertices, and normals unless told otherwise, `count` times; s of this thread."""
        return library().kernel_seconds(self._handle, LEVELS.index(level), normals, self._out.ctypes.data, count)

    def limit(self, level: str, read: int, count: int) -> float:
        """s for the memory traffic alone: six numbers written a vertex, and 0, 7 or 14 read."""
        return library().move_seconds(self._handle, LEVELS.index(level), read, self._out.ctypes.data, count)


@contextmanager
def kernel(
    method: str, pose: Pose, vertex_count: int, resources: Path | None = None, twist_share: float = 0.0
) -> Iterator[Kernel]:
    """A skin; with a folder of resources that of the mesh there. Raises ValueError where the unit refuses it."""
    with Slave("ArmSkin") as skin:
        number = dict(skin.variable("method").entries)[method]
    bones = np.concatenate([pose.shoulder, pose.upper, pose.elbow, pose.fore])
    folder = b"" if resources is None else fspath(resources).encode() + b"/"
    handle = library().kernel_open(folder, int(number), vertex_count, twist_share, bones.ctypes.data)
    if not handle:
        raise ValueError(f"ArmSkin refuses {vertex_count} vertices, or the mesh in {resources}")
    try:
        yield Kernel(handle)
    finally:
        library().kernel_close(handle)
