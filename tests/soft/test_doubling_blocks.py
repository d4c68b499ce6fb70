"""Blocks of 1, 2, 4, ... hold what was added last, and every one of them once."""

from soft.doubling_blocks import DoublingBlocks


def test_completes_blocks_as_a_counter_carries():
    blocks = DoublingBlocks()
    given = [blocks.add(number) for number in (1, 10, 100, 1000, 10_000)]
    assert given == [[1], [10, 11], [100], [1000, 1100, 1111], [10_000]]


def test_order_is_kept():
    blocks = DoublingBlocks()
    assert [blocks.add(letter)[-1] for letter in "abcdefgh"] == [
        "a",
        "ab",
        "c",
        "abcd",
        "e",
        "ef",
        "g",
        "abcdefgh",
    ]
