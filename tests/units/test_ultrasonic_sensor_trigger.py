"""UltrasonicSensor: pings by trigger, and the latency before the burst."""

import pytest
from test_ultrasonic_sensor_pings import BALL, EXACT, NANOSECOND, WALL, outputs, ping, started


def run_with_trigger(edges: list[tuple[float, bool]], until: float, period: float, **values: float) -> int:
    """Number of pings finished when the trigger takes these values at these times [s]."""
    with started(period=period, **EXACT, **WALL, **values) as sensor:
        now = 0.0
        for time, value in edges:
            if time > now:
                sensor.step(now, time - now)
                now = time
            sensor.set("trigger", value)
        sensor.step(now, until - now)
        return sensor.get("sequence")


def test_without_period_only_rising_edges_start_pings():
    assert run_with_trigger([], 1.0, period=0.0) == 0
    assert run_with_trigger([(0.0, True)], 1.0, period=0.0) == 1
    assert run_with_trigger([(0.1, True), (0.3, False)], 1.0, period=0.0) == 1
    assert run_with_trigger([(0.1, True), (0.2, False), (0.3, True)], 1.0, period=0.0) == 2


def test_a_trigger_in_flight_is_lost():
    edges = [(0.1, True), (0.102, False), (0.103, True)]
    assert run_with_trigger(edges, 0.107, period=0.0) == 1  # the flight takes 5.8 ms and is not begun anew
    assert run_with_trigger(edges, 1.0, period=0.0) == 1


def test_a_trigger_at_the_very_end_of_a_flight_starts_the_next():
    end = ping(**EXACT, **WALL)["echo_width"]
    assert run_with_trigger([(0.0, True), (0.001, False), (end, True)], 1.0, period=0.0) == 2


def test_a_trigger_adds_a_ping_and_leaves_the_period_alone():
    assert run_with_trigger([], 0.29, period=0.1) == 3
    assert run_with_trigger([(0.05, True)], 0.29, period=0.1) == 4
    assert run_with_trigger([(0.05, True)], 0.099, period=0.1) == 2
    assert run_with_trigger([(0.098, True)], 0.29, period=0.1) == 3  # the one at 0.1 falls into its flight


# Between trigger and burst

LATENCY = 0.0021  # s


def test_the_burst_leaves_a_latency_after_the_trigger():
    alone = ping(**EXACT, **WALL)
    width = alone["echo_width"]
    with started(trigger_latency=LATENCY, **EXACT, **WALL) as sensor:
        sensor.step(0.0, LATENCY + width - NANOSECOND)
        assert sensor.get("sequence") == 0
        sensor.step(LATENCY + width - NANOSECOND, 2 * NANOSECOND)
        assert outputs(sensor) == alone  # the echo line rises with the burst: a width knows no latency


def test_a_moving_ball_is_met_where_it_is_when_the_burst_leaves():
    speed, approach = 343.98688734488263, 5.0  # m/s; the speed of sound is tested elsewhere
    moving = BALL | {"sphere_velocity": [-approach, 0.0, 0.0], "baseline": 0.0}
    seen = ping(trigger_latency=LATENCY, **EXACT, **moving)
    # 0.9 m less the way of the latency; they meet after distance / (c + approach), and the way back is as long
    expected = 2 * (0.9 - approach * LATENCY) / (speed + approach)
    assert seen["time_of_flight"] == pytest.approx(expected, rel=1e-14)


def test_what_moves_while_the_burst_waits_counts_where_it_then_is():
    near = WALL | {"plane_point": [0.6, 0.0, 0.0]}
    expected = ping(**EXACT, **near)
    with started(trigger_latency=LATENCY, **EXACT, **WALL) as sensor:
        sensor.step(0.0, LATENCY / 2)
        sensor.set("plane_point", [0.6, 0.0, 0.0])
        sensor.step(LATENCY / 2, 0.04)
        assert outputs(sensor) == expected


def test_while_a_burst_waits_no_other_ping_starts():
    end = LATENCY + ping(**EXACT, **WALL)["echo_width"]
    waits = [(0.0, True), (0.001, False), (0.0015, True)]
    assert run_with_trigger(waits, 1.0, period=0.0, trigger_latency=LATENCY) == 1
    after = [(0.0, True), (0.001, False), (end, True)]
    assert run_with_trigger(after, 1.0, period=0.0, trigger_latency=LATENCY) == 2
    # ticks at 0, 10, 20 ms; a burst every 12 ms at the soonest: each second tick falls into a wait or a flight
    assert run_with_trigger([], 0.0999, period=0.01, trigger_latency=0.012 - 0.0059) == 5
