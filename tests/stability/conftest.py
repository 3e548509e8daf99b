"""One quick map for all tests of it."""

import pytest

from ulna.stability import measure


@pytest.fixture(scope="session")
def found() -> dict:
    return measure(quick=True)
