"""Sums over blocks of 1, 2, 4, ... of something that comes one after the other, in little memory."""

from typing import Generic, Protocol, Self, TypeVar


class Summable(Protocol):
    """What can be added to its like."""

    def __add__(self, other: Self, /) -> Self:
        """Put both together."""
        ...


Block = TypeVar("Block", bound=Summable)


class DoublingBlocks(Generic[Block]):
    """Merges what is added as a binary counter carries: of blocks of each length, at most one waits."""

    def __init__(self) -> None:
        self._waiting: list[Block | None] = []

    def add(self, block: Block) -> list[Block]:
        """Add one; give the blocks that it completes: itself, and those of 2, 4, ... that end with it."""
        completed = [block]
        for level, waiting in enumerate(self._waiting):
            if waiting is None:
                self._waiting[level] = block
                return completed
            self._waiting[level] = None
            block = waiting + block
            completed.append(block)
        self._waiting.append(block)
        return completed
