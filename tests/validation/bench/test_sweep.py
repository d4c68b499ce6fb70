import pytest

pytest.importorskip("distributed")

from validation.bench.sweep import bench_sweep

CASE = {
    "scene": "sand_rotation",
    "quick": True,
    "vary": {"motion.angle": [0.01, 0.02], "camera.width": [64], "camera.height": [64]},
}


def test_rows_tell_rates_speed_up_size_and_the_cost_of_many():
    rows = {row.metric: row for row in bench_sweep(case=CASE)}
    one, two = (rows[f"sequences, {workers}"].value for workers in ("1 worker", "2 workers"))
    assert rows["speed-up, 1 to 2 workers"].value == pytest.approx(two / one)
    assert rows["10000 such sequences"].value == pytest.approx(2 * 10_000 / two)
    size = rows["size of a picture with its truth"].value
    assert 64 * 64 < size < 50 * 64 * 64
    assert rows["10000 such sequences, size"].value == pytest.approx(2 * 10_000 * size / 1e9)
    assert rows["pictures, 1 worker"].value > 0 and rows["bed, 1 worker"].value == 0
    assert "2 sequences, 2 x 64 x 64 px, 2 motions" in {row.case for row in rows.values()}
