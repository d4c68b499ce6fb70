"""Processes that end with whoever started them."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

PATIENCE = 300
"""s, on a busy machine; the worker would sleep for longer."""
KILLED = """
import os, time
from validation.processes import worker_processes

if __name__ == "__main__":
    with worker_processes(1) as pool:
        print(pool.submit(os.getpid).result(), flush=True)
        pool.submit(time.sleep, 3600)
        time.sleep(3600)
"""


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are looked for in /proc")
def test_a_killed_process_leaves_no_worker_behind(tmp_path):
    script = tmp_path / "killed.py"
    script.write_text(KILLED, encoding="utf-8")
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as parent:
        worker = int(parent.stdout.readline())
        parent.kill()
    end = time.monotonic() + PATIENCE
    while runs(worker):
        assert time.monotonic() < end, "the process goes on"
        time.sleep(0.05)


def runs(process):
    """Neither gone, also while we look, nor waiting to be buried."""
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
