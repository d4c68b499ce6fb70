"""Do what docs/tutorials/score_my_method.md does on a shear band: python docs/make/tutorial_scores.py FOLDER.

Leaves FOLDER/band, a run folder. The method is the one that stands in the page.
"""

import os
import re
import sys
from pathlib import Path

from validation.cli import run_command

PAGE = Path(__file__).parents[1] / "tutorials" / "score_my_method.md"


def method_of_the_page() -> str:
    """The page's `my_flow.py`."""
    (found,) = re.findall(r"```python\n(# my_flow\.py\n.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    return found


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "my_flow.py").write_text(method_of_the_page(), encoding="utf-8")
    os.chdir(folder)
    sys.path.insert(0, "")
    methods = ["--method", "my_flow:flow", "--method", "dis"]
    sys.exit(run_command(["run", "shear_band", "band", "--quick", *methods]))
