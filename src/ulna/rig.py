"""Reads the meshes of a glTF 2.0 file, .glb, rigged or not, and refuses what it cannot read with the reason."""

import struct
import warnings
from dataclasses import dataclass
from functools import reduce
from os import PathLike
from pathlib import Path

import numpy as np
import pygltflib as gltf

COMPONENTS = {
    gltf.BYTE: np.dtype("i1"),
    gltf.UNSIGNED_BYTE: np.dtype("u1"),
    gltf.SHORT: np.dtype("<i2"),
    gltf.UNSIGNED_SHORT: np.dtype("<u2"),
    gltf.UNSIGNED_INT: np.dtype("<u4"),
    gltf.FLOAT: np.dtype("<f4"),
}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
# attribute: accessor type, component types (glTF 2.0, 3.7.2.1 and 3.7.3.3)
ATTRIBUTES = {
    "POSITION": ("VEC3", (gltf.FLOAT,)),
    "NORMAL": ("VEC3", (gltf.FLOAT,)),
    "JOINTS_0": ("VEC4", (gltf.UNSIGNED_BYTE, gltf.UNSIGNED_SHORT)),
    "WEIGHTS_0": ("VEC4", (gltf.FLOAT, gltf.UNSIGNED_BYTE, gltf.UNSIGNED_SHORT)),
    "indices": ("SCALAR", (gltf.UNSIGNED_BYTE, gltf.UNSIGNED_SHORT, gltf.UNSIGNED_INT)),
    "inverseBindMatrices": ("MAT4", (gltf.FLOAT,)),
}
# extensions that leave geometry as it is
HARMLESS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "MSFT_texture_")
TRIANGLES = 4
# 8-bit weights are each off by half of 1/255
WEIGHT_TOLERANCE = 0.01


@dataclass(frozen=True)
class Primitive:
    """n vertices of a skinned node, as the file has them: in the skin's space, before joints move them."""

    where: str
    """Names mesh and primitive in messages."""
    mesh: str
    vertices: np.ndarray
    """(n, 3)."""
    normals: np.ndarray | None
    """(n, 3) or none; of any length."""
    joints: np.ndarray
    """(n, 4): nodes; the influences' joints."""
    weights: np.ndarray
    """(n, 4): they sum to 1."""
    triangles: np.ndarray
    """(t, 3)."""
    inverse_bind: dict[int, np.ndarray]
    """(4, 4), by node: from the skin's space to the joint's."""


@dataclass(frozen=True)
class Rig:
    """The skinned primitives of a file, and its nodes."""

    names: list[str]
    """Of the nodes."""
    parents: dict[int, int]
    local: list[np.ndarray]
    """(4, 4) of each node, to its parent's space."""
    joints: list[int]
    """Nodes that some skin takes for a joint, in the order of the file."""
    primitives: list[Primitive]

    def to_world(self, node: int) -> np.ndarray:
        """(4, 4): from a node's space to the world of glTF, y up, m, where the file leaves its nodes."""
        return reduce(lambda below, above: self.local[above] @ below, self.ancestors(node), self.local[node])

    def ancestors(self, node: int) -> list[int]:
        """From the parent to the root. Raises ValueError if there is no root."""
        found = []
        while node in self.parents:
            node = self.parents[node]
            if node in found:
                raise ValueError(f"node {self.names[node]!r} is below itself; nodes must form trees")
            found.append(node)
        return found


def read_rig(path: str | PathLike, skinned: bool = True) -> Rig:
    """Reads a .glb file; without `skinned` all its meshes, each on one joint: its node, or the first of its skin's.

    Raises FileNotFoundError, or ValueError that names file, place and allowed range.
    """
    content = Path(path).read_bytes()
    try:
        file = _File(content)
        return file.rig() if skinned else file.meshes()
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    except (KeyError, IndexError, TypeError, AttributeError, struct.error, RecursionError) as error:
        raise ValueError(f"{path} is no valid glTF 2.0: {type(error).__name__}: {error}") from None


class _File:
    """The document and its only buffer."""

    def __init__(self, content: bytes):
        if content[:4] != b"glTF" or len(content) < 20:
            raise ValueError("does not begin as a binary glTF file, .glb; allowed: glTF 2.0, binary")
        version, length = struct.unpack("<2I", content[4:12])
        if version != 2:
            raise ValueError(f"is of glTF version {version}; allowed: 2")
        if length != len(content):
            raise ValueError(f"has {len(content)} bytes, its header says {length}; is the file cut off?")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                self.document = gltf.GLTF2.load_from_bytes(content)
        except Exception as error:  # the library lets whatever its parser meets through
            raise ValueError(f"is no valid glTF 2.0: {type(error).__name__}: {error}") from None
        self.blob = self.document.binary_blob() or b""
        for extension in self.document.extensionsRequired or []:
            if not extension.startswith(HARMLESS):
                raise ValueError(f"requires the extension {extension}; allowed: geometry that is not compressed")

    def rig(self) -> Rig:
        """Everything that is skinned."""
        nodes, skins = self.document.nodes, self.document.skins
        if not skins:
            raise ValueError("has no skin; allowed: a mesh with JOINTS_0, WEIGHTS_0 and a skin")
        binds = [(n, self._inverse_bind(skins[n.skin])) for n in nodes if n.mesh is not None and n.skin is not None]
        if not binds:
            raise ValueError("has a skin that no mesh uses; allowed: a node with both mesh and skin")
        joints = list(dict.fromkeys(joint for skin in skins for joint in skin.joints))
        return self._tree(joints, [p for node, bind in binds for p in self._node(node, bind, True)])

    def meshes(self) -> Rig:
        """Every mesh, as it stands where the file leaves its nodes."""
        binds = []
        for number, node in enumerate(self.document.nodes):
            if node.mesh is not None and node.skin is not None:
                binds.append((node, dict([next(iter(self._inverse_bind(self.document.skins[node.skin]).items()))])))
            elif node.mesh is not None:
                binds.append((node, {number: np.eye(4)}))
        if not binds:
            raise ValueError("has no mesh at a node")
        return self._tree([], [p for node, bind in binds for p in self._node(node, bind, False)])

    def _tree(self, joints: list[int], primitives: list[Primitive]) -> Rig:
        nodes = self.document.nodes
        names = [node.name or f"node {number}" for number, node in enumerate(nodes)]
        return Rig(
            names=names,
            parents={child: number for number, node in enumerate(nodes) for child in node.children or []},
            local=[_local(node, name) for node, name in zip(nodes, names, strict=True)],
            joints=joints,
            primitives=primitives,
        )

    def _node(self, node: gltf.Node, inverse: dict[int, np.ndarray], skinned: bool) -> list[Primitive]:
        mesh = self.document.meshes[node.mesh]
        name = mesh.name or f"mesh {node.mesh}"
        found = []
        for number, primitive in enumerate(mesh.primitives):
            where = f"mesh {name!r}, primitive {number}"
            found.append(self._primitive(where, name, primitive, inverse, skinned))
        return found

    def _inverse_bind(self, skin: gltf.Skin) -> dict[int, np.ndarray]:
        count = len(skin.joints)
        if skin.inverseBindMatrices is None:
            return {joint: np.eye(4) for joint in skin.joints}
        matrices = self._array("a skin", "inverseBindMatrices", skin.inverseBindMatrices).astype(float)
        if len(matrices) < count:
            raise ValueError(f"a skin has {len(matrices)} inverseBindMatrices; allowed: one for each of {count} joints")
        # glTF keeps matrices by columns
        matrices = matrices[:count].reshape(-1, 4, 4).transpose(0, 2, 1)
        for joint, matrix in zip(skin.joints, matrices, strict=True):
            if not abs(np.linalg.det(matrix)) > 0.0:
                raise ValueError(f"the inverse bind matrix of node {joint} has no inverse")
        return dict(zip(skin.joints, matrices, strict=True))

    def _primitive(
        self, where: str, mesh: str, primitive: gltf.Primitive, inverse: dict[int, np.ndarray], skinned: bool
    ) -> Primitive:
        attributes = primitive.attributes
        for name in ("POSITION", "JOINTS_0", "WEIGHTS_0") if skinned else ("POSITION",):
            if getattr(attributes, name) is None:
                raise ValueError(f"{where} has no {name}; allowed: a rigged mesh, or --weights auto")
        if primitive.mode not in (None, TRIANGLES):
            raise ValueError(f"{where} is of mode {primitive.mode}; allowed: 4, triangles")
        vertices = self._array(where, "POSITION", attributes.POSITION).astype(float)
        count = len(vertices)
        joints, weights = np.zeros((count, 4), int), np.eye(4)[np.zeros(count, int)]
        if skinned:
            joints, weights = self._influences(where, attributes, count, len(inverse))
        indices = np.arange(count)
        if primitive.indices is not None:
            indices = self._array(where, "indices", primitive.indices)[:, 0].astype(int)
        if len(indices) % 3 or not len(indices) or indices.max() >= count:
            raise ValueError(f"{where} has {len(indices)} indices; allowed: threes of 0 to {count - 1}")
        normals = None
        if attributes.NORMAL is not None:
            normals = self._array(where, "NORMAL", attributes.NORMAL, count).astype(float)
        nodes = np.array(list(inverse))[joints]
        return Primitive(where, mesh, vertices, normals, nodes, weights, indices.reshape(-1, 3), inverse)

    def _influences(
        self, where: str, attributes: gltf.Attributes, count: int, joint_count: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Joints (count, 4), numbered as in the skin, and weights."""
        if getattr(attributes, "JOINTS_1", None) is not None:
            raise ValueError(f"{where} has JOINTS_1; allowed range: up to 4 influences a vertex")
        joints = self._array(where, "JOINTS_0", attributes.JOINTS_0, count).astype(int)
        weights = _checked_weights(where, self._array(where, "WEIGHTS_0", attributes.WEIGHTS_0, count))
        joints = np.where(weights > 0.0, joints, 0)
        if joints.max() >= joint_count:
            raise ValueError(f"{where} has joint {joints.max()}; allowed range: 0 to {joint_count - 1}")
        return joints, weights

    def _array(self, where: str, name: str, number: int, count: int | None = None) -> np.ndarray:
        """An accessor's rows; normalized integers as numbers between 0 and 1, all finite."""
        what, kinds = f"{where}: {name}", ATTRIBUTES[name]
        accessor = self.document.accessors[number]
        if accessor.sparse is not None:
            raise ValueError(f"{what} is a sparse accessor; allowed: a plain one")
        if accessor.bufferView is None:
            raise ValueError(f"{what} has no bufferView, as if compressed; allowed: geometry that is not compressed")
        if accessor.type != kinds[0] or accessor.componentType not in kinds[1]:
            allowed = f"{kinds[0]} of {', '.join(map(str, kinds[1]))}"
            raise ValueError(
                f"{what} is {accessor.type} of component type {accessor.componentType}; allowed: {allowed}"
            )
        if count is not None and accessor.count != count:
            raise ValueError(f"{what} has {accessor.count} rows; allowed: {count}, as POSITION")
        rows = self._rows(what, accessor)
        if not np.all(np.isfinite(rows)):
            row = int(np.argwhere(~np.isfinite(rows))[0, 0])
            raise ValueError(f"{what} of vertex {row} is not finite")
        return rows / np.iinfo(rows.dtype).max if name == "WEIGHTS_0" and rows.dtype.kind == "u" else rows

    def _rows(self, what: str, accessor: gltf.Accessor) -> np.ndarray:
        view = self.document.bufferViews[accessor.bufferView]
        if view.buffer != 0 or self.document.buffers[0].uri is not None:
            raise ValueError(f"{what} is outside the file; allowed: data inside the .glb")
        kind, width = COMPONENTS[accessor.componentType], WIDTHS[accessor.type]
        size = kind.itemsize * width
        stride = view.byteStride or size
        start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
        end = start + stride * (accessor.count - 1) + size
        if accessor.count < 1 or start < 0 or stride < size or end > len(self.blob):
            raise ValueError(f"{what} ends at byte {end}; allowed range: up to {len(self.blob)}, the file's data")
        return np.ndarray((accessor.count, width), kind, self.blob, start, (stride, kind.itemsize)).copy()


def _checked_weights(where: str, weights: np.ndarray) -> np.ndarray:
    weights = weights.astype(float)
    sums = weights.sum(axis=1)
    bad = np.flatnonzero((weights.min(axis=1) < 0.0) | (np.abs(sums - 1.0) > WEIGHT_TOLERANCE))
    if len(bad):
        row = bad[0]
        values = ", ".join(f"{weight:.6g}" for weight in weights[row])
        raise ValueError(
            f"{where}: weights of vertex {row} are {values}, and sum to {sums[row]:.6g}; "
            f"allowed range: none below 0, sum 1 within {WEIGHT_TOLERANCE}"
        )
    return weights / sums[:, None]


def _local(node: gltf.Node, name: str) -> np.ndarray:
    if node.matrix is not None:
        return _finite(np.reshape(node.matrix, (4, 4)).T.astype(float), name)
    local = np.eye(4)
    x, y, z, w = np.asarray(node.rotation or [0.0, 0.0, 0.0, 1.0], float) / np.linalg.norm(node.rotation or [1.0])
    local[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    local[:3, :3] *= node.scale or [1.0] * 3
    local[:3, 3] = node.translation or [0.0] * 3
    return _finite(local, name)


def _finite(matrix: np.ndarray, name: str) -> np.ndarray:
    if not np.all(np.isfinite(matrix)):
        raise ValueError(f"the transform of node {name!r} is not finite")
    return matrix
