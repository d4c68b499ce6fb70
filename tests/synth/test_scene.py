import math
import re
import tomllib

import pytest

from synth.scene import SceneError, load_scene, parse_scene
from synth.scene_files import scene_names, scenes_folder

SHIPPED = sorted(scenes_folder().rglob("*.toml"))


@pytest.mark.parametrize("name", scene_names())
@pytest.mark.parametrize("quick", [False, True])
def test_resolved_scene_reads_back_equal(tmp_path, name, quick):
    scene = load_scene(name, quick=quick, seed=7)
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    again = load_scene(path)
    assert again == scene
    assert again.hash == scene.hash
    assert (again.quick, again.seed) == (quick, 7)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.name)
def test_every_number_of_a_shipped_file_says_where_it_comes_from(path):
    for line in path.read_text().splitlines():
        number = re.match(r"(\w+) = [-+0-9.]", line)
        if number and number.group(1) not in {"schema_version", "seed"}:
            assert re.search(r"#.*\w", line), f"{path.name}: {line}"


def test_rolling_wheel_is_the_papers():
    scene = load_scene("rolling_wheel")
    assert scene.implement.radius == 0.114
    assert scene.drive.carriage_speed == pytest.approx(0.008)
    assert (scene.camera.height, scene.camera.width, scene.camera.metres_per_pixel) == (600, 1200, 0.2e-3)
    assert (scene.timing.frame_rate, scene.timing.frame_count) == (8.0, 101)


def test_plate_corners_move_as_published():
    scene = load_scene("plate_rotation")
    corner = math.hypot(scene.camera.width / 2, scene.camera.height / 2)
    assert corner * scene.implement.rotation == pytest.approx(15.6, abs=0.05)


def test_quick_rolling_wheel_is_still_fine_grained():
    scene = load_scene("rolling_wheel", quick=True)
    grain = math.pi / 4 * scene.bed.grain_diameter**2 * (1 + scene.bed.polydispersity**2 / 3)
    assert 0.79 * scene.bed.width * scene.bed.depth / grain >= 10_000
    assert scene.camera.metres_per_pixel == 0.2e-3


def test_pictures_do_not_change_the_simulation_hash():
    tables = load_scene("rolling_wheel").to_dict()
    other = {**tables, "sensor": {**tables["sensor"], "read_noise": 20.0}}
    assert parse_scene(other).simulation_hash == parse_scene(tables).simulation_hash
    assert parse_scene(other).hash != parse_scene(tables).hash
    darker = {**tables, "soil": {**tables["soil"], "look": {"albedo": 0.3, "albedo_deviation": 0.1}}}
    assert parse_scene(darker).simulation_hash == parse_scene(tables).simulation_hash
    assert parse_scene(darker).hash != parse_scene(tables).hash
    repainted = parse_scene({**tables, "picture_seed": 7})
    assert repainted.simulation_hash == parse_scene(tables).simulation_hash
    assert repainted.hash != parse_scene(tables).hash
    assert (repainted.seed_of_pictures, parse_scene(tables).seed_of_pictures) == (7, 0)
    assert parse_scene({**tables, "seed": 1}).simulation_hash != parse_scene(tables).simulation_hash


@pytest.mark.parametrize(
    ("table", "key", "value", "says"),
    [
        ("bed", "width", -1, r"bed.width = -1: .*greater than 0"),
        ("bed", "width", 0.2, r"must stay between the end walls.*bed.width = 0.2"),
        ("bed", "wdith", 1, r"bed.wdith = 1: unknown key, allowed are coarsening, .*, width$"),
        ("bed", "grain_diameter", math.nan, r"bed.grain_diameter = nan: .*finite"),
        (
            "contact",
            "steps_per_contact",
            10,
            r"contact.steps_per_contact = 10: .*greater than or equal to 15",
        ),
        ("drive", "slip", 1.0, r"drive.slip = 1.0: .*less than 1"),
        ("sensor", "bits", 12, r"sensor.bits = 12: .*8 or 16"),
        (None, "soil", "mars", r"soil = 'mars': allowed .*grc1"),
        (None, "kind", "bath", r"kind = 'bath': .*soil_bin.*plate_rotation"),
        ("drive", "kind", "flying", r"drive.kind = 'flying': .*'rolling', 'pushing', 'cutting'"),
        ("implement", "kind", "sledge", r"implement.kind = 'sledge': .*'rigid_wheel'"),
        (None, "name", "../x", r"name = '../x'"),
    ],
)
def test_error_names_key_value_and_what_is_allowed(table, key, value, says):
    tables = load_scene("rolling_wheel").to_dict()
    (tables[table] if table else tables)[key] = value
    with pytest.raises(SceneError, match=rf"^file.toml: .*{says}") as caught:
        parse_scene(tables, source="file.toml")
    assert "\n" not in str(caught.value)


def test_missing_key_and_missing_kind():
    tables = load_scene("rolling_wheel").to_dict()
    del tables["bed"]["depth"]
    with pytest.raises(SceneError, match=r"bed.depth: missing"):
        parse_scene(tables)
    del tables["kind"]
    with pytest.raises(SceneError, match=r"kind: missing"):
        parse_scene(tables)


@pytest.mark.parametrize("text", ["= 3", "\xff", "quick = 3\nkind = 'soil_bin'"])
def test_file_that_is_no_scene(tmp_path, text):
    path = tmp_path / "bad.toml"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(SceneError, match=r"bad\.toml"):
        load_scene(path, quick=True)


def test_missing_file_and_unknown_name_list_what_is_shipped():
    for name in ("nowhere.toml", "nonsense", "../plate_rotation"):
        with pytest.raises(SceneError, match=r"plate_rotation, .*rolling_wheel"):
            load_scene(name)


def test_unknown_key_in_quick_is_refused(tmp_path):
    text = (scenes_folder() / "rolling_wheel.toml").read_text()
    tomllib.loads(text)
    path = tmp_path / "x.toml"
    path.write_text(text + "\n[quick.lens]\nsmear = 1.0\n")
    for quick in (False, True):  # told at once, asked for or not
        with pytest.raises(SceneError, match=r"\[quick\]: lens\.smear = 1\.0: unknown key"):
            load_scene(path, quick=quick)


def test_a_fault_that_the_quick_version_would_hide_is_told(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('base = "rolling_wheel"\n[bed]\ngrain_diameter = -1.0\n')
    for quick in (False, True):
        with pytest.raises(SceneError, match=r"mine\.toml: bed\.grain_diameter = -1\.0: "):
            load_scene(path, quick=quick)


def test_quick_cannot_be_asked_of_a_resolved_full_scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(load_scene("rolling_wheel").to_toml())
    with pytest.raises(SceneError, match=r"scene\.toml: quick: this scene has no \[quick\] table"):
        load_scene(path, quick=True)


@pytest.mark.parametrize("seed", ["true", "'5'", "-1", "1.5"])
def test_a_seed_is_a_whole_number(tmp_path, seed):
    path = tmp_path / "x.toml"
    path.write_text(f'base = "rolling_wheel"\nseed = {seed}\n')
    with pytest.raises(SceneError, match="seed"):
        load_scene(path)


def test_a_scene_may_build_on_a_shipped_one(tmp_path):
    path = tmp_path / "mixed.toml"
    path.write_text('base = "rolling_wheel"\nname = "mixed"\n[bed]\npolydispersity = 0.25\n')
    scene, base = load_scene(path).to_dict(), load_scene("rolling_wheel").to_dict()
    assert (scene.pop("name"), scene["bed"].pop("polydispersity")) == ("mixed", 0.25)
    del base["name"], base["bed"]["polydispersity"]
    assert scene == base


def test_a_table_of_another_kind_replaces_that_of_the_base(tmp_path):
    assert load_scene("pushed_wheel").drive.kind == "pushing"
    assert load_scene("pushed_wheel", quick=True).drive.start == 0.22
    path = tmp_path / "x.toml"
    path.write_text('base = "mars"\n')
    with pytest.raises(SceneError, match=r"x\.toml: base = 'mars': allowed are .*rolling_wheel"):
        load_scene(path)


@pytest.mark.parametrize("name", scene_names())
@pytest.mark.parametrize("quick", [False, True])
def test_every_shipped_scene_can_be_a_base(tmp_path, name, quick):
    path = tmp_path / "own.toml"
    path.write_text(f'base = "{name}"\n')
    if quick and "quick" not in merged_keys(name):
        with pytest.raises(SceneError, match=r"no \[quick\] table"):
            load_scene(path, quick=True)
    else:
        assert load_scene(path, quick=quick) == load_scene(name, quick=quick)


def merged_keys(name):
    """Keys of a shipped scene's file and of those it is based on."""
    tables = tomllib.loads((scenes_folder() / f"{name}.toml").read_text())
    return set(tables) | (merged_keys(tables["base"]) if "base" in tables else set())


def test_values_of_a_base_come_before_those_of_its_own_base(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(
        'base = "pushed_wheel"\nname = "own"\n[drive]\nspeed = 0.005\n[quick.sensor]\nread_noise = 7.0\n'
    )
    full, quick = load_scene(path), load_scene(path, quick=True)
    between, first = load_scene("pushed_wheel"), load_scene("rolling_wheel")
    assert full.drive == between.drive.model_copy(update={"speed": 0.005}) != first.drive
    assert full.contact == between.contact
    assert quick.sensor.read_noise == 7.0 != full.sensor.read_noise
    assert quick.drive == load_scene("pushed_wheel", quick=True).drive.model_copy(update={"speed": 0.005})
