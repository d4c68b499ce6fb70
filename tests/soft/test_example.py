import re
import subprocess
import sys
from pathlib import Path

import pytest

from soft import read_soil_flow

SCRIPT = Path(__file__).parents[2] / "docs" / "analyze_photographs.py"


def test_script_in_the_docs(picture_folder, tmp_path_factory):
    """Three pictures moved by (1.5, -0.75) px: at 0.2 mm and 8 a second, 0.24 cm/s."""
    result = tmp_path_factory.mktemp("out") / "flow.nc"
    command = [sys.executable, str(SCRIPT), str(picture_folder), str(result)]
    told = subprocess.run(command, capture_output=True, text=True, cwd=SCRIPT.parents[1], check=True).stdout
    assert re.search(
        r"resting soil 1\.50\d ± 0\.00\d px a pair \(95 % of 2 pairs\): camera -0\.24\d ± 0\.00\d cm/s", told
    )
    # What is left to be seen is the vertical, 0.75 px: 0.12 cm/s.
    fastest = float(re.search(r"soil moves at ([\d.]+) cm/s", told)[1])
    assert fastest == pytest.approx(0.12, rel=0.3)
    with read_soil_flow(result) as flow:
        assert flow.sizes["pair"] == 2
    assert [path.name for path in result.parent.iterdir()] == ["flow.nc"]
