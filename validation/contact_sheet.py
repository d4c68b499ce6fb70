"""One picture of every shipped scene, clean and disturbed: a sheet to look over."""

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation import chain
from validation.manifest import key_of
from validation.run_folder import RunFolder
from validation.studies.nuisance import SEVERITIES, disturbed
from validation.terminal import Terminal
from validation.versions import package_version

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from synth.recording import Recording
    from synth.scene import AnyScene, Scene

SHEET = "contact-sheet.jpg"
RUNS = "runs"
"""Folder below the sheet's with a run folder for each scene."""
CLEAN = "clean"
LEVELS = {CLEAN: None, "light": 0, "heavy": 2}
"""Which of `SEVERITIES` every nuisance has, all at once."""
_SAMPLES = 4
"""Along each side of a pixel: fewer than for measuring, since the sheet shows pictures reduced."""
_CELL = (200, 400)
"""px, height and width of a picture on the sheet."""
_DOTS_PER_INCH = 100
_QUALITY = 72


def make_contact_sheet(
    out: Path,
    names: Sequence[str],
    *,
    given: Mapping[str, Path] | None = None,
    resume: bool = True,
    work: chain.Work,
    terminal: Terminal,
) -> Path:
    """Simulate what is missing, take the pictures, lay them out: OUT/contact-sheet.jpg and OUT/*.png.

    Every scene in its quick version, where it has one: `OUT/runs` has a run folder for each. Called again, it
    does only what is missing.

    Parameters
    ----------
    names : sequence of str
        Shipped scenes.
    given : mapping, optional
        Run folders elsewhere, by scene; their recordings are used.

    Returns
    -------
    Path
        The sheet.

    Raises
    ------
    SceneError
        A scene that there is not; nothing is done then.
    """
    scenes = {name: quick_scene(name) for name in names}  # all of them before the first is simulated
    with RunFolder.create(out) as folder:
        rows: dict[str, list[Path]] = {}
        for number, (name, scene) in enumerate(scenes.items(), start=1):
            terminal.say(f"contact sheet: scene {number} of {len(scenes)}: {name}")
            place = (given or {}).get(name, out / RUNS / name)
            with RunFolder.create(place) as run:
                chain.simulate(run, scene, work=work, terminal=terminal, resume=resume)
                rows[name] = _pictures(folder, scene, run)
        sheet = key_of(step="contact-sheet", made_by=package_version("softbed"), rows=_digests(folder, rows))
        if folder.why_do("contact-sheet", sheet) is not None:
            with folder.writing("contact-sheet", sheet) as draft:
                _write(draft.folder / SHEET, draw_sheet(rows))
    return out / SHEET


def quick_scene(name: str) -> "AnyScene":
    """A shipped scene's quick version; the scene itself where it has none."""
    from synth import SceneError, load_scene

    try:
        return load_scene(name, quick=True)
    except SceneError:
        return load_scene(name)


def draw_sheet(rows: "dict[str, list[Path]]") -> "Figure":
    """Scenes with several pictures one below the other; at the end, several to a line, those with one."""
    from matplotlib.figure import Figure

    columns = len(LEVELS)
    several = {name: paths for name, paths in rows.items() if len(paths) > 1}
    single = [(name, paths[0]) for name, paths in rows.items() if len(paths) == 1]
    lines: list[list[tuple[str, Path]]] = [
        [(f"{name}, {_soil_of(name)}, {level}", path) for level, path in zip(LEVELS, paths, strict=True)]
        for name, paths in several.items()
    ]
    lines += [single[k : k + columns] for k in range(0, len(single), columns)]
    height, width = _CELL
    size = (columns * (width + 6) / _DOTS_PER_INCH, len(lines) * (height + 22) / _DOTS_PER_INCH)
    figure = Figure(figsize=size, dpi=_DOTS_PER_INCH)
    grid = figure.subplots(len(lines), columns, squeeze=False)
    gap = {"wspace": 6 / width, "hspace": 22 / height}
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1 - 18 / (len(lines) * (height + 22)), **gap)
    for place in grid.ravel():
        place.axis("off")
    for line, shown in enumerate(lines):
        for place, (title, path) in enumerate(shown):
            _show(grid[line, place], title, path)
    return figure


def _soil_of(name: str) -> str:
    from synth import load_scene
    from synth.scene import Scene

    scene = load_scene(name)
    assert isinstance(scene, Scene)  # analytic ones have one picture
    return scene.soil.name


def _show(axes: "Axes", title: str, path: Path) -> None:
    import cv2

    picture = np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE))
    axes.imshow(_fitted(picture), cmap="gray", vmin=0, vmax=255, interpolation="nearest", aspect="auto")
    axes.set_title(title, fontsize=8, loc="left", pad=2)


def _fitted(picture: np.ndarray) -> np.ndarray:
    """The middle of a picture, as much as a cell's shape takes, in the cell's size."""
    import cv2

    height, width = _CELL
    scale = min(picture.shape[0] / height, picture.shape[1] / width)
    rows, columns = round(scale * height), round(scale * width)
    top, left = (picture.shape[0] - rows) // 2, (picture.shape[1] - columns) // 2
    part = picture[top : top + rows, left : left + columns]
    return np.asarray(cv2.resize(part, (width, height), interpolation=cv2.INTER_AREA))


def _write(path: Path, figure: "Figure") -> None:
    import cv2
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    grey = np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[..., 0])
    if not cv2.imwrite(str(path), grey, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY]):
        raise OSError(f"{path}: the sheet could not be written")


def _pictures(folder: RunFolder, scene: "AnyScene", run: RunFolder) -> list[Path]:
    """Take a scene's pictures at every level, unless they are there."""
    from synth import AnalyticScene

    levels: dict[str, Any] = {CLEAN: None} if isinstance(scene, AnalyticScene) else LEVELS
    names = [f"{scene.name}-{level}.png" for level in levels]
    key = key_of(
        step=f"pictures {scene.name}",
        made_by={name: package_version(name) for name in ("softbed", "numpy", "taichi")},
        recording=run.manifest.steps["simulate"].facts["digest"],
        scene=scene.hash,
        severities={name: [several[0], several[2]] for name, several in SEVERITIES.items()},
    )
    if folder.why_do(f"pictures {scene.name}", key) is not None:
        from synth import Recording

        recording = Recording.read(run.recording)
        with folder.writing(f"pictures {scene.name}", key) as draft:
            for name, level in zip(names, levels.values(), strict=True):
                _take(recording, _at_level(scene, level), draft.folder / name)
    return [folder.path / name for name in names]


def _at_level(scene: "AnyScene", level: int | None) -> "AnyScene":
    from synth.scene import AnalyticScene

    if isinstance(scene, AnalyticScene):
        return scene
    camera = scene.camera.model_copy(update={"supersampling": _SAMPLES})
    coarse = scene.model_copy(update={"camera": camera})
    if level is None:
        return coarse
    return disturbed(coarse, {name: several[level] for name, several in SEVERITIES.items()})


def _take(recording: "Recording", scene: "AnyScene", path: Path) -> None:
    """Take the picture in the middle of a recording."""
    from synth import Recording
    from synth.footage import write_picture
    from synth.scene import AnalyticScene

    middle = max((recording.frame_count - 1) // 2, 1)
    part = Recording(recording.data.isel(frame=slice(middle - 1, middle + 1)))
    picture = _analytic(part, scene) if isinstance(scene, AnalyticScene) else _photograph(part, scene)
    if picture.dtype != np.uint8:
        picture = np.rint(picture / 257).astype(np.uint8)
    write_picture(path, picture)


def _analytic(part: "Recording", scene: "AnyScene") -> np.ndarray:
    from synth import render

    with tempfile.TemporaryDirectory() as place, render(part, scene, Path(place) / "footage") as footage:
        return footage.picture(0)


def _photograph(part: "Recording", scene: "Scene") -> np.ndarray:
    """The second of two frames alone, without truth."""
    from synth.camera.nuisance import as_seen
    from synth.camera.photographer import Photographer
    from synth.devices import start_taichi
    from synth.truth import grains_and_motion

    start_taichi()
    seen = as_seen(part, scene)
    grains, motion = grains_and_motion(seen, scene)
    first = motion.start()
    _, picture = Photographer(scene, seen, grains, motion).take(motion.advance(first), first)
    return picture


def _digests(folder: RunFolder, rows: "dict[str, list[Path]]") -> dict[str, list[str]]:
    return {name: [folder.manifest.files[path.name] for path in paths] for name, paths in rows.items()}
