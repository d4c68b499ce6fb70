import ast
import subprocess
import sys
from pathlib import Path

import soft


def test_import_is_cheap():
    heavy = ("numpy", "xarray", "matplotlib", "sklearn", "cv2")
    code = f"import sys, soft; print([m for m in {heavy} if m in sys.modules])"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert loaded.strip() == "[]"


def test_every_public_name_is_there():
    assert sorted(soft._HOMES) == sorted(soft.__all__)
    for name in soft.__all__:
        assert callable(getattr(soft, name))


def test_function_stays_the_function_after_its_module_is_imported():
    import soft.analysis

    assert soft.analyze is soft.analysis.analyze


def test_imports_neither_of_the_other_packages():
    for path in Path(soft.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [n for n in names if n.split(".")[0] in ("synth", "validation")], path
