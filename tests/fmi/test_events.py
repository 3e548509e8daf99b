"""Events inside a step: with event mode, with early return, and without either; the pings are the same."""

from dataclasses import dataclass

import numpy as np
import pytest
from raw import VERSIONS, Raw

OUTPUTS = ("distance", "device_distance", "time_of_flight", "echo_width", "valid", "sequence", "level")
WALL = {"plane_point": [1.0, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 0.0], "sphere_center": [0.8, 0.0, 0.0]}
PERIOD = 0.06  # s


@dataclass
class Seen:
    """Outputs and times of all returns of doStep."""

    rows: dict[float, list[bytes]]
    early: list[float]
    announced: list[float]


def started(version: str = "3.0", latency: float = 0.0, **options: bool) -> Raw:
    sensor = Raw("UltrasonicSensor", version, **options)
    for name, value in (WALL | {"trigger_latency": latency}).items():
        sensor.set(name, value)
    sensor.set("sphere_velocity", [-1.0, 0.0, 0.0])
    sensor.set("sphere_radius", 0.1)
    sensor.begin()
    sensor.exitInitializationMode()
    return sensor


def outputs(sensor: Raw) -> list[bytes]:
    return [sensor.get(name).tobytes() for name in OUTPUTS]


def settle(sensor: Raw, announced: list[float]) -> None:
    """Handles all events of this time, then enters step mode."""
    need_update, terminate, _, _, defined, time = sensor.updateDiscreteStates()
    assert (need_update, terminate, defined) == (False, False, True)
    announced.append(time)
    sensor.enterStepMode()


def points_of(step: float | None, end: float) -> list[float]:
    """Ends of steps up to `end`, all of one size but the last; None for steps of all sizes."""
    if step is None:
        return [*np.sort(np.random.default_rng(5).uniform(0.0, end, 40)), end]
    return [*(step * np.arange(1, round(np.ceil(end / step - 1e-9)))), end]


def with_event_mode(early_return: bool, step: float | None, end: float, latency: float = 0.0) -> Seen:
    seen = Seen({}, [], [])
    with started(latency=latency, eventModeUsed=True, earlyReturnAllowed=early_return) as sensor:
        settle(sensor, seen.announced)
        time = 0.0
        for point in points_of(step, end):
            while time < point:
                event, terminate, early, last = sensor.doStep(time, point - time)
                assert not terminate
                assert early == (last < point)
                assert event or not early
                time = last
                if early:
                    assert early_return
                    seen.early.append(time)
                if event:
                    sensor.enterEventMode()
                    settle(sensor, seen.announced)
            seen.rows[time] = outputs(sensor)
    return seen


def without_event_mode(
    step: float | None, end: float, version: str = "3.0", latency: float = 0.0
) -> dict[float, list[bytes]]:
    with started(version, latency) as sensor:
        rows, time = {}, 0.0
        for point in points_of(step, end):
            sensor.doStep(time, point - time)
            rows[point] = outputs(sensor)
            time = point
        return rows


def by_number(rows: dict[float, list[bytes]]) -> dict[int, list[bytes]]:
    """What was read after each ping, by its number; all that was read of one ping is the same."""
    numbered = {}
    for row in rows.values():
        values = [row[0], row[1], row[2], row[3], bool(row[4][0]), row[6]]  # a Boolean of FMI 2 has four bytes
        assert numbered.setdefault(int(np.frombuffer(row[5], np.int32)[0]), values) == values
    return numbered


MODES = {
    "FMI 2.0": lambda step, latency: without_event_mode(step, 0.5, "2.0", latency),
    "FMI 3.0": lambda step, latency: without_event_mode(step, 0.5, "3.0", latency),
    "event mode": lambda step, latency: with_event_mode(False, step, 0.5, latency).rows,
    "early return": lambda step, latency: with_event_mode(True, step, 0.5, latency).rows,
}


@pytest.mark.parametrize("latency", [0.0, 0.0023])
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("step", [0.001, 0.007, 0.1, None])
def test_every_mode_hears_the_same_pings_at_any_step(mode, step, latency):
    pings = by_number(without_event_mode(0.001, 0.5, latency=latency))
    seen = by_number(MODES[mode](step, latency))
    assert len(pings) == 0.5 // PERIOD + 2  # and the state before the first
    assert max(seen) == max(pings)
    assert all(seen[number] == pings[number] for number in seen)


def test_a_burst_is_an_event_of_its_own():
    seen = with_event_mode(True, 0.5, 0.5, latency=0.0023)
    # a ping every period, its burst the latency later, its end a flight later; the ping at 0 starts before the step
    ticks = PERIOD * np.arange(9)
    np.testing.assert_allclose(seen.early[2::3], ticks[1:], rtol=1e-15)
    np.testing.assert_allclose(seen.early[0::3], ticks + 0.0023, rtol=1e-15)
    assert seen.early == seen.announced[: len(seen.early)]


@pytest.mark.parametrize("step", [0.01, 0.025, 0.07, 0.5])
def test_pings_are_the_same_with_and_without_event_mode_and_early_return(step):
    expected = without_event_mode(step, 0.5)
    # an event exactly at the end of a step is handled there only in event mode: none is, at these steps but 0.01
    points = [time for time in expected if abs(time / PERIOD - round(time / PERIOD)) > 1e-9]
    for seen in (with_event_mode(True, step, 0.5).rows, with_event_mode(False, step, 0.5).rows):
        assert [seen[time] for time in points] == [expected[time] for time in points]
    assert np.frombuffer(expected[max(expected)][OUTPUTS.index("sequence")], np.int32)[0] == 0.5 // PERIOD + 1


@pytest.mark.parametrize("version", VERSIONS)
def test_pings_do_not_depend_on_the_communication_step(version):
    rows = [without_event_mode(step, 0.5, version)[0.5] for step in (0.01, 0.05, 0.25, 0.5)]
    assert rows.count(rows[0]) == len(rows)


def test_both_versions_give_the_same_pings():
    two, three = (without_event_mode(0.1, 0.5, version) for version in VERSIONS)
    widths = [[np.frombuffer(rows[time][1]) for time in sorted(rows)] for rows in (two, three)]
    np.testing.assert_array_equal(*widths)


def test_a_step_returns_early_at_the_announced_event():
    seen = with_event_mode(True, 0.5, 0.5)
    # a ping every period from 0 on, and the end of each one, a flight later
    starts = [time for time in seen.early if abs(time / PERIOD - round(time / PERIOD)) < 1e-9]
    np.testing.assert_allclose(starts, PERIOD * np.arange(1, 9), rtol=1e-15)
    assert len(seen.early) == 17
    # what an event announces is where the next step ends, to the bit
    assert seen.early == seen.announced[: len(seen.early)]


def test_without_early_return_a_step_goes_to_its_end():
    seen = with_event_mode(False, 0.5, 0.5)
    assert seen.early == []
    assert list(seen.rows) == [0.5]


def test_no_early_return_without_event_mode():
    with started(earlyReturnAllowed=True) as sensor:
        assert sensor.doStep(0.0, 0.5) == (False, False, False, 0.5)


def test_an_event_at_the_end_of_a_step_is_announced_there():
    with started(eventModeUsed=True, earlyReturnAllowed=True) as sensor:
        settle(sensor, announced := [])
        event, _, early, last = sensor.doStep(0.0, announced[0])
        assert (event, early, last) == (True, False, announced[0])
        sensor.enterEventMode()
        settle(sensor, announced)
        assert sensor.get("sequence") == 1


@pytest.mark.parametrize("early_return", [False, True])
def test_a_trigger_set_in_event_mode_pings_there(early_return):
    with Raw("UltrasonicSensor", "3.0", eventModeUsed=True, earlyReturnAllowed=early_return) as sensor:
        sensor.set("period", 0.0)
        for name, value in WALL.items():
            sensor.set(name, value)
        sensor.begin()
        sensor.exitInitializationMode()
        assert not sensor.updateDiscreteStates()[4]
        sensor.enterStepMode()
        sensor.doStep(0.0, 0.1)
        sensor.enterEventMode()
        sensor.set("trigger", True)
        finish = sensor.updateDiscreteStates()[5]
        assert 0.1 < finish < 0.11
        sensor.enterStepMode()
        event, _, early, last = sensor.doStep(0.1, 0.1)
        assert (event, early) == (early_return, early_return)
        assert last == (finish if early_return else 0.2)
