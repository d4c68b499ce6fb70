"""The tests of a calibration on real grains, on small samples."""

import numpy as np
import pytest

from synth.dem import relative_density
from synth.dem.relative_density import SettlingRelation
from synth.devices import start_taichi
from synth.scene import load_soil
from validation.calibration import biaxial, plate
from validation.calibration.biaxial import measure_point
from validation.calibration.plate import press_plate

RELATION = SettlingRelation((0.0, 0.05, 0.1, 0.2, 0.4, 2.0), (0.19, 0.202, 0.211, 0.229, 0.255, 0.29))


def nothing(done, total):
    assert 0 <= done <= total


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    start_taichi()
    monkeypatch.setenv("SOFTBED_CACHE", str(tmp_path))


def point(rolling_friction, density, seeds):
    contact = load_soil("grc1").contact.model_copy(update={"rolling_friction": rolling_friction})
    return measure_point(contact, 0.2, RELATION, relative_density=density, seeds=seeds, progress=nothing)


def test_a_point_is_measured_once(own_cache, monkeypatch):
    monkeypatch.setattr(biaxial, "SIDE", 14)
    monkeypatch.setattr(relative_density, "SIDE", 14)
    monkeypatch.setattr(biaxial, "END", 0.02)
    first = point(0.3, 0.5, (1,))
    assert 0.1 < first.mean < 0.8
    assert 0.15 < first.void_ratio[0] < 0.35
    monkeypatch.setattr(biaxial, "compress", None)  # any new test would fail
    assert point(0.3, 0.5, (1,)) == first


@pytest.mark.slow
def test_what_resists_rolling_or_is_dense_is_stronger(own_cache):
    seeds = (1, 2)
    weak, strong = point(0.1, 0.4, seeds), point(0.8, 0.4, seeds)
    dense = point(0.1, 1.0, seeds)
    assert strong.mean > weak.mean + 0.1
    assert dense.mean > weak.mean + 0.02
    assert np.mean(dense.void_ratio) < np.mean(weak.void_ratio) - 0.02


@pytest.mark.slow
def test_a_plate_sinks_into_a_bed_of_the_soils_bulk_density(own_cache):
    soil = load_soil("grc1").soil
    curve = press_plate(soil, 0.2, settling_friction=0.3, seeds=(1,), progress=nothing)
    assert curve.bulk_density == pytest.approx(soil.bulk_density, rel=0.01)
    law = curve.fit()
    assert 0.3 < law.exponent < 1.8
    assert curve.pressure[-1] > 3 * curve.pressure[5] > 0
    assert len(curve.sinkage) == len(curve.pressure)
    assert curve.sinkage[-1] < plate.DEPTH
