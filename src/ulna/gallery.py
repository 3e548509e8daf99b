"""Finds scenes: by name among the examples, or by the path of a Python file."""

import importlib.util
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from .names import unknown
from .paths import CHECKOUT, PACKAGE
from .scene import Scene

STEP = 0.001
UNTIL = 10.0


@dataclass(frozen=True)
class Example:
    """A scene file: the function `scene()` that builds it, and how it is meant to run."""

    name: str
    path: Path
    build: Callable[[], Scene]
    until: float
    step: float
    master: str | None
    """None for what suits the scene."""
    about: str


def scenes() -> dict[str, Path]:
    """Name -> file of all examples, of the installed package or of the checkout."""
    folder = PACKAGE / "examples"
    if not folder.is_dir():
        folder = CHECKOUT / "examples"
    return {path.stem: path for path in sorted(folder.glob("*.py")) if not path.stem.startswith("_")}


def load(scene: str) -> Example:
    """The example of that name, or the scene file at that path.

    A file defines `scene()`, and if it likes UNTIL and STEP (s) and MASTER. Raises KeyError for a name that no example
    has, FileNotFoundError for a path without a file, ValueError for a file without `scene()`; what the file raises
    while it is read passes through.
    """
    is_path = scene.endswith(".py") or "/" in scene
    known = scenes()
    if not is_path and scene not in known:
        raise KeyError(unknown("ulna", "scene", scene, known))
    path = Path(scene).resolve() if is_path else known[scene]
    if not path.is_file():
        raise FileNotFoundError(f"no scene file {scene}")
    module = _import(path)
    if not callable(getattr(module, "scene", None)):
        raise ValueError(f"{path} defines no function scene() that returns a Scene")
    return Example(
        name=path.stem,
        path=path,
        build=module.scene,
        until=float(getattr(module, "UNTIL", UNTIL)),
        step=float(getattr(module, "STEP", STEP)),
        master=getattr(module, "MASTER", None),
        about=(module.__doc__ or "").strip().split("\n")[0],
    )


def _import(path: Path):
    name = f"ulna_scene_{path.stem}"
    specification = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(specification)
    # dataclasses and pickle look a module up by its name
    sys.modules[name] = module
    specification.loader.exec_module(module)
    return module
