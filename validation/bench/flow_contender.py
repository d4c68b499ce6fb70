"""Flow methods that are measured side by side."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from validation.bench.flow_case import Case
from validation.versions import package_version

if TYPE_CHECKING:
    from soft.flow import FlowField


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
        The distribution it comes from.
    """

    name: str
    method: str
    own: bool
    options: Mapping[str, Any] = field(default_factory=dict)
    package: str = "opencv-python-headless"

    @property
    def version(self) -> str:
        """Of the package it comes from."""
        return package_version("softbed" if self.own else self.package)

    def measure(self, case: Case, threads: int | None) -> "tuple[FlowField, float]":
        """Motion between the pictures of a case, and the seconds it took."""
        from soft.analysis import around
        from soft.flow import estimate_flow, find_estimator

        keeps = case.soil is not None and find_estimator(self.method).keeps_to_mask
        mask = around(case.soil) if keeps else None  # type: ignore[arg-type]
        began = time.perf_counter()
        flow = estimate_flow(
            case.first, case.second, method=self.method, mask=mask, threads=threads, **self.options
        )
        return flow, time.perf_counter() - began


CONTENDERS = (
    Contender("robust-affine", "robust-affine", True),
    Contender("robust-affine, fast", "robust-affine", True, {"preset": "fast"}),
    Contender("DIS, medium", "dis", False),
    Contender("DIS, medium, to full resolution", "dis", False, {"finest_scale": 0}),
    Contender("Farnebäck", "farneback", False),
)
