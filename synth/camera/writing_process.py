"""A process that writes frames. It ends with the one that started it, however that ends."""

import json
import os
import subprocess
import sys
from multiprocessing.connection import Connection

# It takes the modules from where its parent has them, and needs no guard in the parent's main module.
_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from synth.camera.writing_process import main; main(*map(int, sys.argv[2:]))"
)


def start_process(orders: Connection, memory: int) -> subprocess.Popen[bytes]:
    """Start a process that takes orders from a connection, with the memory of a file descriptor.

    The first thing it gets must be its `Footing`.
    """
    handed_on = (orders.fileno(), memory)
    return subprocess.Popen(
        [sys.executable, "-c", _CODE, json.dumps(sys.path), *map(str, handed_on)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        pass_fds=handed_on,
        process_group=0,  # an interrupt is for the parent, which tells when it is over
    )


def main(orders: int, memory: int) -> None:
    """What the process does."""
    from synth.camera.rooms import memory_for, rooms_in
    from synth.camera.writing_end import carry_out

    connection = Connection(orders)
    try:
        footing = connection.recv()
    except EOFError:
        return
    shared = memory_for(footing.shape, memory)
    os.close(memory)
    carry_out(connection, footing, rooms_in(shared, footing.shape))
