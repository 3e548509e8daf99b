"""The arm of a whole figure of another maker: MakeHuman's body on the mixamo rig of its makers, by ulna skin import."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from human import Human, human, write_rigged
from test_cli import ulna
from ulna import Slave, cli
from ulna.skin_import import import_skin

FLOAT32_BOUND = 3e-7  # m: of the file, the frame and the unit, 3e-8 each at .5 m
ARM, FOREARM = "mixamorig:LeftArm", "mixamorig:LeftForeArm"


@pytest.fixture(scope="module")
def figure(tmp_path_factory) -> tuple[Path, Human, np.ndarray]:
    """The file, what is in it, and its weights (n, joints)."""
    path = tmp_path_factory.mktemp("figure") / "figure.glb"
    weights = write_rigged(path)
    return path, human(), weights


def below(figure: Human, joint: str) -> np.ndarray:
    """Of each joint, whether it is this one or below it."""

    def chain(name: str) -> list[str]:
        return [name, *chain(figure.parents[name])] if name else []

    return np.array([joint in chain(name) for name in figure.parents])


def axes(figure: Human) -> np.ndarray:
    """Of the arm's rest frame, in rows: x along the upper arm, z as near to up as that allows."""
    x = figure.joints[FOREARM] - figure.joints[ARM]
    x /= np.linalg.norm(x)
    z = np.array([0.0, 1.0, 0.0]) - x[1] * x
    z /= np.linalg.norm(z)
    return np.array([x, np.cross(z, x), z])


@pytest.mark.parametrize("only_arm", [False, True])
def test_an_elbow_bends_as_gltf_says(figure, tmp_path, monkeypatch, only_arm):
    """Linear blend by the file's weights; of the arm alone its own triangles, in their order."""
    monkeypatch.setattr(cli.console, "width", 2000)
    path, body, weights = figure
    words = ["--only-arm"] if only_arm else []
    done = ulna("skin", "import", path, "--out", tmp_path / "arm.fmu", *words)
    assert done.exit_code == 0, done.output
    assert f"{ARM}; {FOREARM}" in done.output
    # float32 weights sum to 1 within a rounding
    share = weights @ below(body, FOREARM) / weights.sum(axis=1)
    kept = np.arange(len(share))
    triangles = body.triangles
    if only_arm:
        held = weights @ below(body, ARM) >= 0.5
        triangles = triangles[held[triangles].all(axis=1)]
        kept = np.unique(triangles)
        assert 0.05 * len(share) < len(kept) < 0.2 * len(share), "an arm with its hand, of all of a body"
        # left of the body, and no farther in than the shoulder's joint by its radius
        assert body.vertices[kept, 0].min() > body.joints[ARM][0] - 0.08
    frame = axes(body)
    rest = (body.vertices[kept] - body.joints[FOREARM]) @ frame.T
    share = share[kept]
    assert np.count_nonzero((share > 0.0) & (share < 1.0)) > 50
    with Slave(tmp_path / "arm.fmu") as skin:
        skin.set("method", "linear_blend")
        skin.set("twist_share", 0.0)
        skin.initialize()
        assert skin.get("vertex_count") == len(kept)
        found = skin.get("triangles").reshape(-1, 3)[: len(triangles)]
        assert np.array_equal(kept[found], triangles)
        elbow = [skin.get("upper_arm_length"), 0.0, 0.0]
        assert skin.get("weights") == pytest.approx(share, abs=1e-6)
        for axis, angle in (("y", 0.0), ("y", -60.0), ("z", 45.0), ("x", 90.0), ("y", -120.0)):
            turn = Rotation.from_euler(axis, angle, degrees=True)
            skin.set("forearm_orientation", np.roll(turn.as_quat(), 1))
            expected = rest + share[:, None] * (turn.apply(rest) - rest) + elbow
            assert np.abs(skin.get("vertices").T - expected).max() < 2 * FLOAT32_BOUND, "1.3 m from the elbow"
            # what no joint of the forearm holds stays where it is
            assert np.abs(skin.get("vertices").T - rest - elbow)[share == 0.0].max() < 2 * FLOAT32_BOUND


def test_the_arm_alone_opens_no_more_than_its_weights_say(figure, tmp_path):
    """An edge grows by the step of its weights times the way from one image of its ends to the other, at most."""
    made, _ = import_skin(figure[0], tmp_path / "arm.fmu", only_arm=True)
    assert made.blend_half_width < made.upper_arm_length and made.radius < 0.1
    edges = np.concatenate([made.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    way = 2 * np.sin(np.radians(30.0)) * np.linalg.norm(made.vertices[edges], axis=2).max(axis=1)
    most = (np.abs(np.diff(made.shares[edges], axis=1))[:, 0] * way).max()
    with Slave(tmp_path / "arm.fmu") as skin:
        gaps = {}
        for method in ("rigid", "linear_blend", "dual_quaternion", "compensated"):
            skin.reset()
            skin.set("method", method)
            skin.initialize()
            skin.set("forearm_orientation", np.roll(Rotation.from_euler("y", -60.0, degrees=True).as_quat(), 1))
            gaps[method] = skin.get("elbow_gap")
            assert np.all(np.isfinite(skin.get("normals")))
            # the mesh is open at the shoulder; the zone of `rigid` is the triangles that are torn
            assert method == "rigid" or 0.8 < skin.get("blend_volume_ratio") < 1.2
    assert gaps["linear_blend"] < most < gaps["rigid"] + 0.01
    assert max(gap for method, gap in gaps.items() if method != "rigid") < gaps["rigid"]
