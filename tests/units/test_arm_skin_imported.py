"""A mesh among ArmSkin's resources: the procedural arm, written to the flat file, is the procedural arm."""

import struct
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arm_skin_truth import ELBOW, FOREARM, GENERAL, HALF_WIDTH, RADIUS, UPPER_ARM, about, rest_mesh, smoothstep
from scipy.spatial.transform import Rotation
from test_arm_skin import FLOAT32_BOUND, METHODS, pose

from ulna import Slave, UnitError, fmu
from ulna.skin_mesh import SkinMesh, weight_gradients, write_mesh

MEASURES = ("blend_volume_ratio", "minimum_section_ratio", "elbow_gap", "fold_fraction")


def arm_mesh(vertex_count: int = 2048) -> SkinMesh:
    """The default arm; its weights on four joints, two of which follow each bone."""
    y, normals = rest_mesh(vertex_count)
    share = smoothstep(y[:, 0])
    s = np.clip((y[:, 0] + HALF_WIDTH) / (2 * HALF_WIDTH), 0, 1)
    with Slave("ArmSkin") as skin:
        skin.set("vertex_count", vertex_count)
        skin.initialize()
        triangles = skin.get("triangles").reshape(-1, 3)[:-4]
    return SkinMesh(
        vertices=y,
        normals=normals,
        gradients=(6 * s * (1 - s) / (2 * HALF_WIDTH))[:, None] * [1.0, 0.0, 0.0],
        weights=np.stack([0.75 * (1 - share), 0.25 * share, 0.25 * (1 - share), 0.75 * share], axis=1),
        joints=np.tile([2, 1, 0, 3], (vertex_count, 1)),
        forearm=np.array([False, True, False, True]),
        triangles=triangles,
        upper_arm_length=UPPER_ARM,
        forearm_length=FOREARM,
        radius=RADIUS,
        blend_half_width=HALF_WIDTH,
    )


def with_mesh(path: Path, content: bytes, version: str = "3.0") -> Path:
    """ArmSkin with this file among its resources."""
    with zipfile.ZipFile(fmu("ArmSkin", version)) as source, zipfile.ZipFile(path, "w") as target:
        for name in source.namelist():
            target.writestr(name, source.read(name))
        target.writestr("resources/mesh.bin", content)
    return path


def packed(mesh: SkinMesh, folder: Path) -> bytes:
    write_mesh(folder / "mesh.bin", mesh)
    return (folder / "mesh.bin").read_bytes()


def vector_areas(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Sizes (n,) of the sums of the area vectors around each vertex, m^2."""
    a, b, c = (vertices[triangles[:, k]].astype(float) for k in range(3))
    total = np.zeros((len(vertices), 3))
    for k in range(3):
        np.add.at(total, triangles[:, k], np.cross(b - a, c - a))
    return np.linalg.norm(total, axis=1)


@pytest.fixture(scope="module")
def imported(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("imported")
    return with_mesh(folder / "ArmSkin.fmu", packed(arm_mesh(), folder))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("twist_share", [0.0, 0.7])
def test_an_imported_arm_is_the_procedural_one(imported: Path, method: str, twist_share: float) -> None:
    triangles = arm_mesh().triangles
    rest = vector_areas(arm_mesh().vertices, triangles)
    with Slave(imported) as mesh, Slave("ArmSkin") as rings:
        for skin in (mesh, rings):
            skin.set("method", method)
            skin.set("twist_share", twist_share)
            skin.initialize()
        assert mesh.get("vertex_count") == 2048
        assert np.array_equal(mesh.get("triangles"), rings.get("triangles"))
        assert np.abs(mesh.get("weights") - rings.get("weights")).max() < 2e-7
        for step, turn in enumerate((about("y", 100) * about("x", 60), about("y", 30) * about("x", 230))):
            for skin in (mesh, rings):
                pose(skin, **(GENERAL | {"fore": GENERAL["upper"] * turn}))
                skin.step(0.01 * step, 0.01)
            # centres are sums over triangles, each nearer to one ring, not over bands: below, exactly
            centers = method == "center_of_rotation"
            places = np.abs(mesh.get("vertices") - rings.get("vertices")).max()
            assert places < (5e-6 if centers else 2 * FLOAT32_BOUND)
            # some ten roundings at 1, in skin that shrinks divided by what is left of its area, as the normal is
            off = np.abs(mesh.get("normals") - rings.get("normals")).max(axis=0)
            left = vector_areas(rings.get("vertices").T, triangles) / rest
            assert (off * np.minimum(left, 1.0)).max() < (1e-4 if centers else 6e-7)
        for name in ("minimum_section_ratio", "fold_fraction"):
            assert mesh.get(name) == pytest.approx(rings.get(name), abs=2e-3)


def test_centers_of_rotation_are_those_of_the_triangles(imported: Path) -> None:
    """Le and Hodgins (2016), equation 1, in full: every vertex against every triangle."""
    mesh, turn = arm_mesh(), about("y", 100) * about("x", 40)
    corners, weight = mesh.vertices[mesh.triangles], mesh.shares[mesh.triangles].mean(axis=1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    bent = (mesh.shares > 0) & (mesh.shares < 1)
    w = mesh.shares[bent][:, None]
    likeness = w * (1 - w) * weight * (1 - weight) * np.exp(-(((w - weight) / 0.1) ** 2)) * area
    center = likeness @ corners.mean(axis=1) / likeness.sum(axis=1, keepdims=True)
    q = np.roll(turn.as_quat(), 1)
    mean = (1 - w) * [1.0, 0.0, 0.0, 0.0] + w * (q if q[0] > 0 else -q)
    turned = Rotation.from_quat(np.roll(mean, -1, axis=1)).apply(mesh.vertices[bent] - center)
    expected = turned + (1 - w) * center + w * turn.apply(center) + ELBOW
    with Slave(imported) as skin:
        skin.set("method", "center_of_rotation")
        skin.set("twist_share", 0.0)
        skin.initialize()
        pose(skin, about("x", 0), np.zeros(3), turn, ELBOW)
        # 1024 bins of the weight for the triangles: a twelfth of their width squared over the likeness's, 1e-5 of 6 cm
        assert np.abs(skin.get("vertices").T[bent] - expected).max() < 1e-6


@pytest.mark.parametrize("method", METHODS[1:])
def test_measures_of_triangles_are_those_of_rings(imported: Path, method: str) -> None:
    with Slave(imported) as mesh, Slave("ArmSkin") as rings:
        for skin in (mesh, rings):
            skin.set("method", method)
            skin.initialize()
            pose(skin, about("x", 0), np.zeros(3), about("y", 110), ELBOW)
        of_mesh, of_rings = ([skin.get(name) for name in MEASURES] for skin in (mesh, rings))
    # weights in float32; centres by bins; edges at the elbow's plane that the middle of the blend does not cross
    assert of_mesh[:2] == pytest.approx(of_rings[:2], abs=2e-5)
    assert of_mesh[2] == pytest.approx(of_rings[2], rel=0.3)
    assert of_mesh[3] == pytest.approx(of_rings[3], abs=1e-3)


def test_the_bones_and_start_values_are_those_of_the_mesh(tmp_path: Path) -> None:
    mesh = replace(arm_mesh(), upper_arm_length=0.25, radius=0.05)
    path = with_mesh(tmp_path / "short.fmu", packed(mesh, tmp_path))
    with Slave(path) as skin:
        for _ in range(2):
            assert skin.get("upper_arm_length") == 0.25
            skin.initialize()
            assert skin.get("capsule_2_start") == pytest.approx([0.25, 0, 0])
            assert skin.get("capsule_1_radius") == 0.05
            skin.reset()
        skin.set("upper_arm_length", 0.3)
        with pytest.raises(UnitError, match=r"upper_arm_length .*mesh among the resources.*0\.25"):
            skin.initialize()
    with Slave(path) as skin:
        skin.set("vertex_count", 1024)
        with pytest.raises(UnitError, match=r"vertex_count.*2048"):
            skin.initialize()


def test_gradients_of_a_mesh_are_those_of_a_linear_function() -> None:
    """Exact for one that is linear, along the skin; a seam is no edge."""
    mesh = arm_mesh(512)
    slope = np.array([3.0, -2.0, 1.0])
    twice = np.concatenate([mesh.vertices, mesh.vertices])
    triangles = mesh.triangles + (np.arange(len(mesh.triangles)) % 2 * 512)[:, None]
    gradients = weight_gradients(twice, triangles, twice @ slope)
    normal = np.cross(*(mesh.vertices[mesh.triangles[:, k]] - mesh.vertices[mesh.triangles[:, 0]] for k in (1, 2)))
    area = np.linalg.norm(normal, axis=1)
    normal /= area[:, None]
    along = slope - (normal @ slope)[:, None] * normal
    expected, sizes = np.zeros((512, 3)), np.zeros(512)
    for corner in mesh.triangles.T:
        np.add.at(expected, corner, along * area[:, None])
        np.add.at(sizes, corner, area)
    expected /= sizes[:, None]
    assert np.abs(gradients[:512] - expected).max() < 1e-10
    assert np.array_equal(gradients[:512], gradients[512:])


def changed(content: bytes, place: int, form: str, *values: float) -> bytes:
    piece = struct.pack("<" + form, *values)
    return content[:place] + piece + content[place + len(piece) :]


N, HEAD = 2048, 320
BAD = {
    "another file": (lambda c: b"glTF" + c[4:], "header of a skin"),
    "cut in the header": (lambda c: c[:100], "header of a skin"),
    "another format": (lambda c: changed(c, 8, "I", 2), "format is another"),
    "other byte order": (lambda c: changed(c, 8, "I", 0x01000000), "bytes are in another order"),
    "too few vertices": (lambda c: changed(c, 12, "I", 3), "3 vertices; allowed range: 32 to"),
    "too many vertices": (lambda c: changed(c, 12, "I", 0xFFFFFFFF), "4294967295 vertices"),
    "too many triangles": (lambda c: changed(c, 16, "I", 4097), "4097 triangles"),
    "no joints": (lambda c: changed(c, 20, "I", 0), "no joints"),
    "no length": (lambda c: changed(c, 24, "d", float("nan")), "a length of its arm"),
    "a joint of neither bone": (lambda c: changed(c, 64, "B", 2), "neither the upper arm"),
    "one byte less": (lambda c: c[:-1], "bytes; its header says"),
    "one byte more": (lambda c: c + b"\0", "bytes; its header says"),
    "a vertex nowhere": (lambda c: changed(c, HEAD + 4 * 7, "f", float("nan")), "vertex 7 is not within 100 m"),
    "a vertex far away": (lambda c: changed(c, HEAD + 4 * (N + 5), "f", 1e9), "vertex 5 is not within"),
    "a long normal": (lambda c: changed(c, HEAD + 4 * (3 * N + 9), "f", 2.0), "normal 9 has no length of 1"),
    "an infinite gradient": (lambda c: changed(c, HEAD + 4 * (6 * N + 3), "f", float("inf")), "gradient 3 is not"),
    "a negative weight": (lambda c: changed(c, HEAD + 4 * (9 * N + 2), "f", -0.5), "vertex 2 has weight -0.5"),
    "weights of too little": (lambda c: changed(c, HEAD + 4 * (9 * N + 2), "f", 0.1), "weights of vertex 2 sum to"),
    "a joint too many": (lambda c: changed(c, HEAD + 52 * N + 4, "B", 4), "vertex 4 has weight .* of joint 4"),
    "a corner too many": (lambda c: changed(c, HEAD + 56 * N, "i", N), "triangle 0 is of vertices 2048"),
    "a negative corner": (lambda c: changed(c, HEAD + 56 * N + 4, "i", -1), "triangle 0 is of vertices"),
    "a corner twice": (lambda c: changed(c, HEAD + 56 * N, "2i", 5, 5), "triangle 0 is of vertices 5, 5"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_refused_with_the_reason(imported: Path, tmp_path: Path, name: str) -> None:
    spoil, message = BAD[name]
    with zipfile.ZipFile(imported) as archive:
        content = archive.read("resources/mesh.bin")
    path = with_mesh(tmp_path / "bad.fmu", spoil(content))
    with pytest.raises(Exception, match=message), Slave(path) as skin:
        skin.initialize()


@pytest.mark.parametrize("seed", range(3))
def test_a_damaged_file_does_no_harm(imported: Path, tmp_path: Path, seed: int) -> None:
    """Random bytes at random places: refused, or a mesh like any other."""
    random = np.random.default_rng(seed)
    with zipfile.ZipFile(imported) as archive:
        content = bytearray(archive.read("resources/mesh.bin"))
    for place in random.integers(0, len(content), 40):
        content[place] = random.integers(0, 256)
    try:
        with Slave(with_mesh(tmp_path / "damaged.fmu", bytes(content))) as skin:
            skin.initialize()
            skin.get("vertices")
    except Exception as error:
        assert "mesh among the resources" in str(error)


def test_fmi_2_takes_the_mesh_too(imported: Path, tmp_path: Path) -> None:
    """Its resources are a URI; the mesh is read for the measures."""
    with zipfile.ZipFile(imported) as archive:
        content = archive.read("resources/mesh.bin")
    folder = tmp_path / "with space"
    folder.mkdir()
    with Slave(with_mesh(folder / "two.fmu", content, "2.0")) as two, Slave(imported) as three:
        for skin in (two, three):
            skin.initialize()
            pose(skin, **GENERAL)
        assert [two.get(name) for name in MEASURES] == [three.get(name) for name in MEASURES]
