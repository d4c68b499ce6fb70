"""Whatever a file holds, its reader says what is wrong with it: no other error leaves it."""

import gzip
import json
import re
import shutil
import tomllib
from contextlib import contextmanager
from io import BytesIO

import cv2
import h5py
import numpy as np
import pytest
import tomli_w
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from soft import ImageSequence, SequenceError, SoilFlowError, check_soil_flow, read_soil_flow
from soft.flow import FlowError, FlowFiles
from soft.settings import AnalysisSettings, SettingsError, settings_template
from synth.dataset.members import members_of
from synth.dataset.sweep import SweepError, load_sweep
from synth.footage import Footage
from synth.recording import Recording
from synth.rover.law.catalogue import read_soil
from synth.rover.law.response import SoilError
from synth.scene import SceneError, load_scene, load_soil
from synth.scene_files import scenes_folder
from validation.check import check_folder
from validation.gate.measurement import GateError, Measurement
from validation.manifest import Manifest, RunFolderError
from validation.scoring.score import ScoreError, Scores
from validation.suites.kept import LINES, SHIPPED, KeptError, read_kept

NUMBERS = st.integers(-(2**70), 2**70) | st.floats() | st.sampled_from([0, 1, -1, 0.5, 1e-300, 1e300])
WORDS = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
PLACES = st.sampled_from(["../../etc/passwd", "/etc/passwd", "a/b", "", ".", "\0", "x.toml", "grc1"])
PLAIN = st.booleans() | NUMBERS | WORDS | PLACES
VALUES = st.recursive(
    PLAIN, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(WORDS, inner, max_size=3), max_leaves=6
)


def places_in(tables, before=()):
    """Keys that lead to every value."""
    inner = tables.items() if isinstance(tables, dict) else enumerate(tables)
    for key, value in inner:
        yield (*before, key)
        if isinstance(value, dict | list):
            yield from places_in(value, (*before, key))


def with_change(tables, place, change):
    """A copy with what is at a place replaced, or taken away where `change` is None."""
    changed = json.loads(json.dumps(tables))
    inner = changed
    for key in place[:-1]:
        inner = inner[key]
    if change is None:
        del inner[place[-1]]
    else:
        inner[place[-1]] = change[0]
    return changed


@st.composite
def changed(draw, tables):
    """Tables with one to three values replaced, removed or added."""
    for _ in range(draw(st.integers(1, 3))):
        places = list(places_in(tables))
        if not places:
            return tables
        place = draw(st.sampled_from(places))
        change = draw(st.none() | st.tuples(VALUES))
        if draw(st.booleans()) and isinstance(place[-1], str):
            place, change = (*place[:-1], draw(WORDS)), (draw(VALUES),)
        tables = with_change(tables, place, change)
    return tables


@st.composite
def damaged(draw, content):
    """Bytes cut short, with some of them changed, or others altogether."""
    kind = draw(st.sampled_from(["cut", "changed", "other"]))
    if kind == "other":
        return draw(st.binary(max_size=60))
    content = bytearray(content)
    if kind == "cut":
        return bytes(content[: draw(st.integers(0, len(content)))])
    for _ in range(draw(st.integers(1, 8))):
        content[draw(st.integers(0, len(content) - 1))] = draw(st.integers(0, 255))
    return bytes(content)


def read_toml(path):
    return tomllib.loads(path.read_text(encoding="utf-8"))


SCENES = {
    path.stem: read_toml(path)
    for path in sorted(scenes_folder().glob("*.toml"))
    if path.stem in ("rolling_wheel", "bucket", "plate_rotation", "shear_band", "compliant_wheel")
}
WHOLE = load_scene("rolling_wheel", quick=True).to_dict()
SOIL = read_toml(scenes_folder() / "soils" / "grc1.toml")
SWEEP = {
    "schema_version": 1,
    "name": "own",
    "scene": "sand_rotation",
    "quick": True,
    "design": {"kind": "sobol", "count": 4},
    "vary": {"motion.angle": {"low": 0.01, "high": 0.03}, "lens.blur": [0.5, 1.0]},
    "split": {"train": 0.8, "validation": 0.1, "test": 0.1},
}
SETTINGS = {
    **tomllib.loads(settings_template()),
    "region": {"x": 0, "y": 0, "width": 20, "height": 20},
    "calibration": {"scale_points": [[0, 0], [10, 0]], "scale_length": 0.1},
}


def assert_told(error, path):
    """One line that names the file."""
    assert str(path) in str(error), error


@given(st.sampled_from([*SCENES.values(), WHOLE]).flatmap(changed), st.booleans())
@settings(max_examples=80)
def test_scenes(tmp_path_factory, tables, quick):
    path = tmp_path_factory.getbasetemp() / "fuzzed.toml"
    path.write_text(tomli_w.dumps(tables), encoding="utf-8")
    try:
        scene = load_scene(path, quick=quick)
    except SceneError as error:
        assert_told(error, path)
    else:
        assert scene.hash


@given(changed(SOIL))
def test_soils(tmp_path_factory, tables):
    path = tmp_path_factory.getbasetemp() / "fuzzed.toml"
    path.write_text(tomli_w.dumps(tables), encoding="utf-8")
    try:
        load_soil(path)
    except SceneError as error:
        assert_told(error, path)


@given(changed(SWEEP))
def test_sweeps(tmp_path_factory, tables):
    path = tmp_path_factory.getbasetemp() / "fuzzed.toml"
    path.write_text(tomli_w.dumps(tables), encoding="utf-8")
    try:
        sweep, base = load_sweep(path)
        if (sweep.design.count or 0) < 100:
            members_of(sweep, base)
    except SweepError:
        pass


@given(changed(SETTINGS))
def test_settings(tmp_path_factory, tables):
    path = tmp_path_factory.getbasetemp() / "fuzzed.toml"
    path.write_text(tomli_w.dumps(tables), encoding="utf-8")
    try:
        AnalysisSettings.read(path)
    except SettingsError as error:
        assert_told(error, path)


@given(st.binary(max_size=80) | st.text(max_size=60).map(lambda text: text.encode("utf-8", "surrogatepass")))
@example(b"\xff\xfe")
@example(b"a = 1\na = 2")
@example(b"x = " + b"[" * 3000)
def test_what_is_no_toml(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "fuzzed.toml"
    path.write_bytes(content)
    for read, refusal in (
        (load_scene, SceneError),
        (load_soil, SceneError),
        (load_sweep, SweepError),
        (AnalysisSettings.read, SettingsError),
    ):
        try:
            read(path)
        except refusal as error:
            assert_told(error, path)


def picture_bytes(suffix, colour):
    noise = np.random.default_rng(1).integers(0, 256, (20, 30, *colour), np.uint8)
    return cv2.imencode(suffix, noise)[1].tobytes()


PICTURES = {
    (suffix, colour): picture_bytes(suffix, colour)
    for suffix in (".png", ".jpg", ".tif", ".bmp")
    for colour in ((), (3,))
}


@given(st.sampled_from(list(PICTURES)).flatmap(lambda k: st.tuples(st.just(k[0]), damaged(PICTURES[k]))))
@settings(max_examples=200)
def test_pictures_and_masks(tmp_path_factory, picture):
    suffix, content = picture
    folder = tmp_path_factory.mktemp("pictures")
    (folder / f"a1{suffix}").write_bytes(PICTURES[suffix, ()])
    (folder / f"a2{suffix}").write_bytes(content)
    try:
        frame = ImageSequence.open(folder)[1]
        assert frame.shape == (20, 30) and np.isfinite(frame).all()
    except SequenceError as error:
        assert_told(error, folder)
    try:
        (folder / f"a2{suffix}").write_bytes(PICTURES[suffix, ()])
        (folder / f"mask{suffix}").write_bytes(content)
        ImageSequence.open(folder)
    except SequenceError as error:
        assert_told(error, folder)
    try:
        (folder / f"mask{suffix}").rename(folder.parent / f"fuzzed-mask{suffix}")
        assert ImageSequence.open(folder).mask(folder.parent / f"fuzzed-mask{suffix}").usable(0).any() in (
            0,
            1,
        )
    except SequenceError as error:
        assert_told(error, folder.parent / "fuzzed-mask")


@pytest.fixture(scope="module")
def run(finished_run, tmp_path_factory):
    """A copy of a run folder; every test leaves it as it was."""
    return shutil.copytree(finished_run, tmp_path_factory.mktemp("fuzzed") / "run")


READERS = {
    "manifest.json": [(Manifest.read, RunFolderError)],
    "scores.json": [(lambda run: Scores.read(run / "scores.json"), ScoreError)],
    "scene.toml": [(lambda run: load_scene(run / "scene.toml"), SceneError)],
    "footage/sequence.toml": [
        (lambda run: read_footage(run / "footage"), ValueError),
        (lambda run: ImageSequence.open(run / "footage")[0], SequenceError),
    ],
    "footage/frames/000001.png": [(lambda run: read_footage(run / "footage"), ValueError)],
    "footage/truth.nc": [(lambda run: read_footage(run / "footage"), ValueError)],
    "recording.nc": [(lambda run: Recording.read(run / "recording.nc"), ValueError)],
    "analysis/dis.nc": [(lambda run: read_flow(run / "analysis" / "dis.nc"), SoilFlowError)],
}
"""Who reads a file of a run folder, and how it refuses."""
NETCDF = [name for name in READERS if name.endswith(".nc")]


def read_footage(folder):
    with Footage.open(folder) as footage:
        for pair in range(footage.pair_count):
            footage.picture(pair + 1)
            footage.truth(pair)


def read_flow(path):
    with read_soil_flow(path) as flow:
        check_soil_flow(flow, values=True)


def put(path, content):
    """Another file under the same name: HDF5 knows one that a failed reader left open by its inode."""
    aside = path.with_name(f"{path.name}.new")
    aside.write_bytes(content)
    aside.replace(path)


@contextmanager
def kept(path):
    """Put a file back as it was."""
    before = path.read_bytes()
    try:
        yield before
    finally:
        put(path, before)


def read_with(run, name, content):
    """Read a file of a run folder with another content: whole, or refused in a line that names it."""
    with kept(run / name):
        put(run / name, content)
        read_file(run, name)


def read_file(run, name):
    for read, refusal in READERS[name]:
        try:
            read(run)
        except refusal as error:
            assert_told(error, run)


@given(st.data())
@settings(max_examples=80)
def test_json_of_a_run(run, data):
    name = data.draw(st.sampled_from(["manifest.json", "scores.json"]))
    tables = data.draw(changed(json.loads((run / name).read_text())))
    read_with(run, name, json.dumps(tables).encode())


@given(st.data())
def test_toml_of_a_run(run, data):
    name = data.draw(st.sampled_from(["scene.toml", "footage/sequence.toml"]))
    tables = data.draw(changed(tomllib.loads((run / name).read_text())))
    read_with(run, name, tomli_w.dumps(tables).encode())


@given(st.data())
def test_damaged_files_of_a_run(run, data):
    name = data.draw(st.sampled_from([name for name in READERS if name not in NETCDF]))
    read_with(run, name, data.draw(damaged((run / name).read_bytes())))


@given(st.data())
@settings(max_examples=30)
def test_netcdf_cut_short(run, data):
    name = data.draw(st.sampled_from(NETCDF))
    content = (run / name).read_bytes()
    read_with(run, name, content[: data.draw(st.integers(0, len(content) - 1))])


ODD = {"text": "x", "path": "../../x", "number": 7, "numbers": np.array([1, 2]), "bytes": np.bytes_(b"\xff")}
EDITS = st.one_of(
    st.just(("remove",)),
    st.tuples(
        st.just("replace"),
        st.sampled_from([(), (2,), (1, 80, 96), (2, 3, 4)]),
        st.sampled_from(["f8", "i1", "S3", "u2", "c16"]),
    ),
    st.tuples(
        st.sampled_from(["attribute", "attribute of all"]),
        st.sampled_from(["schema_version", "units", "dtype", "coordinates", "frame", "method"]),
        st.none() | st.sampled_from(sorted(ODD)),
    ),
)


def edit(path, number, change):
    """Take away or replace a variable, or an attribute of it or of the whole, of a netCDF file."""
    kind, *what = change
    with h5py.File(path, "r+") as file:
        name = sorted(file)[number % len(file)]
        if kind in ("remove", "replace"):
            del file[name]
        if kind == "replace":
            file.create_dataset(name, data=np.ones(*what))
        elif kind != "remove":
            attributes = (file if kind == "attribute of all" else file[name]).attrs
            if what[1] is not None:
                attributes[what[0]] = ODD[what[1]]
            elif what[0] in attributes:
                del attributes[what[0]]


@given(st.sampled_from(NETCDF), st.integers(0, 30), EDITS)
@settings(max_examples=30)
def test_netcdf_edited(run, name, number, change):
    with kept(run / name) as before:
        put(run / name, before)
        edit(run / name, number, change)
        read_file(run, name)


@given(st.data())
@settings(max_examples=8)
def test_check_finds_faults_and_never_fails(run, data):
    name = data.draw(st.sampled_from([*READERS, "footage/SHA256SUMS"]))
    content = (run / name).read_bytes()
    if name in NETCDF:
        content = content[: data.draw(st.integers(0, len(content) - 1))]
    else:
        content = data.draw(damaged(content))
    with kept(run / name) as before:
        put(run / name, content)
        assert check_folder(run).faults or content == before


def flow_files():
    flo = b"PIEH" + np.array([3, 2], "<i4").tobytes() + np.ones(12, "<f4").tobytes()
    table = b"x,y,u,v\n1,1,0.5,0.25\n2,1,0.5,0.25\n1,2,0.5,0.25\n2,2,0.5,0.25\n"
    mat = BytesIO()
    x, y = np.meshgrid(np.arange(2.0), np.arange(2.0))
    cells = {name: np.array([a, a, None], object)[:2] for name, a in (("x", x), ("y", y), ("u", x), ("v", y))}
    savemat(mat, {f"{k}{'_original' * (k in 'uv')}": v for k, v in cells.items()})
    return {".flo": flo, ".csv": table, ".txt": table.replace(b",", b" "), ".mat": mat.getvalue()}


FLOW_FILES = flow_files()


@st.composite
def damaged_flow_file(draw):
    suffix = draw(st.sampled_from([suffix for suffix in FLOW_FILES if suffix != ".mat"]))
    return suffix, draw(damaged(FLOW_FILES[suffix]))


@given(damaged_flow_file())
@settings(max_examples=60)
def test_flow_measured_elsewhere(tmp_path_factory, file):
    read_flow_file(tmp_path_factory.mktemp("flow"), *file)


@given(damaged(FLOW_FILES[".mat"]))
@settings(max_examples=8)  # each starts a process
def test_flow_measured_with_matlab(tmp_path_factory, content):
    read_flow_file(tmp_path_factory.mktemp("flow"), ".mat", content)


@pytest.mark.parametrize(("place", "byte"), [(688, 242), (225, 171), (313, 35)])
def test_a_file_that_ends_its_reader_is_refused(tmp_path, place, byte):
    content = bytearray(FLOW_FILES[".mat"])
    content[place] = byte
    (tmp_path / "a.mat").write_bytes(content)
    with pytest.raises(FlowError, match=r"a\.mat: not a readable \.mat file: "):
        FlowFiles(tmp_path).read(0, (2, 3))


def read_flow_file(folder, suffix, content):
    (folder / f"a{suffix}").write_bytes(content)
    try:
        FlowFiles(folder).read(0, (2, 3))
    except FlowError as error:
        assert_told(error, folder)


SCORE = {"coverage": 1.0, "median": 0.1, "p95": 0.3, "wrong_share": 0.05}
ALONE = {
    "baseline.json": {
        "schema_version": 1,
        "method": "dis",
        "clips_digest": "a",
        "clips": {"band": [{"all": SCORE, "complex": SCORE}]},
        "versions": {"softbed": "1"},
    },
    "identification.json": {"soil": {"scale": 1.0, "surface_friction": 0.5, "stiffness": 2.0}},
    "about.json": {"schema_version": 1, "measured": 3, "of": 4},
}
"""JSON files that stand alone: what is needed of them."""
READ_ALONE = {
    "baseline.json": (Measurement.read, GateError),
    "identification.json": (read_soil, SoilError),
    "about.json": (lambda path: read_kept(path.parent), KeptError),
}
PYTHON = re.compile(
    r"NoneType|\bdict|\btuple\b|indices|argument|attribute|subscript|__init__|instance of|Error\b"
)


@given(st.data())
def test_json_files_that_stand_alone(tmp_path_factory, data):
    name = data.draw(st.sampled_from(list(ALONE)))
    tables = st.one_of(changed(ALONE[name]), VALUES).map(lambda told: json.dumps(told).encode())
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(data.draw(tables | damaged(json.dumps(ALONE[name]).encode())))
    read, refusal = READ_ALONE[name]
    try:
        read(path)
    except refusal as error:
        assert_told(error, path.parent)
        assert not PYTHON.search(str(error)), error


TABLE = b"".join(gzip.decompress((SHIPPED / LINES).read_bytes()).splitlines(keepends=True)[:3])


@given(st.one_of(damaged(TABLE).map(gzip.compress), damaged(gzip.compress(TABLE))))
@settings(max_examples=30)
def test_tables_that_were_kept(tmp_path_factory, content):
    folder = tmp_path_factory.getbasetemp() / "kept"
    if not folder.exists():
        shutil.copytree(SHIPPED, folder)
    (folder / LINES).write_bytes(content)
    try:
        read_kept(folder)
    except KeptError as error:
        assert_told(error, folder / LINES)
