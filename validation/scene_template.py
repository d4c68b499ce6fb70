"""A scene file to start from."""

import re
from pathlib import Path

from synth import SceneError, load_scene, scene_names
from synth.scene_files import scenes_folder

_HEADER = """\
# A scene of your own, copied from the shipped scene {source!r}.
# Every number may be changed; unknown keys are refused.
#   softbed run {file} OUT            simulate, render, analyze, score, report
#   softbed run {file} OUT --quick    the same with what the [quick] tables change
# `soil` is a shipped soil's name or a table like those in the run folder's scene.toml, which has every key.

"""


def write_template(file: Path, source: str) -> None:
    """Write a copy of a shipped scene, with its comments, under the name of `file`.

    Raises
    ------
    SceneError
        There is such a file already, or no such scene.
    """
    if source not in scene_names():
        raise SceneError(f"--from {source!r}: shipped scenes are {', '.join(scene_names())}")
    shipped = (scenes_folder() / f"{source}.toml").read_text(encoding="utf-8")
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", file.stem) or "scene"
    named = re.sub(r'^name = ".*"$', f'name = "{name}"', shipped, count=1, flags=re.MULTILINE)
    try:
        with file.open("x", encoding="utf-8") as stream:
            stream.write(_HEADER.format(source=source, file=file) + named)
    except FileExistsError:
        raise SceneError(f"{file}: exists already: nothing is overwritten, choose another name") from None
    load_scene(file)
