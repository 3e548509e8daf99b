"""The C driver: compiled when it is needed, by the compiler of the machine."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from ctypes import CDLL, c_double, c_long, c_void_p
from functools import cache
from pathlib import Path

import fmpy

HERE = Path(__file__).resolve().parent
HEADERS = Path(fmpy.__file__).parent / "c-code"
FLAGS = (
    *("-std=c11", "-O3", "-DNDEBUG", "-ffp-contract=off", "-fno-math-errno", "-fno-tree-slp-vectorize"),
    *("-fPIC", "-shared"),
)
"""Those with which the bodies are built."""
ARGUMENTS = {
    "time_steps": (c_void_p, c_void_p, c_void_p, c_void_p, c_double, c_long, c_long),
    "time_advances": (c_void_p, c_void_p, c_void_p, c_long),
    "time_bare": (c_void_p, c_double, c_long),
    "time_attitude": (c_void_p, c_double, c_long),
}


def compiler() -> str:
    """Path of the C compiler: CC, or the first that is found; raises FileNotFoundError without one."""
    for name in filter(None, (os.environ.get("CC"), "cc", "gcc", "clang")):
        if found := shutil.which(name):
            return found
    raise FileNotFoundError("the chart times C by C and needs a C compiler: install gcc or clang, or set CC")


def compile_library(source: str, target: Path, sources: Path | None = None, flags: Sequence[str] = ()) -> None:
    """Compiles a source of this folder, which includes the unit in the folder `sources` if one is given.

    Raises RuntimeError with what the compiler said.
    """
    files = [HERE / f"{source}.c"]
    if sources is not None and (sources / "complex.c").exists():
        files.append(sources / "complex.c")
    includes = [f"-I{folder}" for folder in (sources, HEADERS) if folder]
    command = [compiler(), *FLAGS, *flags, *includes, *map(str, files), "-lm", "-o", str(target)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode:
        raise RuntimeError(f"{' '.join(command)}\n{result.stderr}")


@cache
def compiled(source: str, sources: Path | None = None) -> CDLL:
    """The same as a loaded library, whose functions return seconds."""
    with tempfile.TemporaryDirectory(prefix="ulna-") as folder:
        target = Path(folder) / f"{source}.so"
        compile_library(source, target, sources)
        loaded = CDLL(str(target))
    for name, arguments in ARGUMENTS.items():
        if hasattr(loaded, name):
            function = getattr(loaded, name)
            function.argtypes, function.restype = arguments, c_double
    return loaded
