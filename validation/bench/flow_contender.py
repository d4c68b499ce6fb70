"""Flow methods that are measured side by side."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from validation.bench.flow_case import Case
from validation.bench.rows import PeerError
from validation.versions import package_version

if TYPE_CHECKING:
    from soft.flow import FlowField

_OPENCV, _SKIMAGE = "opencv-python-headless", "scikit-image"
_AS_GIVEN = {"forward_backward": False, "uncertainty": False}
"""Peers are timed and scored as their library gives them: what is found out about them here is left off."""


@dataclass(frozen=True, eq=False)
class Answer:
    """Motion, the seconds it took, and the version of what measured it."""

    flow: "FlowField"
    seconds: float
    version: str


class Subject(Protocol):
    """Whoever can be asked for the motion between the pictures of a case.

    Attributes
    ----------
    name : str
        What rows call it.
    own : bool
        Ours, or a peer's.
    """

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def own(self) -> bool: ...  # noqa: D102

    def measure(self, case: Case, threads: int | None) -> Answer:
        """Motion between the pictures of a case; a PeerError says why there is none."""
        ...


@dataclass(frozen=True)
class Contender:
    """A method of `soft.estimate_flow` with options.

    Attributes
    ----------
    name : str
        What rows call it.
    method : str
    own : bool
        Ours, or a peer's.
    options : mapping
    package : str
        The distribution that a peer comes from.
    """

    name: str
    method: str
    own: bool
    options: Mapping[str, Any] = field(default_factory=dict)
    package: str = "softbed"

    def measure(self, case: Case, threads: int | None) -> Answer:
        """Motion between the pictures of a case; ours as users get it, peers' as their libraries give it.

        Raises
        ------
        PeerError
            The package is not installed.
        """
        from soft.flow import estimate_flow, find_estimator
        from soft.pair_analysis import around

        version = package_version(self.package)
        if version == "not installed":
            raise PeerError(f"{self.package} is not installed")
        keeps = case.soil is not None and find_estimator(self.method).keeps_to_mask
        mask = around(case.soil) if keeps else None  # type: ignore[arg-type]
        options = dict(self.options) | ({} if self.own else _AS_GIVEN)
        began = time.perf_counter()
        flow = estimate_flow(
            case.first, case.second, method=self.method, mask=mask, threads=threads, **options
        )
        return Answer(flow, time.perf_counter() - began, version)


CONTENDERS = (
    Contender("robust-affine", "robust-affine", True),
    Contender("robust-affine, fast", "robust-affine-fast", True),
    Contender("black-anandan", "black-anandan", True),
    Contender("soft-2014", "soft-2014", True),
    Contender("DIS, medium", "dis", False, package=_OPENCV),
    Contender("DIS, medium, to full resolution", "dis-full", False, package=_OPENCV),
    Contender("Farnebäck", "farneback", False, package=_OPENCV),
    Contender("TV-L1", "tvl1", False, package=_SKIMAGE),
    Contender("iterative Lucas-Kanade", "ilk", False, package=_SKIMAGE),
)
