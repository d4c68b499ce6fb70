"""What took long to compute is computed once, by one of those who want it at the same time."""

import multiprocessing
import threading
import time

import pytest

from synth.cache import cached
from synth.locks import locked, sole_maker

MADE_FROM = {"recipe": 1, "friction": 0.5}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SOFTBED_CACHE", str(tmp_path))
    return tmp_path


def ask(computed):
    def compute():
        computed.append(threading.get_ident())
        time.sleep(0.1)
        return [1.5, len(computed)]

    return cached("packing", MADE_FROM, compute)


def test_what_several_want_at_once_is_computed_by_one_of_them(cache):
    computed, found = [], []
    asking = [threading.Thread(target=lambda: found.append(ask(computed))) for _ in range(4)]
    for one in asking:
        one.start()
    for one in asking:
        one.join()
    assert found == [[1.5, 1]] * 4 and len(computed) == 1
    assert [path.suffix for path in (cache / "packing").iterdir()] == [".json"]  # and no lock


@pytest.mark.parametrize("content", ["", "{", "[]", "7", '{"made_from": {}}', "\udcff"])
def test_a_damaged_value_is_made_anew(cache, content):
    ask([])
    (path,) = (cache / "packing").iterdir()
    path.write_bytes(content.encode(errors="surrogateescape"))
    computed = []
    assert ask(computed) == ask(computed) == [1.5, 1] and len(computed) == 1


def hold(path, held):
    with sole_maker(path):
        held.set()
        time.sleep(3600)


def test_a_lock_ends_with_its_process(tmp_path):
    context = multiprocessing.get_context("fork")
    held = context.Event()
    maker = context.Process(target=hold, args=(tmp_path / "bed.npz", held))
    maker.start()
    assert held.wait(300)
    with locked(tmp_path / ".bed.npz.lock", wait=False) as handle:
        assert handle is None
    maker.kill()
    maker.join()
    with sole_maker(tmp_path / "bed.npz"):
        assert (tmp_path / ".bed.npz.lock").exists()
    assert not any(tmp_path.iterdir())


def test_computing_that_fails_lets_the_next_one_try():
    with pytest.raises(ZeroDivisionError):
        cached("packing", MADE_FROM, lambda: 1 // 0)
    assert ask([]) == [1.5, 1]
