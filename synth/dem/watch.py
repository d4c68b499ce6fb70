"""When to look at how far grains have moved, and when to list neighbours anew."""

from dataclasses import dataclass

REBUILD_AT = 0.4
"""Share of the skin a grain may move before neighbours are listed anew; past half, contacts are missed."""
_FIRST_LOOK, _MOST = 8, 128
"""Steps before the first look, and between two looks at most.

Each time up to twice as many as the last, so that a grain that is thrown out of an overlap is seen in time.
"""
_LEAST = 8
"""Steps between two looks, at least: neighbours are listed anew rather than looked at more often."""


@dataclass
class Watch:
    """Looks at the grains between launches.

    The next look is due when the fastest grain, at its present speed, moves half of what is left to it.

    Parameters
    ----------
    skin : float
        Thickness of the neighbour list's skin, m.
    period : int
        Steps between the last look and the next.
    unwatched : int
        Steps since the last look.
    """

    skin: float
    period: int = _FIRST_LOOK
    unwatched: int = 0

    @property
    def left(self) -> int:
        """Steps until the next look."""
        return max(0, self.period - self.unwatched)

    def too_far(self, shift: float) -> bool:
        """Whether a contact may have been missed where something moved so far, m, since the listing."""
        return shift > 0.5 * self.skin

    def list_anew(self, shift: float, reach: float) -> bool:
        """Plan the next look; returns whether neighbours have to be listed anew before.

        Parameters
        ----------
        shift, reach : float
            The farthest that anything has moved since the listing, and moves in one step, m.
        """
        reach = max(reach, 1e-9 * self.skin)
        room = REBUILD_AT * self.skin - shift
        anew = 0.5 * room < _LEAST * reach
        if anew:
            room = REBUILD_AT * self.skin
        self.period = max(1, int(min(2 * self.period, _MOST, 0.5 * room / reach)))
        self.unwatched = 0
        return anew
