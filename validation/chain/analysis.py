"""Pictures to soil flow, and its figures."""

import os
import shutil
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.chain.scoring import require_truth
from validation.chain.step import Work, made_by, skips
from validation.manifest import RunFolderError, file_digest, key_of
from validation.material import Material
from validation.methods import DEFAULT, Method
from validation.processes import worker_processes
from validation.run_folder import RunFolder
from validation.terminal import Terminal

if TYPE_CHECKING:
    from concurrent.futures import Executor
    from contextlib import AbstractContextManager

    import xarray as xr

    from soft import AnalysisSettings, ImageSequence

_NARROWEST, _WIDEST = 0.01, 10.0
"""Width in m that pictures of a soil bin may have."""
_STILL = 0.3
"""Px a pair; what 95 % of the published technique's errors do not exceed."""
_STEADY = 1.0
"""Px; a carriage's motion changes less from pair to pair."""
_PAIRS_LOOKED_AT = 5
_NEVER_SKIPPED = "a function of your own, whose code may have changed"


def analyze(
    run: RunFolder,
    material: Material,
    method: Method,
    *,
    settings: "AnalysisSettings | None" = None,
    work: Work,
    terminal: Terminal,
) -> None:
    """Write `analysis/<method>.nc`; say how the camera moved.

    Flow is kept pair by pair until the file is whole: stopped, the same command measures what is missing.
    """
    import soft

    settings = settings or soft.AnalysisSettings()
    _require_same_place(run, material)
    key = _analyze_key(material, method, settings)
    step = _analyze_step(method)
    if skips(run, step, key, terminal, never=_NEVER_SKIPPED if method.is_function else None):
        return
    if material.sequence.remark:
        terminal.say(f"warning: {material.sequence.remark}")
    _tell_size(material.sequence, terminal)
    kept = run.kept_flow(method.slug)
    if kept.is_dir():
        terminal.say(f"{step}: was stopped: flow of {len(list(kept.glob('*.npz')))} pairs is kept")
    with (
        run.writing(step, key) as draft,
        terminal.progress(f"analyze with {method.name}") as progress,
        _executor(work) as executor,
    ):
        path = draft.folder / "analysis" / f"{method.slug}.nc"
        path.parent.mkdir()
        with soft.analyze(
            material.sequence,
            method=method.name,
            options=_options(method, settings),
            soil=settings.soil.kind,
            camera=settings.camera.motion,
            vertical=settings.camera.vertical,
            seed=settings.flow.seed,
            threads=work.threads if executor is None else _threads_each(work),
            device=work.device,
            progress=progress,
            path=path,
            keep=kept,
            executor=executor,
        ) as flow:
            travel = str(flow.attrs["camera_speed"])
            doubts = _camera_doubts(flow, settings)
        draft.facts |= {
            "method": method.name,
            "pictures": material.digest,
            "picture_files": material.files_digest,
            "source": _source(run, material),
            "soil": settings.soil.kind,
            "vertical": settings.camera.vertical,
            "settings": settings.rooted().to_dict(),
            "camera_speed": travel,
        }
    shutil.rmtree(kept, ignore_errors=True)
    terminal.say(f"  camera: {travel}")
    for doubt in doubts:
        terminal.say(f"  warning: {doubt}")


def _tell_size(sequence: "ImageSequence", terminal: Terminal) -> None:
    """Say how large the pictures are: with millimetres given for metres, one is as wide as a town."""
    if sequence.metres_per_pixel is None:
        return
    rows, columns = sequence.shape
    width = columns * sequence.metres_per_pixel
    size = f"{columns} x {rows} px of {sequence.metres_per_pixel:.4g} m: {width:.3g} m wide"
    if _NARROWEST <= width <= _WIDEST:
        terminal.say(f"  pictures: {size}")
    else:
        terminal.say(f"warning: pictures: {size}: is the pixel size in metres?")


def _require_same_place(run: RunFolder, material: Material) -> None:
    """Refuse to replace what was measured in pictures that lie elsewhere and are others.

    Raises
    ------
    RunFolderError
        It would be replaced.
    """
    for step, record in run.manifest.steps.items():
        if not step.startswith("analyze ") or "source" not in record.facts:
            continue
        elsewhere = record.facts["source"] != _source(run, material)
        if elsewhere and record.facts["picture_files"] != material.files_digest:
            raise RunFolderError(
                f"{run.path}: holds what was measured in {record.facts['source']}: nothing is replaced, "
                "choose another folder with --out"
            )


def _source(run: RunFolder, material: Material) -> str:
    """Where pictures lie; those of a run folder move with it."""
    place, home = material.folder.resolve(), run.path.resolve()
    return str(place.relative_to(home) if place.is_relative_to(home) else place)


def draw(run: RunFolder, material: Material, methods: Sequence[Method], *, terminal: Terminal) -> None:
    """Write `figures/` of measurements on pictures without truth, of the pair that `softbed figure` shows."""
    import soft
    from validation.pair_view import middle_pair

    paths = {method.slug: run.analysis(method.slug) for method in methods}
    key = key_of(step="figures", made_by=made_by(), analyses={s: file_digest(p) for s, p in paths.items()})
    if skips(run, "figures", key, terminal):
        return
    with run.writing("figures", key) as draft, terminal.progress("figures") as progress:
        for done, (slug, path) in enumerate(paths.items(), start=1):
            folder = draft.folder / run.figures.name / slug
            folder.mkdir(parents=True)
            with soft.read_soil_flow(path) as flow:
                pair = middle_pair(flow.sizes["pair"])
                soft.write_figures(flow, material.sequence, folder, pair=pair)
                terminal.say(f"  {slug}, pair {pair}: {_interface_told(flow, pair, folder)}")
                agreement = _agreement_told(flow, pair, material.sequence)
                terminal.say(f"  {slug}, SIFT on pair {pair}: {agreement}")
            progress(done, len(paths))


def _interface_told(flow: "xr.Dataset", pair: int, folder: Path) -> str:
    """Write the shear interface of a pair; say what it is."""
    import soft

    interface = soft.shear_interface_of(flow, pair=pair)
    path = folder / f"interface-{pair:04d}.csv"
    soft.write_interface(interface, path, metres_per_pixel=flow.attrs.get("metres_per_pixel"))
    return interface.remark


def _agreement_told(flow: "xr.Dataset", pair: int, sequence: "ImageSequence") -> str:
    """How well the flow of a pair agrees with SIFT."""
    import numpy as np

    import soft

    one = flow[["u", "v", "valid", "soil", "first_frame", "second_frame"]].isel(pair=pair).load()
    first, second = (sequence[int(one[name])] for name in ("first_frame", "second_frame"))
    displacement = np.stack([one["u"].values, one["v"].values], axis=2)
    check = soft.cross_validate(first, second, displacement, one["valid"].values, mask=one["soil"].values)
    return check.remark


def analyzed_methods(run: RunFolder, material: Material, *, terminal: Terminal) -> list[Method]:
    """Methods whose analysis of these very pictures is there; says which are left out."""
    found = []
    for step, record in run.manifest.steps.items():
        if not step.startswith("analyze "):
            continue
        method = Method(str(record.facts.get("method")))
        reason = run.why_do(step, record.key)
        if record.facts.get("pictures") != material.digest:
            reason = "of other pictures than these"
        if reason is None:
            found.append(method)
        else:
            terminal.say(f"{step}: {reason}: left out")
    return found


def require_methods(methods: Sequence[Method]) -> None:
    """Refuse, before long work is done, a method that does not exist.

    Raises
    ------
    soft.FlowError
        A name that leads nowhere.
    """
    from soft.flow import find_estimator

    for method in methods:
        find_estimator(method.name)


def methods_to_score(
    run: RunFolder, material: Material, asked: Sequence[Method], *, work: Work, terminal: Terminal
) -> list[Method]:
    """Choose the methods asked for, analyzed where needed; else all analyzed ones; else the default."""
    require_truth(material)
    methods = list(asked) or analyzed_methods(run, material, terminal=terminal)
    if asked or not methods:
        methods = methods or [Method(DEFAULT)]
        for method in methods:
            analyze(run, material, method, work=work, terminal=terminal)
    return methods


def _camera_doubts(flow: "xr.Dataset", settings: "AnalysisSettings") -> list[str]:
    """Say where what was taken out may not be the camera's motion, or not all of it."""
    import soft

    doubts = []
    down = _median_down(flow)
    if not settings.camera.vertical and abs(down) > _STILL:
        doubts.append(
            f"most soil moves {abs(down):.1f} px {'down' if down > 0 else 'up'} a pair, which is left in: "
            "if that is the camera, give --vertical"
        )
    if settings.camera.motion == "median" and soft.camera_speed(flow).u_range > _STEADY:
        doubts.append(
            "that changes much from pair to pair: where over half of the soil moves, its median is not the "
            "camera's motion: see --camera mode and far"
        )
    return doubts


def _median_down(flow: "xr.Dataset") -> float:
    """Median of soil's vertical displacement in some of the pairs, px."""
    import numpy as np

    count = flow.sizes["pair"]
    found = []
    for pair in range(0, count, max(count // _PAIRS_LOOKED_AT, 1)):
        one = flow[["v", "soil"]].isel(pair=pair).load()
        down = one["v"].values[one["soil"].values.astype(bool)]
        found.append(float(np.nanmedian(down)) if np.isfinite(down).any() else np.nan)
    return float(np.nanmedian(found)) if np.isfinite(found).any() else 0.0


def _executor(work: Work) -> "AbstractContextManager[Executor | None]":
    return worker_processes(work.processes) if work.processes > 1 else nullcontext()


def _threads_each(work: Work) -> int:
    return max((work.threads or os.cpu_count() or 1) // work.processes, 1)


def _analyze_step(method: Method) -> str:
    return f"analyze {method.slug}"


def _options(method: Method, settings: "AnalysisSettings") -> dict[str, Any]:
    """Options of the method that they were set for; any other has its defaults."""
    return dict(settings.flow.options) if method.name == settings.flow.method else {}


def _analyze_key(material: Material, method: Method, settings: "AnalysisSettings") -> str:
    return key_of(
        step="analyze",
        made_by=made_by("numpy", "opencv-python-headless", "scikit-learn", *_needs(method)),
        pictures=material.digest,
        method=method.name,
        options=_options(method, settings),
        files=_flow_files(method),
        soil=settings.soil.kind,
        camera=settings.camera.motion,
        vertical=settings.camera.vertical,
        seed=settings.flow.seed,
    )


def _needs(method: Method) -> list[str]:
    from soft.flow import NEEDS

    return [NEEDS[method.name]] if method.name in NEEDS else []


def _flow_files(method: Method) -> list[str]:
    """SHA-256 of every file of flow measured elsewhere, in order."""
    if not method.is_files:
        return []
    from soft.flow import FlowFiles

    return [file_digest(path) for path in FlowFiles(method.folder).sources]
