"""Changes a .glb file: its document, and the numbers behind its accessors."""

import json
import struct
from pathlib import Path

import numpy as np

from ulna import Scene
from ulna.gltf import write_glb

WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def rewritten(source: Path, out: Path, change) -> Path:
    """The file after `change(document, data)`; `data` is its buffer, to be changed in place."""
    content = source.read_bytes()
    size = struct.unpack("<I", content[12:16])[0]
    document, data = json.loads(content[20 : 20 + size]), bytearray(content[28 + size :])
    change(document, data)
    out.write_bytes(packed(document, data))
    return out


def packed(document: dict, data: bytes) -> bytes:
    """The bytes of a .glb file."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + bytes(data)
    return struct.pack("<4s2I", b"glTF", 2, 12 + len(chunks)) + chunks


def primitive(document: dict) -> dict:
    """The skinned one."""
    node = next(node for node in document["nodes"] if "skin" in node)
    return document["meshes"][node["mesh"]]["primitives"][0]


def accessor(document: dict, name: str) -> dict:
    if name == "inverseBindMatrices":
        return document["accessors"][document["skins"][0][name]]
    of = primitive(document)
    return document["accessors"][of["indices"] if name == "indices" else of["attributes"][name]]


def numbers(document: dict, data: bytearray, name: str, kind: type = np.float32) -> np.ndarray:
    """An accessor's elements, to be changed in place."""
    start = document["bufferViews"][accessor(document, name)["bufferView"]].get("byteOffset", 0)
    count = (
        accessor(document, name)["count"]
        * {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[accessor(document, name)["type"]]
    )
    return np.frombuffer(data, kind, count, start)


def exported_arm(folder: Path) -> Path:
    """The default arm at rest, as `ulna run` exports it: one joint at the shoulder, one at the elbow."""
    with Scene("arm") as scene:
        scene.add("ArmSkin", "arm", method="linear_blend", twist_share=0.0)
        write_glb(folder / "arm.glb", scene.run(0.1, 0.05), scene)
    return folder / "arm.glb"
