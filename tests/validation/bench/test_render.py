import numpy as np
import pytest

from synth.scene import load_scene, parse_scene
from validation.bench import render
from validation.bench.rolling_field import rolling_field


def test_the_recording_is_soil_around_a_wheel_that_sinks_and_turns_clockwise():
    scene = load_scene("rolling_wheel", quick=True)
    recording = rolling_field(scene, 3)
    data = recording.data
    away = np.hypot(data["position_x"] - data["implement_x"], data["position_z"] - data["implement_z"])
    assert float((away[0] - data["radius"]).min()) > scene.implement.radius
    assert float(data["implement_z"][0]) - scene.implement.radius < scene.bed.depth
    moved = np.hypot(*(np.diff(data[f"position_{axis}"].values[:2], axis=0)[0] for axis in "xz"))
    assert moved.max() > 0.4 * scene.drive.rim_speed / scene.timing.frame_rate
    assert moved[int(away[0].values.argmax())] < 0.01 * moved.max()
    under = int((np.abs(data["position_x"][0] - data["implement_x"][0]) + away[0]).values.argmin())
    assert data["implement_angle"][1] < 0
    assert float(data["position_x"][1, under] - data["position_x"][0, under]) < 0  # dragged backwards


def test_rows_tell_rate_grains_stages_and_memory(monkeypatch):
    scene = load_scene("rolling_wheel", quick=True).to_dict()
    scene["camera"] |= {"width": 128, "height": 96, "supersampling": 4}
    monkeypatch.setattr(render, "_scene", lambda sampling: parse_scene(scene))
    monkeypatch.setattr(render, "FRAME_COUNT", 3)
    rows = {row.metric: row for row in render.bench_render(supersampling=[4], repeats=2)}
    assert rows["pictures with truth"].value > 0
    assert rows["pictures with truth"].repeats == 2
    seen, hidden = rows["micro-grains that are seen"], rows["micro-grains in view, hidden ones too"]
    assert 0 < seen.value < hidden.value
    assert {"until the first picture", "covering", "lighting", "moving", "truth", "writing"} <= set(rows)
    assert 0 < rows["memory"].value < 16
    assert all(row.value == pytest.approx(row.value) and row.own for row in rows.values())
