import h5py
import numpy as np
import pytest

from synth.deflate import deflated_chunk

_GENERATOR = np.random.default_rng(4)
CASES = {
    "noise": _GENERATOR.normal(size=(40, 70)).astype(np.float32),
    "large": _GENERATOR.normal(size=(300, 400)).astype(np.float32),
    "constant": np.full((50, 60), np.nan, np.float32),
    "numbers": _GENERATOR.integers(-5, 9000, (33, 17), dtype=np.int32),
    "mask": _GENERATOR.integers(0, 2, (64, 48), dtype=np.int8),
}


@pytest.mark.parametrize("name", CASES)
def test_any_reader_of_hdf5_reads_the_same_values(tmp_path, name):
    values = CASES[name]
    with h5py.File(tmp_path / "file.h5", "w") as file:
        options = {"chunks": (1, *values.shape), "compression": "gzip", "shuffle": True}
        variable = file.create_dataset("values", (2, *values.shape), values.dtype, **options)
        variable.id.write_direct_chunk((1, 0, 0), deflated_chunk(values))
    with h5py.File(tmp_path / "file.h5") as file:
        assert file["values"][1].tobytes() == values.tobytes()


def test_what_repeats_is_small():
    assert len(deflated_chunk(CASES["constant"])) < CASES["constant"].nbytes / 50
    noise = CASES["noise"]
    assert len(deflated_chunk(noise)) < noise.nbytes
