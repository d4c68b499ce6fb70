"""What every way of estimating flow is to `estimate_flow`."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Protocol

import numpy as np

from soft.flow.field import FlowError, FlowField
from soft.flow.options import build_options


class Solver(Protocol):
    """Measures displacement; knows nothing of textureless pixels or of motion out of the picture."""

    def __call__(self, first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: Any, /) -> FlowField:
        """Measure displacement from `first` to `second`.

        Both are (H, W) float32 0-255, finite and of one shape; mask is (H, W) bool, True = use, and true
        somewhere.
        """
        ...


class BackwardSolver(Protocol):
    """Measures the way back, from the second picture to the first, knowing the way there."""

    def __call__(
        self, first: np.ndarray, second: np.ndarray, forward: FlowField, options: Any, /
    ) -> np.ndarray:
        """Measure displacement from `second` to `first`, (H, W, 2) px on the grid of `second`.

        Or (h, w, 2) px on that of every second, third, ... pixel each way. Pictures are as given to the
        `Solver`; `forward` is its answer. NaN where not measured: what lands there is not valid.
        """
        ...


@dataclass(frozen=True)
class Estimator:
    """A named solver and what it takes.

    Attributes
    ----------
    name : str
        What a user calls it, and what results are labelled with.
    options_type : type
        A frozen dataclass that refuses impossible values with a FlowError.
    solve : Solver
        Does the work.
    resolved : callable
        Options to a plain dict with every default spelt out, for the record in a result.
    least_side : int
        Fewest px a picture may have each way.
    devices : tuple of str
        Where it can run.
    own_texture : bool
        True if it decides itself, by NaN, where there was too little texture to measure.
    keeps_to_mask : bool
        True if pixels outside the mask do not disturb those inside.
    start : callable, optional
        Called with device and threads (None: every core) before `solve`.
    forward_backward : bool, float or callable
        Whether motion there and back is compared unless a user says otherwise; a number: to so many px; a
        function: of the options.
    gridded : bool
        True if it tells of nodes of a grid, and in its field where they are.
    reversible : bool
        False if it cannot measure from the second picture to the first.
    backward : BackwardSolver, optional
        Measures the way back at less cost; None: `solve` does it, with the pictures swapped.
    effective_window : callable, optional
        Options to the side of the square that it averages over, in effect, px: the uncertainty is estimated
        from that (`plain_uncertainty`). None: it tells its own, or none.
    settled : mapping
        Options that its name stands for and a user does not give.
    """

    name: str
    options_type: type
    solve: Solver
    resolved: Callable[[Any], dict[str, object]] = asdict
    least_side: int = 1
    devices: tuple[str, ...] = ("cpu",)
    own_texture: bool = False
    keeps_to_mask: bool = False
    start: Callable[[str, int | None], object] | None = None
    forward_backward: bool | float | Callable[[Any], bool | float] = True
    gridded: bool = False
    reversible: bool = True
    backward: BackwardSolver | None = None
    effective_window: Callable[[Any], float] | None = None
    settled: Mapping[str, object] = field(default_factory=dict)

    def options(self, given: Mapping[str, object]) -> Any:
        """Build the options dataclass from keywords; unknown ones, and settled ones, are a FlowError."""
        for name in self.settled:
            if name in given:
                raise FlowError(f"method {self.name!r}: option {name} is {self.settled[name]!r} by its name")
        return build_options(self.options_type, self.name, {**self.settled, **given})
