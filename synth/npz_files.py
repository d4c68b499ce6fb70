"""NumPy's `.npz` files, which a full disk or a killed process may have left damaged."""

import zipfile
import zlib

UNREADABLE = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error)
"""What reading an array of one that is not there, or damaged, raises."""
