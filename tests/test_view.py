"""What is put into the page of a run; test_viewer plays it."""

import re

import numpy as np
import pytest
from typer.testing import CliRunner

from ulna import Scene, cli, gallery, view
from ulna.skeleton import rotate
from ulna.view import BEAM_HALF_ANGLE, BUNDLES, SPANS, pings, thinned, write_view

BALL = np.array([0.9, 0.1, 0.0])
# Names in the page that no browser asks for: of XML dialects
NAMESPACES = {"http://www.w3.org/1999/xhtml", "http://www.w3.org/2000/svg"}


def test_the_page_is_one_file(tmp_path):
    if not any(path.is_file() for path in BUNDLES):
        pytest.skip("view.html needs its script: apt-get install nodejs npm, then make build")
    example = gallery.load("follow")
    with example.build() as scene:
        write_view(tmp_path / "view.html", scene.run(0.5, example.step), scene)
    page = (tmp_path / "view.html").read_text(encoding="utf-8")
    assert set(re.findall(r"https?://[^\s\"'`<>)]+", page)) == NAMESPACES
    assert set(re.findall(r"<[^<>]+\s(?:src|href)=\"?([^\s\">]+)", page)) == {"data:,"}
    assert "@import" not in page and "url(" not in page
    # and what is asked for all the same is refused
    assert "default-src 'none'" in page


def test_skins_over_other_bones_are_switched_one_by_one(tmp_path):
    with Scene("two") as scene:
        for name in ("left", "right"):
            scene.add("ArmSkin", name, upper_arm_position=[0.0, float(name == "left"), 0.0])
        results = scene.run(0.1, 0.05)
        assert [[skin["name"] for skin in group] for group in view._skins(results, scene)] == [["left"], ["right"]]


def test_echoes_end_on_the_ball_and_silence_straight_ahead():
    example = gallery.load("follow")
    with example.build() as scene:
        results = scene.run(2.0, 0.002)
        heard = pings(results, scene, scene["sensor"])
    rows = np.searchsorted(results.time, heard.time)
    assert len(rows) == results["sensor.sequence"][-1]
    assert 0 < np.count_nonzero(heard.heard) < len(rows)
    measured = np.linalg.norm(heard.end - heard.start, axis=1)
    np.testing.assert_allclose(measured, results["sensor.distance"][rows], rtol=1e-12)
    off = np.linalg.norm(heard.end - results["ball.position"][rows], axis=1) - 0.10
    # a ping tells of the past: 9 ms of flight and a row, at up to 2 m/s; and noise, rounding
    assert np.abs(off[heard.heard]).max() < 0.04
    ahead = rotate(results["forearm.tip_orientation"][rows], np.array([1.0, 0.0, 0.0]))
    aside = np.linalg.norm(np.cross(heard.end - heard.start, ahead), axis=1)
    assert aside[~heard.heard].max() < 1e-12


@pytest.mark.parametrize(
    ("targets", "nearest"),
    [
        ({"plane_point": [2.0, 0, 0], "plane_normal": [-1.0, 0.0, 0.2]}, [2 / 1.04, 0.0, -0.4 / 1.04]),
        (
            {"capsule_1_start": [1.0, -1, 0.1], "capsule_1_end": [1.0, 1, 0.1], "capsule_1_radius": 0.05},
            np.array([1.0, 0.0, 0.1]) * (1 - 0.05 / 1.01**0.5),
        ),
        # of which the surface is nearer than the wall, and the centre is not
        (
            {"plane_point": [0.85, 0, 0], "plane_normal": [-1.0, 0, 0], "sphere_center": BALL, "sphere_radius": 0.3},
            BALL * (1 - 0.3 / np.linalg.norm(BALL)),
        ),
    ],
    ids=["plane", "capsule", "ball before a plane"],
)
def test_an_echo_comes_from_the_nearest_point_of_its_target(targets, nearest):
    with Scene("one") as scene:
        sensor = scene.add("UltrasonicSensor", "sensor", **targets)
        results = scene.run(0.1, 0.01)
        heard = pings(results, scene, sensor)
    assert heard.heard.all() and len(heard.time) > 0
    # resolution is 3 mm; the baseline moves the mirror point by less
    np.testing.assert_allclose(heard.end, np.tile(nearest, (len(heard.time), 1)), atol=0.003)


def test_a_ball_at_the_edge_of_the_beam_is_12_dB_weaker():
    """6 dB on each way; the same distance, so that nothing else differs but the 1.5 degrees between both ears."""

    def level(angle):
        with Scene("one") as scene:
            center = [np.cos(angle), 0.0, np.sin(angle)]
            scene.add("UltrasonicSensor", "sensor", threshold=-100.0, sphere_center=center, sphere_radius=0.1)
            return scene.run(0.1, 0.01)["sensor.level"][-1]

    assert level(0.0) - level(BEAM_HALF_ANGLE) == pytest.approx(12.0, abs=0.3)


def test_a_thinned_curve_keeps_ends_and_extremes():
    time = np.linspace(0.0, 1.0, 12_345)
    values = np.sin(900.0 * time)
    values[7000] = 5.0
    short, kept = thinned(time, values)
    assert len(short) <= 2 * SPANS + 2
    assert np.all(np.diff(short) > 0.0)
    assert (short[0], short[-1], kept.max(), kept.min()) == (0.0, 1.0, 5.0, values.min())
    np.testing.assert_array_equal(values[np.searchsorted(time, short)], kept)
    np.testing.assert_array_equal(thinned(time[:100], values[:100])[1], values[:100])


def test_without_its_script_the_other_files_are_written_and_the_command_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(view, "BUNDLES", ())
    monkeypatch.setattr(cli.errors, "width", 200)
    done = CliRunner().invoke(cli.app, ["run", "tumble", "--until", "0.01", "--out", str(tmp_path)])
    assert done.exit_code == 0
    assert "no view.html" in done.output and "make build" in done.output
    assert (tmp_path / "arm.glb").exists() and not (tmp_path / "view.html").exists()
