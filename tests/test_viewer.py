"""The page of a run in a real browser: it plays, and what it shows is what was recorded and computed."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from chromium import Browser, find_chromium
from ulna import Scene, Slave, gallery
from ulna.gltf import frames
from ulna.skeleton import rotate
from ulna.view import BUNDLES, pings, write_view

METHODS = ("rigid", "linear_blend", "dual_quaternion")
ELBOW = np.array([0.3, 0.0, 0.0])


def turn(axis, angle):
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * np.array(axis) / np.linalg.norm(axis)])


def bones(time):
    """A shoulder that moves and turns; a forearm that bends by 150 degrees and twists by 30 within a second."""
    position, upper = np.array([0.1 * time, 0.0, 1.0]), turn([1.0, 2.0, -1.0], 0.7 * time)
    (w, *v), (s, *u) = upper, turn([0.2, -1.0, 0.0], 2.618 * time)
    forearm = np.concatenate([[w * s - np.dot(v, u)], w * np.array(u) + s * np.array(v) + np.cross(v, u)])
    return {
        "upper_arm_position": position,
        "upper_arm_orientation": upper,
        "forearm_position": position + rotate(upper, ELBOW),
        "forearm_orientation": forearm,
    }


@pytest.fixture(scope="module", autouse=True)
def script():
    if not any(path.is_file() for path in BUNDLES):
        pytest.skip("view.html needs its script: apt-get install nodejs npm, then make build")


@pytest.fixture(scope="module")
def follow(tmp_path_factory):
    """Page and results of two seconds of the scene `follow`."""
    path = tmp_path_factory.mktemp("follow") / "view.html"
    example = gallery.load("follow")
    with example.build() as scene:
        results = scene.run(2.0, 0.002)
        write_view(path, results, scene)
        heard = pings(results, scene, scene["sensor"])
    return path, results, heard


@pytest.fixture(scope="module")
def skins(tmp_path_factory):
    """Page and results of three skins over the same bones."""
    path = tmp_path_factory.mktemp("skins") / "view.html"
    with Scene("skins") as scene:
        for method in METHODS:
            skin = scene.add("ArmSkin", method, vertex_count=1024, method=method)
            for name in bones(0.0):
                scene.signal(skin[name], lambda time, name=name: bones(time)[name])
        results = scene.run(1.0, 0.01)
        write_view(path, results, scene)
    return path, results


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    if find_chromium() is None:
        pytest.skip("needs a browser: apt-get install chromium")
    chromium = Browser(tmp_path_factory.mktemp("profile"))
    yield chromium
    chromium.close()


@pytest.fixture
def show(browser):
    """Opens a page, at rest unless told otherwise; it must neither ask for anything else nor complain."""

    def opened(path, motion="reduce", scheme="light", size=(1280, 720)):
        browser.resize(*size)
        browser.prefer(prefers_reduced_motion=motion, prefers_color_scheme=scheme)
        browser.open(path)
        browser.value("ulna.world.then((world) => { window.world = world; })")
        return browser

    yield opened
    assert browser.requests == [browser.value("location.href")]
    assert browser.complaints == []


def centre(browser, selector, share=0.5):
    """Where to click an element: from its left side by a share of its width."""
    left, top, width, height = browser.value(
        f"(({{left, top, width, height}}) => [left, top, width, height])"
        f"(document.querySelector({selector!r}).getBoundingClientRect())"
    )
    return left + share * width, top + height / 2


def test_it_plays_by_itself_unless_motion_is_unwelcome(show, follow):
    page = show(follow[0], motion="no-preference")
    page.wait("ulna.clock.time > 0.1")
    page = show(follow[0])
    assert page.value("[ulna.clock.playing, ulna.clock.time]") == [False, 0]


def test_button_and_space_play_and_pause(show, follow):
    page = show(follow[0])
    page.click(*centre(page, "#play"))
    page.wait("ulna.clock.time > 0.05")
    assert page.value("document.getElementById('play').textContent") == "Pause"
    page.value("document.activeElement.blur()")
    page.press(" ", 32)
    assert page.value("[ulna.clock.playing, document.getElementById('play').textContent]") == [False, "Play"]


def test_time_passes_at_the_chosen_speed_and_begins_again_at_the_end(show, follow):
    page = show(follow[0])
    page.value("""
        window.choose = (speed) => {
            const select = document.getElementById("speed");
            select.value = speed;
            select.dispatchEvent(new Event("change"));
        };
        window.tenth = (time) => {
            ulna.clock.seek(time);
            Object.assign(ulna.clock, {playing: true, last: 1000});
            ulna.clock.advance(1100);
            ulna.clock.pause();
            return ulna.clock.time;
        };
    """)
    for speed in (0.1, 1.0, 4.0):
        page.value(f"choose({speed})")
        assert page.value("tenth(0.5)") == pytest.approx(0.5 + 0.1 * speed, abs=1e-12)
    assert page.value("tenth(1.9)") == 0


def test_slider_plot_and_keys_scrub(show, follow):
    page = show(follow[0])
    page.click(*centre(page, "#time"))
    # the middle of the slider is the middle of the run, to a pixel of 250
    assert page.value("ulna.clock.time") == pytest.approx(1.0, abs=0.01)
    page.click(*centre(page, ".plot", 0.25))
    assert page.value("ulna.clock.time") == pytest.approx(0.5, abs=0.01)
    page.value("document.activeElement.blur()")
    page.value("ulna.clock.seek(1)")
    page.press("ArrowRight", 39)
    assert page.value("ulna.clock.time") == pytest.approx(1 + 1 / 30, abs=1e-9)
    page.press("End", 35)
    assert page.value("document.getElementById('reading').textContent") == "2.00 / 2.00 s"


@pytest.mark.parametrize("name", ["ball", "sensor"])
def test_parts_are_where_they_were_recorded(show, follow, name):
    path, results, _ = follow
    page = show(path)
    column = {"ball": "ball.{}", "sensor": "forearm.tip_{}"}[name]
    for row in frames(results.time)[::10].tolist():
        page.value(f"ulna.clock.seek({float(results.time[row])!r})")
        pose = np.array(page.value(f"world.pose({name!r})")).reshape(4, 4).T
        axes = rotate(results[column.format("orientation")][row], np.eye(3)).T
        # float32 keys, up to 3 m away
        np.testing.assert_allclose(pose[:3, 3], results[column.format("position")][row], atol=1e-6)
        np.testing.assert_allclose(pose[:3, :3], axes, atol=1e-6)


# as in test_gltf: float32 keys, and 17 joints for dual quaternions
@pytest.mark.parametrize(("method", "bound"), [("rigid", 1e-6), ("linear_blend", 1e-6), ("dual_quaternion", 3e-4)])
def test_vertices_are_where_arm_skin_puts_them(show, skins, method, bound):
    path, results = skins
    page = show(path)
    with Slave("ArmSkin") as skin:
        skin.set("vertex_count", 1024)
        skin.set("method", method)
        skin.initialize()
        for row in frames(results.time)[::6]:
            time = float(results.time[row])
            for name, value in bones(time).items():
                skin.set(name, value)
            page.value(f"ulna.clock.seek({time!r})")
            shown = np.array(page.value(f"world.vertices({method!r})")).reshape(-1, 3)
            assert np.abs(shown - skin.get("vertices").T).max() < bound


def test_the_skin_is_drawn_where_its_vertices_are(show, follow):
    """The pixels that change when the arm is switched off."""
    page = show(follow[0])
    page.value("world.scene.traverse((object) => { object.castShadow = false; }); ulna.clock.seek(1.5)")

    def picture():
        page.value("new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(() => drawn())))")
        return np.asarray(Image.open(BytesIO(page.screenshot())).convert("RGB")).astype(int)

    before = picture()
    left, top, width, height = page.value(
        "Object.values(document.getElementById('canvas').getBoundingClientRect().toJSON()).slice(0, 4)"
    )
    page.click(*centre(page, "#shown input[value=arm]"))
    changed = np.abs(picture() - before).max(axis=2)[int(top) : int(top + height), int(left) : int(left + width)] > 12
    rows, columns = np.nonzero(changed)
    points = np.array(page.value("world.vertices('arm')")).reshape(-1, 3)[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
    projection, look = (
        np.array(page.value(f"world.camera.{name}.elements")).reshape(4, 4).T
        for name in ("projectionMatrix", "matrixWorldInverse")
    )
    clipped = np.column_stack([points, np.ones(len(points))]) @ (projection @ look).T
    x, y = ((clipped[:, :2] / clipped[:, 3:] * [1.0, -1.0] + 1.0) / 2.0 * [width, height]).T
    expected = [x.min(), x.max(), y.min(), y.max()]
    # vertices 10 mm apart, pixels of 4 mm and their half-covered neighbours
    np.testing.assert_allclose([columns.min(), columns.max(), rows.min(), rows.max()], expected, atol=4.0)


def test_one_skin_of_those_over_the_same_bones_is_shown(show, skins):
    page = show(skins[0])
    shown = f"{list(METHODS)}.filter((name) => world.objects.get(name).layers.isEnabled(0))"
    assert page.value(shown) == ["dual_quaternion"]
    for method in METHODS:
        page.click(*centre(page, f"input[value={method}]"))
        assert page.value(shown) == [method]


def test_the_last_echo_is_drawn_from_the_sensor_to_the_ball(show, follow):
    path, results, heard = follow
    page = show(path)
    for time in (0.9, 1.5):
        last = np.searchsorted(heard.time, time, side="right") - 1
        assert heard.heard[last]
        page.value(f"ulna.clock.seek({time})")
        middle, length = page.value("(({position, scale}) => [position.toArray(), scale.y])(world.sensors[0].ray)")
        np.testing.assert_allclose(middle, (heard.start[last] + heard.end[last]) / 2, atol=1e-6)
        # the last one whose end was recorded by then
        row = np.searchsorted(results.time, time)
        assert length == pytest.approx(results["sensor.distance"][row], abs=1e-6)
    page.value("ulna.clock.seek(0)")
    assert page.value("world.sensors[0].ray.scale.y") == 0


def test_plots_read_what_was_recorded_at_the_cursor(show, follow):
    path, results, _ = follow
    page = show(path)
    page.value("ulna.clock.seek(1.234)")
    panel = "[...document.querySelectorAll('.panel')].find((one) => one.textContent.startsWith('forearm: elbow'))"
    target, angle = page.value(f"[...{panel}.querySelectorAll('output')].map((one) => Number(one.textContent))")
    row = np.searchsorted(results.time, 1.234)
    # one decimal, or two
    assert angle == pytest.approx(np.degrees(results["forearm.angle"][row]), abs=0.06)
    assert target == pytest.approx(np.degrees(results["forearm.target_angle"][row]), abs=0.06)
    left = page.value(f"parseFloat({panel}.querySelector('.cursor').style.left)")
    assert left == pytest.approx(61.7, abs=1e-3)


def test_the_camera_goes_along_and_comes_back(show, follow):
    page = show(follow[0])
    place = "world.camera.position.toArray()"
    home = page.value(place)
    page.value("document.getElementById('follow').value = 'ball'")
    page.value("document.getElementById('follow').dispatchEvent(new Event('change'))")
    ball = np.array(page.value("world.pose('ball')"))[12:15]
    page.value("ulna.clock.seek(1.5)")
    moved = (np.array(page.value("world.pose('ball')"))[12:15] - ball)[[0, 2, 1]] * [1.0, 1.0, -1.0]
    np.testing.assert_allclose(np.array(page.value(place)) - home, moved, atol=1e-9)
    page.click(*centre(page, "#reset"))
    np.testing.assert_allclose(page.value(place), home, atol=1e-9)


@pytest.mark.parametrize(("scheme", "bright"), [("light", True), ("dark", False)])
def test_it_is_light_or_dark_as_preferred_and_fits_a_telephone(show, follow, scheme, bright):
    page = show(follow[0], scheme=scheme, size=(375, 700))
    red = page.value("Number(getComputedStyle(document.body).backgroundColor.match(/[0-9]+/)[0])")
    assert (red > 128) is bright
    assert page.value("document.documentElement.scrollWidth") <= 375


def test_everything_that_takes_the_keyboard_has_a_name(show, follow):
    page = show(follow[0])
    nodes = page.call("Accessibility.getFullAXTree")["nodes"]
    focusable = [
        node
        for node in nodes
        if any(p["name"] == "focusable" and p["value"]["value"] for p in node.get("properties", []))
    ]
    roles = {node["role"]["value"] for node in focusable}
    assert {"button", "slider", "combobox", "checkbox"} <= roles
    assert [node["role"]["value"] for node in focusable if not node.get("name", {}).get("value")] == []


def test_names_are_shown_and_not_obeyed(show, tmp_path):
    name = "</script><b>&amp;"
    with Scene(name) as scene:
        scene.add("RigidBody", "body")
        results = scene.run(0.1, 0.05)
        results.units["body.position"] = name
        write_view(tmp_path / "view.html", results, scene)
    page = show(tmp_path / "view.html")
    assert page.value("[document.title, document.querySelector('h1').textContent]") == [name, name]
    assert f"[{name}]" in page.value("[...document.querySelectorAll('.unit')].map((one) => one.textContent)")


def test_without_webgl_it_says_so_and_plots_go_on(browser, follow):
    blind = "HTMLCanvasElement.prototype.getContext = () => null"
    script = browser.call("Page.addScriptToEvaluateOnNewDocument", source=blind)["identifier"]
    try:
        browser.prefer(prefers_reduced_motion="reduce")
        browser.open(follow[0])
        browser.wait("!document.getElementById('message').hidden")
        assert "WebGL" in browser.value("document.getElementById('message').textContent")
        browser.value("ulna.clock.seek(1)")
        assert browser.value("document.querySelector('.cursor').style.left") == "50%"
    finally:
        browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
