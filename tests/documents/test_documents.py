"""Every code block and command of the README and the docs is run, or parsed where running takes too long."""

import dataclasses
import itertools
import json
import re
import shutil
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
import typer

from soft.flow.registry import method_names
from synth.dataset.members import members_of
from synth.dataset.sweep import load_sweep
from synth.scene import load_scene
from tests.documents.blocks import PAGES, ROOT, Block, blocks_of, inline_commands
from tests.documents.command_line import options_of, parse, parse_told
from validation.cli import app, run_command
from validation.cli.app import BAD_INPUT, CHECK_FAILED, FAULT, INTERRUPTED

# What a page takes for given, by the name of the fixture that makes it.
GIVEN = {
    "README.md": ["own_pictures", "own_film", "small_band"],
    "docs/analysis.md": ["own_pictures"],
    "docs/datasets.md": ["wheels"],
    "docs/figures.md": ["sand_run"],
    "docs/measures.md": ["own_pictures"],
    "docs/tutorials/study_push_rolling.md": ["small_scenes"],
    "docs/tutorials/make_a_data_set.md": ["wheels"],
}
SCORING = "docs/tutorials/score_my_method.md"
PHOTOGRAPHS = "docs/tutorials/my_photographs.md"
SMALL = ("rolling_wheel", "pushed_wheel", "shear_band")  # scenes that a fixture has small ones of
# Commands that take minutes to hours, whatever they are asked for.
LONG = {"bench", "calibrate", "contact-sheet", "drawbar", "identify", "study", "suite", "verify"}
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
# What may be told of besides softbed; never run here.
OTHERS = {"make", "python", "python3", "pip", ".venv/bin/pip", "dask", "source"}


@pytest.fixture
def place(request, tmp_path, monkeypatch):
    """Make a folder with what a page takes for given, and go there."""

    def prepare(page: str) -> Path:
        for name in GIVEN.get(page, ()):
            given = request.getfixturevalue(name)
            if name in ("own_pictures", "sand_run"):
                shutil.copytree(given, tmp_path / given.name)
            else:
                shutil.copytree(given, tmp_path, dirs_exist_ok=True)
        monkeypatch.chdir(tmp_path)
        monkeypatch.syspath_prepend(tmp_path)
        return tmp_path

    yield prepare
    # Another page or test has a method of its own by that name.
    for name in [n for n, one in sys.modules.items() if lies_in(one, tmp_path)]:
        del sys.modules[name]


def lies_in(module: ModuleType, folder: Path) -> bool:
    """Whether a module was imported from a folder."""
    file = getattr(module, "__file__", None)
    return file is not None and Path(file).is_relative_to(folder)


def run_shell(block: Block, place: Path) -> None:
    """Run the commands of a block, scenes that take long replaced by small ones of the same name."""
    for program, *words in block.commands:
        if program == "softbed":
            parse(words)
        else:
            assert program.removeprefix(".venv/bin/") in OTHERS | {"softbed"}, program
            assert program != "make" or set(words) <= TARGETS
            assert block.parsed_only or program == "make"
        if program == "softbed" and not block.parsed_only:
            assert words[0] not in LONG, f"line {block.line}: mark it <!-- parsed only: how long it takes -->"
            assert run_command([small_scene(word, place) for word in words]) == block.exit_status, " ".join(
                words
            )


def small_scene(word: str, place: Path) -> str:
    """The small scene of that name where there is one; else the word itself."""
    return f"{word}.toml" if word in SMALL and (place / f"{word}.toml").exists() else word


def write_file(block: Block, place: Path) -> None:
    """Write a block that is a file, beside a fixture's of that name; scenes and sweeps must be some."""
    path = place / block.file_name
    if path.exists():
        path = place / f"shown_{path.name}"
    path.write_text(block.text)
    if path.suffix == ".py":
        compile(block.text, path.name, "exec")
    elif "base" in tomllib.loads(block.text):
        load_scene(path, quick=True)
    elif "vary" in tomllib.loads(block.text):
        assert not members_of(*load_sweep(path)).impossible


def run_python(block: Block, names: dict[str, object]) -> None:
    """Run a program; the page's former ones have left their names."""
    code = compile(block.text, f"line {block.line}", "exec")
    if not (block.parsed_only or block.needs):
        exec(code, names)


def run_block(block: Block, place: Path, names: dict[str, object]) -> None:
    if block.kind == "sh":
        run_shell(block, place)
    elif block.file_name:
        write_file(block, place)
    elif block.kind == "python":
        run_python(block, names)
    elif block.kind == "toml":
        tomllib.loads(block.text)
    elif block.kind == "yaml":
        pytest.importorskip("yaml").safe_load(block.text)
    else:
        assert not block.kind or block.kind.startswith("{")


@pytest.mark.parametrize("page", [page for page in PAGES if blocks_of(page)])
def test_blocks(page, place, capsys):
    where, names = place(page), {"__name__": "page"}
    for block in blocks_of(page):
        run_block(block, where, names)
    if page == SCORING:
        assert_told(page, where / "out" / "band" / "scores.json")
    if page == PHOTOGRAPHS:
        assert_said(page, "".join(capsys.readouterr()))


def assert_told(page: str, path: Path) -> None:
    """The page's table has the scores that its commands have just come to."""
    text, method = (ROOT / page).read_text(encoding="utf-8"), ""
    scores = json.loads(path.read_text())["methods"]
    rows = re.findall(r"^\| (`[^`]+`)? ?\| (\w+) \| (\d.+) \|$", text, re.MULTILINE)
    assert len(rows) == 6
    for name, stratum, numbers in rows:
        method = name.strip("`") or method
        one = scores[method]["strata"][stratum]
        wrong = one["wrong_share"]["0.3"]
        told = f"{one['coverage']:.1%} | {one['median']:.3f} | {one['p95']:.2f} | {wrong:.1%}"
        assert numbers == told.replace("%", " %"), (method, stratum)


def assert_said(page: str, printed: str) -> None:
    """Every line that the page shows in a block of no kind has been printed."""
    shown = [line for block in blocks_of(page) if not block.kind for line in block.text.splitlines()]
    assert shown
    assert set(shown) - {line.strip() for line in printed.splitlines()} == set()


@pytest.mark.parametrize("page", PAGES)
def test_what_is_said_to_be_run_on_another_page_is_run_there(page):
    for block in blocks_of(page):
        if named := re.match(r"run in (\S+\.md)", block.parsed_only):
            there = blocks_of((Path(page).parent / named[1]).as_posix())
            run = [forms_of(one) for one in there if one.kind == "sh" and not one.parsed_only]
            assert forms_of(block) <= set().union(*run), (page, block.line)


def forms_of(block: Block) -> set[tuple[str, frozenset[str]]]:
    """Its commands without what they are given: names, and options."""
    return {
        (words[0], frozenset(word for word in words if word.startswith("--"))) for _, *words in block.commands
    }


NEEDING = [pytest.param(page, block, id=page) for page in PAGES for block in blocks_of(page) if block.needs]


@pytest.mark.parametrize(("page", "block"), NEEDING)
def test_blocks_that_need_what_tests_do_not_install(page, block, place):
    pytest.importorskip(block.needs)
    place(page)
    run_python(dataclasses.replace(block, needs=""), {"__name__": "page"})


# What running text has for a number, a form, or more of the same.
STANDS_FOR = {"N": "1", "F": "flo", "FORMAT": "flo", "...": ""}


@pytest.mark.parametrize("page", PAGES)
def test_commands_in_running_text_exist(page):
    for _, *words in inline_commands(page):
        alternatives = [STANDS_FOR.get(word, word).split("|") for word in words]
        for one in itertools.product(*alternatives):
            parse_told([word for word in one if word])


@pytest.mark.parametrize("page", PAGES)
def test_targets_of_make_in_running_text_exist(page):
    told = re.findall(r"`make ([a-z -]+)", (ROOT / page).read_text(encoding="utf-8"))
    assert {target for one in told for target in one.split()} <= TARGETS


@pytest.mark.parametrize("told", ["export OUT --format nonsense", "nonsense OUT", "run --nonsense"])
def test_what_is_wrong_in_running_text_is_found(told):
    with pytest.raises(Exception, match="nonsense"):
        parse_told(told.split())


@pytest.mark.parametrize("page", ["docs/commands.md", "docs/flow.md"])
def test_tables_of_methods_name_all_of_them(page):
    rows = re.findall(r"^\| (`.+?`[^|]*) \|", (ROOT / page).read_text(encoding="utf-8"), re.MULTILINE)
    start = next(k for k, row in enumerate(rows) if row.startswith("`robust-affine`"))
    end = next(k for k, row in enumerate(rows) if k > start and "`package.module:function`" in row)
    told = re.findall(r"`([\w.-]+)`", " ".join(rows[start:end]))
    assert sorted(told) == sorted(method_names())


def test_the_table_of_environment_variables_names_those_that_are_read():
    sources = [path for room in ("soft", "synth", "validation") for path in (ROOT / room).rglob("*.py")]
    read = {name for path in sources for name in re.findall(r"SOFTBED_[A-Z]+", path.read_text("utf-8"))}
    told = re.findall(
        r"^\| `(SOFTBED_[A-Z]+)` \|", (ROOT / "docs/commands.md").read_text("utf-8"), re.MULTILINE
    )
    assert told == sorted(read)


def test_statuses_that_are_told_are_those_that_there_are():
    (told,) = re.findall(r"^Exit status: (.+)$", (ROOT / "docs/commands.md").read_text("utf-8"), re.MULTILINE)
    assert [int(number) for number in re.findall(r"\b\d+\b", told)] == [
        0,
        CHECK_FAILED,
        BAD_INPUT,
        FAULT,
        INTERRUPTED,
    ]


def test_every_command_takes_what_commands_share():
    commands = typer.main.get_command(app).commands
    assert {"findings", "run", "new-scene"} <= set(commands)
    assert {name for name in commands if not {"--json", "--debug"} <= options_of([name])} == set()
