"""Scene: what may be connected, what is recorded and when, and what is left when a unit fails."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from toy_fmu import toy
from ulna.results import Results
from ulna.scene import Scene
from ulna.slave import UnitError


def chain(version: str = "3.0", length: int = 3) -> Scene:
    """Integrators in a row, x' = u: the first has the constant input (1, 0, 0)."""
    scene = Scene("chain")
    for number in range(length):
        scene.add(toy(version), f"unit{number}")
    scene["unit0"].set("u", [1.0, 0.0, 0.0])
    for number in range(1, length):
        scene.connect(scene[f"unit{number - 1}"].x, scene[f"unit{number}"].u)
    return scene


@pytest.fixture
def pair():
    with Scene("pair") as scene:
        scene.add(toy(), "a")
        scene.add(toy(), "b")
        yield scene


# Connections


@pytest.mark.parametrize(
    ("source", "target", "message"),
    [
        ("u", "x", r"a\.u \(input, Float64\[3\], unit m\) to b\.x .*the other way round"),
        ("u", "u", r"a\.u .* to b\.u .*the source is no output"),
        ("x", "y", r"a\.x .* to b\.y \(output, Float64\[3\], unit metre\): the target is no input"),
        ("not_flag", "u", r"a\.not_flag \(output, Boolean, unit 1\) to b\.u .*their types differ"),
        ("next_count", "flag", r"a\.next_count \(output, Int32, unit 1\) to b\.flag .*their types differ"),
        ("plug", "u", r"a\.plug \(frame of position: output, count: input\) to b\.u .*one is a frame"),
        ("plug", "plug", r"a\.plug .* to b\.plug .*both put out position"),
    ],
)
def test_ends_that_do_not_fit_are_refused_by_name(pair, source, target, message):
    with pytest.raises(ValueError, match=message):
        pair.connect(pair["a"][source], pair["b"][target])
    assert not pair.connections


def test_sizes_and_units_must_match_and_a_factor_converts_units():
    with Scene() as scene:
        body, arm = scene.add("RigidBody", "body"), scene.add("HingedBody", "arm")
        with pytest.raises(ValueError, match=r"Float64\[3\], unit m\) to arm.target_angle.*sizes differ"):
            scene.connect(body.position, arm.target_angle)
        with pytest.raises(ValueError, match=r"unit m\) to arm.tip_force .*unit N\): their units differ"):
            scene.connect(body.position, arm.tip_force)
        with pytest.raises(ValueError, match="units differ"):
            scene.connect(body.position, arm.tip_force, offset=1.0)
        scene.connect(body.position, arm.tip_force, factor=-2.0)


def test_units_match_by_their_si_base_and_not_by_their_names(pair):
    pair.connect(pair["a"].y, pair["b"].u)
    assert pair["a"].y.variable.unit.name != pair["b"].u.variable.unit.name


def test_an_input_takes_one_driver_only(pair):
    a, b = pair["a"], pair["b"]
    pair.connect(a.x, b.u)
    with pytest.raises(ValueError, match=r"a\.y .* to b\.u .*: a\.x .* is connected to b.u already"):
        pair.connect(a.y, b.u)
    with pytest.raises(ValueError, match=r"drive b\.u .* by a signal: a\.x .* is connected to b.u already"):
        pair.signal(b.u, lambda t: [t, t, t])
    pair.signal(a.u, lambda t: [t, t, t])
    with pytest.raises(ValueError, match=r"a signal drives a\.u already"):
        pair.connect(b.x, a.u)


def test_a_frame_connects_its_members_in_both_directions(pair):
    pair.connect(pair["a"].plug, pair["b"].socket)
    assert [str(connection) for connection in pair.connections] == ["a.x -> b.u", "b.next_count -> a.count"]


def test_motion_goes_out_on_a_frame_and_the_wrench_comes_back():
    with Scene() as scene:
        body, arm = scene.add("RigidBody", "body"), scene.add("HingedBody", "arm")
        scene.connect(body.tip, arm.anchor)
        names = {str(connection) for connection in scene.connections}
    assert {"body.tip_position -> arm.anchor_position", "arm.reaction_force -> body.tip_force"} <= names


def test_factor_and_offset_act_on_the_value(pair):
    pair["a"].set("u", [1.0, 2.0, 3.0])
    pair.connect(pair["a"].y, pair["b"].u, factor=-2.0, offset=0.5)
    np.testing.assert_array_equal(pair.run(0.0, 1.0)["b.y"], [[-1.5, -3.5, -5.5]])


@pytest.mark.parametrize(("source", "target"), [("2.0", "3.0"), ("3.0", "2.0")])
def test_every_type_crosses_between_the_versions(source, target):
    with Scene() as scene:
        a, b = scene.add(toy(source), "a", count=41, flag=False), scene.add(toy(target), "b")
        for output, name in ((a.not_flag, "flag"), (a.next_count, "count"), (a.x, "u")):
            scene.connect(output, b[name])
        a.set("u", [1.0, 2.0, 4.0])
        results = scene.run(0.5, 0.5, master="gauss_seidel")
    np.testing.assert_array_equal(results["b.next_count"], [43, 43])
    np.testing.assert_array_equal(results["b.not_flag"], [False, False])
    np.testing.assert_array_equal(results["b.y"][-1], [0.5, 1.0, 2.0])


# Names


def test_wrong_names_get_the_nearest_right_one(pair):
    a = pair["a"]
    for wrong, message in {
        "plg": "a has no input, output or frame 'plg': did you mean plug?",
        "next_cuont": "did you mean next_count",
        "gain": r"a\.gain is a parameter, which is set, not connected",
    }.items():
        with pytest.raises(AttributeError, match=message):
            getattr(a, wrong)
    with pytest.raises(KeyError, match="pair has no unit 'c': it has a, b"):
        pair["c"]
    with pytest.raises(KeyError, match=r"c has no variable 'gian': did you mean gain\?"):
        pair.add(toy(), "c", gian=2.0)
    with pytest.raises(ValueError, match=r"a\.x is output: only parameters and inputs can be set"):
        a.set("x", [0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="already has a unit 'a'"):
        pair.add(toy(), "a")
    with pytest.raises(ValueError, match="cannot name a unit"):
        pair.add(toy(), "a.b")
    with pytest.raises(ValueError, match=r"ulna has no master 'jacoby': did you mean jacobi\?"):
        pair.run(1.0, 0.1, master="jacoby")
    assert list(pair.units) == ["a", "b"]


def test_a_frame_hides_the_parameter_of_the_same_name():
    with Scene() as scene:
        body = scene.add("RigidBody", "body", tip=[0.0, 0.0, 1.0])
        assert body.tip.terminal == "tip"


def test_a_value_that_the_unit_refuses_is_reported_at_once():
    with Scene() as scene, pytest.raises(UnitError, match=r"body at t = 0 s: fmi3SetFloat64 .*mass"):
        scene.add("RigidBody", "body", mass=-1.0)


# Time and rows


@pytest.mark.parametrize("start", [0.0, 0.7])
def test_times_are_a_step_count_times_the_step_to_the_bit(start):
    with chain(length=1) as scene:
        time = scene.run(start + 100.3, 0.1, start=start).time
    assert time.tolist() == [start + n * 0.1 for n in range(1004)]


def test_the_last_step_is_shorter_if_the_step_does_not_divide_the_time():
    with chain(length=1) as scene:
        results = scene.run(1.1, 0.25)
    assert results.time.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0, 1.1]
    np.testing.assert_array_equal(results["unit0.x"][:-1, 0], results.time[:-1])
    # x gained 1.1 - 1.0, which is not 0.1 in binary.
    assert results["unit0.x"][-1, 0] == 1.0 + (1.1 - 1.0)


@pytest.mark.parametrize(("until", "step"), [(1.0, 0.0), (1.0, -1.0), (-1.0, 0.1), (math.inf, 0.1), (math.nan, 0.1)])
def test_times_that_make_no_run_are_refused(until, step):
    with chain(length=1) as scene, pytest.raises(ValueError, match="cannot run from"):
        scene.run(until, step)


def test_row_t_holds_the_values_at_t():
    with chain(length=1) as scene:
        results = scene.run(10.0, 0.125)
    np.testing.assert_array_equal(results["unit0.x"][:, 0], results.time)


def test_the_first_row_is_the_initialised_system_in_whatever_order_units_were_added():
    # The value passes three units directly, against the order in which they were added.
    with Scene() as scene:
        last, middle, first = (scene.add(toy(), name, mode="doubled") for name in ("last", "middle", "first"))
        scene.connect(first.y, middle.u)
        scene.connect(middle.y, last.u)
        scene.signal(first.u, lambda t: [t, 1.0, 0.0])
        results = scene.run(3.0, 1.0, start=3.0)
    np.testing.assert_array_equal(results["last.y"], [[24.0, 8.0, 0.0]])
    assert results.summary["initial_passes"] == 2


def test_a_second_run_repeats_the_first_to_the_bit():
    with chain() as scene:
        first, second = (scene.run(1.0, 0.1)["unit2.x"] for _ in range(2))
        scene["unit0"].set("gain", 2.0)
        third = scene.run(1.0, 0.1)["unit2.x"]
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(third, 2.0 * first)


# Recording


def test_all_outputs_are_recorded_unless_some_are_chosen():
    with chain(length=2) as scene:
        everything = scene.run(1.0, 0.5)
        scene.record(scene["unit0"].plug, scene["unit1"].next_count, scene["unit1"].u)
        chosen = scene.run(1.0, 0.5)
    assert list(everything) == [f"unit{n}.{name}" for n in (0, 1) for name in ("x", "y", "not_flag", "next_count")]
    assert list(chosen) == ["unit0.x", "unit1.next_count", "unit1.u"]
    assert chosen.units == {"unit0.x": "m", "unit1.next_count": "1", "unit1.u": "m"}
    assert everything["unit0.not_flag"].dtype == bool
    with pytest.raises(KeyError, match=r"did you mean unit0\.x"):
        chosen["unit0.xx"]


def test_a_stream_is_recorded_only_if_it_is_asked_for():
    with Scene() as scene:
        skin = scene.add("ArmSkin", "skin")
        assert "skin.vertices" not in scene.run(0.1, 0.1)
        scene.record(skin.vertices)
        results = scene.run(0.1, 0.1)
        np.testing.assert_array_equal(results["skin.vertices"][-1], skin.slave.get("vertices"))


def test_a_table_reads_back_to_the_bit(tmp_path):
    awkward = np.array([0.1, 1e-310, -0.0, np.nan, np.inf, 1 / 3])
    columns = {
        "a.scalar": awkward,
        "a.flag": np.arange(6) % 2 == 0,
        "a.count": np.arange(6) - 3,
        "a.matrix": np.linspace(-1.0, 1.0, 36).reshape(6, 2, 3),
    }
    written = Results(
        np.arange(6) * 0.1, columns, {"a.scalar": "kg.m2", "a.flag": "1", "a.count": "1", "a.matrix": "m"}
    )
    path = tmp_path / "results.csv"
    written.to_csv(path)
    read = Results.from_csv(path)
    assert path.read_text().startswith('time [s],a.scalar [kg.m2],a.flag [1],a.count [1],"a.matrix[1,1] [m]"')
    assert read.units == written.units
    for name in ("time", *columns):
        assert read[name].dtype == written[name].dtype
        assert read[name].tobytes() == written[name].tobytes()


def test_progress_tells_the_time_from_the_start_to_the_end():
    seen = []
    with chain(length=1) as scene:
        scene.run(1.0, 1e-4, progress=seen.append)
    assert (seen[0], seen[-1]) == (0.0, 1.0)
    assert seen == sorted(seen)
    assert len(seen) < 1000


# Ends before the end


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("master", ["jacobi", "gauss_seidel"])
def test_a_failing_unit_stops_the_run_and_what_was_recorded_is_kept(version, master):
    with Scene() as scene:
        ball = scene.add("RigidBody", "ball", version=version)
        scene.signal(ball.force, lambda t: [0.0, 0.0, math.nan if t > 0.5 else 0.0])
        scene.record(ball.position)
        with pytest.raises(UnitError, match=r"ball at t = .*force\[3\]") as caught:
            scene.run(1.0, 0.125, master=master)
    # The value at t = 0.625 is the first bad one: Jacobi sets it there, Gauss-Seidel for the step that ends there.
    assert caught.value.time == {"jacobi": 0.625, "gauss_seidel": 0.5}[master]
    kept = caught.value.results
    assert kept.time[-1] == caught.value.time
    np.testing.assert_allclose(kept["ball.position"][:, 2], -0.5 * 9.80665 * kept.time**2, rtol=1e-12)


def test_a_unit_may_ask_for_the_end():
    with chain(length=2) as scene:
        scene["unit0"].set("gain", 1000.0)
        results = scene.run(10.0, 0.5)
    # The toy asks in the first step that begins at 1000 m or beyond: at t = 1.
    assert results.time[-1] == 1.5
    assert results.summary["ended_by"] == "unit0"


def test_a_signal_of_the_wrong_shape_is_refused_before_the_run():
    with chain(length=1) as scene:
        scene.signal(scene["unit0"].u, lambda t: 1.0)
        with pytest.raises(ValueError, match=r"the signal for unit0\.u .*shape \(\)"):
            scene.run(1.0, 0.1)


# Loops


def test_algebraic_loops_are_told_from_loops_through_states():
    with Scene() as scene:
        a, b = scene.add(toy(), "a"), scene.add(toy(), "b")
        scene.connect(a.y, b.u)
        assert scene.loops() == []
        scene.connect(b.x, a.u)
        (loop,) = scene.loops()
    # b.u reaches no output that is connected, so an old value there makes no row inconsistent
    assert (loop.units, loop.broken, loop.algebraic) == (("b", "a"), ("a.y -> b.u",), ())
    with Scene() as scene:
        a, b = scene.add(toy(), "a"), scene.add(toy(), "b")
        scene.connect(a.y, b.u)
        scene.connect(b.y, a.u, factor=0.5, offset=1.0)
        (loop,) = scene.loops()
        # u = u / 2 + 1 settles at 2, by halving the error until it is below one unit in the last place.
        results = scene.run(0.0, 1.0)
    assert set(loop.algebraic) == {"a.u", "b.u"}
    np.testing.assert_array_equal(results["b.y"], [[2.0, 2.0, 2.0]])
    assert 50 < results.summary["initial_passes"] < 60


def test_a_loop_is_opened_at_the_start_values_and_not_at_zero():
    with Scene() as scene:
        a, b = scene.add(toy(), "a", u=[1.0, 2.0, 3.0]), scene.add(toy(), "b", u=[4.0, 5.0, 6.0])
        scene.connect(a.y, b.u)
        scene.connect(b.y, a.u)
        results = scene.run(0.0, 1.0)
    np.testing.assert_array_equal(results["a.y"], [[4.0, 5.0, 6.0]])


def test_an_algebraic_loop_that_does_not_settle_is_reported():
    with Scene() as scene:
        a, b = scene.add(toy(), "a"), scene.add(toy(), "b")
        scene.connect(a.y, b.u)
        scene.connect(b.y, a.u, factor=-1.0, offset=1.0)
        with pytest.warns(UserWarning, match=r"do not settle in 100 passes: a, b: broken at b\.y -> a\.u"):
            scene.run(0.0, 1.0)


# Several at once


def test_scenes_in_threads_give_what_they_give_alone():
    def simulate(gain: float) -> np.ndarray:
        with chain() as scene:
            scene["unit0"].set("gain", gain)
            return scene.run(1.0, 1e-3)["unit2.x"]

    gains = [1.0, 2.0, 3.0, 4.0]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(simulate, gains))
    for gain, values in zip(gains, together, strict=True):
        np.testing.assert_array_equal(values, simulate(gain))
