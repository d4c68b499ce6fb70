"""Tables of pages say what the kept files say, and no kept file is there for nothing."""

import sys
from pathlib import Path

import pytest

from tests.documents.blocks import PAGES, ROOT, WRITTEN, blocks_of
from validation.markdown_tables import UnknownTableError, with_tables

MEASURED = Path("docs/measured")


@pytest.fixture(scope="module")
def writer(docs_make):
    """The program that writes them."""
    return docs_make("write_tables")


def read(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def asked_for(page: str) -> list[str]:
    """Names of the measured tables of a page."""
    return [name for kind, name in WRITTEN.findall(read(page)) if kind == "measured"]


WITH_TABLES = [page for page in PAGES if asked_for(page)]


@pytest.mark.parametrize("page", WITH_TABLES)
def test_pages_say_what_the_kept_files_say(writer, page):
    assert with_tables(read(page), writer.KIND, writer.TABLES) == read(page)


def test_every_table_is_on_one_page(writer):
    assert sorted(name for page in WITH_TABLES for name in asked_for(page)) == sorted(writer.TABLES)


def test_every_kept_file_is_made_by_a_command(entries):
    listed = [file for entry in entries for file in entry.files if file.parent == MEASURED]
    assert sorted(listed) == sorted(path.relative_to(ROOT) for path in (ROOT / MEASURED).iterdir())


def test_a_table_is_made_from_every_kept_file(writer, monkeypatch):
    opened, own = set(), Path.open

    def noted(path, *given, **named):
        opened.add(path)
        return own(path, *given, **named)

    monkeypatch.setattr(Path, "open", noted)
    for table in writer.TABLES.values():
        table()
    assert set((ROOT / MEASURED).iterdir()) <= opened


def test_another_number_in_a_file_is_another_one_on_the_page(writer, monkeypatch, tmp_path):
    kept = sys.modules["kept"]
    text = (kept.FOLDER / "texture.csv").read_text(encoding="utf-8")
    number = "2.2,11,interpolated,dis,3.59223,12097,1,0.148783"
    assert text.count(number) == 1
    (tmp_path / "texture.csv").write_text(text.replace(number, number.replace("0.148783", "7.654")))
    before = writer.TABLES["texture"]()
    monkeypatch.setattr(kept, "FOLDER", tmp_path)
    assert writer.TABLES["texture"]() == before.replace("0.06, 0.08, 0.15", "0.06, 0.08, 7.65", 1)


def test_a_table_that_there_is_not(writer):
    with pytest.raises(UnknownTableError, match=r"measured: 'speed': allowed are .*nuisance, "):
        with_tables("<!-- measured: speed -->\n<!-- end -->", writer.KIND, writer.TABLES)


def test_the_method_that_the_tutorial_scores_is_the_page_s(docs_make):
    method = docs_make("tutorial_scores").method_of_the_page()
    assert method in [block.text for block in blocks_of("docs/tutorials/score_my_method.md")]
    assert "def flow(first, second, mask):" in method
