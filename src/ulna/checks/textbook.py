"""Loading models: those of the units, from `models/` of the checkout or the installed package, and a user's file."""

import sys
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from ..paths import CHECKOUT, PACKAGE
from .needs import MisuseError

FOLDERS = (PACKAGE / "models", CHECKOUT / "models")
NAME = "ulna_models"
"""The name under which the models are imported, so that no other package of the name `models` is in the way."""


def load_model(unit: str) -> ModuleType:
    """The model of a unit, by the name of its folder (`rigid_body`); raises FileNotFoundError if there is none."""
    if NAME not in sys.modules:
        folder = next((folder for folder in FOLDERS if (folder / "__init__.py").is_file()), None)
        if folder is None:
            raise FileNotFoundError(f"no models found in {' or '.join(map(str, FOLDERS))}")
        _load(NAME, folder / "__init__.py", [str(folder)])
    try:
        return import_module(f"{NAME}.{unit}")
    except ModuleNotFoundError as error:
        if error.name != f"{NAME}.{unit}":
            raise
        raise FileNotFoundError(f"no model of {unit} in {sys.modules[NAME].__path__[0]}") from error


def load_file(path: str | Path) -> ModuleType:
    """A model in a Python file; raises FileNotFoundError, and MisuseError if it has no `equations`."""
    path = Path(path).resolve()
    if not path.is_file():
        raise FileNotFoundError(f"no model file {path}")
    sys.path.insert(0, str(path.parent))
    try:
        module = _load(path.stem, path, None)
    finally:
        sys.path.remove(str(path.parent))
    if not hasattr(module, "equations"):
        raise MisuseError(f"{path} has no function equations(values), which returns expressions by variable name")
    if not hasattr(module, "SAMPLES"):
        module.SAMPLES = {}
    return module


def _load(name: str, path: Path, search: list[str] | None) -> ModuleType:
    spec = spec_from_file_location(name, path, submodule_search_locations=search)
    module = module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
