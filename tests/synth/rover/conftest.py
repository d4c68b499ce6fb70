import pytest

from synth.rover.vehicle import load_vehicle


@pytest.fixture
def scarab():
    return load_vehicle("scarab")
