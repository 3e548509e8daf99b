"""Automatic weights of a mesh without any: against the cubic of a thin rod, and on a human figure of another maker.

They need libigl and TetGen: pip install 'ulna[skin]'.
"""

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from glb_edit import exported_arm, rewritten
from human import Human, human
from test_cli import ulna
from ulna import Slave, cli
from ulna.biharmonic import biharmonic_shares, check_closed

LENGTH, HALF_WIDTH = 1.0, 0.15  # m, of the rods
ARM = ("mixamorig:LeftArm", "mixamorig:LeftForeArm", "mixamorig:LeftHand")


@pytest.fixture(autouse=True, scope="session")
def libraries():
    """In every test of this file."""
    for module in ("igl", "tetgen"):
        pytest.importorskip(module, reason="install it with: pip install 'ulna[skin]'")


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    """So that no line is broken."""
    monkeypatch.setattr(cli.console, "width", 2000)
    monkeypatch.setattr(cli.errors, "width", 2000)


def rod(radius: float, rings: int, spokes: int = 8) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a closed cylinder along x about the origin, its two poles last."""
    angle = 2 * np.pi * np.arange(spokes) / spokes
    circle = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    x = np.linspace(-LENGTH / 2, LENGTH / 2, rings)
    vertices = np.column_stack([np.repeat(x, spokes), np.tile(circle, (rings, 1))])
    poles = [[-LENGTH / 2, 0.0, 0.0], [LENGTH / 2, 0.0, 0.0]]
    first, last, triangles = rings * spokes, rings * spokes + 1, []
    for k in range(spokes):
        for start in range(0, (rings - 1) * spokes, spokes):
            a, b = start + k, start + (k + 1) % spokes
            triangles += [[a, b, b + spokes], [a, b + spokes, a + spokes]]
        end = (rings - 1) * spokes
        triangles += [[first, (k + 1) % spokes, k], [last, end + k, end + (k + 1) % spokes]]
    return np.concatenate([vertices, poles]), np.array(triangles)


def rod_shares(radius: float, rings: int) -> tuple[np.ndarray, np.ndarray]:
    """x and the forearm's shares, vertex by vertex."""
    vertices, triangles = rod(radius, rings)
    check_closed(vertices, triangles)
    joints = np.array([[-0.45, 0.0, 0.0], [0.0, 0.0, 0.0], [0.45, 0.0, 0.0]])
    return vertices[:, 0], biharmonic_shares(vertices, triangles, joints, HALF_WIDTH)


def cubic(x: np.ndarray) -> np.ndarray:
    s = np.clip(0.5 + x / (2 * HALF_WIDTH), 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


def test_a_thin_rod_has_the_cubic_of_one_dimension():
    """Least integral of w''^2 between w = 0 and w = 1, both without slope: 3 s^2 - 2 s^3.

    The bones hold the axis alone: what is off it is free within a radius or so of their ends, as if the blend were up
    to one radius longer at both ends. d(cubic)/dh is 3 u (1 - u^2) / 4h at u = x / h, at most .289 / h.
    """
    errors = []
    for radius in (0.02, 0.01, 0.005):
        x, shares = rod_shares(radius, 161)
        errors.append(np.abs(shares - cubic(x)).max())
        assert errors[-1] < 0.289 * radius / HALF_WIDTH
    assert errors[1] < 0.75 * errors[0] and errors[2] < 0.75 * errors[1]


def test_shares_are_bounded_end_at_0_and_1_and_mirror():
    asymmetry = []
    for rings in (41, 161):
        x, shares = rod_shares(0.02, rings)
        assert shares.min() == 0.0 and shares.max() == 1.0
        assert np.all(shares[x < -2 * HALF_WIDTH] == 0.0) and np.all(shares[x > 2 * HALF_WIDTH] == 1.0)
        by_ring = shares[:-2].reshape(rings, -1)
        asymmetry.append(np.abs(by_ring + by_ring[::-1] - 1.0).max())
    # the rod is its own mirror image, its tetrahedra are not: an error of theirs, which falls with their size at least
    assert 4 * asymmetry[1] < asymmetry[0] < 0.289 * 0.02 / HALF_WIDTH


def write_obj(path: Path, vertices: np.ndarray, triangles: np.ndarray) -> Path:
    lines = ["v {!r} {!r} {!r}".format(*row) for row in vertices.tolist()]
    lines += ["f {} {} {}".format(*row) for row in (triangles + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


def options(joints) -> list[str]:
    words = [",".join(map(str, joint)) if not isinstance(joint, str) else joint for joint in joints]
    return ["--weights", "auto", "--shoulder", words[0], "--elbow", words[1], "--wrist", words[2]]


@pytest.fixture(scope="session")
def figure() -> Human:
    return human()


@pytest.fixture(scope="session")
def man(figure, tmp_path_factory) -> Path:
    """The human figure as a skin of its left arm, without its own weights."""
    folder = tmp_path_factory.mktemp("man")
    obj = write_obj(folder / "man.obj", figure.vertices, figure.triangles)
    joints = [figure.joints[name].tolist() for name in ARM]
    done = ulna("skin", "import", obj, "--out", folder / "man.fmu", *options(joints))
    assert done.exit_code == 0, done.output
    assert "13380, 26756" in done.output
    return folder / "man.fmu"


def rest_and_bent(skin: Slave, method: str, turn: Rotation) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) from the elbow, m."""
    skin.reset()
    skin.set("method", method)
    skin.set("twist_share", 0.0)
    skin.initialize()
    elbow = [skin.get("upper_arm_length"), 0.0, 0.0]
    rest = skin.get("vertices").T.astype(float) - elbow
    skin.set("forearm_orientation", np.roll(turn.as_quat(), 1))
    return rest, skin.get("vertices").T.astype(float) - elbow


def test_the_arm_of_a_human_figure_bends_and_does_not_tear(figure, man):
    turn = Rotation.from_euler("y", -90.0, degrees=True)
    with Slave(man) as skin:
        skin.initialize()
        weights, triangles = skin.get("weights"), skin.get("triangles").reshape(-1, 3)[: len(figure.triangles)]
        rest, bent = rest_and_bent(skin, "linear_blend", turn)
        folded, gap = skin.get("fold_fraction") * len(triangles), skin.get("elbow_gap")
        torn, moved = rest_and_bent(skin, "rigid", turn)
        tear = skin.get("elbow_gap")
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    before, after, rigid = (np.linalg.norm(p[edges[:, 1]] - p[edges[:, 0]], axis=1) for p in (rest, bent, moved))
    # an edge grows by the step of the weight times the way from one image to the other, and no more; float32
    way = 2 * np.sin(np.pi / 4) * np.linalg.norm(rest[edges], axis=2).max(axis=1)
    step = np.abs(np.diff(weights[edges], axis=1))[:, 0]
    assert np.all(after - before < step * way + 1e-6)
    # no edge of a smooth blend is as long as 2.6 times (`ulna chart skin`); a torn one is
    assert (after / before).max() < 2.6 < (rigid / before).max()
    assert np.array_equal(torn, rest) and gap < 0.25 * tear
    # the crease of the elbow: five of 26756
    assert folded <= 8


def test_bones_hold_what_the_maker_of_the_figure_gives_them(figure, man):
    with Slave(man) as skin:
        skin.initialize()
        weights = skin.get("weights")
    assert weights.min() == 0.0 and weights.max() == 1.0
    elbow, wrist = (figure.joints[name] for name in ARM[1:])
    along = (figure.vertices - elbow) @ (wrist - elbow) / np.linalg.norm(wrist - elbow)
    own = np.zeros(len(weights))
    for name, shares in figure.weights.items():
        if name.startswith(ARM[1]) or name.startswith(ARM[2]):
            own += shares
    # the maker's own weights, painted by hand: who has all of the forearm or nothing of it has so here
    held = np.linalg.norm(figure.vertices - elbow, axis=1) > 0.1
    assert np.all(weights[(own > 0.99) & held] > 0.98) and np.all(weights[(own < 0.01) & held] < 0.02)
    assert np.all(weights[figure.vertices[:, 0] < 0.0] == 0.0), "the other half of the body"
    assert along[weights > 0.5].min() > -0.1


def test_weights_of_a_node_and_of_places_are_the_same(tmp_path):
    """Our own arm without its skin; a wrist by name."""

    def unrigged(document, _):
        node = next(node for node in document["nodes"] if "skin" in node)
        del node["skin"], document["skins"]
        document["nodes"].append({"name": "wrist", "translation": [0.62, 0.0, 0.0]})
        document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)

    path = rewritten(exported_arm(tmp_path), tmp_path / "plain.glb", unrigged)
    places = ([0.04, 0.0, 0.0], [0.3, 0.0, 0.0], "wrist")
    outs = []
    for number, wrist in enumerate(("wrist", [0.62, 0.0, 0.0])):
        outs.append(tmp_path / f"{number}.fmu")
        done = ulna("skin", "import", path, "--out", outs[-1], *options((*places[:2], wrist)))
        assert done.exit_code == 0, done.output
        assert "2048, 4092" in done.output
    assert outs[0].read_bytes() == outs[1].read_bytes()
    with Slave(outs[0]) as skin, Slave("ArmSkin") as stock:
        for one in (skin, stock):
            one.initialize()
        # as the rod, at r = 2/3 h
        assert np.abs(skin.get("weights") - stock.get("weights")).max() < 0.289 * 2 / 3
        skin.set("forearm_orientation", [0.5**0.5, 0.0, -(0.5**0.5), 0.0])
        assert skin.get("fold_fraction") == 0.0 and skin.get("elbow_gap") < 0.005
        assert 0.95 < skin.get("blend_volume_ratio") < 1.0


ROD, ROD_TRIANGLES = rod(0.05, 21)
JOINTS = ([-0.4, 0.0, 0.0], [0.0, 0.0, 0.0], [0.4, 0.0, 0.0])


def dented(vertices):
    """A vertex pulled around the rod, through the triangles of two others."""
    vertices = vertices.copy()
    vertices[10 * 8, 1:] = 0.02, 0.06
    return vertices


BAD = {
    "a hole": (ROD, ROD_TRIANGLES[1:], JOINTS, "is not closed: the edge from .* on one side only, as have 2 more"),
    "inside out": (ROD, ROD_TRIANGLES[:, ::-1], JOINTS, "face inward"),
    "a triangle twice": (ROD, np.concatenate([ROD_TRIANGLES, ROD_TRIANGLES[:1]]), JOINTS, "more than two triangles"),
    "crossing itself": (dented(ROD), ROD_TRIANGLES, JOINTS, "self-intersections.*crosses itself"),
    "two pieces": (
        np.concatenate([ROD, np.add(ROD, [0.0, 1.0, 0.0])]),
        np.concatenate([ROD_TRIANGLES, ROD_TRIANGLES + len(ROD)]),
        JOINTS,
        "2 separate pieces",
    ),
    "a shoulder outside": (ROD, ROD_TRIANGLES, ([-0.4, 0.1, 0.0], *JOINTS[1:]), r"a bone leaves the surface at \(-"),
    "no upper arm": (ROD, ROD_TRIANGLES, (JOINTS[1], *JOINTS[1:]), "upper_arm_length = 0 m"),
    "no number": (ROD, ROD_TRIANGLES, ("nan,0,0", *JOINTS[1:]), "the shoulder is at .*three numbers"),
    "two numbers": (ROD, ROD_TRIANGLES, ("1,0", *JOINTS[1:]), "the shoulder is at .*three numbers"),
    "a name in a file without": (ROD, ROD_TRIANGLES, ("Arm", *JOINTS[1:]), "the shoulder is at Arm; allowed: three"),
    "no triangle": (ROD, np.array([[0, 1, 1]]), JOINTS, "no triangle with an area"),
    "a vertex nowhere": (ROD, np.array([[0, 1, 999]]), JOINTS, "cannot be read|that it has not"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_have_weights_is_refused_with_the_reason(tmp_path, monkeypatch, name):
    vertices, triangles, joints, message = BAD[name]
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    path = write_obj(tmp_path / "bad.obj", vertices, triangles)
    done = ulna("skin", "import", path, "--out", tmp_path / "bad.fmu", *options(joints))
    assert (done.exit_code, "Traceback" in done.output) == (2, False), done.output
    assert re.search(message, done.output), done.output
    assert not (tmp_path / "bad.fmu").exists() and not list((tmp_path / "here").iterdir())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--weights", "auto"], "needs all three"),
        (["--weights", "none"], "--weights none; allowed: file, auto"),
        (["--elbow", "0,0,0"], "belong to --weights auto"),
        ([*options(JOINTS), "--forearm", "a"], "and --only-arm to --weights file"),
        ([*options(JOINTS), "--only-arm"], "--only-arm to --weights file"),
        ([*options(JOINTS), "--mesh", "a"], "has no names"),
        ([*options(JOINTS), "--blend-half-width", "0.5"], "blend_half_width = 0.5 m; allowed range: above 0, below"),
        ([*options(JOINTS), "--blend-half-width", "-1"], "blend_half_width = -1 m"),
    ],
)
def test_options_that_do_not_go_together_are_refused(tmp_path, words, message):
    path = write_obj(tmp_path / "rod.obj", ROD, ROD_TRIANGLES)
    done = ulna("skin", "import", path, "--out", tmp_path / "bad.fmu", *words)
    assert (done.exit_code, message in done.output) == (2, True), done.output


@pytest.mark.parametrize("module", ["igl", "tetgen"])
def test_without_the_libraries_it_says_what_to_install(tmp_path, monkeypatch, module):
    monkeypatch.setitem(sys.modules, module, None)
    path = write_obj(tmp_path / "rod.obj", ROD, ROD_TRIANGLES)
    done = ulna("skin", "import", path, "--out", tmp_path / "bad.fmu", *options(JOINTS))
    assert (done.exit_code, "pip install 'ulna[skin]'" in done.output) == (2, True), done.output


def test_a_file_that_is_none_is_refused(tmp_path):
    done = ulna("skin", "import", tmp_path / "none.obj", "--out", tmp_path / "bad.fmu", *options(JOINTS))
    assert (done.exit_code, "no file" in done.output) == (2, True), done.output
    (tmp_path / "text.obj").write_text("hello")
    done = ulna("skin", "import", tmp_path / "text.obj", "--out", tmp_path / "bad.fmu", *options(JOINTS))
    assert done.exit_code == 2 and re.search("cannot be read|that it has not", done.output), done.output
