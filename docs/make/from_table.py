"""A study's figure from its kept table: python docs/make/from_table.py STUDY TABLE.csv FIGURE.png."""

import sys
from pathlib import Path

from kept import read_rows

from validation.figures import to_png
from validation.studies import find_study
from validation.studies.study import Findings

if __name__ == "__main__":
    name, table, figure = sys.argv[1:]
    drawn = find_study(name).draw(Findings(read_rows(Path(table)), conclusion=""))
    Path(figure).write_bytes(to_png(drawn))
