"""A glTF player on paper: reads a .glb with pygltflib and moves its skin as the standard says, in float64."""

import numpy as np
import pygltflib as gltf

TYPES = {
    gltf.UNSIGNED_BYTE: np.uint8,
    gltf.UNSIGNED_SHORT: np.uint16,
    gltf.UNSIGNED_INT: np.uint32,
    gltf.FLOAT: np.float32,
}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Player:
    """`time` (m,) are the key frames, s; world positions have glTF's y up."""

    def __init__(self, path):
        self.document = gltf.GLTF2().load(str(path))
        self.blob = self.document.binary_blob()
        self.channels = {}
        for channel in (c for animation in self.document.animations for c in animation.channels):
            sampler = self.document.animations[0].samplers[channel.sampler]
            self.time = self.array(sampler.input)[:, 0]
            self.channels[channel.target.node, channel.target.path] = self.array(sampler.output)
        self.parents = {c: n for n, node in enumerate(self.document.nodes) for c in node.children or []}

    def array(self, number):
        """An accessor as an array (count, width)."""
        accessor = self.document.accessors[number]
        view = self.document.bufferViews[accessor.bufferView]
        width = WIDTHS[accessor.type]
        start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
        values = np.frombuffer(self.blob, TYPES[accessor.componentType], accessor.count * width, start)
        return values.reshape(accessor.count, width)

    def node(self, name):
        return next(number for number, node in enumerate(self.document.nodes) if node.name == name)

    def world(self, number, frame):
        """The global 4 x 4 transform of a node at a key frame."""
        node = self.document.nodes[number]
        move = (
            self.channels[number, "translation"][frame]
            if (number, "translation") in self.channels
            else node.translation
        )
        turn = self.channels[number, "rotation"][frame] if (number, "rotation") in self.channels else node.rotation
        x, y, z, w = np.float64(turn if turn is not None else [0, 0, 0, 1])
        local = np.eye(4)
        local[:3, 3] = 0.0 if move is None else move
        local[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        scale = self.channels[number, "scale"][frame] if (number, "scale") in self.channels else node.scale
        local[:3, :3] *= 1.0 if scale is None else scale
        return self.world(self.parents[number], frame) @ local if number in self.parents else local

    def skinned(self, name, frame):
        """World positions (n, 3) of the vertices of a skinned node at a key frame."""
        node = self.document.nodes[self.node(name)]
        skin = self.document.skins[node.skin]
        inverse = self.array(skin.inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1).astype(float)
        matrices = np.array([self.world(joint, frame) for joint in skin.joints]) @ inverse
        attributes = self.document.meshes[node.mesh].primitives[0].attributes
        joints, weights = self.array(attributes.JOINTS_0), self.array(attributes.WEIGHTS_0).astype(float)
        points = np.column_stack([self.array(attributes.POSITION), np.ones(len(joints))])
        return np.einsum("nj,njab,nb->na", weights, matrices[joints], points)[:, :3]


def z_up(points):
    """From glTF's y up to the world's z up."""
    return points[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
