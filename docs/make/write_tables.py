"""Write the tables of pages from the files in docs/measured: python docs/make/write_tables.py PAGE.md ...

A page holds a table between `<!-- measured: NAME -->` and `<!-- end -->`; `page_tables` has a function for
each NAME.
"""

import sys
from pathlib import Path

from page_tables import flow, pictures, scarab, score_my_method, simulator, wheel_law

from validation.markdown_tables import update_tables

KIND = "measured"
PAGES = (flow, pictures, scarab, score_my_method, simulator, wheel_law)
TABLES = {name: table for page in PAGES for name, table in page.TABLES.items()}

if __name__ == "__main__":
    for page in map(Path, sys.argv[1:]):
        update_tables(page, KIND, TABLES)
