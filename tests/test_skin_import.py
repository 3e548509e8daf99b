"""A rigged glTF mesh as ArmSkin: what the unit computes is what glTF's own skinning computes.

The judge is `Player`, or matrices of the file in NumPy. Bounds: float32 positions in the file, the unit and the frame
between them round by 3e-8 m at .5 m each.
"""

import shutil
import subprocess
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from glb_edit import accessor, exported_arm, numbers, primitive, rewritten
from glb_player import Player
from test_cli import ulna
from ulna import Slave, cli
from ulna.description import read_description
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
    """Our own arm as a rigged mesh."""
    return exported_arm(tmp_path_factory.mktemp("own"))


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
    """A mean of facets' normals lies in the cone that holds them: no farther from the true one than the farthest is.

    Of a ring's neighbours: half a spoke, 180/32 degrees, and on a round end half of a step of 90/6.5 from ring to ring.
    """
    path = rewritten(own, tmp_path / "plain.glb", lambda d, _: primitive(d)["attributes"].pop("NORMAL"))
    made, true = mesh_of(path, tmp_path), mesh_of(own, tmp_path).normals
    a, b, c = (made.vertices[made.triangles[:, k]] for k in range(3))
    facet = np.cross(b - a, c - a)
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    nearest = np.ones(len(true))
    for k in range(3):
        np.minimum.at(nearest, made.triangles[:, k], np.sum(facet * true[made.triangles[:, k]], axis=1))
    # the tilt of a chord's plane adds .1 degrees
    half_turns = np.cos(np.radians(180 / 32)) * np.cos(np.radians(90 / 6.5 / 2))
    assert nearest.min() > np.cos(np.arccos(half_turns) + np.radians(0.1))
    cosines = np.sum(made.normals * true, axis=1)
    assert np.all(cosines > nearest - 1e-6)
    # on the cylinder, where the facets around a vertex lean both ways alike: a tenth of that
    middle = np.abs(made.vertices[:, 0]) < 0.055
    assert np.degrees(np.arccos(np.minimum(cosines[middle], 1.0))).max() < 180 / 32


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


def test_weights_in_bytes_between_other_data_are_taken_at_sum_1(own, tmp_path):
    """Joints and weights in turn, eight bytes a vertex; the weights sum to 254/255."""

    def change(document, data):
        share = np.rint(254 * numbers(document, data, "WEIGHTS_0").reshape(-1, 4)[:, 1]).astype(np.uint8)
        row = np.zeros((len(share), 8), np.uint8)
        row[:, 1], row[:, 4], row[:, 5] = 1, 254 - share, share
        view = {"buffer": 0, "byteOffset": len(data), "byteLength": row.size, "byteStride": 8}
        data += row.tobytes()
        document["buffers"][0]["byteLength"] = len(data)
        document["bufferViews"].append(view)
        at = len(document["bufferViews"]) - 1
        accessor(document, "JOINTS_0").update(bufferView=at, byteOffset=0)
        accessor(document, "WEIGHTS_0").update(bufferView=at, byteOffset=4, componentType=5121, normalized=True)

    packed, plain = mesh_of(rewritten(own, tmp_path / "packed.glb", change), tmp_path), mesh_of(own, tmp_path)
    assert np.abs(packed.weights.sum(axis=1) - 1.0).max() < 1e-12
    assert np.abs(packed.shares - plain.shares).max() <= 0.5 / 254 + 1e-7


def test_a_vertex_without_triangles_and_triangles_without_area_are_left_out(own, tmp_path):
    def change(document, data):
        corners = numbers(document, data, "indices", np.uint16)
        corners[corners == 100] = 101

    made, plain = mesh_of(rewritten(own, tmp_path / "less.glb", change), tmp_path), mesh_of(own, tmp_path)
    assert np.array_equal(made.vertices, np.delete(plain.vertices, 100, axis=0))
    # the two triangles at the edge from 100 to 101
    assert len(made.triangles) == len(plain.triangles) - 2


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
