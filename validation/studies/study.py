"""What a study is: cases to simulate, what is found in their recordings, and a figure of it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from synth.scene import SoilBinScene, parse_scene

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from synth.recording import Recording

Row = dict[str, float | str]
"""A line of the table: value by column."""


@dataclass(frozen=True)
class Case:
    """One run of a study.

    Attributes
    ----------
    label : str
        Names its folder.
    scene : SoilBinScene
    """

    label: str
    scene: SoilBinScene


@dataclass(frozen=True)
class Run:
    """A case that has been simulated."""

    case: Case
    path: Path

    def recording(self) -> "Recording":
        """Read its recording: one at a time is in memory."""
        from synth.recording import Recording

        return Recording.read(self.path)


@dataclass(frozen=True)
class Findings:
    """What a study found.

    Attributes
    ----------
    rows : list of Row
        Tidy: one line an observation, the same columns in each.
    conclusion : str
        One line, with numbers.
    curves : dict of ndarray, shape (2, n)
        More for the figure than the table holds, by name.
    """

    rows: list[Row]
    conclusion: str
    curves: "Mapping[str, np.ndarray]" = field(default_factory=dict)


class Study(ABC):
    """A question, and how it is answered.

    Attributes
    ----------
    scene : str
        The shipped scene that its cases start from.
    columns : mapping
        Unit of each column of its table, in order.
    """

    scene: ClassVar[str]
    columns: ClassVar[Mapping[str, str]]

    @abstractmethod
    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """What to run; `scene` is what the cases start from, quick itself where that is asked for."""

    @property
    def inputs(self) -> Mapping[str, Any]:
        """What the findings depend on besides the recordings and the scenes; anything JSON can hold."""
        return {}

    @abstractmethod
    def find(self, runs: Sequence[Run]) -> Findings:
        """Look into the recordings, in the order of the cases."""

    @abstractmethod
    def draw(self, findings: Findings) -> "Figure":
        """Show it in one figure."""


def changed(scene: SoilBinScene, **tables: Any) -> SoilBinScene:
    """The scene with some values of some tables changed, `bed={"width": 1.0}`, or of the scene itself."""
    told = scene.to_dict()
    for table, values in tables.items():
        told[table] = {**told[table], **values} if isinstance(values, dict) else values
    other = parse_scene(told, source=f"{scene.name}, changed")
    assert isinstance(other, SoilBinScene)
    return other


def steady_means(recording: "Recording") -> dict[str, tuple[float, float]]:
    """Mean and standard deviation, since the first frame, of sinkage (m), forces (N) and torque (N m)."""
    import numpy as np

    data = recording.data
    since = data["sample_time"].values > 0
    found = {}
    for name in ("sinkage", "force_x", "force_z", "torque"):
        values = data[name].values[since]
        found[name] = (float(np.mean(values)), float(np.std(values)))
    return found


def plain_axes(figure: "Figure", rows: int, columns: int) -> "np.ndarray":
    """Axes (rows, columns) with a faint grid and nothing more."""
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.ravel():
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)
    return grid


def column(rows: Sequence[Row], name: str) -> "np.ndarray":
    """Numbers of one column."""
    import numpy as np

    return np.array([row[name] for row in rows], float)


def error_bars(axes: "Axes", x: Any, mean: Any, deviation: Any, *, colour: str) -> None:
    """Points with bars of one standard deviation."""
    axes.errorbar(x, mean, deviation, marker="o", capsize=3, color=colour, linewidth=1.4)
