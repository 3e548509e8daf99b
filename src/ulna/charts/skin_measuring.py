"""What the chart of skins measures: cost a vertex, and volume, bulge, folds and normals over flexion and twist."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..bench.arm_skin import READS, SKEW, posed, repeated_read
from ..bench.measuring import choices, side_by_side
from ..bench.skinning import (
    ELBOW,
    FOREARM,
    HALF_WIDTH,
    ON_THE_ELBOW,
    RADIUS,
    SPOKES,
    Array,
    Pose,
    about,
    bone_distance,
    normals,
    rest_mesh,
    smoothstep,
    turned,
)
from .skin_peers import peers

AXES = {"flexion": [0.0, 1.0, 0.0], "twist": [1.0, 0.0, 0.0]}
COST_VERTICES = 20_000
FLAT = 1e-3
"""Of its area at rest: a triangle whose area there is less has no side, for its coordinates are rounded."""


@dataclass(frozen=True)
class Mesh:
    """A mesh at rest."""

    points: Array
    """[n, 3] m from the elbow"""
    tangents: Array
    """[2, n, 3]"""
    triangles: NDArray[np.int32]
    """[m, 3], counterclockwise from outside"""


@dataclass(frozen=True)
class Effort:
    """How much is measured."""

    vertices: int
    """Of the meshes whose shape is measured."""
    spacing: int
    """Degrees between angles, a divisor of 30."""
    rounds: int
    sizes: tuple[int, ...]
    """Vertices of the meshes whose speed is measured."""


FULL, QUICK = Effort(8192, 5, 31, (2048, 20_000, 200_000)), Effort(2048, 30, 5, (2048, 20_000))


@dataclass(frozen=True)
class Cost:
    """What a skin costs."""

    name: str
    method: str
    peer: bool
    normals: bool
    """Whether they are in the time."""
    seconds: float
    """Of a vertex: position, and normal where there is one."""


@dataclass(frozen=True)
class Shape:
    """What a skin does to the arm at one angle."""

    name: str
    method: str
    peer: bool
    bend: str
    angle: float
    """degrees"""
    volume_error: float
    """Of the blend zone, relative to rest."""
    bulge: float
    """Largest distance of a vertex to the bones, in radii."""
    fold_fraction: float
    """Inverted triangles over all."""
    stretch: float
    """Largest length of an edge over that at rest; where it grows with the mesh, the skin is torn."""
    section: float | None
    """Smallest vector area of a ring over that at rest; of our own."""
    normal_error: float | None
    """degrees, mean over the blend zone, to the float64 truth; of what has normals."""


def costs(effort: Effort) -> list[Cost]:
    """Positions and normals of 20 000 vertices in a pose without symmetry, interleaved."""
    methods = choices("ArmSkin", "method")
    skins = {method: posed(method, SKEW, COST_VERTICES) for method in methods}
    calls = {method: both(repeated_read(s, "vertices"), repeated_read(s, "normals")) for method, s in skins.items()}
    own = side_by_side(calls, effort.rounds)
    others = {peer.name: peer for peer in peers(COST_VERTICES, SKEW)}
    # by themselves, since NumPy's threads go on turning after a call
    theirs = side_by_side({name: peer.call for name, peer in others.items()}, effort.rounds)
    each = 1.0 / COST_VERTICES
    return [
        *(Cost(method, method, False, True, own[method][0] / READS * each) for method in methods),
        *(Cost(n, p.method, True, p.call()[1] is not None, theirs[n][0] * each) for n, p in others.items()),
    ]


def both(first: Callable[[], None], second: Callable[[], None]) -> Callable[[], None]:
    """A call of one after the other."""
    return lambda: (first(), second())[0]


def angles(bend: str, effort: Effort) -> list[float]:
    """degrees"""
    return [float(angle) for angle in range(0, 181 if bend == "twist" else 151, effort.spacing)]


def bent(bend: str, angle: float) -> Pose:
    """The upper arm at rest, the forearm turned about the elbow by an angle in degrees."""
    return Pose(about([1, 0, 0], 0.0), np.zeros(3), about(AXES[bend], angle), ELBOW)


def shapes(effort: Effort, say: Callable[[str], None] = lambda _: None) -> Iterator[Shape]:
    """Every method and peer over flexion and twist, all of the twist in the blend zone."""
    methods = choices("ArmSkin", "method")
    skins = {method: posed(method, bent("flexion", 0.0), effort.vertices) for method in methods}
    mesh = Mesh(*rest_mesh(effort.vertices), skins[methods[0]].get("triangles").reshape(-1, 3)[:-4])
    for bend in AXES:
        for angle in angles(bend, effort):
            say(f"{bend} {angle:.0f}")
            pose = bent(bend, angle)
            for method, skin in skins.items():
                skin.set("forearm_orientation", pose.fore)
                found = skin.get("vertices").T, skin.get("normals").T
                measures = ("blend_volume_ratio", "fold_fraction", "minimum_section_ratio")
                yield shape(method, method, (bend, angle), mesh, found, [skin.get(name) for name in measures])
            for peer in peers(effort.vertices, pose):
                found = peer.call()
                measures = [volume_ratio(found[0], mesh), fold_fraction(found[0], mesh, pose), None]
                yield shape(peer.name, peer.method, (bend, angle), mesh, found, measures)


def shape(
    name: str,
    method: str,
    where: tuple[str, float],
    mesh: Mesh,
    found: tuple[NDArray, NDArray | None],
    measures: Sequence[float | None],
) -> Shape:
    """What vertices and normals of a skin say, beside volume ratio, fold fraction and section that were measured."""
    bend, angle = where
    pose = bent(bend, angle)
    vertices, outward = found
    volume, folded, section = measures
    hand = ELBOW + turned(pose.fore, np.array([FOREARM, 0.0, 0.0]))
    bulge = bone_distance(vertices.astype(float), hand).max() / RADIUS
    off = None if outward is None else normal_error(method, mesh, pose, outward)
    stretch = (edges(vertices, mesh) / edges(mesh.points, mesh)).max()
    sizes = float(volume - 1.0), float(bulge), folded, float(stretch)
    return Shape(name, method, name != method, bend, angle, *sizes, section, off)


def normal_error(method: str, mesh: Mesh, pose: Pose, outward: NDArray) -> float:
    """Mean angle, degrees, between normals [n, 3] and the truth within the zone; rings shrunk to a point left out."""
    zone = np.abs(mesh.points[:, 0]) < HALF_WIDTH
    with np.errstate(invalid="ignore"):
        truth = normals(method, mesh.points, mesh.tangents, pose)[zone]
    outward = outward[zone].astype(float)
    there = np.isfinite(truth).all(axis=1) & (np.linalg.norm(outward, axis=1) > 0.5)
    sine = np.linalg.norm(np.cross(truth, outward), axis=1)
    return float(np.degrees(np.arctan2(sine, np.sum(truth * outward, axis=1))[there]).mean())


def edges(vertices: NDArray, mesh: Mesh) -> Array:
    """Lengths [m, 3] of the triangles' edges, m."""
    corners = vertices.astype(float)[mesh.triangles]
    return np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)


def volume_ratio(vertices: NDArray, mesh: Mesh) -> float:
    """Volume of the zone of vertices [n, 3], closed by its end rings, over that at rest."""
    return zone_volume(vertices.astype(float), mesh) / zone_volume(mesh.points, mesh)


def zone_volume(vertices: Array, mesh: Mesh) -> float:
    """m^3, within the triangles of the zone and the polygons of its end rings, by the divergence theorem."""
    inside = np.abs(mesh.points[:, 0]) < HALF_WIDTH * (1 + ON_THE_ELBOW)
    vertices = vertices - vertices[inside].mean(axis=0)
    a, b, c = np.moveaxis(vertices[mesh.triangles[inside[mesh.triangles].all(axis=1)]], 1, 0)
    volume = np.sum(a * np.cross(b, c))
    first, last = vertices[inside].reshape(-1, SPOKES, 3)[[0, -1]]
    for ring, side in ((first, -1.0), (last, 1.0)):
        areas = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
        volume += side * ring.mean(axis=0) @ areas
    return float(volume) / 6


def fold_fraction(vertices: NDArray, mesh: Mesh, pose: Pose) -> float:
    """Inverted triangles of vertices [n, 3] over all: as ArmSkin's README has it, by more than FLAT of their area."""
    corners = mesh.points[mesh.triangles]
    ends = np.stack([corners[:, :, :1].min(axis=1), corners[:, :, :1].max(axis=1)])
    weight = smoothstep(ends.reshape(-1, 1)).reshape(2, -1, 1).mean(axis=0)
    rest = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    real = (1 - weight) * pose.upper + weight * pose.nearer_fore
    carried = turned(real / np.linalg.norm(real, axis=1, keepdims=True), rest)
    corners = vertices.astype(float)[mesh.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.mean(np.sum(normal * carried, axis=1) < -FLAT * np.sum(rest * rest, axis=1)))
