"""Makes an ArmSkin FMU of a mesh of the user's: `ulna skin import`.

A rigged mesh is taken as it was bound, where the file leaves the upper arm's joint, in m. The rest frame has the elbow,
the forearm's joint, at the origin, the upper arm along x; z is the direction across it nearest to up, or to the front
where the arm hangs or points up. Joints at or below the forearm's follow the forearm; all others follow the upper arm.
"""

import re
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree as ET

import numpy as np

from .generate.model_description import to_string
from .generate.package import write_fmu
from .names import unknown
from .paths import fmu
from .rig import Rig, read_rig
from .skin_automatic import automatic_mesh
from .skin_frame import LENGTHS, lengths, placed, rest_frame, whole_normals, without_unused
from .skin_mesh import MOST_JOINTS, SkinMesh, weight_gradients, write_mesh
from .slave import Slave, UnitError

MESH_FILE = "mesh.bin"
# Upper arm, forearm: names in small letters, without marks and the rig's own prefix.
PREFIX = re.compile(r"^(mixamorig\d*|jbip|bip\d*|def)")
COMMON = (
    ("leftarm", "leftforearm"),
    ("leftupperarm", "leftlowerarm"),
    ("upperarml", "forearml"),
    ("upperarml", "lowerarml"),
    ("lupperarm", "lforearm"),
    ("lupperarm", "llowerarm"),
    ("rightarm", "rightforearm"),
    ("rightupperarm", "rightlowerarm"),
    ("upperarmr", "forearmr"),
    ("upperarmr", "lowerarmr"),
    ("rupperarm", "rforearm"),
    ("rupperarm", "rlowerarm"),
    ("upperarm", "forearm"),
    ("upperarm", "lowerarm"),
)


@dataclass(frozen=True)
class Bones:
    """The two joints of a rig that are the arm."""

    upper_arm: int
    forearm: int
    followers: frozenset[int]
    """All nodes that follow the forearm."""


def import_skin(
    path: str | PathLike,
    out: str | PathLike,
    *,
    upper_arm: str | None = None,
    forearm: Sequence[str] = (),
    mesh: str | None = None,
    only_arm: bool = False,
    version: str = "3.0",
) -> tuple[SkinMesh, tuple[str, str]]:
    """Writes the FMU `out`; returns its mesh and the names of the two joints. The same file gives the same bytes.

    `forearm`: the joint whose origin is the elbow, then others that follow the forearm too, in rigs that do not put
    them below it. `mesh`: the only mesh to take. `only_arm`: of a figure, leaves out what the arm does not hold. Raises
    FileNotFoundError, KeyError for a name, ValueError.
    """
    stock = fmu("ArmSkin", version)
    rig = read_rig(path)
    bones = find_bones(rig, upper_arm, forearm)
    skin = arm_mesh(rig, bones, mesh, only_arm)
    write_skin_fmu(out, skin, stock)
    return skin, (rig.names[bones.upper_arm], rig.names[bones.forearm])


def import_unrigged(
    path: str | PathLike,
    out: str | PathLike,
    joints: Sequence[str | Sequence[float]],
    *,
    mesh: str | None = None,
    half_width: float | None = None,
    version: str = "3.0",
) -> SkinMesh:
    """Writes the FMU `out` of a mesh without weights; returns the mesh. Arguments and errors as `automatic_mesh`."""
    stock = fmu("ArmSkin", version)
    skin = automatic_mesh(path, joints, mesh=mesh, half_width=half_width)
    write_skin_fmu(out, skin, stock)
    return skin


def find_bones(rig: Rig, upper_arm: str | None = None, forearm: Sequence[str] = ()) -> Bones:
    """The joints by name, or by what common rigs call them, the left arm first. Raises KeyError, listing the joints."""
    known = [rig.names[joint] for joint in rig.joints]
    if (upper_arm is None) != (not forearm):
        raise ValueError("name both joints or none: upper arm and forearm")
    if upper_arm is None:
        upper_arm, *forearm = _common(known)
    first, *others = (_joint(rig, name) for name in (upper_arm, *forearm))
    if first in others:
        raise ValueError(f"{upper_arm!r} is named for both the upper arm and the forearm")
    followers = {joint for joint in rig.joints if {joint, *rig.ancestors(joint)} & set(others)}
    if first in followers:
        raise ValueError(f"{upper_arm!r} is below {forearm[0]!r}; allowed: an upper arm that is not below its forearm")
    return Bones(first, others[0], frozenset(followers))


def arm_mesh(rig: Rig, bones: Bones, mesh: str | None = None, only_arm: bool = False) -> SkinMesh:
    """The mesh in the arm's rest frame, and the lengths of its bones. Raises ValueError, KeyError for a mesh's name.

    `only_arm` keeps the triangles of whose corners all are held, by half of their weight or more, by the upper arm's
    joint, those below it and those that follow the forearm; what other joints hold of them goes with the upper arm.
    """
    taken = [p for p in rig.primitives if {bones.upper_arm, bones.forearm} <= p.inverse_bind.keys()]
    if not taken:
        raise ValueError("no skin has both joints")
    if mesh is not None and mesh not in {p.mesh for p in taken}:
        raise KeyError(unknown("the skin", "mesh", mesh, sorted({p.mesh for p in taken})))
    taken = [p for p in taken if mesh in (None, p.mesh)]
    world = rig.to_world(bones.upper_arm)
    bind = world @ taken[0].inverse_bind[bones.upper_arm]
    joints_of_arm = (bones.upper_arm, bones.forearm)
    ends = [(bind @ np.linalg.inv(taken[0].inverse_bind[joint]))[:3, 3] for joint in joints_of_arm]
    frame, length = rest_frame(*ends)
    moves = [frame @ world @ p.inverse_bind[bones.upper_arm] for p in taken]
    pieces = [placed(p.where, p.vertices, p.normals, p.triangles, m) for p, m in zip(taken, moves, strict=True)]
    starts = np.cumsum([0, *(len(p.vertices) for p in taken[:-1])])
    triangles = np.concatenate([piece[2] + start for piece, start in zip(pieces, starts, strict=True)])
    vertices, normals = (np.concatenate([piece[k] for piece in pieces]) for k in range(2))
    weights, nodes = (np.concatenate([getattr(p, name) for p in taken]) for name in ("weights", "joints"))
    if only_arm:
        below = [joint for joint in rig.joints if bones.upper_arm in (joint, *rig.ancestors(joint))]
        held = np.sum(weights * np.isin(nodes, [*below, *bones.followers]), axis=1) >= 0.5
        triangles = triangles[held[triangles].all(axis=1)]
    used, triangles = without_unused(triangles)
    vertices, normals, weights, nodes = vertices[used], normals[used], weights[used], nodes[used]
    joints, numbers = np.unique(nodes, return_inverse=True)
    if len(joints) > MOST_JOINTS:
        raise ValueError(f"{len(joints)} joints move the mesh; allowed range: up to {MOST_JOINTS}")
    forearm = np.isin(joints, list(bones.followers))
    numbers = numbers.reshape(-1, 4)
    shares = np.sum(weights * forearm[numbers], axis=1)
    if not (shares.min() < 0.5 <= shares.max()):
        raise ValueError("the joints move no vertices apart; allowed: a mesh of which either bone holds a part")
    held = np.sum(weights * np.isin(nodes, joints_of_arm), axis=1) >= 0.5
    return SkinMesh(
        vertices=vertices,
        normals=whole_normals(vertices, triangles, normals),
        gradients=weight_gradients(vertices, triangles, shares),
        weights=weights,
        joints=numbers,
        forearm=forearm,
        triangles=triangles,
        **lengths(vertices, shares, np.where(held, np.hypot(vertices[:, 1], vertices[:, 2]), np.nan), length),
    )


def write_skin_fmu(out: str | PathLike, mesh: SkinMesh, stock: Path) -> None:
    """The stock FMU with the mesh among its resources; start values are those of the mesh. Raises ValueError.

    The unit itself loads it before `out` is written, so that a mesh that its loader refuses leaves no file.
    """
    with zipfile.ZipFile(stock) as archive:
        files = {name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}
    with TemporaryDirectory() as folder:
        write_mesh(Path(folder) / MESH_FILE, mesh)
        files[f"resources/{MESH_FILE}"] = (Path(folder) / MESH_FILE).read_bytes()
        files["modelDescription.xml"] = _with_starts(files["modelDescription.xml"], mesh)
        trial = Path(folder) / "trial.fmu"
        write_fmu(trial, files)
        try:
            with Slave(trial, name="ArmSkin") as skin:
                skin.initialize()
        except UnitError as error:
            raise ValueError(error.message or str(error)) from None
        Path(out).parent.mkdir(parents=True, exist_ok=True)
        Path(out).write_bytes(trial.read_bytes())


def _common(known: list[str]) -> tuple[str, str]:
    by_core = {PREFIX.sub("", re.sub(r"[^a-z0-9]", "", name.lower())): name for name in reversed(known)}
    for pair in COMMON:
        if all(core in by_core for core in pair):
            return by_core[pair[0]], by_core[pair[1]]
    raise KeyError(
        f"no joints have the names of an arm; name two with --upper-arm and --forearm, of: {', '.join(known)}"
    )


def _joint(rig: Rig, name: str) -> int:
    found = [joint for joint in rig.joints if rig.names[joint] == name]
    if not found:
        raise KeyError(f"no joint {name!r}; allowed: {', '.join(rig.names[joint] for joint in rig.joints)}")
    if len(found) > 1:
        raise ValueError(f"{len(found)} joints have the name {name!r}; allowed: a name that one joint has")
    return found[0]


def _with_starts(description: bytes, mesh: SkinMesh) -> bytes:
    """modelDescription.xml with the start values of the mesh, and the token of an FMU that is nothing without it."""
    root = ET.fromstring(description)
    token = "instantiationToken" if "instantiationToken" in root.attrib else "guid"
    root.set(token, f"{root.get(token)}+{MESH_FILE}")
    starts = {name: repr(float(getattr(mesh, name))) for name in LENGTHS}
    elbow = starts["upper_arm_length"]
    starts |= {"vertex_count": str(len(mesh.vertices)), "forearm_position": f"{elbow} 0.0 0.0"}
    starts["forearm_position[1]"] = elbow
    for variable in root.iter():
        if variable.get("name") in starts:
            # FMI 2.0 keeps the start in a child
            holder = variable if "start" in variable.attrib else variable.find("*[@start]")
            if holder is not None:
                holder.set("start", starts[variable.get("name")])
    return to_string(root).encode()
