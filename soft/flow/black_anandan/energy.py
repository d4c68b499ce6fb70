"""The energy of a motion field on one level of a pyramid, and how it is lowered.

With first picture I1, second I2, motion u, penalties D and S and their weight::

    E(u) = sum over pixels of D(I2(x + u) - I1(x))
         + smoothness * sum over neighbours x, x' of (S(u(x) - u(x')) + S(v(x) - v(x')))

as in Black and Anandan (1996, Eq. 25), Sun, Roth and Black (2010, Eq. 1).
"""

import numpy as np

from soft.flow.black_anandan.pyramid import Level
from soft.flow.black_anandan.settings import Stage
from soft.flow.black_anandan.system import System

_HOLD = 1e-4
"""What ties a change of flow to zero / what ties neighbours' flow together."""


class Energy:
    """Of a level under a stage's penalties, around a field where it was made linear last."""

    def __init__(self, level: Level, stage: Stage) -> None:
        self._level, self._stage = level, stage
        self.linked, self.data_width = level.linked, stage.data_width
        self.equation = np.zeros((*level.usable.shape, 4), np.float32)
        self.system = System(level.usable.shape)

    def linearize(self, flow: np.ndarray) -> np.ndarray:
        """Warp the second picture by `flow` (H, W, 2) and expand the data term there.

        Returns
        -------
        (H, W, 4) float32
            Grey level there, its slopes along x and y, and 1 where it is in sight, else 0.
        """
        from soft.flow.black_anandan.energy_kernels import linearize
        from soft.flow.spline_kernels import warp

        warped = np.empty_like(self.equation)
        warp(self._level.coefficients, 1, flow, 1, warped)
        linearize(self._level.first, warped, self._level.usable, flow, self.equation)
        return warped

    def weigh(self, flow: np.ndarray) -> None:
        """Fill in the linear equations for the next change of `flow`; their right side is minus its slope."""
        from soft.flow.black_anandan.energy_kernels import weigh

        stage, system = self._stage, self.system
        hold = _HOLD * stage.smoothness / stage.step_width**2
        weigh(
            self.equation, self._level.linked, flow, stage.convex, stage.data_width, stage.step_width,
            stage.smoothness, hold, system.tensor, system.links, system.right,
        )  # fmt: skip
        system.prepare()

    def lowered(self, flow: np.ndarray, tolerance: float) -> np.ndarray:
        """`flow` after one weighing and solution of the equations."""
        self.weigh(flow)
        return flow + self.system.solve(tolerance)

    def noise(self, flow: np.ndarray) -> float:
        """Standard deviation of what brightness constancy leaves at `flow`, grey levels, without outliers."""
        used = self.equation[self.equation[:, :, 3] > 0]
        if not len(used):
            return 0.0
        u, v = flow[self.equation[:, :, 3] > 0].T
        return float(1.4826 * np.median(np.abs(used[:, 0] * u + used[:, 1] * v + used[:, 2])))
