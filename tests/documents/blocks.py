"""Code blocks and command lines of Markdown pages.

Own code, as pytest-codeblocks, mktestdocs and Sybil make a test of each block, which `pytest -n` would spread
over processes, while the blocks of a page build on each other; and none of them parses a command without
running it.
"""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt
from markdown_it.token import Token

ROOT = Path(__file__).parents[2]
_PLACES = (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "scenes").rglob("*.md"))
PAGES = sorted(path.relative_to(ROOT).as_posix() for path in _PLACES)
WRITTEN = re.compile(r"<!-- (findings|measured): ([a-z0-9-]+) -->")
"""Stands before a table that a command writes: of which kind, and which."""
_MARK = re.compile(r"<!-- (parsed only|exit status|needs): (.+?) -->", re.DOTALL)
_FILE = re.compile(r"# (\w+\.(?:py|toml))\b")
_SEPARATORS = ("&&", ";", "|")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Attributes
    ----------
    kind : str
        `sh`, `python`, `toml`, `yaml` or nothing.
    text : str
        What is in it.
    line : int
        The page's line that it begins at.
    parsed_only : str
        Why it is not run; empty where it is.
    exit_status : int
        What its commands end with.
    needs : str
        The module without which it cannot be run, and that tests do not install; mostly empty.
    """

    kind: str
    text: str
    line: int
    parsed_only: str = ""
    exit_status: int = 0
    needs: str = ""

    @property
    def file_name(self) -> str | None:
        """The file that it is, by its first line."""
        found = _FILE.match(self.text)
        return found[1] if found else None

    @property
    def commands(self) -> list[list[str]]:
        """Its command lines as words, comments left out."""
        lines = self.text.replace("\\\n", " ").splitlines()
        return [command for line in lines for command in _split(shlex.split(line, comments=True))]


def blocks_of(page: str) -> list[Block]:
    """Every fenced block of a page, with the mark that stands before it."""
    tokens = _tokens(page)
    before = [None, *tokens]
    return [_block(token, last) for last, token in zip(before, tokens, strict=False) if token.type == "fence"]


def inline_commands(page: str) -> Iterator[list[str]]:
    """Commands in running text and tables: `softbed ...`."""
    for token in _tokens(page):
        for child in token.children or ():
            if child.type == "code_inline" and re.match(r"softbed [a-z]", child.content):
                yield shlex.split(child.content)


@dataclass(frozen=True)
class Table:
    """A table of a page: the heading that it stands under, its cells, and whether a command writes it."""

    heading: str
    cells: tuple[str, ...]
    written: bool

    @property
    def is_measured(self) -> bool:
        """Whether a fifth of what stands in it has decimals or shares."""
        filled = [cell for cell in self.cells if cell]
        return 5 * sum(bool(re.search(r"\d\.\d|\d %|\d / \d", cell)) for cell in filled) > len(filled)


def tables_of(page: str) -> Iterator[Table]:
    """Every table of a page."""
    heading, written, tokens = "", False, _tokens(page)
    for k, token in enumerate(tokens):
        if token.type == "heading_open":
            heading = tokens[k + 1].content
        elif token.type == "html_block":
            written = bool(WRITTEN.search(token.content)) or (written and "<!-- end" not in token.content)
        elif token.type == "table_open":
            yield Table(heading, _cells(tokens[k:]), written)


def _cells(tokens: list[Token]) -> tuple[str, ...]:
    """What the body of the table holds that tokens begin with."""
    end = next(k for k, token in enumerate(tokens) if token.type == "table_close")
    return tuple(tokens[k + 1].content for k in range(end) if tokens[k].type == "td_open")


def _tokens(page: str) -> list[Token]:
    text = (ROOT / page).read_text(encoding="utf-8")
    return MarkdownIt().enable("table").parse(text)


def _block(token: Token, last: Token | None) -> Block:
    assert token.map is not None
    mark = _MARK.fullmatch(last.content.strip()) if last and last.type == "html_block" else None
    name, value = mark.groups() if mark else ("", "")
    return Block(
        token.info,
        token.content,
        token.map[0] + 1,
        parsed_only=" ".join(value.split()) if name == "parsed only" else "",
        exit_status=int(value) if name == "exit status" else 0,
        needs=value if name == "needs" else "",
    )


def _split(words: list[str]) -> Iterator[list[str]]:
    command: list[str] = []
    for word in words:
        if word in _SEPARATORS:
            yield command
            command = []
        else:
            command.append(word)
    if command:
        yield command
