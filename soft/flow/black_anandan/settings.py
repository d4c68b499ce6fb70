"""What the presets of `black-anandan` stand for."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Stage:
    """A pass over a pyramid under the same penalties.

    Attributes
    ----------
    convex : float
        Share of the quadratic penalty: 1 quadratic, 0 Lorentzian alone.
    spacing : float
        Size of a level / that of the next coarser one.
    level_count : int
        Levels at most.
    smoothness : float
        Weight of the steps of motion (lambda).
    data_width, step_width : float
        Of the penalties (sigma), grey levels and px.
    """

    convex: float
    spacing: float
    level_count: int
    smoothness: float
    data_width: float
    step_width: float


@dataclass(frozen=True)
class Settings:
    """A preset.

    Attributes
    ----------
    stages : tuple of Stage
        One after the other.
    blur : float
        Standard deviation by which pictures are blurred from level to level / sqrt(spacing), px.
    warp_count : int
        Times that each level's second picture is warped.
    weighing_count : int
        Times that the equations of a warp are weighted by the penalties' slopes, and solved; once where the
        penalty is the quadratic one.
    tolerance : float
        What the solver may leave of the equations' right-hand side.
    median : int
        Side of the median filter over motion after each warp, px; 1: none.
    nonlocal_median : bool
        With Lorentzian penalties, near motion boundaries, a weighted median of a large window instead.
    texture : bool
        Work on the pictures' texture instead of their grey levels.
    coarse_start : bool
        Start from dense inverse search on coarse levels, and from the shift that most of the picture shares
        where that is large and explains a pixel better; else from rest.
    """

    stages: tuple[Stage, ...]
    blur: float
    warp_count: int
    weighing_count: int
    tolerance: float
    median: int
    nonlocal_median: bool
    texture: bool
    coarse_start: bool


PRESETS = {
    "accurate": Settings(
        stages=(
            Stage(1.0, 2.0, 4, 0.045, 3.5, 0.1),
            Stage(0.0, 1.25, 2, 0.045, 3.5, 0.1),
            Stage(0.0, 1.25, 2, 0.045, 1.5, 0.04),
        ),
        blur=0.35,
        warp_count=3,
        weighing_count=1,
        tolerance=0.05,
        median=5,
        nonlocal_median=True,
        texture=True,
        coarse_start=True,
    ),
    "soft-2014": Settings(
        stages=(
            Stage(1.0, 2.0, 4, 0.05, 6.3, 0.1),
            Stage(0.0, 1.25, 2, 0.1, 12.6, 0.2),
            Stage(0.0, 1.25, 2, 0.1, 6.3, 0.1),
        ),
        blur=0.71,
        warp_count=3,
        weighing_count=3,
        tolerance=0.01,
        median=1,
        nonlocal_median=False,
        texture=False,
        coarse_start=False,
    ),
}
