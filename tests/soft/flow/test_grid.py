"""Grids of vectors measured elsewhere: every convention against a motion that is known."""

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from soft.flow import FlowError, FlowFiles, estimate_flow
from soft.flow.grid import Grid, GridConventions, to_field

SHAPE = (160, 220)
CENTRE = np.array([109.5, 79.5])
A = np.array([[1.01, -0.05], [0.04, 0.98]])
SHIFT = np.array([6.0, -4.0])


def forward(places):
    """Displacement of what is at `places` (.., 2) in the first picture."""
    return (places - CENTRE) @ A.T + CENTRE + SHIFT - places


def nodes(step=16, start=20.0):
    x, y = np.meshgrid(np.arange(start, 200, step), np.arange(start, 140, step))
    return np.stack([x, y], axis=-1)


def midpoint(places):
    """The same motion, of what is at `places` half-way."""
    # x + d(x) / 2 = place is linear in x.
    half = (A + np.eye(2)) / 2
    origin = np.linalg.solve(half, (places - CENTRE - SHIFT / 2).reshape(-1, 2).T).T.reshape(places.shape)
    return forward(origin + CENTRE)


def write(path, places, vectors, *, header="x,y,u,v", extra=None, separator=","):
    columns = [places[..., 0], places[..., 1], vectors[..., 0], vectors[..., 1], *(extra or [])]
    rows = np.stack([np.ravel(column) for column in columns], axis=1)
    lines = [separator.join(f"{value:.9g}" for value in row) for row in rows]
    path.write_text("\n".join([header, *lines]) + "\n")


def read(folder, **told):
    picture = np.random.default_rng(0).uniform(0, 255, SHAPE)
    return estimate_flow(picture, picture, method=f"files:{folder}", pair=0, **told)


def assert_right(field, count):
    """Every vector is the motion of the place that it says it was measured at."""
    assert field.valid.sum() == count
    assert field.displacement[field.valid] == pytest.approx(
        forward(field.nodes[field.valid].astype(float)), abs=2e-5
    )


class TestConventions:
    def test_forward_and_down_is_the_default_and_vectors_stay_at_their_nodes(self, tmp_path):
        write(tmp_path / "a.csv", nodes(), forward(nodes()))
        field = read(tmp_path)
        assert_right(field, nodes().size // 2)
        rows, columns = np.nonzero(field.valid)
        assert set(rows) == set(range(20, 140, 16)) and set(columns) == set(range(20, 200, 16))

    def test_nodes_between_pixels_are_held_by_the_nearest_and_keep_their_place(self, tmp_path):
        places = nodes(start=20.4)
        write(tmp_path / "a.csv", places, forward(places))
        field = read(tmp_path)
        assert_right(field, places.size // 2)
        assert field.nodes[20, 36] == pytest.approx([36.4, 20.4], abs=1e-5)

    def test_midpoint_vectors_go_to_where_the_motion_starts(self, tmp_path):
        write(tmp_path / "a.csv", nodes(), midpoint(nodes()))
        field = read(tmp_path, convention="midpoint")
        assert_right(field, nodes().size // 2)
        wrong = read(tmp_path)
        off = np.abs(wrong.displacement - forward(wrong.nodes))[wrong.valid].max()
        assert off > 0.1  # what confusing the two costs: half the displacement times the gradient

    def test_y_up_from_the_bottom(self, tmp_path):
        places, vectors = nodes(start=21.0), forward(nodes(start=21.0))
        up = np.stack([places[..., 0], SHAPE[0] - 1 - places[..., 1]], axis=-1)
        write(tmp_path / "a.csv", up, vectors * [1, -1])
        assert_right(read(tmp_path, y="up"), places.size // 2)

    def test_mirrored_as_openpiv_does(self, tmp_path):
        """Its rows are told in reverse order with the y of the others, and v is turned round."""
        places, vectors = nodes(), forward(nodes())
        mirrored = np.stack([places[..., 0], places[::-1, :, 1]], axis=-1)
        write(tmp_path / "a.txt", mirrored, vectors * [1, -1], header="# x\ty\tu\tv", separator="\t")
        assert_right(read(tmp_path, y="mirrored"), places.size // 2)

    @pytest.mark.parametrize("origin", [1.0, 0.5])
    @pytest.mark.parametrize("y", ["down", "up"])
    def test_origin_is_the_first_pixels_centre(self, tmp_path, origin, y):
        places, vectors = nodes(), forward(nodes())
        told = places.copy()
        if y == "up":
            told[..., 1] = SHAPE[0] - 1 - told[..., 1]
            vectors = vectors * [1, -1]
        write(tmp_path / "a.csv", told + origin, vectors)
        assert_right(read(tmp_path, origin=origin, y=y), places.size // 2)

    def test_the_folder_may_tell_and_options_win(self, tmp_path):
        write(tmp_path / "a.csv", nodes() + 1, midpoint(nodes()))
        (tmp_path / "grid.toml").write_text('convention = "midpoint"\norigin = 1\n')
        assert_right(read(tmp_path), nodes().size // 2)
        assert FlowFiles(tmp_path).sources == [tmp_path / "a.csv", tmp_path / "grid.toml"]
        assert FlowFiles(tmp_path).conventions({"origin": 0.0}) == GridConventions("midpoint", "down", 0.0)


class TestNodes:
    def test_two_in_a_pixel_the_measured_then_the_nearer_stays(self):
        x, y = np.array([10.4, 10.1, 30.1, 30.4]), np.full(4, 20.0)
        grid = Grid(x, y, np.arange(4.0), np.zeros(4), np.array([True, True, False, True]))
        field = to_field(grid, GridConventions(), SHAPE, name="it")
        assert field.displacement[20, 10, 0] == 1.0 and field.displacement[20, 30, 0] == 3.0
        assert field.valid.sum() == 2

    def test_what_was_not_measured_is_a_node_without_a_vector(self, tmp_path):
        vectors, flags = forward(nodes()), np.zeros(nodes().shape[:2])
        flags[2, 3] = 1
        vectors[4, 5] = np.nan
        write(tmp_path / "a.csv", nodes(), vectors, header="x,y,u,v,flags", extra=[flags])
        field = read(tmp_path)
        assert field.valid.sum() == flags.size - 2
        assert np.isfinite(field.nodes).all(axis=2).sum() == flags.size
        assert not field.valid[20 + 32, 20 + 48] and not field.valid[20 + 64, 20 + 80]

    def test_mask_and_leaving_the_picture_hold_as_elsewhere(self, tmp_path):
        write(tmp_path / "a.csv", nodes(), np.full(nodes().shape, 70.0))
        picture, mask = np.full(SHAPE, 9.0), np.ones(SHAPE, bool)
        mask[:, :60] = False
        field = estimate_flow(picture, picture, method=f"files:{tmp_path}", pair=0, mask=mask)
        rows, columns = np.nonzero(field.valid)
        assert columns.min() == 68 and columns.max() == 148 and rows.max() == 84


class TestText:
    def test_openpiv(self, tmp_path):
        zero = np.zeros(nodes().shape[:2])
        flags, mask = zero.copy(), zero.copy()
        flags[0, 0], mask[0, 1] = 1, 1
        header = "# x\ty\tu\tv\tflags\tmask"
        write(
            tmp_path / "a.txt", nodes(), forward(nodes()), header=header, extra=[flags, mask], separator="\t"
        )
        assert_right(read(tmp_path), flags.size - 2)

    def test_pivlab(self, tmp_path):
        kind = np.ones(nodes().shape[:2])
        kind[0, 0], kind[0, 1] = 0, 2
        header = (
            "PIVlab, ASCII chart output - 01-Jan-2020\n"
            "FRAME: 1, filenames: A.png & B.png, conversion factor xy (px -> m): 1\n"
            "x [px],y [px],u [px/frame],v [px/frame],Vector type [-]"
        )
        write(tmp_path / "a.txt", nodes() + 1, forward(nodes()), header=header, extra=[kind])
        assert_right(read(tmp_path, origin=1.0), kind.size - 2)

    def test_blanks_comments_and_other_columns(self, tmp_path):
        (tmp_path / "a.txt").write_text(
            "% made by hand\n  s2n   x  y (px)  u  v\n\n 1.5  30 40 1.25 -2\n# a remark\n 9 50 40 nan 1\n"
        )
        field = read(tmp_path)
        assert field.displacement[40, 30] == pytest.approx([1.25, -2])
        assert field.valid.sum() == 1 and np.isfinite(field.nodes[40, 50]).all()

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("1,2,3,4\n", "no header that names the columns x, y, u, v"),
            ("", "no header"),
            ("x,y,u\n1,2,3\n", "no header"),
            ("x [m],y [m],u [m/s],v [m/s]\n1,2,3,4\n", r"x in m: must be px"),
            ("x,y,u,v\n1,2,3\n", "line 2: 3 columns: the header names 4"),
            ("x,y,u,v\n1,2,three,4\n", "line 2: '1,2,three,4': must be numbers"),
            ("x,y,u,v\n", "holds no vectors"),
            ("x,y,u,v\n,2,3,4\n", "x or y is not a number"),
            ("x,y,u,v\n500,2,3,4\n", "x = 500 to 500 px, .* must lie in the picture, 0 to 219"),
            ("x,y,u,v\n5,-2,3,4\n", "y = -2 to -2 px"),
        ],
    )
    def test_wrong_files(self, tmp_path, text, message):
        (tmp_path / "a.csv").write_text(text)
        with pytest.raises(FlowError, match=message) as refused:
            read(tmp_path)
        assert "\n" not in str(refused.value)

    def test_not_text(self, tmp_path):
        (tmp_path / "a.csv").write_bytes(bytes(range(256)))
        with pytest.raises(FlowError, match="cannot be read as text"):
            read(tmp_path)


def cells(*arrays):
    made = np.empty((len(arrays), 1), object)
    made[:, 0] = arrays
    return made


class TestMat:
    def session(self, path, **changed):
        """Two pairs as PIVlab keeps them: pixels counted from 1; the second pair was not filtered."""
        x, y = np.moveaxis(nodes() + 1, -1, 0)
        u, v = np.moveaxis(forward(nodes()), -1, 0)
        kind = np.ones(x.shape)
        kind[1, 1], kind[1, 2] = 0, 2
        none = np.zeros((0, 0))
        content = {
            "x": cells(x, x),
            "y": cells(y, y),
            "u_original": cells(u + 5, u),
            "v_original": cells(v + 5, v),
            "u_filtered": cells(u, none),
            "v_filtered": cells(v, none),
            "typevector_original": cells(np.ones(x.shape), np.ones(x.shape)),
            "typevector_filtered": cells(kind, none),
            "calxy": 1.0,
            "calu": 1.0,
            "calv": 1.0,
        }
        savemat(path, content | changed)
        return x.size

    def test_pivlab_session(self, tmp_path):
        count = self.session(tmp_path / "session.mat")
        assert len(FlowFiles(tmp_path)) == 2
        picture = np.full(SHAPE, 9.0)
        for pair, measured in ((0, count - 2), (1, count)):
            assert_right(estimate_flow(picture, picture, method=f"files:{tmp_path}", pair=pair), measured)
        with pytest.raises(FlowError, match=r"1 \.mat files with 2 pairs: none for pair 2"):
            estimate_flow(picture, picture, method=f"files:{tmp_path}", pair=2)

    def test_one_pair_a_file_as_plain_arrays(self, tmp_path):
        x, y = np.moveaxis(nodes() + 1, -1, 0)
        u, v = np.moveaxis(forward(nodes()), -1, 0)
        savemat(tmp_path / "a2.mat", {"x": x, "y": y, "u": u, "v": v})
        savemat(tmp_path / "a10.mat", {"x": x[0], "y": y[:, 0], "u": u, "v": v})
        picture = np.full(SHAPE, 9.0)
        for pair in (0, 1):
            assert_right(estimate_flow(picture, picture, method=f"files:{tmp_path}", pair=pair), x.size)

    @pytest.mark.parametrize(
        ("changed", "message"),
        [
            ({"calxy": 2e-4}, "calxy = 0.0002: must be px"),
            ({"calu": 0.01}, "calu = 0.01: must be px"),
            (
                {"u_filtered": cells(np.zeros((3, 3)), np.zeros((3, 3)))},
                r"x: shape .*: u_filtered has \(3, 3\)",
            ),
            ({"u_filtered": 0.0, "u_original": 0.0}, r"shape"),
            ({"x": cells("text", "text")}, "x: must hold real numbers for pair 0"),
        ],
    )
    def test_wrong_content(self, tmp_path, changed, message):
        self.session(tmp_path / "session.mat", **changed)
        with pytest.raises(FlowError, match=message):
            read(tmp_path)

    def test_no_vectors(self, tmp_path):
        savemat(tmp_path / "a.mat", {"x": np.ones(3), "y": np.ones(3), "velocity": np.ones(3)})
        with pytest.raises(FlowError, match=r"no vectors of pair 0 in .*: holds velocity, x, y"):
            read(tmp_path)
        savemat(tmp_path / "a.mat", {"u": np.ones(3)})
        with pytest.raises(FlowError, match="no variable x"):
            read(tmp_path)

    def test_version_73_is_read_alike(self, tmp_path):
        self.session(tmp_path / "old.mat")
        old = loadmat(tmp_path / "old.mat", appendmat=False)
        (tmp_path / "old.mat").unlink()
        write_73(tmp_path / "session.mat", {name: v for name, v in old.items() if not name.startswith("__")})
        picture = np.full(SHAPE, 9.0)
        for pair, measured in ((0, nodes()[..., 0].size - 2), (1, nodes()[..., 0].size)):
            assert_right(estimate_flow(picture, picture, method=f"files:{tmp_path}", pair=pair), measured)

    def test_damage_is_refused(self, tmp_path):
        path = tmp_path / "a.mat"
        write_73(path, {"x": np.ones(3)})
        content = path.read_bytes()
        for damaged in (content[:900], b"nonsense" * 99, b""):
            path.write_bytes(damaged)
            with pytest.raises(FlowError, match=r"a\.mat: not a readable"):
                read(tmp_path)


def write_73(path, content):
    """A file as MATLAB writes its version 7.3: text, then HDF5, axes in reverse and cells by reference."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in content.items():
            if value.dtype != object:
                file[name] = value.T
                continue
            references = np.empty(value.T.shape, h5py.ref_dtype)
            for place, cell in np.ndenumerate(value.T):
                kept = f"#refs#/{name}{place[1]}"
                file[kept] = cell.T if cell.size else np.array(cell.shape, np.uint64)
                if not cell.size:
                    file[kept].attrs["MATLAB_empty"] = np.uint8(1)
                references[place] = file[kept].ref
            file.create_dataset(name, data=references, dtype=h5py.ref_dtype)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(512, b" "))


class TestGeoPiv:
    """Subsets followed over three pictures, pixels counted from 1."""

    def tracks(self, path, writer=savemat, *, steps=2, **changed):
        places = [nodes().reshape(-1, 2)]
        for _ in range(steps):
            places.append(places[-1] + forward(places[-1]))
        data = np.ones((len(places[0]), 2 + steps, 3))
        data[:, 0] = np.arange(1, 1 + len(data))[:, None]
        data[:, 1:, :2] = np.stack(places, axis=1) + 1
        data[3, 2, :2] = np.nan  # lost in the second picture
        writer(path, {"data": data} | changed)
        return len(data)

    @pytest.mark.parametrize("version", ["7", "7.3"])
    def test_pairs_of_places(self, tmp_path, version):
        count = self.tracks(tmp_path / "M2_data.mat", savemat if version == "7" else write_73)
        assert len(FlowFiles(tmp_path)) == 2
        picture = np.full(SHAPE, 9.0)
        first, second = (
            estimate_flow(picture, picture, method=f"files:{tmp_path}", pair=pair) for pair in (0, 1)
        )
        assert_right(first, count - 1)
        assert (
            first.nodes[20, 68] == pytest.approx([68, 20]) and not first.valid[20, 68]
        )  # lost, but was there
        assert_right(second, count - 1)
        with pytest.raises(FlowError, match=r"1 \.mat files with 2 pairs: none for pair 2"):
            estimate_flow(picture, picture, method=f"files:{tmp_path}", pair=2)

    @pytest.mark.parametrize(
        ("data", "message"),
        [
            (
                np.ones((5, 3)),
                r"data: float64 of shape \(5, 3\): must be numbers, subsets x",
            ),
            (np.ones((5, 2, 3)), "of two pictures at least"),
            (np.ones((5, 3, 3)), "first column: must be the subsets' numbers, each once"),
            (np.random.default_rng(0).uniform(0, 9, (5, 3, 3)), "first column"),
        ],
    )
    def test_wrong_content(self, tmp_path, data, message):
        savemat(tmp_path / "a.mat", {"data": data})
        with pytest.raises(FlowError, match=message):
            read(tmp_path)


class TestFolder:
    @pytest.mark.parametrize(
        ("told", "message"),
        [
            ({"convention": "central"}, "convention: 'central': allowed are forward, midpoint"),
            ({"y": "flipped"}, "y: 'flipped': allowed are down, up, mirrored"),
            ({"origin": "left"}, "origin: 'left': must be a number"),
            ({"scale": 2}, "unknown option scale: allowed are pair, convention, y, origin"),
        ],
    )
    def test_impossible_conventions(self, tmp_path, told, message):
        write(tmp_path / "a.csv", nodes(), forward(nodes()))
        with pytest.raises(FlowError, match=message):
            read(tmp_path, **told)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("y = up", "not readable TOML"),
            ("axis = 1", "unknown option axis"),
            ("y = 1", "y: 1: allowed are"),
        ],
    )
    def test_impossible_grid_toml(self, tmp_path, text, message):
        write(tmp_path / "a.csv", nodes(), forward(nodes()))
        (tmp_path / "grid.toml").write_text(text)
        with pytest.raises(FlowError, match=message):
            read(tmp_path)

    def test_one_kind_of_file(self, tmp_path):
        with pytest.raises(FlowError, match=r"holds no \.flo, \.csv, \.txt or \.mat file"):
            FlowFiles(tmp_path)
        for name in ("a.csv", "b.txt"):
            write(tmp_path / name, nodes(), forward(nodes()))
        with pytest.raises(FlowError, match=r"holds \.csv and \.txt files: must be of one kind"):
            FlowFiles(tmp_path)

    def test_dense_files_have_no_conventions(self, tmp_path):
        from soft.flow import write_flo

        write_flo(tmp_path / "a.flo", np.zeros((*SHAPE, 2)))
        with pytest.raises(FlowError, match=r"convention: not for \.flo files"):
            read(tmp_path, convention="midpoint")
