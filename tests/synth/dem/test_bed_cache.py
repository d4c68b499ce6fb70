"""A bed is settled once; a damaged one in the cache is made anew."""

import numpy as np
import pytest

from synth.dem import bed
from synth.dem.grains import Grains


@pytest.fixture
def prepared(monkeypatch, tmp_path):
    """Count beds made, of a few grains each."""
    made = []

    def prepare(scene, friction, progress):
        made.append(friction)
        position = np.random.default_rng(1).uniform(0, 0.1, (2, 50))
        return Grains.at_rest(position, np.full(50, 1e-3), 2000.0), 0.82

    monkeypatch.setenv("SOFTBED_CACHE", str(tmp_path))
    monkeypatch.setattr(bed, "_prepared", prepare)
    return made


@pytest.mark.parametrize("keep", [0, 1, 100, 2000])
def test_a_damaged_bed_is_made_anew(prepared, tiny_wheel, tmp_path, keep):
    first = bed.settled_bed(tiny_wheel)
    (path,) = (tmp_path / "beds").iterdir()
    assert path.stat().st_size > 2000
    path.write_bytes(path.read_bytes()[:keep])
    for _ in range(2):
        again = bed.settled_bed(tiny_wheel)
        np.testing.assert_array_equal(again.grains.position, first.grains.position)
        assert again.grains.density == first.grains.density and again.solid_fraction == first.solid_fraction
    assert len(prepared) == 2
