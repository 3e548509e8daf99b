"""Right-hand sides of a unit's solvers: counted, by the sources in its FMU compiled with a hook at each function."""

import re
from atexit import register
from ctypes import CDLL, c_double
from functools import cache
from pathlib import Path
from shutil import copytree, make_archive, rmtree
from tempfile import mkdtemp

from ..description import read_description
from ..paths import fmu
from .driver import compile_library

COUNTED = {
    "RigidBody": {"rigid_body_wrench": 1, "next_coefficients": 1, "rk4_free_step": 4},
    "HingedBody": {"angular_acceleration": 1, "extend_series": 1},
}
"""Right-hand sides in a call of a function: all torques at one instant are one, as is one coefficient of all series."""
FLAGS = ("-DFMI3_OVERRIDE_FUNCTION_PREFIX", "-O1", "-fno-inline", "-finstrument-functions")


@cache
def counting_fmu(unit: str) -> tuple[Path, c_double]:
    """An FMU that does as a unit does and counts, and where it counts; raises RuntimeError if it does not compile."""
    original = read_description(fmu(unit)).folder
    text = "".join(path.read_text() for path in (original / "sources").glob("*.[ch]"))
    counted = {name: worth for name, worth in COUNTED[unit].items() if re.search(rf"\b{name}\(", text)}
    table = "".join(f"{{(void (*)(void)){name},{worth}}}," for name, worth in counted.items())
    folder = Path(mkdtemp(prefix="ulna-"))
    register(rmtree, folder, ignore_errors=True)
    copytree(original, folder / unit)
    [library] = (folder / unit / "binaries").glob(f"*/{unit}.*")
    compile_library("counter", library, original / "sources", (*FLAGS, f"-DCOUNTED={table}"))
    path = Path(make_archive(str(folder / unit), "zip", folder / unit)).rename(folder / f"{unit}.fmu")
    [loaded] = read_description(path).folder.glob(f"binaries/*/{unit}.*")
    return path, c_double.in_dll(CDLL(str(loaded)), "evaluations")
