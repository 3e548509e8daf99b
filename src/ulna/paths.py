"""Where the built units are."""

import difflib
import os
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
CHECKOUT = PACKAGE.parents[1]


def _folders() -> list[Path]:
    """Places that may hold FMUs: an explicit one, the installed package, the build folder of a checkout."""
    chosen = os.environ.get("ULNA_FMUS")
    return [Path(chosen)] if chosen else [PACKAGE / "fmus", CHECKOUT / "build" / "fmus"]


def names(version: str = "3.0") -> list[str]:
    """Names of the units that are built for a version of FMI."""
    return sorted({path.stem for folder in _folders() for path in (folder / version).glob("*.fmu")})


def fmu(name: str, version: str = "3.0") -> Path:
    """Path of a unit's FMU.

    `name` is the unit's (`RigidBody`), `version` "2.0" or "3.0". Raises FileNotFoundError, with the
    nearest name or the command that builds them, when there is none.
    """
    for folder in _folders():
        path = folder / version / f"{name}.fmu"
        if path.is_file():
            return path
    known = names(version)
    if not known:
        raise FileNotFoundError(f"no FMUs for FMI {version} found; build them with 'make build' or 'pip install .'")
    near = difflib.get_close_matches(name, known, 1)
    hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(known)}"
    raise FileNotFoundError(f"no unit {name!r} for FMI {version}; {hint}")
