"""Which method of measuring flow is meant, and the name its results are filed under."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

DEFAULT = "robust-affine"
_FILES = "files:"


class MethodError(ValueError):
    """Methods that cannot be filed; the message is one line."""


@dataclass(frozen=True)
class Method:
    """A method as it was asked for.

    Attributes
    ----------
    name : str
        A built-in name, `package.module:function`, or `files:FOLDER`.
    """

    name: str

    @property
    def slug(self) -> str:
        """Name of its file: the method's own, without what a file name should not hold.

        >>> Method("dis").slug, Method("lab.flow:fast").slug, Method("files:/data/other flow/").slug
        ('dis', 'lab.flow-fast', 'files-other-flow')
        """
        name = self.name
        if self.is_files:
            name = f"files-{self.folder.resolve().name}"
        return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.") or "method"

    @property
    def is_files(self) -> bool:
        """Whether it is a folder of flow measured elsewhere."""
        return self.name.startswith(_FILES)

    @property
    def is_function(self) -> bool:
        """Whether it is a user's own function, whose code may have changed since it was last run."""
        return ":" in self.name and not self.is_files

    @property
    def folder(self) -> Path:
        """Where the flow measured elsewhere lies."""
        return Path(self.name.removeprefix(_FILES))


def choose(names: Sequence[str]) -> list[Method]:
    """Choose the methods of these names, each once, in order.

    Raises
    ------
    MethodError
        Two would be filed under one name.
    """
    methods = [Method(name) for name in dict.fromkeys(names)]
    filed: dict[str, Method] = {}
    for method in methods:
        # Lower case: some file systems do not tell cases apart.
        other = filed.setdefault(method.slug.lower(), method)
        if other is not method:
            raise MethodError(
                f"methods {other.name!r} and {method.name!r} would both be filed as {method.slug!r}: "
                "run them one at a time, into different folders"
            )
    return methods
