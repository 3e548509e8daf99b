"""What `ulna skin import` refuses: each with the reason, exit code 2, and no file."""

import re
import struct
from pathlib import Path

import numpy as np
import pytest

from glb_edit import accessor, exported_arm, numbers, primitive, rewritten
from test_cli import ulna
from ulna import cli

OPTIONS = ["--upper-arm", "arm joint 0", "--forearm", "arm joint 1"]


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    """So that no line is broken."""
    monkeypatch.setattr(cli.console, "width", 2000)
    monkeypatch.setattr(cli.errors, "width", 2000)


@pytest.fixture(scope="module")
def own(tmp_path_factory) -> Path:
    """Our own arm as a rigged mesh."""
    return exported_arm(tmp_path_factory.mktemp("own"))


def poke(name: str, place: int, value: float, kind: type = np.float32):
    def change(document, data):
        numbers(document, data, name, kind)[place] = value

    return change


def extension(name):
    return lambda document, _: document.update(extensionsRequired=[name], extensionsUsed=[name])


def attribute(name, number):
    return lambda document, _: primitive(document)["attributes"].update({name: number})


def of_accessor(name, **values):
    return lambda document, _: accessor(document, name).update(values)


def stretched(document, _):
    document["nodes"][document["skins"][0]["joints"][0]]["scale"] = [1.0, 2.0, 1.0]


def in_a_ring(document, _):
    document["nodes"][document["skins"][0]["joints"][0]]["children"] = [0]


def one_place(document, _):
    document["skins"][0].pop("inverseBindMatrices")


def no_forearm(document, data):
    numbers(document, data, "JOINTS_0", np.uint8)[:] = 0


def zero_normals(document, data):
    numbers(document, data, "POSITION")[:] = 0.0
    numbers(document, data, "NORMAL")[:] = 0.0


SPOILT = {
    "no skin": (lambda d, _: d.pop("skins"), "has no skin"),
    "no skinned mesh": (lambda d, _: [n.pop("skin", 0) for n in d["nodes"]], "has a skin that no mesh uses"),
    "no weights": (lambda d, _: primitive(d)["attributes"].pop("WEIGHTS_0"), "has no WEIGHTS_0"),
    "more influences": (attribute("JOINTS_1", 0), "up to 4 influences"),
    "lines": (lambda d, _: primitive(d).update(mode=1), "mode 1; allowed: 4"),
    "sparse": (of_accessor("POSITION", sparse={"count": 1}), "POSITION is a sparse accessor"),
    "Draco": (extension("KHR_draco_mesh_compression"), "requires the extension KHR_draco_mesh_compression"),
    "meshopt": (extension("EXT_meshopt_compression"), "requires the extension EXT_meshopt_compression"),
    "no view": (lambda d, _: accessor(d, "POSITION").pop("bufferView"), "POSITION has no bufferView"),
    "weights of doubles": (of_accessor("WEIGHTS_0", componentType=5125), "WEIGHTS_0 is VEC4 of component type 5125"),
    "fewer joints": (of_accessor("JOINTS_0", count=2000), "JOINTS_0 has 2000 rows; allowed: 2048"),
    "long accessor": (of_accessor("indices", count=999999), "indices ends at byte .* allowed range: up to"),
    "no rows": (of_accessor("POSITION", count=0), "POSITION ends at byte"),
    "other file": (lambda d, _: d["buffers"][0].update(uri="a.bin"), "outside the file"),
    "weights of 0.5": (poke("WEIGHTS_0", 0, 0.5), r"weights of vertex 0 are 0.5, .* sum 1 within 0.01"),
    "a negative weight": (poke("WEIGHTS_0", 4, -1.0), "weights of vertex 1 are -1"),
    "NaN weight": (poke("WEIGHTS_0", 8, np.nan), "WEIGHTS_0 of vertex 2 is not finite"),
    "NaN position": (poke("POSITION", 9, np.nan), "POSITION of vertex 3 is not finite"),
    "far away": (poke("POSITION", 9, 1e6), "vertex 3 is not within 100 m"),
    "NaN bind matrix": (poke("inverseBindMatrices", 3, np.nan), "inverseBindMatrices of vertex 0 is not finite"),
    "flat bind matrix": (lambda d, b: numbers(d, b, "inverseBindMatrices").__setitem__(slice(16), 0.0), "no inverse"),
    "few matrices": (of_accessor("inverseBindMatrices", count=1), "has 1 inverseBindMatrices"),
    "joint beyond": (poke("JOINTS_0", 0, 9, np.uint8), "has joint 9; allowed range: 0 to 1"),
    "corner beyond": (poke("indices", 0, 2048, np.uint16), "allowed: threes of 0 to 2047"),
    "two thirds of a triangle": (of_accessor("indices", count=5), "has 5 indices"),
    "stretched": (stretched, "the same scale in all directions"),
    "a ring of nodes": (in_a_ring, "is below itself"),
    "joints at one place": (one_place, "upper_arm_length = 0 m by the file; allowed range: 0.001 m to 100 m"),
    "one bone": (no_forearm, "move no vertices apart"),
    "no area": (zero_normals, "neither a normal nor a triangle with an area"),
    "a text for a number": (of_accessor("POSITION", count="many"), "no valid glTF"),
}


@pytest.mark.parametrize("name", SPOILT)
def test_a_bad_file_is_refused_with_the_reason_and_leaves_nothing(own, tmp_path, name):
    change, message = SPOILT[name]
    path = rewritten(own, tmp_path / "bad.glb", change)
    done = ulna("skin", "import", path, "--out", tmp_path / "bad.fmu", *OPTIONS)
    assert done.exit_code == 2, done.output
    assert re.search(message, done.output), done.output
    assert "Traceback" not in done.output
    assert not (tmp_path / "bad.fmu").exists()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda c: c[:-100], "is the file cut off?"),
        (lambda c: c[:10], "does not begin as a binary glTF"),
        (lambda c: b"solid stl" + c[9:], "does not begin as a binary glTF"),
        (lambda c: c[:4] + b"\1" + c[5:], "glTF version 1; allowed: 2"),
        (lambda c: c[:20] + b"?" + c[21:], "no valid glTF"),
    ],
)
def test_what_is_no_glb_is_refused(own, tmp_path, spoil, message):
    (tmp_path / "bad.glb").write_bytes(spoil(own.read_bytes()))
    done = ulna("skin", "import", tmp_path / "bad.glb", "--out", tmp_path / "bad.fmu", *OPTIONS)
    assert (done.exit_code, message in done.output) == (2, True), done.output


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "name two with --upper-arm and --forearm, of: arm joint 0, arm joint 1"),
        (["--upper-arm", "arm joint 0"], "name both joints or none"),
        (["--upper-arm", "arm joint 0", "--forearm", "arm joint 2"], "no joint 'arm joint 2'; allowed: arm joint 0,"),
        (["--upper-arm", "arm joint 0", "--forearm", "arm joint 0"], "both the upper arm and the forearm"),
        ([*OPTIONS, "--version", "1.0"], "no FMUs for FMI 1.0"),
    ],
)
def test_a_wrong_name_is_refused(own, tmp_path, options, message):
    done = ulna("skin", "import", own, "--out", tmp_path / "bad.fmu", *options)
    assert (done.exit_code, message in done.output) == (2, True), done.output


@pytest.mark.parametrize("seed", range(40))
def test_a_damaged_file_does_no_harm(own, tmp_path, seed):
    """Random bytes in the document or the data: refused, or a mesh like any other."""
    random = np.random.default_rng(seed)
    content = bytearray(own.read_bytes())
    end = len(content) if seed % 4 == 0 else 20 + struct.unpack("<I", content[12:16])[0]
    for place in random.integers(12, end, 3):
        content[place] = random.integers(32, 127)
    (tmp_path / "damaged.glb").write_bytes(content)
    done = ulna("skin", "import", tmp_path / "damaged.glb", "--out", tmp_path / "out.fmu", *OPTIONS)
    assert done.exit_code in (0, 2), done.output
