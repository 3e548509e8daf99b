"""Writes a run as an animated glTF 2.0 file, with its skin, that opens in any viewer.

The skin's positions are those of ArmSkin: see `skeleton`. Its normals are those that the viewer makes, which turns them
with the joints; ArmSkin's own are exact. The world's z is up, glTF's y: all hangs below one node that turns it.
"""

from os import PathLike
from pathlib import Path

import numpy as np
import pygltflib as gltf

from .drawing import Part, Shape, parts, series, skin_like, units_of
from .results import Results
from .scene import Scene, SceneUnit
from .skeleton import Arm, Skeleton, continuous, skeleton

FRAME_RATE = 30.0
UPRIGHT = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]
SKIN_COLOR = [0.80, 0.52, 0.40, 1.0]
COMPONENT_TYPES = {
    np.dtype(np.uint8): gltf.UNSIGNED_BYTE,
    np.dtype(np.uint16): gltf.UNSIGNED_SHORT,
    np.dtype(np.uint32): gltf.UNSIGNED_INT,
    np.dtype(np.float32): gltf.FLOAT,
}
ELEMENT_TYPES = {(): gltf.SCALAR, (3,): gltf.VEC3, (4,): gltf.VEC4, (4, 4): gltf.MAT4}


def write_glb(path: str | PathLike, results: Results, scene: Scene) -> None:
    """Writes what `glb` returns, and raises what it does."""
    Path(path).write_bytes(glb(results, scene))


def glb(results: Results, scene: Scene) -> bytes:
    """The units of a scene as they moved in a run, 30 frames a second, times from 0 s.

    Raises KeyError, with the name, if a pose was neither recorded nor driven by what was.
    """
    rows = frames(results.time)
    file = _File(np.asarray(results.time[rows] - results.time[0], np.float32))
    for part in parts(results, scene):
        file.add_part(part, rows)
    for unit in units_of(scene, "ArmSkin"):
        file.add_skin(unit, results, scene, rows)
    return file.finish()


def frames(time: np.ndarray) -> np.ndarray:
    """The rows nearest to the frames, first and last row included."""
    wanted = np.append(np.arange(time[0], time[-1], 1.0 / FRAME_RATE), time[-1])
    after = np.clip(np.searchsorted(time, wanted), 1, max(len(time) - 1, 1))
    before_is_nearer = wanted - time[after - 1] < time[np.minimum(after, len(time) - 1)] - wanted
    return np.unique(np.where(before_is_nearer, after - 1, np.minimum(after, len(time) - 1)))


def arm_skeleton(
    unit: SceneUnit, results: Results, scene: Scene, rows: np.ndarray, at_rest: dict[str, np.ndarray]
) -> Skeleton:
    """The joints of an ArmSkin unit at some rows of a run; `at_rest`: its vertices, weights and triangles."""
    poses = [
        tuple(series(results, scene, f"{unit.name}.{bone}_{what}")[rows] for what in ("position", "orientation"))
        for bone in ("upper_arm", "forearm")
    ]
    values = {
        name: unit.slave.get(name)
        for name in ("method", "upper_arm_length", "forearm_length", "radius", "blend_half_width", "twist_share")
    }
    arm = Arm(
        method=values["method"],
        elbow=np.array([values["upper_arm_length"], 0.0, 0.0]),
        vertices=at_rest["vertices"].T.astype(float),
        weights=at_rest["weights"],
        triangles=at_rest["triangles"],
        blend_half_width=values["blend_half_width"],
        twist_share=values["twist_share"],
        twist_end=values["forearm_length"] - values["radius"],
    )
    return skeleton(arm, *poses)


class _File:
    """A glTF document in the making: arrays go to one buffer, each behind a view and an accessor of its own."""

    def __init__(self, times: np.ndarray):
        self.document = gltf.GLTF2(
            asset=gltf.Asset(version="2.0", generator="ulna"),
            scene=0,
            scenes=[gltf.Scene(nodes=[0])],
            nodes=[gltf.Node(name="world, z up", rotation=UPRIGHT, children=[])],
        )
        self.data = bytearray()
        self.times = times
        self.animation = gltf.Animation(name="run")
        self._time_accessor: int | None = None

    def add_part(self, part: Part, rows: np.ndarray) -> None:
        node = self._add_node(part.name, part.position[rows], continuous(part.orientation[rows]))
        self.document.nodes[node].mesh = self._add_mesh(part.name, part.shape)

    def add_skin(self, unit: SceneUnit, results: Results, scene: Scene, rows: np.ndarray) -> None:
        with skin_like(unit) as skin:
            at_rest = {name: skin.get(name) for name in ("vertices", "normals", "weights", "triangles")}
        # the last rows of `triangles` have no area
        triangles = at_rest["triangles"] = at_rest["triangles"].reshape(-1, 3)[:-4]
        bones = arm_skeleton(unit, results, scene, rows, at_rest)
        joints = np.zeros((len(bones.joints), 4), np.uint8)
        weights = np.zeros((len(bones.joints), 4), np.float32)
        joints[:, :2] = np.where(bones.weights > 0.0, bones.joints, 0)
        weights[:, :2] = bones.weights
        attributes = gltf.Attributes(
            POSITION=self._add_array(np.ascontiguousarray(at_rest["vertices"].T), gltf.ARRAY_BUFFER, limits=True),
            NORMAL=self._add_array(np.ascontiguousarray(at_rest["normals"].T), gltf.ARRAY_BUFFER),
            JOINTS_0=self._add_array(joints, gltf.ARRAY_BUFFER),
            WEIGHTS_0=self._add_array(weights, gltf.ARRAY_BUFFER),
        )
        mesh = self._add_primitive(unit.name, attributes, triangles, self._add_material("skin", SKIN_COLOR, 0.55))
        nodes = [
            self._add_node(f"{unit.name} joint {j}", bones.positions[j], bones.orientations[j], bones.widths[j])
            for j in range(len(bones.origins))
        ]
        inverse = np.tile(np.eye(4, dtype=np.float32), (len(nodes), 1, 1))
        # glTF keeps matrices by columns
        inverse[:, 3, :3] = -bones.origins
        self.document.skins.append(
            gltf.Skin(name=unit.name, joints=nodes, skeleton=0, inverseBindMatrices=self._add_array(inverse))
        )
        # a skinned mesh takes the place of its joints, so it belongs at the root
        self.document.nodes.append(gltf.Node(name=unit.name, mesh=mesh, skin=len(self.document.skins) - 1))
        self.document.scenes[0].nodes.append(len(self.document.nodes) - 1)

    def finish(self) -> bytes:
        document = self.document
        if self.animation.channels:
            document.animations.append(self.animation)
        document.buffers = [gltf.Buffer(byteLength=len(self.data))] if self.data else []
        document.set_binary_blob(bytes(self.data))
        return b"".join(document.save_to_bytes())

    def _add_node(
        self, name: str, position: np.ndarray, orientation: np.ndarray, width: np.ndarray | None = None
    ) -> int:
        """A node below the world, its y and z stretched by `width`; what does not move is not animated."""
        document = self.document
        number = len(document.nodes)
        turns = np.float32(np.roll(orientation, -1, axis=1))
        turns /= np.linalg.norm(turns, axis=1, keepdims=True)
        moves = np.float32(position)
        widths = np.ones(1) if width is None else width
        scales = np.stack([np.ones_like(widths), widths, widths], axis=1).astype(np.float32)
        scale = scales[0].tolist() if np.any(scales != 1.0) else None
        node = gltf.Node(name=name, translation=moves[0].tolist(), rotation=turns[0].tolist(), scale=scale)
        document.nodes.append(node)
        document.nodes[0].children.append(number)
        for target, values in (("translation", moves), ("rotation", turns), ("scale", scales)):
            if np.any(values != values[0]):
                self._animate(number, target, values)
        return number

    def _animate(self, node: int, path: str, values: np.ndarray) -> None:
        if self._time_accessor is None:
            self._time_accessor = self._add_array(self.times, limits=True)
        output = self._add_array(np.ascontiguousarray(values))
        self.animation.samplers.append(
            gltf.AnimationSampler(input=self._time_accessor, output=output, interpolation=gltf.ANIM_LINEAR)
        )
        target = gltf.AnimationChannelTarget(node=node, path=path)
        self.animation.channels.append(gltf.AnimationChannel(sampler=len(self.animation.samplers) - 1, target=target))

    def _add_mesh(self, name: str, shape: Shape) -> int:
        colors = np.zeros((len(shape.colors), 4), np.uint8)
        colors[:, :3] = np.rint(shape.colors * 255)
        colors[:, 3] = 255
        attributes = gltf.Attributes(
            POSITION=self._add_array(shape.vertices, gltf.ARRAY_BUFFER, limits=True),
            NORMAL=self._add_array(shape.normals, gltf.ARRAY_BUFFER),
            COLOR_0=self._add_array(colors, gltf.ARRAY_BUFFER, normalized=True),
        )
        return self._add_primitive(name, attributes, shape.triangles, self._add_material(name, [1.0] * 4, 0.5))

    def _add_primitive(self, name: str, attributes: gltf.Attributes, triangles: np.ndarray, material: int) -> int:
        index_type = np.uint16 if triangles.max() < 65535 else np.uint32
        indices = self._add_array(triangles.astype(index_type).reshape(-1), gltf.ELEMENT_ARRAY_BUFFER)
        primitive = gltf.Primitive(attributes=attributes, indices=indices, material=material)
        self.document.meshes.append(gltf.Mesh(name=name, primitives=[primitive]))
        return len(self.document.meshes) - 1

    def _add_material(self, name: str, color: list[float], roughness: float) -> int:
        surface = gltf.PbrMetallicRoughness(baseColorFactor=color, metallicFactor=0.0, roughnessFactor=roughness)
        self.document.materials.append(gltf.Material(name=name, pbrMetallicRoughness=surface, alphaCutoff=None))
        return len(self.document.materials) - 1

    def _add_array(
        self, values: np.ndarray, target: int | None = None, *, limits: bool = False, normalized: bool = False
    ) -> int:
        """An accessor for an array, one element per row.

        All data starts at multiples of four bytes, as it must: closed meshes have an even number of triangles.
        """
        view = gltf.BufferView(buffer=0, byteOffset=len(self.data), byteLength=values.nbytes, target=target)
        self.document.bufferViews.append(view)
        self.data += values.tobytes()
        rows = values.reshape(len(values), -1)
        accessor = gltf.Accessor(
            bufferView=len(self.document.bufferViews) - 1,
            componentType=COMPONENT_TYPES[values.dtype],
            count=len(values),
            type=ELEMENT_TYPES[values.shape[1:]],
            normalized=normalized,
            max=rows.max(axis=0).tolist() if limits else None,
            min=rows.min(axis=0).tolist() if limits else None,
        )
        self.document.accessors.append(accessor)
        return len(self.document.accessors) - 1
