"""One quick map of each kind for all tests of it."""

import pytest

from ulna.stability import measure, measure_coupling, measure_sensor, measure_skin


@pytest.fixture(scope="session")
def found() -> dict:
    return measure(quick=True)


@pytest.fixture(scope="session")
def coupled() -> dict:
    return measure_coupling(quick=True)


@pytest.fixture(scope="session")
def skins() -> dict:
    return measure_skin(quick=True)


@pytest.fixture(scope="session")
def sensed() -> dict:
    return measure_sensor(quick=True)
