import pytest

from synth.scene import SceneError, load_scene, load_soil
from synth.scene_files import scenes_folder, soil_names
from synth.soil import Published

PUBLISHED = Published(
    loosest_density=1600.0, densest_density=1890.0, loosest_friction_angle=30.0, densest_friction_angle=44.0
)


def test_relative_density_is_linear_in_the_void_ratio():
    assert PUBLISHED.relative_density(1600.0) == 0.0
    assert PUBLISHED.relative_density(1890.0) == 1.0
    grain = 2600.0
    loosest, densest, bed = (grain / density - 1 for density in (1600.0, 1890.0, 1700.0))
    assert PUBLISHED.relative_density(1700.0) == pytest.approx((loosest - bed) / (loosest - densest))
    assert PUBLISHED.friction_angle(0.25) == pytest.approx(33.5)


@pytest.mark.parametrize("name", soil_names())
def test_a_shipped_soil_is_within_what_is_published(name):
    soil = load_soil(name)
    assert 0 <= soil.published.relative_density(soil.bulk_density) <= 1


@pytest.mark.parametrize("name", soil_names())
def test_a_shipped_soil_is_calibrated(name):
    soil = load_soil(name)
    evidence = soil.evidence
    wanted = soil.published.friction_angle(soil.published.relative_density(soil.bulk_density))
    assert evidence["published_friction_angle"] == pytest.approx(wanted, abs=0.01)
    scatter = 2 * evidence["standard_error"]
    assert evidence["found_friction_angle"] == pytest.approx(wanted, abs=scatter)
    assert evidence["bulk_density_measured"] == pytest.approx(soil.bulk_density, rel=0.01)
    tried = {point["rolling_friction"] for point in evidence["biaxial"]}
    assert soil.contact.rolling_friction in tried
    assert soil.packing.is_of(soil.contact, 0.2)


def test_a_scene_may_name_a_soil_file_beside_it(tmp_path):
    text = (scenes_folder() / "soils" / "grc1.toml").read_text()
    (tmp_path / "mine.toml").write_text(text.replace("bulk_density = 1700.0", "bulk_density = 1650.0"))
    path = tmp_path / "scene.toml"
    path.write_text('base = "rolling_wheel"\nsoil = "mine.toml"\n')
    scene = load_scene(path)
    assert scene.soil.bulk_density == 1650.0
    assert "evidence" not in scene.to_dict()["soil"]
    (tmp_path / "mine.toml").write_text(text.replace("friction = 0.5  ", "friction = 5.0  "))
    with pytest.raises(SceneError, match=r"mine\.toml: contact\.friction = 5\.0"):
        load_scene(path)
    path.write_text('base = "rolling_wheel"\nsoil = "yours.toml"\n')
    with pytest.raises(SceneError, match=r"yours\.toml: No such file"):
        load_scene(path)
