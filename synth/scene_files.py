"""Where the shipped scenes and soils are: one resolver for an installed wheel and for a checkout."""

from pathlib import Path

_PACKAGE = Path(__file__).parent
_CANDIDATES = (_PACKAGE / "scenes", _PACKAGE.parent / "scenes")


def scenes_folder() -> Path:
    """Folder with the shipped scenes.

    A wheel carries it inside the package; an editable install leaves it beside the package.

    Raises
    ------
    FileNotFoundError
        The installation is incomplete.
    """
    for folder in _CANDIDATES:
        if (folder / "soils").is_dir():
            return folder
    raise FileNotFoundError(f"the shipped scenes are at neither of {[str(folder) for folder in _CANDIDATES]}")


def scene_names() -> list[str]:
    """Names of the shipped scenes, sorted."""
    return sorted(path.stem for path in scenes_folder().glob("*.toml"))


def study_scene_names() -> list[str]:
    """Names of the small scenes that studies were carried out on, `studies/NAME`, sorted."""
    return sorted(f"studies/{path.stem}" for path in (scenes_folder() / "studies").glob("*.toml"))


def soil_names() -> list[str]:
    """Names of the shipped soils, sorted."""
    return sorted(path.stem for path in (scenes_folder() / "soils").glob("*.toml"))
