"""`truth.nc` on disk."""

from pathlib import Path
from typing import TYPE_CHECKING, Self

from synth.deflate import deflated_chunk
from synth.disk import require_space
from synth.truth import CAMERA_VARIABLES, VARIABLES, PairTruth, file_attributes

if TYPE_CHECKING:
    import numpy as np

    from synth.scene import AnyScene

_BOOLEAN = {"dtype": "bool"}  # netCDF has none: xarray stores int8 with this attribute and reads bool back


class TruthWriter:
    """Writes `truth.nc` pair by pair, so that a sequence of any length needs the memory of one pair."""

    def __init__(self, path: Path, scene: "AnyScene", frame_times: "np.ndarray") -> None:
        import h5netcdf
        import numpy as np

        count = len(frame_times) - 1
        require_space(path, 0)
        self._path, self._file = path, h5netcdf.File(path, "w")
        self._file.attrs.update(file_attributes(scene))
        self._file.dimensions = {"pair": count, "y": scene.camera.height, "x": scene.camera.width}
        frames = np.arange(count + 1, dtype=np.int32)
        self._by_pair("first_frame", frames[:-1], "1", "index of the first frame")
        self._by_pair("second_frame", frames[1:], "1", "index of the second frame")
        times = np.asarray(frame_times[:-1], np.float64)
        self._by_pair("time", times, "s", "time of the first frame in the laboratory")
        for name, (unit, meaning) in CAMERA_VARIABLES.items():
            self._by_pair(name, np.full(count, np.nan), unit, meaning)
        for name, (dtype, unit, meaning) in VARIABLES.items():
            self._variable(name, dtype, unit, meaning)
        # h5netcdf has no way to write a chunk that is compressed already; h5py, below it, has.
        self._chunks = {name: self._file[name]._h5ds.id for name in VARIABLES}
        # Its own variables leave weak references behind, and an interrupt that meets one's end is lost.
        self._camera = {name: self._file[name]._h5ds for name in CAMERA_VARIABLES}

    def _by_pair(self, name: str, values: "np.ndarray", unit: str, meaning: str) -> None:
        variable = self._file.create_variable(name, ("pair",), data=values)
        variable.attrs.update({"units": unit, "long_name": meaning})

    def _variable(self, name: str, dtype: str, unit: str, meaning: str) -> None:
        shape = self._file.dimensions["y"].size, self._file.dimensions["x"].size
        variable = self._file.create_variable(
            name,
            ("pair", "y", "x"),
            "int8" if dtype == "bool" else dtype,
            chunks=(1, *shape),
            compression="gzip",
            compression_opts=1,
            shuffle=True,
        )
        coordinates = {"coordinates": "first_frame second_frame time"}
        boolean = _BOOLEAN if dtype == "bool" else {}
        variable.attrs.update({"units": unit, "long_name": meaning, **coordinates, **boolean})

    def write(self, pair: int, truth: PairTruth) -> None:
        """Write the truth of a pair."""
        chunks = {name: deflated_chunk(_stored(truth.arrays[name], name)) for name in VARIABLES}
        require_space(self._path, sum(map(len, chunks.values())))
        for name, values in self._camera.items():
            values[pair] = truth.camera[name]
        for name, chunk in chunks.items():
            self._chunks[name].write_direct_chunk((pair, 0, 0), chunk)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


def _stored(values: "np.ndarray", name: str) -> "np.ndarray":
    dtype, _, _ = VARIABLES[name]
    return values.astype("int8" if dtype == "bool" else dtype, copy=False)
