"""Where ArmSkin looks for its mesh, and what it does without one: the raw C functions of the FMU."""

import os
import re
import struct
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import pytest
from test_arm_skin_imported import arm_mesh, packed, with_mesh

from ulna import Slave, fmu
from ulna.skin_import import write_skin_fmu

OWN_RADIUS, MESH_RADIUS = 0.04, 0.0625
SCRIPT = """
import ctypes, sys
library, version, token, place, reference = sys.argv[1:]
library = ctypes.CDLL(library)
text, none, no = ctypes.c_char_p, ctypes.c_void_p(), ctypes.c_bool(False)
place = place.encode() or None
if version == "3.0":
    @ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, text, text)
    def log(_, __, ___, message): print(message.decode())
    make = library.fmi3InstantiateCoSimulation
    make.restype = ctypes.c_void_p
    skin = make(b"x", token.encode(), place, no, ctypes.c_bool(True), no, no, none, ctypes.c_size_t(0), none, log, none)
else:
    @ctypes.CFUNCTYPE(None, ctypes.c_void_p, text, ctypes.c_int, text, text, text)
    def log(_, __, ___, ____, form, message): print(form.replace(b"%s", message).decode())
    class Callbacks(ctypes.Structure):
        _fields_ = [(name, ctypes.c_void_p) for name in ("logger", "allocate", "free", "finished", "environment")]
    libc = ctypes.CDLL(None)
    pointers = [ctypes.cast(f, ctypes.c_void_p) for f in (log, libc.calloc, libc.free)]
    calls = Callbacks(*pointers, None, None)
    make = library.fmi2Instantiate
    make.restype = ctypes.c_void_p
    skin = make(b"x", 1, token.encode(), place, ctypes.byref(calls), 0, 1)
if skin:
    value, reference, one = ctypes.c_double(), ctypes.c_uint32(int(reference)), ctypes.c_size_t(1)
    arguments = ctypes.c_void_p(skin), ctypes.byref(reference), one, ctypes.byref(value)
    library.fmi3GetFloat64(*arguments, one) if version == "3.0" else library.fmi2GetReal(*arguments)
    print(value.value)
"""


@dataclass(frozen=True)
class Unpacked:
    """An FMU in a folder; its mesh, where it has one, is of another radius than the unit's own."""

    folder: Path
    version: str
    reference: int
    """Of the radius."""

    def said(self, place: str) -> str:
        """What an instance of its says, in a process of its own: its radius, or why there is none."""
        description = (self.folder / "modelDescription.xml").read_text()
        token = re.search(r'(?:instantiationToken|guid)="([^"]+)"', description)[1]
        library = next((self.folder / "binaries").glob("*/ArmSkin.*"))
        command = [sys.executable, "-c", SCRIPT, os.fspath(library), self.version, token, place, str(self.reference)]
        return subprocess.check_output(command, text=True).strip()


def unpacked(path: Path, folder: Path, version: str) -> Unpacked:
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    with Slave(path) as skin:
        found = Unpacked(folder, version, skin.variable("radius").references[0])
    mesh = folder / "resources" / "mesh.bin"
    if mesh.exists():
        content = bytearray(mesh.read_bytes())
        content[40:48] = struct.pack("<d", MESH_RADIUS)
        mesh.write_bytes(bytes(content))
    return found


LOCATIONS = {
    "path": lambda p: p,
    "path with separator": lambda p: p + "/",
    "URI": lambda p: "file://" + quote(p),
    "URI with separator": lambda p: "file://" + quote(p) + "/",
    "short URI": lambda p: "file:" + quote(p),
    "URI of a host": lambda p: "file://localhost" + quote(p),
}


@pytest.mark.parametrize("location", LOCATIONS)
def test_every_way_to_name_the_folder(tmp_path: Path, location: str) -> None:
    """FMI 3 asks for a path, importers give what they like; a mesh that was put among the stock FMU's resources."""
    path = with_mesh(tmp_path / "ArmSkin.fmu", packed(arm_mesh(), tmp_path))
    skin = unpacked(path, tmp_path / "a b%", "3.0")
    assert skin.said(LOCATIONS[location](os.fspath(skin.folder / "resources"))) == str(MESH_RADIUS)
    assert skin.said("") == str(OWN_RADIUS)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_an_imported_skin_is_none_without_its_resources(tmp_path: Path, version: str) -> None:
    write_skin_fmu(tmp_path / "arm.fmu", arm_mesh(), fmu("ArmSkin", version))
    skin = unpacked(tmp_path / "arm.fmu", tmp_path / "arm", version)
    assert skin.said(os.fspath(skin.folder / "resources")) == str(MESH_RADIUS)
    for place in ("", os.fspath(tmp_path), os.fspath(tmp_path / "nowhere")):
        assert f"needs mesh.bin among its resources, which is not in the folder '{place}" in skin.said(place)
    # a token is still that of one unit
    other = Unpacked(skin.folder, version, skin.reference)
    text = (skin.folder / "modelDescription.xml").read_text()
    (skin.folder / "modelDescription.xml").write_text(text.replace("+mesh.bin", "mesh.bin"))
    assert "is not this unit's" in other.said(os.fspath(skin.folder / "resources"))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_stock_skin_needs_none(tmp_path: Path, version: str) -> None:
    skin = unpacked(fmu("ArmSkin", version), tmp_path / "arm", version)
    for place in ("", os.fspath(tmp_path)):
        assert skin.said(place) == str(OWN_RADIUS)
