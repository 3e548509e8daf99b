"""What the tests of this folder share: the units, their FMUs, a motion that is worth simulating."""

import importlib
import os
import platform
import re
import tomllib
import zipfile
from pathlib import Path
from types import ModuleType

import fmpy
import pytest

import ulna

CHECKOUT = Path(__file__).parents[2]
HEADERS = Path(fmpy.__file__).parent / "c-code"
VERSIONS = ("2.0", "3.0")
UNITS = {raw["name"]: raw for raw in (tomllib.loads(p.read_text()) for p in sorted(CHECKOUT.glob("fmus/*/unit.toml")))}
KINDS = {"co-simulation": "CoSimulation", "model-exchange": "ModelExchange"}

each_unit = pytest.mark.parametrize("name", UNITS)
each_version = pytest.mark.parametrize("version", VERSIONS)
each_kind = pytest.mark.parametrize(
    ("name", "kind"), [(name, KINDS[kind]) for name, raw in UNITS.items() for kind in raw["kinds"]]
)

MOTION = {
    "RigidBody": {
        "initial_angular_velocity": (0.6, 1.0, 0.4),
        "initial_velocity": (1.0, -2.0, 3.0),
        "tip": (0.1, 0.2, 0.3),
        "tip_force": (1.0, 0.5, -0.7),
        "torque": (0.2, -0.1, 0.3),
    },
    "HingedBody": {
        "initial_angle": 0.4,
        "initial_rate": -1.0,
        "damping": 0.5,
        "target_angle": 1.0,
        "anchor_acceleration": (0.3, -0.2, 1.0),
        "tip_force": (0.5, 0.0, 2.0),
    },
    "CompliantJoint": {
        "friction": 0.5,
        "first_position": (0.01, 0.0, 0.02),
        "first_velocity": (0.2, -0.1, 0.3),
        "second_orientation": (0.8, 0.1, 0.58, 0.1),
        "second_angular_velocity": (0.5, 2.0, -1.0),
    },
    "ArmSkin": {"forearm_orientation": (0.8, 0.0, 0.6, 0.0), "forearm_position": (0.31, 0.0, 0.01)},
    "UltrasonicSensor": {"plane_point": (1.5, 0.0, 0.0), "plane_normal": (-1.0, 0.1, 0.0), "period": 1 / 64},
}
"""Values of parameters and inputs that make every term of a unit count; another unit runs at its start values."""


def motion(name: str, version: str) -> dict[str, float | list[float]]:
    """`MOTION` of a unit as FMPy's start values: element by element in FMI 2."""
    values: dict[str, float | list[float]] = {}
    for variable, value in MOTION.get(name, {}).items():
        if not isinstance(value, tuple):
            values[variable] = value
        elif version == "3.0":
            values[variable] = list(value)
        else:
            values |= {f"{variable}[{i}]": x for i, x in enumerate(value, 1)}
    return values


def needs(package: str, module: str, remedy: str | None = None) -> ModuleType:
    """The module of a tool that may be missing; skips the test, with the remedy, where it is."""
    try:
        return importlib.import_module(module)
    except (ImportError, OSError) as error:
        pytest.skip(f"{error}: install it with: {remedy or f'pip install {package}'}")


def extract(name: str, version: str, folder: Path) -> Path:
    """The files of a unit's FMU, in `folder`."""
    with zipfile.ZipFile(ulna.fmu(name, version)) as archive:
        archive.extractall(folder)
    return folder


def library(folder: Path, name: str) -> Path:
    """The shared library of an extracted FMU."""
    (path,) = folder.glob(f"binaries/*/{name}{fmpy.sharedLibraryExtension}")
    return path


def standard_functions(version: str) -> list[str]:
    """Names of all functions that the header of the standard declares."""
    major = version[0]
    header = (HEADERS / f"fmi{major}Functions.h").read_text()
    return re.findall(rf"fmi{major}\w+TYPE\s+(fmi{major}\w+);", header)


def same_bits_expected() -> bool:
    """Whether another compiler call gives the same bits.

    The instructions of plain x86-64 hold no fused multiply-add, and no flag used here reorders sums; elsewhere the
    compiler may fuse, where our own build forbids it.
    """
    return platform.machine() in ("x86_64", "AMD64") and not os.environ.get("CFLAGS")
