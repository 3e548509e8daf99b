"""Ulna: FMI co-simulation units for an arm that moves, has skin, and listens."""

from importlib import import_module
from typing import Any

_PUBLIC = {
    "Scene": "ulna.scene",
    "Slave": "ulna.slave",
    "UnitError": "ulna.slave",
    "Results": "ulna.results",
    "fmu": "ulna.paths",
    "devices": "ulna.ultrasonic_devices",
}

_MODULES = ("inertia",)

__all__ = [*_PUBLIC, *_MODULES]
__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    # loaded on first use: the build runs ulna.generate where numpy and fmpy are not installed
    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), name)
    if name in _MODULES:
        return import_module(f"ulna.{name}")
    raise AttributeError(f"module 'ulna' has no attribute {name!r}")
