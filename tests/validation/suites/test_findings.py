"""Tables that are kept tell what was measured, docs tell what the tables do, and own methods join."""

import gzip
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from validation.cli import run_command
from validation.markdown_tables import UnknownTableError
from validation.suites import complex_flow, findings_figures
from validation.suites.execution import carry_out
from validation.suites.findings import TABLES, leaderboard, with_findings
from validation.suites.findings_figures import write_figures
from validation.suites.gathered import gather
from validation.suites.kept import SHIPPED, KeptError, read_kept, write_kept
from validation.suites.leaderboard import difference_over_scenes, over_scenes
from validation.suites.plan import Motion, Realisation, Suite
from validation.terminal import Terminal

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def suite():
    pictures = [
        Realisation(Motion("shear_band", seed, quick=True), severity="paper", pair_count=1) for seed in (1, 2)
    ]
    return Suite("small", "a jump", tuple(pictures), ("dis",)).with_methods(["own_method:rest"])


ABOUT = {"command": "softbed suite small OUT", "measured": 4, "of": 4}


@pytest.fixture(scope="module")
def gathered(suite, tmp_path_factory):
    """A small suite that a method of the user's own has joined by its name."""
    out = tmp_path_factory.mktemp("suite")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(Path(__file__).parent))
        patch.setenv("PYTHONPATH", str(Path(__file__).parent), prepend=":")
        assert carry_out(suite, out, processes=1, terminal=Terminal()) == []
    return gather(suite, out)


def test_what_is_kept_is_what_was_measured(gathered, tmp_path):
    write_kept(gathered, tmp_path, ABOUT)
    kept = read_kept(tmp_path)
    assert len(kept.lines) == len(gathered.lines) == 2 * 2 * 5
    for line, original in zip(kept.lines, gathered.lines, strict=True):
        assert line["scene_hash"] == original["scene_hash"]
        assert line["median"] == pytest.approx(original["median"], rel=1e-5, nan_ok=True)
    told = kept.profiles["pixel_count"].where(kept.profiles["explanation"] == "cause").sum("bin").values
    every = [line["pixel_count"] for line in kept.lines if line["stratum"] == "all"]
    assert told.tolist() == every
    wrong = kept.profiles["wrong_count"].where(kept.profiles["explanation"] == "cause").sum("bin").values
    shares = [line["wrong_0.3"] for line in kept.lines if line["stratum"] == "all"]
    assert wrong / told == pytest.approx(shares, abs=0.003)  # a histogram's bin is shared out


def test_same_tables_same_bytes(gathered, tmp_path):
    for folder in ("a", "b"):
        write_kept(gathered, tmp_path / folder, ABOUT)
    assert (tmp_path / "a" / "lines.csv.gz").read_bytes() == (tmp_path / "b" / "lines.csv.gz").read_bytes()


def test_a_method_of_ones_own_joins_the_leaderboard(gathered, tmp_path):
    write_kept(gathered, tmp_path, ABOUT)
    rows = leaderboard(read_kept(tmp_path)).splitlines()[2:]
    assert {row.split("|")[2].strip() for row in rows} == {"`dis`", "`own_method:rest`"}


def test_no_tables(tmp_path):
    with pytest.raises(KeptError, match=r"no tables of a suite: it holds no about\.json"):
        read_kept(tmp_path)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("[]", "a JSON object is needed"),
        ("{}", "schema_version: missing"),
        ('{"schema_version": 2}', "schema_version = 2: this program reads 1"),
        ('{"schema_version": 1, "of": 3}', "measured: missing"),
        ('{"schema_version": 1, "measured": [], "of": 3}', "measured: a whole number is needed"),
    ],
)
def test_what_is_no_about(tmp_path, capfd, content, told):
    (tmp_path / "about.json").write_text(content)
    assert run_command(["findings", str(tmp_path / "out"), "--tables", str(tmp_path)]) == 2
    error = capfd.readouterr().err
    assert error == f"softbed: {tmp_path / 'about.json'}: not of the tables of a suite: {told}\n"


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda text: "", "no column 'scene'"),
        (lambda text: text.replace("stratum", "where", 1), "no column 'stratum'"),
        (lambda text: text + "a,b\n", "2 values, needed are"),
        (
            lambda text: re.sub(r"\n([^,]*,[^,]*,[^,]*),\d+,", r"\n\1,one,", text, count=1),
            "seed = 'one': a number",
        ),
    ],
)
def test_lines_that_are_none(tmp_path, change, told):
    shutil.copytree(SHIPPED, tmp_path / "tables")
    path = tmp_path / "tables" / "lines.csv.gz"
    lines = gzip.decompress(path.read_bytes()).decode().splitlines(keepends=True)[:3]
    path.write_bytes(gzip.compress(change("".join(lines)).encode()))
    with pytest.raises(KeptError, match=told) as caught:
        read_kept(tmp_path / "tables")
    assert str(path) in str(caught.value)


def test_the_command_gives_one_document(tmp_path, capfd, monkeypatch):
    drawn = tmp_path / "a.png"
    monkeypatch.setattr(
        findings_figures, "write_figures", lambda kept, out: [drawn]
    )  # they have their own test
    assert run_command(["findings", str(tmp_path), "--json"]) == 0
    told = json.loads(capfd.readouterr().out)
    assert told["figures"] == [str(drawn)] and told["updated"] == []
    assert 0 < told["measured"] <= told["of"]


def line(scene, seed, value, picture=0):
    told = {"scene": scene, "label": "", "severity": "paper", "stride": 1, "stratum": "complex"}
    return told | {"seed": seed, "picture_seed": picture, "pair": 0, "wrong_0.3": value}


def test_scenes_count_alike():
    lines = [line("a", 1, 0.1), line("a", 2, 0.1), *(line("b", s, 0.3, p) for s in (1, 2) for p in range(4))]
    assert over_scenes(lines, "complex", "wrong_0.3").value == pytest.approx(0.2)


def test_differences_rest_on_pictures_that_both_saw():
    first = [line("a", seed, 0.5, picture) for seed in (1, 2) for picture in (0, 1)]
    second = [line("a", seed, 0.2) for seed in (1, 2)] + [line("b", 1, 9.0)]
    interval, _ = difference_over_scenes(first, second, "wrong_0.3")
    assert interval.value == pytest.approx(0.3) and interval.pair_count == 2


def test_unknown_table():
    with pytest.raises(UnknownTableError, match="findings: 'best': allowed are leaderboard"):
        with_findings("<!-- findings: best -->\n<!-- end -->", None)


@pytest.fixture(scope="module")
def shipped():
    return read_kept(SHIPPED)


def test_shipped_tables_say_what_they_are_of(shipped):
    told = {one["scene"] for one in shipped.lines}
    known = {one.motion.scene for one in complex_flow.complex_suite(quick=True).realisations}
    assert {"rolling_wheel", "bucket", "fillite_wheel", "shear_band"} <= told <= known
    assert {one["soil"] for one in shipped.lines} >= {"grc1", "fillite"}
    assert shipped.about["measured"] <= shipped.about["of"] and shipped.about["versions"]["softbed"]


@pytest.mark.parametrize(
    "document", ["README.md", "docs/complex_regions.md", "docs/suites.md", "docs/paper.md"]
)
def test_documents_say_what_the_tables_say(document, shipped):
    text = (ROOT / document).read_text(encoding="utf-8")
    assert "<!-- findings:" in text
    assert with_findings(text, shipped) == text


def test_figures(shipped, tmp_path):
    for path in write_figures(shipped, tmp_path):
        assert path.stat().st_size > 10_000
        assert (ROOT / "docs" / path.name).is_file()


def test_every_table_is_of_finite_numbers(shipped):
    for name, table in TABLES.items():
        assert not re.search(r"\bnan\b", table(shipped)), name
    assert np.isfinite([one["seconds"] for one in shipped.lines]).all()
