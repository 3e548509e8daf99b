"""What the tests of this folder share: every unit's declaration and the files generated from it, in memory."""

import re
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pytest

from ulna.generate.declaration import Declaration, load
from ulna.generate.package import TERMINAL_FILE, content

CHECKOUT = Path(__file__).parents[2]
CORE = CHECKOUT / "src" / "fmi"
LICENSE = CHECKOUT / "LICENSE"
FOLDERS = {load(path).name: path.parent for path in sorted(CHECKOUT.glob("fmus/*/unit.toml"))}

each_unit = pytest.mark.parametrize("name", FOLDERS)
each_version = pytest.mark.parametrize("version", [2, 3])


@cache
def declaration(name: str) -> Declaration:
    """The declaration of a unit of the repository."""
    return load(FOLDERS[name] / "unit.toml")


@cache
def files(name: str, version: int) -> dict[str, bytes]:
    """All files of a unit's FMU but its binary."""
    return content(declaration(name), CORE, version, "1.2.3", LICENSE)


def description(name: str, version: int) -> ElementTree.Element:
    """The root of a unit's model description."""
    return ElementTree.fromstring(files(name, version)["modelDescription.xml"])


def terminals(name: str, version: int) -> ElementTree.Element:
    """The root of a unit's terminals."""
    return ElementTree.fromstring(files(name, version)[TERMINAL_FILE[version]])


def stem(name: str) -> str:
    """`der(x[2])` -> `der(x)`."""
    return re.sub(r"\[\d+\]", "", name)
