"""Skinning by other libraries, as far as they are installed, on ArmSkin's rest mesh and weights."""

from collections.abc import Callable, Iterator
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bench.arm_skin import posed
from ..bench.skinning import ELBOW, Array, Pose, rest_mesh, smoothstep, turned

Skinned = tuple[Array, Array | None]
"""Positions [n, 3] m, and normals [n, 3] or None where the library has none."""


class Peer(NamedTuple):
    """A library's way to skin."""

    name: str
    method: str
    """ArmSkin's of the same shape."""
    call: Callable[[], Skinned]


def matrices(pose: Pose) -> Array:
    """Of both bones, [2, 4, 4], for row vectors of the world at rest: x' = x M."""
    found = np.tile(np.eye(4), (2, 1, 1))
    bones = (pose.upper, np.zeros(3), pose.shoulder), (pose.fore, ELBOW, pose.elbow)
    for matrix, (turn, rest, place) in zip(found, bones, strict=True):
        matrix[:3, :3] = turned(turn, np.eye(3))
        matrix[3, :3] = place - turned(turn, rest)
    return found


def peers(vertex_count: int, pose: Pose) -> Iterator[Peer]:
    """All that are installed, on this many vertices in this pose."""
    points, tangents = rest_mesh(vertex_count)
    mesh = points + ELBOW, np.cross(*tangents), smoothstep(points)
    yield _numpy(*mesh, matrices(pose))
    if find_spec("igl"):
        yield _libigl(*mesh, matrices(pose))
    if find_spec("pxr"):
        yield from _usd(*mesh, matrices(pose))


def position_peers(vertex_count: int, pose: Pose) -> Iterator[Peer]:
    """All that are installed, each by one thread and without normals, but for MuJoCo, which has no skin without."""
    points, tangents = rest_mesh(vertex_count)
    mesh = points + ELBOW, np.cross(*tangents), smoothstep(points)
    yield _numpy(*mesh, matrices(pose), normal=False)
    if find_spec("igl"):
        yield _libigl(*mesh, matrices(pose))
    if find_spec("pxr"):
        yield from _usd(*mesh, matrices(pose), normal=False)
    if find_spec("mujoco"):
        yield _mujoco(mesh[0], mesh[2], pose)


def _numpy(points: Array, normals: Array, weight: Array, bones: Array, normal: bool = True) -> Peer:
    """The linear blend of matrices; normals by the blend of the rotations alone, as is usual."""
    rest, normals, weight = (np.float32(values) for values in (points, normals, weight))
    first, second = np.float32(bones)

    def skin() -> Skinned:
        here = rest @ first[:3, :3] + first[3, :3]
        here += weight * (rest @ second[:3, :3] + second[3, :3] - here)
        if not normal:
            return here, None
        outward = normals @ first[:3, :3]
        outward += weight * (normals @ second[:3, :3] - outward)
        return here, outward

    return Peer("NumPy, linear blend", "linear_blend", skin)


def _libigl(points: Array, _: Array, weight: Array, bones: Array) -> Peer:
    """Jacobson's matrix of the linear blend times the bones' matrices."""
    import igl

    # numbered vertex-major: a handle's 4 columns follow each other
    blend = igl.lbs_matrix(np.ascontiguousarray(points), np.concatenate([1 - weight, weight], axis=1))
    stack = bones[:, :, :3].reshape(8, 3)
    return Peer("libigl, linear blend", "linear_blend", lambda: (blend @ stack, None))


def _usd(points: Array, normals: Array, weight: Array, bones: Array, normal: bool = True) -> Iterator[Peer]:
    """UsdSkel's two methods, which skin in place a copy of the rest mesh, by one thread."""
    from pxr import Gf, UsdSkel, Vt

    rest, outward = (Vt.Vec3fArray.FromNumpy(np.float32(values)) for values in (points, normals))
    joints = Vt.IntArray.FromNumpy(np.tile(np.int32([0, 1]), len(points)))
    weights = Vt.FloatArray.FromNumpy(np.float32(np.concatenate([1 - weight, weight], axis=1)).ravel())
    moves = Vt.Matrix4fArray([Gf.Matrix4f(matrix.tolist()) for matrix in bones])
    turns = Vt.Matrix3fArray([Gf.Matrix3f(matrix[:3, :3].tolist()) for matrix in bones])

    def skin(token: str) -> Skinned:
        here, there = Vt.Vec3fArray(rest), Vt.Vec3fArray(outward)
        UsdSkel.SkinPoints(token, Gf.Matrix4f(1.0), moves, joints, weights, 2, here, True)
        if not normal:
            return np.asarray(here), None
        UsdSkel.SkinNormals(token, Gf.Matrix3f(1.0), turns, joints, weights, 2, there, True)
        return np.asarray(here), np.asarray(there)

    tokens = UsdSkel.Tokens.classicLinear, UsdSkel.Tokens.dualQuaternion
    for token, method in zip(tokens, ("linear_blend", "dual_quaternion"), strict=True):
        name = f"UsdSkel, {method.replace('_', ' ')}"
        yield Peer(name, method, lambda token=token: skin(token))


def _mujoco(points: Array, weight: Array, pose: Pose) -> Peer:
    """The skin of MuJoCo's scene over two bodies that are moved by hand; its normals are those of the triangles."""
    import mujoco

    with posed("rigid", pose, len(points)) as skin:
        triangles = skin.get("triangles").reshape(-1, 3)[:-4]
    rests = {"upper_arm": (np.zeros(3), 1 - weight), "forearm": (ELBOW, weight)}
    bodies = "".join(f'<body name="{name}" mocap="true"><geom size="0.1"/></body>' for name in rests)
    numbers = _text(np.arange(len(points)))
    bones = "".join(
        f'<bone body="{name}" bindpos="{_text(place)}" bindquat="1 0 0 0" vertid="{numbers}" '
        f'vertweight="{_text(share)}"/>'
        for name, (place, share) in rests.items()
    )
    mesh = f'<skin vertex="{_text(points)}" face="{_text(triangles)}">{bones}</skin>'
    document = f"<mujoco><worldbody>{bodies}</worldbody><deformable>{mesh}</deformable></mujoco>"
    model = mujoco.MjModel.from_xml_string(document)
    data, option, camera = mujoco.MjData(model), mujoco.MjvOption(), mujoco.MjvCamera()
    data.mocap_pos[:], data.mocap_quat[:] = (pose.shoulder, pose.elbow), (pose.upper, pose.fore)
    mujoco.mj_kinematics(model, data)
    scene = mujoco.MjvScene(model, 2)

    def skin() -> Skinned:
        # of no category but skins
        mujoco.mjv_updateScene(model, data, option, None, camera, 0, scene)
        return scene.skinvert.reshape(-1, 3), scene.skinnormal.reshape(-1, 3)

    return Peer("MuJoCo, linear blend", "linear_blend", skin)


def _text(values: NDArray) -> str:
    return " ".join(map(repr, values.ravel().tolist()))
