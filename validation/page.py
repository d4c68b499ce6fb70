"""Pages a person reads: one HTML file each, that needs nothing else."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.figures import to_png

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class Panel:
    """A figure of a page.

    Attributes
    ----------
    title, caption : str
        What it is, and how to read it.
    source : str
        The PNG as a `data:` address.
    wide : bool
        Whether it needs the page's whole width.
    """

    title: str
    caption: str
    source: str
    wide: bool = False

    @classmethod
    def of(cls, title: str, caption: str, figure: "Figure", *, wide: bool = False) -> "Panel":
        """Put a figure on a page."""
        encoded = base64.b64encode(to_png(figure)).decode("ascii")
        return cls(title, caption, f"data:image/png;base64,{encoded}", wide)


def write_page(path: Path, template: str, content: Mapping[str, Any]) -> None:
    """Fill a template of this package, and write the page."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    path.write_text(environment.get_template(template).render(content), encoding="utf-8")
