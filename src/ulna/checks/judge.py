"""All claims about a unit, or about any FMU and a model of it."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

from ..description import read_description
from ..paths import fmu, names
from .as_built import stranger_as_built, unit_as_built
from .built_steps import steps_as_built
from .claims import Row, of_equations, of_steps, own_identities
from .lift import extract, lift, read_header
from .needs import MisuseError
from .solvers import cases_of, of_solvers
from .textbook import load_file, load_model

VERSIONS = ("3.0", "2.0")


def judge_unit(name: str) -> Iterator[Row]:
    """Every claim about one of our units, of the sources that its FMUs carry and of the FMUs as built."""
    for version in VERSIONS:
        path = fmu(name, version)
        with tempfile.TemporaryDirectory() as scratch:
            sources = extract(path, scratch)
            lifted = lift(sources)
            model = load_model(read_header(sources / "variables.h").snake)
            cases = cases_of(sources, model)
        if version == VERSIONS[0]:
            yield from of_equations(name, lifted, model)
            yield from of_steps(name, lifted, model)
            yield from of_solvers(name, model, cases)
        yield from unit_as_built(name, path, lifted, model)
        yield from steps_as_built(name, path, cases)


def judge_fmu(path: str | Path, model_file: str | Path) -> Iterator[Row]:
    """Every claim about any FMU with a co-simulation interface, by a user's model of it.

    Raises FileNotFoundError, and MisuseError for an FMU or a model that cannot be used.
    """
    model = load_file(model_file)
    try:
        read_description(path)
    except ValueError as error:
        raise MisuseError(str(error)) from error
    yield from own_identities(Path(path).stem, model)
    yield from stranger_as_built(path, model)


def units() -> list[str]:
    """Names of the units that are built."""
    return names(VERSIONS[0])
