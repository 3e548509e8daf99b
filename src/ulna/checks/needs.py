"""What the checks need beyond the package itself, and what they refuse, with the message for each."""

import os
import shutil
from importlib.util import find_spec


class MissingNeedError(RuntimeError):
    """Something is not installed; the message says how to install it."""


class MisuseError(ValueError):
    """A call that cannot be answered; the message says what to change."""


def require_modules() -> None:
    """Raises MissingNeedError if CasADi or mpmath is missing."""
    missing = [name for name in ("casadi", "mpmath") if find_spec(name) is None]
    if missing:
        raise MissingNeedError(
            f"the checks need {' and '.join(missing)}, not installed here: pip install 'ulna[test]' brings them"
        )


def compiler(variable: str, candidates: tuple[str, ...], language: str) -> str:
    """Path of a compiler: the one that the environment names in `variable`, else the first candidate found.

    Raises MissingNeedError, which says what to install.
    """
    chosen = os.environ.get(variable)
    for name in (chosen,) if chosen else candidates:
        path = shutil.which(name)
        if path:
            return path
    looked = chosen or ", ".join(candidates)
    raise MissingNeedError(
        f"the checks need a {language} compiler, and none of {looked} is found: install one "
        f"(Debian, Ubuntu: apt install g++; Fedora: dnf install gcc-c++; macOS: xcode-select --install), "
        f"or name yours in the environment variable {variable}"
    )


def cpp_compiler() -> str:
    """Path of a C++17 compiler; raises MissingNeedError."""
    return compiler("CXX", ("g++", "c++", "clang++"), "C++")


def c_compiler() -> str:
    """Path of a C11 compiler; raises MissingNeedError."""
    return compiler("CC", ("cc", "gcc", "clang"), "C")
