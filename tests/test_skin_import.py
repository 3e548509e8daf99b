"""A rigged glTF mesh as ArmSkin: what the unit computes is what glTF's own skinning computes.

The judge is `Player`, or matrices of the file in NumPy. Bounds: float32 positions in the file, the unit and the frame
between them round by 3e-8 m at .5 m each.
"""

import re
import shutil
import struct
import subprocess
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from glb_edit import accessor, numbers, primitive, rewritten
from glb_player import Player
from test_cli import ulna
from ulna import Scene, Slave, cli
from ulna.description import read_description
from ulna.gltf import write_glb
from ulna.paths import CHECKOUT, fmu
from ulna.rig import read_rig
from ulna.skin_import import find_bones, import_skin
from ulna.skin_mesh import SkinMesh

FLOAT32_BOUND = 3e-7
HAND = "@webxr-input-profiles/assets@1.0.20"
HAND_FILE = "package/dist/profiles/generic-hand/left.glb"
FINGER = "index-finger-phalanx-"
FOREARM = [f"{FINGER}intermediate", f"{FINGER}distal", "index-finger-tip"]


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    """So that no line is broken."""
    monkeypatch.setattr(cli.console, "width", 2000)
    monkeypatch.setattr(cli.errors, "width", 2000)


@pytest.fixture(scope="session")
def hand() -> Path:
    """A hand of the WebXR input profiles (MIT licence): 25 joints, none below another, up to four influences."""
    path = CHECKOUT / "build" / "hand" / "left.glb"
    if not path.exists():
        if not shutil.which("npm"):
            pytest.skip(f"a rigged mesh, {HAND}, needs npm: apt-get install npm")
        path.parent.mkdir(parents=True, exist_ok=True)
        done = subprocess.run(["npm", "pack", HAND], cwd=path.parent, capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.skip(f"npm could not fetch {HAND}; connect to its registry once: {done.stderr.strip()}")
        (package,) = path.parent.glob("*.tgz")
        with tarfile.open(package) as archive:
            path.write_bytes(archive.extractfile(HAND_FILE).read())
        package.unlink()
    return path


def bend(skin: Slave, turn: Rotation) -> None:
    """Linear blend, the forearm turned about the elbow."""
    skin.set("method", "linear_blend")
    skin.set("twist_share", 0.0)
    skin.initialize()
    skin.set("forearm_position", [skin.get("upper_arm_length"), 0.0, 0.0])
    skin.set("forearm_orientation", np.roll(turn.as_quat(), 1))


@pytest.fixture(scope="module")
def own(tmp_path_factory) -> Path:
    """The default arm at rest, as `ulna run` exports it, but for the first joint: from the elbow to the shoulder."""
    folder = tmp_path_factory.mktemp("own")
    with Scene("arm") as scene:
        scene.add("ArmSkin", "arm", method="linear_blend", twist_share=0.0)
        write_glb(folder / "arm.glb", scene.run(0.1, 0.05), scene)

    def to_shoulder(document, data):
        document["nodes"][document["skins"][0]["joints"][0]]["translation"] = [0.0, 0.0, 0.0]
        numbers(document, data, "inverseBindMatrices")[:16] = np.eye(4).ravel()

    return rewritten(folder / "arm.glb", folder / "shoulder.glb", to_shoulder)


def poke(name: str, place: int, value: float, kind: type = np.float32):
    def change(document, data):
        numbers(document, data, name, kind)[place] = value

    return change


def mesh_of(path: Path, tmp_path: Path, **how) -> SkinMesh:
    return import_skin(path, tmp_path / "made.fmu", **(JOINTS | how))[0]


JOINTS = {"upper_arm": "arm joint 0", "forearm": ["arm joint 1"]}
OPTIONS = ["--upper-arm", "arm joint 0", "--forearm", "arm joint 1"]
TURNS = [
    Rotation.from_euler(axis, angle, degrees=True)
    for axis, angle in (("y", 0), ("y", -90), ("z", 60), ("x", 100), ("y", -150))
]


def test_our_own_arm_comes_back(own, tmp_path):
    done = ulna("skin", "import", own, "--out", tmp_path / "back.fmu", *OPTIONS)
    assert done.exit_code == 0, done.output
    assert "2048, 4092" in done.output
    with Slave(tmp_path / "back.fmu") as back, Slave("ArmSkin") as stock:
        assert back.get("upper_arm_length") == pytest.approx(0.3, abs=1e-7)
        # the last of the 64 rings of an end is 12 % of a step from its pole
        assert 0.399 < back.get("forearm_length") < 0.4
        assert back.get("radius") == pytest.approx(0.04, abs=1e-7)
        # rings are 3.75 mm apart: the last above 1 % is up to one farther in
        assert 0.06 - 0.00375 / 0.88 < back.get("blend_half_width") <= 0.06
        for turn in TURNS:
            for skin in (back, stock):
                skin.reset()
                bend(skin, turn)
            assert np.abs(back.get("vertices") - stock.get("vertices")).max() < FLOAT32_BOUND
            # gradients of triangles 3.75 mm long in a zone of 120 mm, not the smoothstep's own: 3 % off, 2 degrees;
            # linear blend collapses to a line at one vertex at 90 degrees
            normals = stock.get("normals")
            whole = np.linalg.norm(normals, axis=0) > 0.5
            assert np.sum(back.get("normals") * normals, axis=0)[whole].min() > np.cos(np.radians(2.0))
            assert np.array_equal(back.get("triangles").reshape(-1, 3)[:-4], stock.get("triangles").reshape(-1, 3)[:-4])


def test_fmi_2_takes_it_too(own, tmp_path):
    measures = {}
    for version in ("2.0", "3.0"):
        import_skin(own, tmp_path / "arm.fmu", version=version, **JOINTS)
        with Slave(tmp_path / "arm.fmu") as skin:
            assert skin.version == version
            bend(skin, TURNS[1])
            measures[version] = [skin.get(name) for name in ("blend_volume_ratio", "elbow_gap", "capsule_2_end")]
    assert str(measures["2.0"]) == str(measures["3.0"])


def test_a_hand_of_another_maker_moves_as_gltf_says(hand, tmp_path):
    """A finger for an arm: every joint with a matrix of its own, all four influences, against the file's matrices."""
    options = [word for name in FOREARM for word in ("--forearm", name)]
    done = ulna("skin", "import", hand, "--out", tmp_path / "hand.fmu", "--upper-arm", f"{FINGER}proximal", *options)
    assert done.exit_code == 0, done.output
    player = Player(hand)
    document = player.document
    attributes = document.meshes[0].primitives[0].attributes
    points = np.column_stack([player.array(attributes.POSITION), np.ones(1360)]).astype(float)
    joints, weights = player.array(attributes.JOINTS_0), player.array(attributes.WEIGHTS_0).astype(float)
    inverse = player.array(document.skins[0].inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1).astype(float)
    assert np.count_nonzero(weights > 0.0, axis=1).max() == 4
    rest = np.array([player.world(joint, 0) for joint in document.skins[0].joints])
    names = [document.nodes[joint].name for joint in document.skins[0].joints]
    shoulder, elbow = (rest[names.index(f"{FINGER}{name}"), :3, 3] for name in ("proximal", "intermediate"))
    x = (elbow - shoulder) / np.linalg.norm(elbow - shoulder)
    # the finger points down
    z = np.array([0.0, 0.0, 1.0]) - x[2] * x
    z /= np.linalg.norm(z)
    axes = np.array([x, np.cross(z, x), z])
    for turn in TURNS:
        moved = rest.copy()
        world_turn = axes.T @ turn.as_matrix() @ axes
        for joint in map(names.index, FOREARM):
            moved[joint, :3, :3] = world_turn @ rest[joint, :3, :3]
            moved[joint, :3, 3] = elbow + world_turn @ (rest[joint, :3, 3] - elbow)
        placed = np.einsum("nj,njab,nb->na", weights, (moved @ inverse)[joints], points)[:, :3]
        expected = (placed - shoulder) @ axes.T
        with Slave(tmp_path / "hand.fmu") as skin:
            bend(skin, turn)
            assert np.abs(skin.get("vertices").T - expected).max() < FLOAT32_BOUND
            # the tip of the finger is 46 mm from its joint, its side 8 mm from the axis
            far = np.linalg.norm(skin.get("vertices").T - (points[:, :3] - shoulder) @ axes.T, axis=1).max()
            assert far > 0.012 or turn.magnitude() == 0.0


def test_the_same_file_gives_the_same_bytes_and_start_values(own, tmp_path):
    for name in ("a.fmu", "b.fmu"):
        mesh, names = import_skin(own, tmp_path / name, **JOINTS)
    assert (tmp_path / "a.fmu").read_bytes() == (tmp_path / "b.fmu").read_bytes()
    assert names == ("arm joint 0", "arm joint 1")
    variables = read_description(tmp_path / "a.fmu").variables
    assert list(map(float, variables["radius"].start)) == [mesh.radius]
    assert list(map(float, variables["forearm_position"].start)) == [mesh.upper_arm_length, 0.0, 0.0]
    with zipfile.ZipFile(fmu("ArmSkin")) as stock, zipfile.ZipFile(tmp_path / "a.fmu") as made:
        assert set(made.namelist()) - set(stock.namelist()) == {"resources/mesh.bin"}
        same = set(stock.namelist()) - {"modelDescription.xml"}
        assert all(stock.read(name) == made.read(name) for name in same)


@pytest.mark.parametrize("scale", [(100.0, 100.0, 100.0), (-1.0, 1.0, 1.0)])
def test_units_and_mirrors_of_the_bind_matrices_are_undone(own, tmp_path, scale):
    """The skin's space in centimetres, or left-handed: the world is the same."""

    def change(document, data):
        numbers(document, data, "POSITION").reshape(-1, 3)[:] *= scale
        numbers(document, data, "NORMAL").reshape(-1, 3)[:] *= np.sign(scale)
        numbers(document, data, "inverseBindMatrices").reshape(-1, 4, 4)[:, :3, :3] /= np.array(scale)[:, None]
        if min(scale) < 0.0:
            corners = numbers(document, data, "indices", np.uint16).reshape(-1, 3)
            corners[:] = corners[:, ::-1].copy()

    plain, other = mesh_of(own, tmp_path), mesh_of(rewritten(own, tmp_path / "other.glb", change), tmp_path)
    for name in ("vertices", "normals", "triangles"):
        np.testing.assert_allclose(getattr(other, name), getattr(plain, name), atol=FLOAT32_BOUND)


def test_normals_that_the_file_has_not_are_computed(own, tmp_path):
    path = rewritten(own, tmp_path / "plain.glb", lambda d, _: primitive(d)["attributes"].pop("NORMAL"))
    # facets of 32 around are 11 degrees apart, and so are normals of those that meet at a vertex from its own
    cosines = np.sum(mesh_of(path, tmp_path).normals * mesh_of(own, tmp_path).normals, axis=1)
    assert cosines.min() > np.cos(np.radians(11.25))


def test_one_mesh_of_several_is_taken_by_name(own, tmp_path):
    def change(document, _):
        node = next(node for node in document["nodes"] if "skin" in node)
        document["meshes"].append(document["meshes"][node["mesh"]] | {"name": "sleeve"})
        document["nodes"].append({"mesh": len(document["meshes"]) - 1, "skin": 0})

    path = rewritten(own, tmp_path / "two.glb", change)
    assert len(mesh_of(path, tmp_path).vertices) == 4096
    assert np.array_equal(mesh_of(path, tmp_path, mesh="sleeve").vertices, mesh_of(own, tmp_path).vertices)
    with pytest.raises(KeyError, match="sleeve"):
        mesh_of(path, tmp_path, mesh="slevee")


def test_the_pose_that_the_file_leaves_the_forearm_in_does_not_count(own, tmp_path):
    def bent(document, _):
        document["nodes"][document["skins"][0]["joints"][1]]["rotation"] = [0.0, 0.6, 0.0, 0.8]

    path = rewritten(own, tmp_path / "bent.glb", bent)
    assert np.array_equal(mesh_of(path, tmp_path).vertices, mesh_of(own, tmp_path).vertices)


def test_what_is_below_the_forearm_follows_it(own, tmp_path):
    def with_fingers(document, _):
        first, elbow = document["skins"][0]["joints"]
        document["nodes"] += [{"name": "wrist", "children": [len(document["nodes"]) + 1]}, {"name": "finger"}]
        finger = len(document["nodes"]) - 1
        document["nodes"][elbow]["children"] = [finger - 1]
        document["skins"][0] = {"joints": [first, elbow, finger]}

    rig = read_rig(rewritten(own, tmp_path / "fingers.glb", with_fingers))
    followers = find_bones(rig, "arm joint 0", ["arm joint 1"]).followers
    assert {rig.names[node] for node in followers} == {"arm joint 1", "finger"}
    with pytest.raises(ValueError, match="'finger' is below 'arm joint 1'"):
        find_bones(rig, "finger", ["arm joint 1"])


@pytest.mark.parametrize(
    "pair",
    [
        ("mixamorig:LeftArm", "mixamorig:LeftForeArm"),
        ("LeftArm", "LeftForeArm"),
        ("upper_arm.L", "forearm.L"),
        ("DEF-upper_arm.L", "DEF-forearm.L"),
        ("upperarm_l", "lowerarm_l"),
        ("J_Bip_L_UpperArm", "J_Bip_L_LowerArm"),
        ("Bip01 L UpperArm", "Bip01 L Forearm"),
        ("RightArm", "RightForeArm"),
    ],
)
def test_names_of_common_rigs_are_known(own, tmp_path, pair):
    def change(document, _):
        for joint, name in zip(document["skins"][0]["joints"], pair, strict=True):
            document["nodes"][joint]["name"] = name

    rig = read_rig(rewritten(own, tmp_path / "named.glb", change))
    bones = find_bones(rig)
    assert (rig.names[bones.upper_arm], rig.names[bones.forearm]) == pair


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
