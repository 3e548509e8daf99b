"""Clocks of FMI 3: a trigger that ticks and an echo counted down give the pings of every other mode, to the bit."""

import ctypes

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from raw import VERSIONS, Raw, variables_of
from test_events import OUTPUTS, WALL, points_of

SENSOR = "UltrasonicSensor"
NOT_YET_KNOWN, UNCHANGED, CHANGED = 0, 1, 2
END = 0.5  # s
TRIGGERS = (0.0, 0.0311, 0.05, 0.13, 0.1302, 0.23, 0.3, 0.4107)  # s; the fifth falls into a flight
STEPS = (0.001, 0.007, 0.1, None)


def reference(name: str):
    return (ctypes.c_uint32 * 1)(*variables_of(SENSOR, "3.0")[name].references)


def made(version: str = "3.0", period: float = 0.0, latency: float = 0.0, **options: bool) -> Raw:
    """Before a wall and a ball that comes near; in event mode, at the start, where that is used."""
    sensor = Raw(SENSOR, version, **options)
    for name, value in WALL.items():
        sensor.set(name, value)
    sensor.set("sphere_velocity", [-1.0, 0.0, 0.0])
    sensor.set("sphere_radius", 0.1)
    sensor.set("period", period)
    sensor.set("trigger_latency", latency)
    sensor.begin()
    sensor.exitInitializationMode()
    return sensor


def outputs(sensor: Raw) -> list[bytes]:
    row = [sensor.get(name) for name in OUTPUTS]
    row[OUTPUTS.index("valid")] = row[OUTPUTS.index("valid")].astype(bool)  # a Boolean of FMI 2 has four bytes
    return [values.tobytes() for values in row]


def interval(sensor: Raw, fraction: bool = False) -> tuple[float, int]:
    """Interval of the clock of the echo, seconds, and its qualifier."""
    qualifier = (ctypes.c_int * 1)(-1)
    if fraction:
        counter, resolution = (ctypes.c_uint64 * 1)(), (ctypes.c_uint64 * 1)()
        sensor.getIntervalFraction(reference("echo_clock"), counter, resolution, qualifier)
        return counter[0] / resolution[0], qualifier[0]
    seconds = (ctypes.c_double * 1)()
    sensor.getIntervalDecimal(reference("echo_clock"), seconds, qualifier)
    return seconds[0], qualifier[0]


def tick(sensor: Raw, name: str, active: bool = True) -> None:
    sensor.setClock(reference(name), [active])


def is_active(sensor: Raw, name: str) -> bool:
    return bool(sensor.getClock(reference(name))[0])


def grid(step: float | None) -> list[float]:
    """The ends of the steps, with all triggers among them, and where an edge falls again."""
    return sorted({*points_of(step, END), *TRIGGERS[1:], *(time + 1e-4 for time in TRIGGERS)})


def size(time: float, point: float) -> float:
    """Of a step towards `point`: the last one ends there to the bit, since it is shorter than the way behind it."""
    return point - time if 2.0 * time >= point else 0.75 * (point - time)


def with_edges(version: str, step: float | None, period: float, latency: float, events: bool = False) -> dict:
    """The Boolean input: an edge at each trigger, set in event mode where that is used; nobody asks for an interval."""
    options = {"eventModeUsed": True, "earlyReturnAllowed": True} if events else {}
    rows, time = {}, 0.0
    with made(version, period, latency, **options) as sensor:
        in_event_mode = events
        for point in grid(step):
            if events and not in_event_mode:
                sensor.enterEventMode()
            sensor.set("trigger", time in TRIGGERS)
            if events:
                sensor.updateDiscreteStates()
                sensor.enterStepMode()
                in_event_mode = False
            while time < point:
                reached = sensor.doStep(time, size(time, point) if events else point - time)
                time = reached[3] if events else point
                if events and time < point:
                    sensor.enterEventMode()
                    sensor.updateDiscreteStates()
                    sensor.enterStepMode()
            rows[point] = outputs(sensor)
    return rows


def with_clocks(step: float | None, period: float, latency: float, *, early: bool, fraction: bool, asks: bool) -> dict:
    """Both clocks; steps end where the echo's is counted down to, which is not asked for unless `asks`."""
    rows, time, due = {}, 0.0, np.inf
    with made("3.0", period, latency, eventModeUsed=True, earlyReturnAllowed=early) as sensor:
        points = grid(step)
        while True:  # in event mode, at `time`
            if time in TRIGGERS and time not in rows:
                tick(sensor, "trigger_clock")
            if time == due:
                tick(sensor, "echo_clock")
            need_update, *_ = sensor.updateDiscreteStates()
            assert not need_update
            if asks:
                seconds, qualifier = interval(sensor, fraction)
                known = qualifier != NOT_YET_KNOWN
                due = (time + seconds if qualifier == CHANGED else due) if known else np.inf
            if time in points:
                rows[time] = outputs(sensor)
                points = points[1:]
                if not points:
                    return rows
            rows.setdefault(time, None)
            sensor.enterStepMode()
            stop = min(points[0], due)
            _, _, _, time = sensor.doStep(time, size(time, stop))
            sensor.enterEventMode()


def pings(rows: dict) -> dict[int, list[bytes]]:
    """What was read after each ping, by its number."""
    numbered = {}
    for row in filter(None, rows.values()):
        number = int(np.frombuffer(row[OUTPUTS.index("sequence")], np.int32)[0])
        assert numbered.setdefault(number, row) == row
    return numbered


MODES = {
    "FMI 2.0": lambda *case: with_edges("2.0", *case),
    "FMI 3.0": lambda *case: with_edges("3.0", *case),
    "event mode": lambda *case: with_edges("3.0", *case, events=True),
    "clocks": lambda *case: with_clocks(*case, early=False, fraction=False, asks=True),
    "clocks and early return": lambda *case: with_clocks(*case, early=True, fraction=False, asks=True),
    "clocks by fractions": lambda *case: with_clocks(*case, early=True, fraction=True, asks=True),
    "no interval asked for": lambda *case: with_clocks(*case, early=False, fraction=False, asks=False),
}


@pytest.fixture(scope="module")
def expected() -> dict:
    """Pings without any events, at 1 ms, by period and latency."""
    cases = [(0.0, 0.0), (0.06, 0.0), (0.0, 0.004)]
    return {case: pings(with_edges("3.0", 0.001, *case)) for case in cases}


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize(("period", "latency"), [(0.0, 0.0), (0.06, 0.0), (0.0, 0.004)])
def test_every_mode_gives_the_same_pings_to_the_bit(expected, mode, step, period, latency):
    truth = expected[period, latency]
    seen = pings(MODES[mode](step, period, latency))
    assert max(truth) == max(seen) >= len(TRIGGERS) - 1
    assert all(seen[number] == truth[number] for number in seen)


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("mode", [mode for mode in MODES if "clocks" in mode])
def test_at_each_communication_point_the_outputs_are_those_without_clocks(mode, step):
    """No ping ends at one of them."""
    rows, clocked = with_edges("3.0", step, 0.06, 0.0), MODES[mode](step, 0.06, 0.0)
    assert all(clocked[time] == row for time, row in rows.items())


# One ping, call by call


@pytest.fixture
def sensor():
    """In event mode, at the start; no periodic pings."""
    with made(eventModeUsed=True, earlyReturnAllowed=True) as unit:
        unit.updateDiscreteStates()
        yield unit


def fly(sensor: Raw) -> float:
    """Starts a ping by its clock and returns when it ends."""
    tick(sensor, "trigger_clock")
    return sensor.updateDiscreteStates()[5]


def test_a_clock_is_active_until_the_discrete_states_are_updated(sensor):
    assert not is_active(sensor, "trigger_clock")
    tick(sensor, "trigger_clock")
    assert is_active(sensor, "trigger_clock")
    assert not is_active(sensor, "echo_clock")
    sensor.updateDiscreteStates()
    assert not is_active(sensor, "trigger_clock")


def test_a_clock_that_is_deactivated_again_does_nothing(sensor):
    tick(sensor, "trigger_clock")
    tick(sensor, "trigger_clock", False)
    assert not sensor.updateDiscreteStates()[4]


def test_a_tick_together_with_an_edge_is_one_ping(sensor):
    sensor.set("trigger", True)
    finish = fly(sensor)
    sensor.enterStepMode()
    sensor.doStep(0.0, 0.1)
    sensor.enterEventMode()
    tick(sensor, "echo_clock")
    assert not sensor.updateDiscreteStates()[4]
    assert finish < 0.1
    assert sensor.get("sequence") == 1


def test_the_interval_is_told_once_and_then_repeated(sensor):
    assert interval(sensor)[1] == NOT_YET_KNOWN
    finish = fly(sensor)
    assert interval(sensor) == (finish, CHANGED)
    assert interval(sensor) == (finish, UNCHANGED)
    assert interval(sensor, fraction=True) == (pytest.approx(finish, abs=2**-51), UNCHANGED)
    sensor.enterStepMode()
    sensor.doStep(0.0, finish / 2)
    sensor.enterEventMode()
    sensor.updateDiscreteStates()
    assert interval(sensor) == (finish, UNCHANGED)  # from the event at which it was told
    sensor.enterStepMode()
    sensor.doStep(finish / 2, finish - finish / 2)
    sensor.enterEventMode()
    tick(sensor, "echo_clock")
    assert is_active(sensor, "echo_clock")
    sensor.updateDiscreteStates()
    assert not is_active(sensor, "echo_clock")
    assert interval(sensor)[1] == NOT_YET_KNOWN
    assert sensor.get("sequence") == 1
    assert interval(sensor)[1] == NOT_YET_KNOWN
    later = fly(sensor)
    assert interval(sensor) == (later - finish, CHANGED)


def test_the_interval_is_not_known_before_the_burst():
    with made(latency=0.01, eventModeUsed=True, earlyReturnAllowed=True) as sensor:
        assert fly(sensor) == 0.01  # the burst, an event of its own
        assert interval(sensor)[1] == NOT_YET_KNOWN
        sensor.enterStepMode()
        assert sensor.doStep(0.0, 0.1)[3] == 0.01
        sensor.enterEventMode()
        finish = sensor.updateDiscreteStates()[5]
        assert interval(sensor) == (finish - 0.01, CHANGED)


def test_in_initialization_no_interval_is_known():
    with Raw(SENSOR, "3.0", eventModeUsed=True) as sensor:
        sensor.begin()
        assert interval(sensor)[1] == NOT_YET_KNOWN


@pytest.mark.parametrize("miss", [-9e-10, -1e-15, 0.0, 1e-15, 9e-10])
@pytest.mark.parametrize("early", [False, True])
def test_a_tick_that_misses_its_time_by_a_rounding_ends_the_ping(miss, early):
    """Too late, the unit has ended it by itself: then the tick says nothing new."""
    with made(eventModeUsed=True, earlyReturnAllowed=early) as sensor:
        finish = fly(sensor)
        assert interval(sensor) == (finish, CHANGED)
        sensor.enterStepMode()
        time = 0.0
        while time < finish + miss:
            time = sensor.doStep(time, finish + miss - time)[3]
            sensor.enterEventMode()
            if time >= finish + miss:
                tick(sensor, "echo_clock")
            sensor.updateDiscreteStates()
            sensor.enterStepMode()
        assert sensor.get("sequence") == 1
        with made() as other:
            other.set("trigger", True)
            other.doStep(0.0, 0.1)
            assert outputs(sensor) == outputs(other)


def test_the_late_tick_of_one_ping_does_not_end_the_next(sensor):
    first = fly(sensor)
    interval(sensor)
    sensor.enterStepMode()
    sensor.doStep(0.0, first)
    sensor.enterEventMode()
    tick(sensor, "trigger_clock")
    second = sensor.updateDiscreteStates()[5]  # the first ends by itself, the second begins
    assert sensor.get("sequence") == 1
    tick(sensor, "echo_clock")
    assert sensor.updateDiscreteStates()[5] == second
    assert sensor.get("sequence") == 1


@pytest.mark.parametrize("miss", [-1e-6, -2e-3, 1e-3])
def test_a_tick_at_another_time_is_refused(sensor, miss):
    finish = fly(sensor)
    sensor.enterStepMode()
    time = 0.0
    while time < finish + miss:
        time = sensor.doStep(time, finish + miss - time)[3]
        sensor.enterEventMode()
        if time < finish + miss:
            sensor.updateDiscreteStates()
            sensor.enterStepMode()
    with pytest.raises(FMICallException):
        tick(sensor, "echo_clock")
    said = "allowed: at 0.0" if miss < 0.0 else "no tick of it is due"
    assert "echo_clock is set at 0.0" in sensor.log[-1][2]
    assert said in sensor.log[-1][2]


def test_a_saved_state_remembers_what_was_said(sensor):
    finish = fly(sensor)
    before = sensor.save()
    assert interval(sensor) == (finish, CHANGED)
    after = sensor.save()
    sensor.setFMUState(before)
    assert interval(sensor) == (finish, CHANGED)
    sensor.setFMUState(after)
    assert interval(sensor) == (finish, UNCHANGED)
    sensor.freeFMUState(before)
    sensor.freeFMUState(after)


def refuses(sensor: Raw, call, *words: str) -> None:
    lines = len(sensor.log)
    with pytest.raises(FMICallException):
        call()
    assert len(sensor.log) == lines + 1
    assert all(word in sensor.log[-1][2] for word in words), sensor.log[-1]


def test_what_clocks_cannot_do_is_refused_by_name(sensor):
    decimal, qualifier = (ctypes.c_double * 1)(), (ctypes.c_int * 1)()
    one, other = (ctypes.c_uint64 * 1)(1), (ctypes.c_uint64 * 1)(1)
    trigger, echo, position = map(reference, ("trigger_clock", "echo_clock", "position"))
    unknown = (ctypes.c_uint32 * 1)(70000)
    refuses(sensor, lambda: sensor.getClock(unknown), "fmi3GetClock", "unknown value reference 70000")
    refuses(sensor, lambda: sensor.setClock(unknown, [True]), "fmi3SetClock", "unknown value reference 70000")
    refuses(sensor, lambda: sensor.getClock(position), "fmi3GetClock: position is of type Float64")
    refuses(sensor, lambda: sensor.setClock(position, [True]), "fmi3SetClock: position is of type Float64")
    refuses(sensor, lambda: sensor.getBoolean(trigger), "fmi3GetBoolean: trigger_clock is of type Clock")
    refuses(sensor, lambda: tick(sensor, "echo_clock"), "fmi3SetClock: echo_clock", "no tick of it is due")
    refuses(
        sensor, lambda: sensor.getIntervalDecimal(trigger, decimal, qualifier), "trigger_clock is triggered", "interval"
    )
    refuses(sensor, lambda: sensor.getIntervalFraction(trigger, one, other, qualifier), "trigger_clock is triggered")
    refuses(sensor, lambda: sensor.getShiftDecimal(echo, decimal), "fmi3GetShiftDecimal: echo_clock is not periodic")
    refuses(sensor, lambda: sensor.getShiftFraction(echo, one, other), "fmi3GetShiftFraction: echo_clock")
    refuses(sensor, lambda: sensor.setIntervalDecimal(echo, decimal), "fmi3SetIntervalDecimal: echo_clock")
    refuses(sensor, lambda: sensor.setIntervalFraction(echo, one, other), "fmi3SetIntervalFraction: echo_clock")


@pytest.mark.parametrize("mode", ["Instantiated", "Initialization Mode", "Step Mode"])
def test_clocks_move_in_event_mode_only(mode):
    with Raw(SENSOR, "3.0", eventModeUsed=True) as sensor:
        if mode != "Instantiated":
            sensor.begin()
        if mode == "Step Mode":
            sensor.exitInitializationMode()
            sensor.updateDiscreteStates()
            sensor.enterStepMode()
        refuses(sensor, lambda: tick(sensor, "trigger_clock"), f"fmi3SetClock is not allowed in {mode}", "Event Mode")
        refuses(sensor, lambda: is_active(sensor, "echo_clock"), f"fmi3GetClock is not allowed in {mode}")


def test_without_event_mode_there_is_none_to_set_a_clock_in():
    with made() as sensor:
        refuses(sensor, lambda: tick(sensor, "trigger_clock"), "fmi3SetClock is not allowed in Step Mode")
        refuses(sensor, sensor.enterEventMode, "eventModeUsed = false")


def test_a_long_flight_is_told_as_a_decimal_only():
    """`time_out` may be an hour, and the latency a second: both are far below where a fraction would overflow."""
    with Raw(SENSOR, "3.0", eventModeUsed=True) as sensor:
        sensor.set("time_out", 3600.0)
        sensor.set("period", 0.0)
        sensor.begin()
        sensor.exitInitializationMode()
        finish = fly(sensor)
        assert finish == 3600.0
        assert interval(sensor) == (3600.0, CHANGED)
        assert interval(sensor, fraction=True) == (3600.0, UNCHANGED)


@pytest.mark.parametrize("version", VERSIONS)
def test_fmi_2_has_no_clocks(version):
    assert ("echo_clock" in variables_of(SENSOR, version)) == (version == "3.0")
