"""Units of figures: mm and mm/s where the pictures are calibrated, px and px per frame else."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Units:
    """Factors from px, and what they lead to.

    Attributes
    ----------
    length : float
        `length_name` per px.
    length_name : str
        `mm` or `px`.
    speed : float
        `speed_name` per px of displacement between the pictures of a pair.
    speed_name : str
        `mm/s` or `px/frame`.
    rate : float
        `rate_name` per 1/pair, for gradients of displacement.
    rate_name : str
        `1/s` or `1/frame`.
    """

    length: float = 1.0
    length_name: str = "px"
    speed: float = 1.0
    speed_name: str = "px/frame"
    rate: float = 1.0
    rate_name: str = "1/frame"

    @classmethod
    def of(cls, *, metres_per_pixel: float | None, frame_rate: float | None, frame_step: int = 1) -> "Units":
        """Choose units for pictures of this pixel size (m) and frame rate (1/s), either of which may be None.

        `frame_step` is how many frames lie between the pictures of a pair.
        """
        length, length_name = (1.0, "px") if metres_per_pixel is None else (1e3 * metres_per_pixel, "mm")
        rate, rate_name = (1.0, "1/frame") if frame_rate is None else (frame_rate, "1/s")
        rate /= frame_step
        if metres_per_pixel is None or frame_rate is None:
            return cls(length, length_name, 1.0 / frame_step, "px/frame", rate, rate_name)
        return cls(length, length_name, length * rate, "mm/s", rate, rate_name)

    @classmethod
    def of_flow(cls, flow: "xarray.Dataset", pair: int = 0) -> "Units":
        """Choose units for one pair of a SoilFlow."""
        step = int(flow["second_frame"][pair]) - int(flow["first_frame"][pair])
        return cls.of(
            metres_per_pixel=flow.attrs.get("metres_per_pixel"),
            frame_rate=flow.attrs.get("frame_rate"),
            frame_step=max(step, 1),
        )
