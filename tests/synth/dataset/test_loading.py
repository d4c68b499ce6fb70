"""What was made is read back: as NumPy arrays, by xarray, by PyTorch."""

import importlib.util
import json
import shutil
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import synth.dataset
from synth.dataset import DataSetError, load_data_set
from synth.footage import Footage


def test_pairs_are_those_of_the_footage_and_splits_are_kept(sand_set):
    data = load_data_set(sand_set)
    assert len(data.sequences) == 6 and data.manifest["name"] == "tiny"
    simulations = {
        split: {one.simulation for one in data.split(split)} for split in ("train", "validation", "test")
    }
    assert sum(map(len, simulations.values())) == len(set().union(*simulations.values())) == 3
    pairs = data.pairs("train")
    assert len(pairs) == 4 and len(pairs[:3]) == 3 and len(list(pairs)) == 4
    sequence, index = pairs.place(3)
    with Footage.open(sequence.folder) as footage:
        truth = footage.truth(index)
        np.testing.assert_array_equal(pairs[3].first, footage.picture(index))
        np.testing.assert_array_equal(pairs[3].second, footage.picture(index + 1))
    for component, name in enumerate("uv"):
        wanted = truth[name].where(truth["valid"])
        np.testing.assert_array_equal(pairs[3].flow[..., component], wanted)
    assert pairs[3].valid.any() and not pairs[3].valid.all() and pairs[3].soil.all()
    assert not pairs[3].implement.any() and pairs[3].mixed.dtype == bool
    assert sequence.scene().lens.blur == float(sequence.values["lens.blur"])


def test_the_second_picture_shows_what_the_flow_says(sand_set):
    from scipy.ndimage import map_coordinates

    sequence = load_data_set(sand_set).split("train")[0]
    pair = sequence.pair(0)
    y, x = np.mgrid[: pair.first.shape[0], : pair.first.shape[1]].astype(float)
    inside = pair.valid & (x > 4) & (x < x.max() - 4) & (y > 4) & (y < y.max() - 4)
    there = [y + pair.flow[..., 1], x + pair.flow[..., 0]]
    brought_back = map_coordinates(pair.second.astype(float), there, order=3)
    still = np.abs(pair.second.astype(float) - pair.first)[inside].mean()
    assert np.abs(brought_back - pair.first)[inside].mean() < still / 2


def test_a_pair_that_is_not_there_and_a_split_that_is_none(sand_set):
    data = load_data_set(sand_set)
    with pytest.raises(IndexError, match="pair = 2: allowed are 0 to 1"):
        data.sequences[0].pair(2)
    with pytest.raises(ValueError, match="split = 'eval': allowed are train, validation, test"):
        data.split("eval")


def test_xarray_reads_pictures_only_where_they_are_used(sand_set, monkeypatch):
    sequence = load_data_set(sand_set).sequences[0]
    read = []
    picture = Footage.picture
    monkeypatch.setattr(Footage, "picture", lambda self, frame: read.append(frame) or picture(self, frame))
    with sequence.to_xarray() as data:
        read.clear()
        assert data["picture"].sizes == {"frame": 3, "y": 64, "x": 96} and read == []
        part = data["picture"].isel(frame=2, y=slice(3, 9), x=slice(None, None, 2)).values
        assert read == [2] and part.shape == (6, 48)
        np.testing.assert_array_equal(part, sequence.pair(1).second[3:9, ::2])
        np.testing.assert_array_equal(data["picture"][1:].values[0], sequence.pair(1).first)
        assert data["picture"].isel(frame=[2, 0]).values.shape == (2, 64, 96)
        assert {"u", "v", "valid", "strain_rate"} <= set(data)
        assert data["u"].isel(pair=1).shape == (64, 96)


def test_another_schema_version_is_refused_with_a_hint(sand_set, tmp_path):
    copy = shutil.copytree(sand_set, tmp_path / "copy")
    manifest = json.loads((copy / "manifest.json").read_text())
    (copy / "manifest.json").write_text(json.dumps({**manifest, "schema_version": 2}))
    with pytest.raises(
        DataSetError, match=r"schema_version = 2: this program reads 1: use softbed .* anew with"
    ):
        load_data_set(copy)
    for versions in ({}, "lost"):
        told = {**manifest, "schema_version": 2, "versions": versions}
        (copy / "manifest.json").write_text(json.dumps(told))
        with pytest.raises(DataSetError, match="use softbed an unknown version, which made it"):
            load_data_set(copy)
    (copy / "manifest.json").write_text("{}")
    with pytest.raises(DataSetError, match="not a data set"):
        load_data_set(copy)
    with pytest.raises(DataSetError, match=r"holds no manifest\.json"):
        load_data_set(tmp_path)


@pytest.mark.parametrize("workers", [0, 2])
def test_pytorch_trains_on_it(sand_set, workers):
    torch = pytest.importorskip("torch")
    from synth.dataset import TorchPairs

    pairs = TorchPairs(sand_set, "train")
    loader = torch.utils.data.DataLoader(pairs, batch_size=2, num_workers=workers, shuffle=True)
    batches = list(loader)
    assert len(batches) == 2
    for batch in batches:
        assert batch["first"].shape == batch["second"].shape == (2, 1, 64, 96)
        assert batch["flow"].shape == (2, 2, 64, 96) and torch.isfinite(batch["flow"]).all()
        assert 0 < batch["first"].mean() < 1 and batch["first"].dtype == torch.float32
    known = load_data_set(sand_set).pairs("train")[0]
    sample = pairs[0]
    np.testing.assert_array_equal(sample["flow"].numpy()[:, known.valid], known.flow[known.valid].T)
    assert not sample["flow"].numpy()[:, ~known.valid].any()


@pytest.fixture
def torch_pairs(monkeypatch):
    """`synth.dataset.torch_pairs` beside a stand-in of torch whose tensors are NumPy's arrays."""
    torch, utils, data = (ModuleType(name) for name in ("torch", "torch.utils", "torch.utils.data"))
    torch.from_numpy, torch.utils, utils.data, data.Dataset = np.asarray, utils, data, object
    for module in (torch, utils, data):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    path = Path(synth.dataset.__file__).with_name("torch_pairs.py")
    spec = importlib.util.spec_from_file_location("torch_pairs_beside_a_stand_in", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.TorchPairs


def test_samples_for_pytorch_hold_what_the_pairs_do(torch_pairs, sand_set):
    pairs, known = torch_pairs(sand_set, "train"), load_data_set(sand_set).pairs("train")
    assert len(pairs) == len(known) == 4
    for sample, pair in zip([pairs[k] for k in range(4)], known, strict=True):
        assert set(sample) == {"first", "second", "flow", "valid", "soil", "mixed"}
        for name in ("first", "second"):
            assert sample[name].shape == (1, 64, 96) and sample[name].dtype == np.float32
            np.testing.assert_allclose(255 * sample[name][0], getattr(pair, name), atol=1e-4)
        assert sample["flow"].shape == (2, 64, 96) and sample["flow"].flags.c_contiguous
        np.testing.assert_array_equal(sample["flow"][:, pair.valid], pair.flow[pair.valid].T)
        assert not sample["flow"][:, ~pair.valid].any()
        for name in ("valid", "soil", "mixed"):
            np.testing.assert_array_equal(sample[name], getattr(pair, name))
    turned = torch_pairs(sand_set, "train", lambda sample: {"first": sample["second"]})
    np.testing.assert_array_equal(turned[1]["first"], pairs[1]["second"])


def test_without_pytorch_it_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    monkeypatch.delitem(sys.modules, "synth.dataset.torch_pairs", raising=False)
    with pytest.raises(ImportError, match="pip install torch"):
        from synth.dataset import TorchPairs  # noqa: F401
