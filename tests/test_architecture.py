"""Which package may import which, and that nothing heavy is imported before it is needed."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
MAY_IMPORT = {
    "soft": {"soft"},
    "synth": {"synth"},
    "validation": {"soft", "synth", "validation"},
}
NEEDING_TORCH = {"TorchPairs"}
"""Public names whose import needs PyTorch, which the tests do without."""
HEAVY = (
    "cv2",
    "h5netcdf",
    "h5py",
    "jinja2",
    "matplotlib",
    "mujoco",
    "numpy",
    "pydantic",
    "scipy",
    "skimage",
    "sklearn",
    "taichi",
    "xarray",
)


def imported_packages(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.partition(".")[0]


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_import_direction(room):
    for path in sorted((ROOT / room).rglob("*.py")):
        strangers = set(imported_packages(path)) & set(MAY_IMPORT) - MAY_IMPORT[room]
        assert not strangers, f"{path.relative_to(ROOT)} imports {strangers}"


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_no_future_annotations(room):
    # They break taichi kernels, and one rule for all is easier to keep.
    for path in sorted((ROOT / room).rglob("*.py")):
        assert "__future__" not in set(imported_packages(path)), path.relative_to(ROOT)


@pytest.mark.parametrize(
    "statement", ["import soft, synth, validation", "import validation.cli, soft.flow.registry"]
)
def test_imports_nothing_heavy(statement):
    code = f"import sys; {statement}; print(*sorted(set(sys.modules) & set({HEAVY!r})))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == []


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from validation.cli import run_command; run_command(['--help']);"
        f"print('found', *sorted(set(sys.modules) & set({HEAVY!r})))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.splitlines()[-1] == "found"


@pytest.mark.parametrize("package", ["soft", "soft.flow", "synth", "synth.dataset"])
def test_public_names_are_listed_found_and_known_to_type_checkers(package):
    module = importlib.import_module(package)
    tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    typed = [alias.name for node in block.body for alias in node.names]
    assert sorted(typed) == sorted(module.__all__) == sorted(module._HOMES)
    assert set(module.__all__) <= set(dir(module))
    assert all(hasattr(module, name) for name in set(module.__all__) - NEEDING_TORCH)
    assert (ROOT / package.partition(".")[0] / "py.typed").is_file()
