"""scikit-image counts (row, column) and is an optional extra."""

import subprocess
import sys

import numpy as np
import pytest

from soft.flow import BUILT_IN, NEEDS, estimate_flow, installed, registry
from soft.flow.skimage import to_displacement


def test_rows_become_v_and_columns_u():
    flow = np.stack([np.full((4, 6), 2.0), np.full((4, 6), -1.0)])
    assert to_displacement(flow).shape == (4, 6, 2)
    assert (to_displacement(flow) == [-1.0, 2.0]).all()


@pytest.mark.parametrize("method", ["tvl1", "ilk"])
def test_displacement_is_on_the_first_pictures_grid(moved, method):
    """Turned by 0.05 rad and moved by (5, -3) px, the two grids' displacements differ by up to 0.29 px."""
    first, second, truth = moved(matrix=((1.0, -0.05), (0.05, 1.0)), shift=(5.0, -3.0))
    # On the second grid stands at x what belongs at x - (5, -3), nearly: less by the gradient times that.
    on_second = truth - np.array([[0, -0.05], [0.05, 0]]) @ [5.0, -3.0]
    field = estimate_flow(first, second, method=method)
    inner = np.s_[24:-24, 24:-24]
    error, other = (
        np.median(np.hypot(*np.moveaxis(field.displacement - t, -1, 0))[inner]) for t in (truth, on_second)
    )
    assert error < 0.1 and other > 3 * error


@pytest.mark.parametrize("method", ["tvl1", "ilk"])
def test_where_it_is_missing_the_message_says_how_to_get_it(method):
    code = (
        "import sys; sys.modules['skimage'] = None; import numpy as np; from soft.flow import *\n"
        "picture = np.random.default_rng(0).uniform(0, 255, (40, 50))\n"
        f"try: estimate_flow(picture, picture, method={method!r})\n"
        "except FlowError as error: print(error)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.startswith(f"method '{method}' needs scikit-image")
    assert "pip install 'softbed[skimage]'" in said and said.count("\n") == 1


def test_what_is_installed(monkeypatch):
    assert installed() == sorted(BUILT_IN)
    monkeypatch.setattr(registry, "NEEDS", dict.fromkeys(NEEDS, "no-such-distribution"))
    assert installed() == sorted(set(BUILT_IN) - {"ilk", "tvl1"})
