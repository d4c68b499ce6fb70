"""Every picture of README and docs has a command that makes it; what is cheap to make is not stale."""

import re
import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import soft
import synth
import synth.dataset
from tests.documents.blocks import PAGES, ROOT, WRITTEN, tables_of
from tests.documents.command_line import parse

PICTURES = (".png", ".jpg")


def shown() -> set[Path]:
    """Every picture that a page shows, from the root."""
    found = (
        (ROOT / page, one) for page in PAGES for one in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", read(page))
    )
    return {(page.parent / one).resolve().relative_to(ROOT.resolve()) for page, one in found}


def read(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def test_every_picture_is_made_by_a_command_and_every_one_is_shown(entries):
    listed = [file for entry in entries for file in entry.files]
    assert len(listed) == len(set(listed))
    kept = {path.relative_to(ROOT) for path in (ROOT / "docs").iterdir() if path.suffix in PICTURES}
    assert shown() == {file for file in listed if file.suffix in PICTURES} == shown() | kept
    assert all((ROOT / file).is_file() for file in listed)


def test_pictures_are_small(entries):
    large = {file for entry in entries for file in entry.files if (ROOT / file).stat().st_size > 500_000}
    assert not large


def test_commands_are_such(maker, entries):
    for entry in entries:
        for (program, *words), _ in map(maker.parted, entry.commands):
            if program == "softbed":
                parse(words)
            else:
                assert program == "python" and (ROOT / words[0]).is_file()


def test_tables_that_a_command_writes_are_all_listed(entries):
    written = {page for page in PAGES if WRITTEN.search(read(page))}
    assert {table for entry in entries for table in entry.tables} == written
    for entry in entries:
        assert all(page in command for page in entry.tables for command in entry.commands)


# Under these headings numbers are defined, assumed or published, not measured.
NOT_MEASURED = {
    ("docs/measures.md", "What is measured from soil flow"),
    ("docs/paper.md", "The rule"),
    ("docs/pictures.md", "Analytic scenes"),
    ("scenes/scarab/README.md", "What is known"),
}


def test_tables_of_measurements_are_written_by_a_command_or_listed_as_typed(maker):
    typed = {(one.page, heading) for one in maker.read_typed() for heading in one.headings}
    every = [(page, one) for page in PAGES for one in tables_of(page)]
    assert sum(one.is_measured for _, one in every) > 50
    tables = [(page, one) for page, one in every if not one.written]
    measured = {(page, one.heading) for page, one in tables if one.is_measured}
    assert measured - NOT_MEASURED <= typed
    assert typed | NOT_MEASURED <= {(page, one.heading) for page, one in tables}


def test_pages_name_the_commands_that_their_tables_were_typed_from(maker):
    for one in maker.read_typed():
        assert one.commands or one.how, one
        for command in one.commands:
            _, *words = shlex.split(command)
            parse(words)
            named = re.match(r"softbed (?:(?:bench|study|suite|verify|calibrate) [\w-]+|[\w-]+)", command)[0]
            assert named in read(one.page), (one.page, named)


def test_what_a_command_prints_is_kept_where_it_succeeds(maker, tmp_path):
    kept = tmp_path / "kept.txt"
    maker.carry_out(f"python -c 'print(6 * 7)' > {kept}")
    with pytest.raises(subprocess.CalledProcessError):
        maker.carry_out(f"python -c 'print(1); 1 / 0' > {kept}")
    assert kept.read_text() == "42\n"


def test_what_lasts_longest_is_made_first_and_what_lacks_files_is_told(maker, monkeypatch, capsys):
    monkeypatch.setenv("ELSEWHERE", "/nowhere")
    lasting = [maker.Entry((f"softbed {one}",), one) for one in maker.LASTS]
    lacking = maker.Entry(("softbed rig",), "minutes", needs=("Makefile", "$ELSEWHERE/rig.mat"))
    made = []
    monkeypatch.setattr(maker, "read_entries", lambda: [*lasting, lacking])
    monkeypatch.setattr(maker, "remake", made.append)
    maker.main("minutes")
    assert [entry.lasts for entry in made] == ["minutes", "seconds"]
    told = capsys.readouterr().out
    assert "not remade, as it takes minutes, and needs $ELSEWHERE/rig.mat:\n    softbed rig\n" in told
    assert "not remade, as it takes hours:\n    softbed hours\n" in told


def test_what_was_typed_is_told(maker, capsys):
    maker.tell_typed([maker.Typed("docs/a.md", ("B", "C"), ("softbed bench dem",), "in turn")])
    told = capsys.readouterr().out
    assert "not remade" in told and told.endswith("  docs/a.md, B; C\n    softbed bench dem\n    in turn\n")


@pytest.mark.parametrize("name", ["conventions", "texture"])
def test_what_is_cheap_to_make_is_as_it_is_made(maker, entries, name, tmp_path, monkeypatch):
    (entry,) = (one for one in entries if one.files == (Path(f"docs/{name}.png"),))
    kept, new = ROOT / entry.files[0], tmp_path / "new.png"
    command = entry.commands[0].replace(str(entry.files[0]), str(new))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    maker.remake(maker.Entry((command,), entry.lasts, files=(new,)))
    pixels = [np.asarray(Image.open(path).convert("RGB"), float) for path in (kept, new)]
    assert pixels[0].shape == pixels[1].shape
    assert np.abs(pixels[0] - pixels[1]).mean() < 0.1  # grey levels


def test_tests_that_pages_name_exist():
    named = [one for page in PAGES for one in re.findall(r"`(tests/[\w/]+\.py)((?:::\w+)*)`", read(page))]
    assert len(named) > 20
    for file, names in named:
        source = (ROOT / file).read_text(encoding="utf-8")
        assert all(re.search(rf"(?:def|class) {name}\b", source) for name in names.split("::") if name), names


@pytest.mark.parametrize("room", [soft, synth, synth.dataset])
def test_every_public_name_is_in_the_reference(room):
    page = read(f"docs/reference/{room.__name__.partition('.')[0]}.md")
    listed = set(re.findall(r"^\.\. auto\w+:: (\w+)$", page, re.MULTILINE))
    assert set(room.__all__) <= listed
