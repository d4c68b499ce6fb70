"""Remake pictures and tables of the README and the docs: python docs/make/figures.py [seconds|minutes|hours].

docs/make/figures.toml says what makes each. What is left out is listed, and which tables were typed, so
that nothing goes stale unseen.
"""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[2]
OUT = Path("out/figures")
LASTS = ("seconds", "minutes", "hours")
_JPEG_SIDE = 1000
"""px, the greatest width of a figure that is kept as JPEG."""


@dataclass(frozen=True)
class Entry:
    """Files that some commands make together; the meaning of each is told in `figures.toml`."""

    commands: tuple[str, ...]
    lasts: str
    files: tuple[Path, ...] = ()
    made: tuple[Path, ...] = ()
    tables: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()

    @property
    def missing(self) -> list[str]:
        """What it needs and is not there."""
        return [one for one in self.needs if not (ROOT / os.path.expandvars(one)).exists()]


@dataclass(frozen=True)
class Typed:
    """Tables under some headings of a page, typed from what commands measured."""

    page: str
    headings: tuple[str, ...]
    commands: tuple[str, ...] = ()
    how: str = ""


def read_entries() -> list[Entry]:
    """What `figures.toml` lists, in its order."""
    return [_entry(**one) for one in _listed()["figures"]]


def read_typed() -> list[Typed]:
    """Which tables `figures.toml` lists as typed."""
    return [_typed(**one) for one in _listed()["typed"]]


def _listed() -> dict[str, list[dict]]:
    return tomllib.loads((ROOT / "docs/make/figures.toml").read_text(encoding="utf-8"))


def _entry(
    *,
    commands: Sequence[str],
    lasts: str,
    files: Sequence[str] = (),
    made: Sequence[str] = (),
    tables: Sequence[str] = (),
    needs: Sequence[str] = (),
) -> Entry:
    if lasts not in LASTS or (made and len(made) != len(files)):
        raise SystemExit(
            f"figures.toml: {commands[0]}: lasts {lasts!r}, {len(made)} made of {len(files)} files"
        )
    return Entry(
        commands=tuple(command.format(out=OUT) for command in commands),
        lasts=lasts,
        files=tuple(map(Path, files)),
        made=tuple(Path(one.format(out=OUT)) for one in made),
        tables=tuple(tables),
        needs=tuple(needs),
    )


def _typed(*, headings: list[str], commands: Sequence[str] = (), **others: str) -> Typed:
    return Typed(headings=tuple(headings), commands=tuple(commands), **others)


def remake(entry: Entry) -> None:
    """Carry out the commands, and put what they leave in its place."""
    for command in entry.commands:
        print(command, flush=True)
        carry_out(command)
    for file, made in zip(entry.files, entry.made, strict=False):
        keep(ROOT / made, ROOT / file)


def carry_out(command: str) -> None:
    """Run a command from the root; what it prints goes to the file after `>`, and is left out without one."""
    beside = Path(sys.executable).parent
    environment = os.environ | {"PATH": f"{beside}{os.pathsep}{os.environ['PATH']}"}
    words, printed = parted(command)
    with tempfile.TemporaryFile() as output:
        subprocess.run(
            [os.path.expandvars(word) for word in words], cwd=ROOT, env=environment, check=True, stdout=output
        )
        if printed:  # a command that fails leaves what was kept before
            output.seek(0)
            (ROOT / printed).write_bytes(output.read())


def parted(command: str) -> tuple[list[str], str]:
    """Words of a command, and the file after `>`."""
    words = shlex.split(command)
    return (words[:-2], words[-1]) if ">" in words[-2:-1] else (words, "")


def keep(made: Path, file: Path) -> None:
    """Copy a file; a figure that is kept as JPEG is made as small as a page shows it."""
    if made.suffix == file.suffix:
        shutil.copy(made, file)
        return
    with Image.open(made) as figure:
        shown = figure.convert("RGB")
    shown.thumbnail((_JPEG_SIDE, _JPEG_SIDE), Image.Resampling.LANCZOS)
    shown.save(file, quality=85, optimize=True)


def made_on(file: Path) -> str:
    """The day of the last commit that changed a file."""
    git = ["git", "log", "-1", "--format=%as", "--", str(file)]
    try:
        return subprocess.run(git, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "an unknown day"


def tell_left(entry: Entry) -> None:
    """Say why something was not remade, how old it is, and what makes it."""
    lacks = f", and needs {', '.join(entry.missing)}" if entry.missing else ""
    print(f"\nnot remade, as it takes {entry.lasts}{lacks}:")
    for line in (*(f"{file}, as of {made_on(file)}" for file in entry.files), *entry.tables):
        print(f"  {line}")
    for command in entry.commands:
        print(f"    {command}")


def tell_typed(typed: list[Typed]) -> None:
    """List what no run of this program remakes."""
    print("\nnot remade, as it was typed from what was measured:")
    for one in typed:
        print(f"  {one.page}, {'; '.join(one.headings)}")
        print("\n".join(f"    {line}" for line in (*one.commands, one.how) if line))


def main(most: str = "seconds") -> None:
    """Remake what lasts as long as `most` at most, the longest first, and list the rest."""
    if most not in LASTS:
        raise SystemExit(f"LASTS={most}: allowed are {', '.join(LASTS)}")
    entries = read_entries()
    wanted = LASTS[: LASTS.index(most) + 1]
    (ROOT / OUT).mkdir(parents=True, exist_ok=True)
    for lasts in reversed(wanted):  # tables are made from what lasts longer
        for entry in (one for one in entries if one.lasts == lasts and not one.missing):
            remake(entry)
    for entry in (one for one in entries if one.lasts not in wanted or one.missing):
        tell_left(entry)
    tell_typed(read_typed())


if __name__ == "__main__":
    main(*sys.argv[1:])
