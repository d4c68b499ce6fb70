"""Tables of the README and the docs, and how a page gets them.

A page holds a table between `<!-- KIND: NAME -->` and `<!-- end -->`. What stands there is replaced by what
kept files say, so that no number of it was typed by hand. KIND is `findings` for what comes along with this
program (`validation.suites.findings`), `measured` for what is kept with the docs (`docs/make/page_tables`).
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path


class UnknownTableError(ValueError):
    """A page asks for a table that does not exist; the message is one line."""


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]], *, words: int | None = None) -> str:
    """A table in Markdown, a line for its head and for each row.

    Parameters
    ----------
    words : int, optional
        How many columns, from the left, hold words: numbers in the others are set to the right.
    """
    left = len(head) if words is None else words
    sides = ["---"] * left + ["---:"] * (len(head) - left)
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, sides, *rows))


def with_tables(text: str, kind: str, tables: Mapping[str, Callable[[], str]]) -> str:
    """A Markdown text whose tables of one kind are made anew; everything else in it stays.

    Raises
    ------
    UnknownTableError
        It names a table that does not exist.
    """

    def replaced(match: re.Match[str]) -> str:
        name = match["name"]
        if name not in tables:
            raise UnknownTableError(f"{kind}: {name!r}: allowed are {', '.join(tables)}")
        return f"{match['begin']}\n{tables[name]()}\n\n{match['end']}"

    place = rf"(?P<begin><!-- {kind}: (?P<name>[a-z0-9-]+) -->\n).*?(?P<end><!-- end -->)"
    return re.sub(place, replaced, text, flags=re.DOTALL)


def update_tables(path: Path, kind: str, tables: Mapping[str, Callable[[], str]]) -> None:
    """Bring the tables of one kind in a Markdown file up to date."""
    text = path.read_text(encoding="utf-8")
    path.write_text(with_tables(text, kind, tables), encoding="utf-8")
