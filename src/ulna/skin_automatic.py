"""A mesh without weights as ArmSkin's: `ulna skin import --weights auto`, by bounded biharmonic weights."""

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from .biharmonic import biharmonic_shares, check_closed, libigl, surface_distance
from .names import unknown
from .rig import read_rig
from .skin_frame import check_length, lengths, placed, rest_frame, whole_normals, without_unused
from .skin_mesh import SkinMesh, weight_gradients

JOINTS = ("shoulder", "elbow", "wrist")
WIDE = 1.5
"""Half width of the blend, in distances from the elbow to the skin: ArmSkin's own."""


def automatic_mesh(
    path: str | PathLike,
    joints: Sequence[str | Sequence[float]],
    *,
    mesh: str | None = None,
    half_width: float | None = None,
) -> SkinMesh:
    """The mesh of a .glb file, or of one that libigl reads (.obj, .ply, .stl, .off: in m, y up), with weights.

    `joints`: shoulder, elbow and wrist, each x, y, z in the file's world, m, or the name of a node. `half_width`, m:
    how far from the elbow the bones end that hold the skin. Raises FileNotFoundError, ModuleNotFoundError without
    libigl or TetGen, KeyError for a name, and ValueError for a surface that is not closed, crosses itself or has a bone
    outside.
    """
    if Path(path).suffix.lower() == ".glb":
        vertices, triangles, nodes = _gltf_surface(path, mesh)
    else:
        vertices, triangles, nodes = _other_surface(path, mesh)
    vertices, triangles = _welded(vertices, triangles)
    places = np.array([_place(name, joint, nodes) for name, joint in zip(JOINTS, joints, strict=True)])
    frame, length = rest_frame(places[0], places[1])
    vertices, places = (points @ frame[:3, :3].T + frame[:3, 3] for points in (vertices, places))
    try:
        check_closed(vertices, triangles)
        if half_width is None:
            half_width = WIDE * surface_distance(vertices, triangles, places[1])
        check_length("blend_half_width", half_width)
        shares = biharmonic_shares(vertices, triangles, places, half_width)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not shares.min() < 0.5 <= shares.max():
        raise ValueError(f"{path}: the bones move no vertices apart; allowed: a mesh of which either holds a part")
    return SkinMesh(
        vertices=vertices,
        normals=whole_normals(vertices, triangles, np.zeros_like(vertices)),
        gradients=weight_gradients(vertices, triangles, shares),
        weights=np.stack([1.0 - shares, shares, 0.0 * shares, 0.0 * shares], axis=1),
        joints=np.tile([0, 1, 0, 0], (len(shares), 1)),
        forearm=np.array([False, True]),
        triangles=triangles,
        **lengths(vertices, shares, _from_forearm(vertices, shares, places), length),
    )


def _from_forearm(vertices: np.ndarray, shares: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Distances (n,), m, from the bone between elbow and wrist of what it holds beside it; NaN of all else."""
    bone = places[2] - places[1]
    along = (vertices - places[1]) @ bone / (bone @ bone)
    beside = (shares >= 0.5) & (along > 0.0) & (along < 1.0)
    return np.where(beside, np.linalg.norm(vertices - places[1] - along[:, None] * bone, axis=1), np.nan)


def _gltf_surface(path: str | PathLike, mesh: str | None) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Vertices and triangles in glTF's world, m, and where its nodes are."""
    rig = read_rig(path, skinned=False)
    names = {p.mesh for p in rig.primitives}
    if mesh is not None and mesh not in names:
        raise KeyError(unknown("the file", "mesh", mesh, sorted(names)))
    pieces, count = [], 0
    for p in (p for p in rig.primitives if mesh in (None, p.mesh)):
        ((node, inverse),) = p.inverse_bind.items()
        vertices, _, triangles = placed(p.where, p.vertices, None, p.triangles, rig.to_world(node) @ inverse)
        pieces.append((vertices, triangles + count))
        count += len(vertices)
    nodes = {name: rig.to_world(number)[:3, 3] for number, name in enumerate(rig.names)}
    return np.concatenate([piece[0] for piece in pieces]), np.concatenate([piece[1] for piece in pieces]), nodes


def _other_surface(path: str | PathLike, mesh: str | None) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    if not Path(path).is_file():
        raise FileNotFoundError(f"no file {path}")
    if mesh is not None:
        raise KeyError(f"no mesh {mesh!r}: {path} has no names; allowed: --mesh with a .glb file")
    try:
        vertices, triangles = libigl().read_triangle_mesh(str(path))
    except RuntimeError:
        raise ValueError(f"{path} cannot be read; allowed: .glb, or .obj, .ply, .stl, .off of triangles") from None
    if triangles.size == 0 or triangles.shape[1] != 3 or triangles.min() < 0 or triangles.max() >= len(vertices):
        raise ValueError(f"{path} has a triangle of vertices that it has not; allowed range: 0 to {len(vertices) - 1}")
    if not np.all(np.isfinite(vertices)):
        raise ValueError(f"{path}: a vertex is not finite")
    return vertices, triangles, {}


def _place(name: str, joint: str | Sequence[float], nodes: dict[str, np.ndarray]) -> np.ndarray:
    """Where a joint is, m."""
    if isinstance(joint, str):
        if joint not in nodes:
            raise KeyError(unknown(f"the {name}", "node", joint, sorted(nodes)) if nodes else _not_a_place(name, joint))
        return nodes[joint]
    place = np.asarray(joint, float)
    if place.shape != (3,) or not np.all(np.isfinite(place)):
        raise ValueError(_not_a_place(name, joint))
    return place


def _not_a_place(name: str, joint: object) -> str:
    return f"the {name} is at {joint}; allowed: three numbers x,y,z in m, or the name of a node of a .glb file"


def _welded(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """With one vertex at a place, as a surface has them before seams of textures part it; none without a triangle."""
    _, first, same = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    used, triangles = without_unused(first[same.ravel()][triangles])
    if not len(triangles):
        raise ValueError("the mesh has no triangle with an area")
    return vertices[used], triangles
