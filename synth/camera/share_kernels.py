# type: ignore  # taichi reads annotations and operators in its own way
"""How rows, tiles and parts of a picture are shared among threads.

taichi cuts a parallel loop into as many pieces as there are threads, of no fewer than 512 turns, however long
each takes: a loop over a picture's rows would run on one or two threads. So such loops make `SHARES` turns of
every item and do it in the first of them; the others cost next to nothing, but not nothing: one thread alone
makes one turn of each.

Nor do the pieces take equally long: half of a picture may be sky. Where that matters, items are `dealt`.
"""

import taichi as ti

from synth.devices import thread_count

SHARES = 512 if thread_count() > 1 else 1
"""Turns of a parallel loop that one item of work is made of."""
ROWS, TILES = 32, 4
"""Rows of pixels, or tiles, dealt together: they mostly need the same grains."""


@ti.func
def dealt(turn, count, together: ti.template()):
    """Item whose turn it is, of `count`: runs of `together` neighbours go to one thread after the other."""
    return dealt_to(turn, count, together, ti.static(thread_count()))


@ti.func
def dealt_to(turn, count, together: ti.template(), hands: ti.template()):
    """The same for any number of hands, each of which takes its turns one after the other.

    What is left where not every hand gets another run comes last, in its own order.
    """
    rounds = count // (together * hands)
    item = turn
    if turn < rounds * together * hands:
        hand, own = turn // (rounds * together), turn % (rounds * together)
        item = ((own // together) * hands + hand) * together + own % together
    return item
