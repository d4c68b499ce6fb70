"""How rows, tiles and parts of a picture are shared among threads.

taichi gives a CPU thread no fewer than 512 turns of a parallel loop, however long each takes: a loop over a
picture's rows would run on one or two threads. So such loops make `SHARES` turns of every item and do it in
the first of them; the others cost next to nothing.
"""

SHARES = 512
"""Turns of a parallel loop that one item of work is made of."""
