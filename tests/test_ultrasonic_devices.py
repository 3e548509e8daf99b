"""The real devices' parameters are taken by the unit, and read a wall as the devices would."""

import pytest

import ulna


@pytest.mark.parametrize("name", ulna.devices)
def test_a_device_reads_a_wall_at_a_metre(name):
    scene = ulna.Scene("wall")
    ears = scene.add("UltrasonicSensor", "ears", **ulna.devices[name])
    ears.set("plane_point", [1.0, 0.0, 0.0])
    ears.set("plane_normal", [-1.0, 0.0, 0.0])
    results = scene.run(until=0.2, step=0.01)
    step = ulna.devices[name]["resolution"]
    # to half a step, and up to 11 mm that the threshold walk and 20 C take
    assert results["ears.device_distance"][-1] == pytest.approx(1.005, abs=0.008 + step / 2)
    assert results["ears.distance"][-1] == pytest.approx(1.0, abs=1e-12 + step / 2)


def test_the_line_of_an_hc_sr04_falls_after_38_milliseconds():
    scene = ulna.Scene("nothing")
    scene.add("UltrasonicSensor", "ears", **ulna.devices["HC-SR04"])
    results = scene.run(until=0.2, step=0.01)
    assert results["ears.echo_width"][-1] == 0.038
    assert not results["ears.valid"][-1]
