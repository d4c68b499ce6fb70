"""`data_card.md` of a data set: what a stranger must know to use it."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from synth.dataset.card_figures import SHEET_FILE, STATISTICS_FILE, draw_sheet, draw_statistics
from synth.dataset.facts import EDGES, PAIRS_LOOKED_AT
from synth.dataset.folder import BASE_FILE, CARD_FILE, FAILURES_FILE, MEMBERS_FILE, SWEEP_FILE, DataSetFolder
from synth.dataset.members import Member
from synth.dataset.sweep import SPLITS

if TYPE_CHECKING:
    from synth.dataset.summary import Facts, Told
    from synth.scene import AnyScene

_CARD = """\
# Data set `{name}`

{description}{made} sequences of synthetic grey pictures of moving soil, {pairs} consecutive pairs in all,
with the true motion at every pixel. Nothing in here was photographed or measured.{incomplete}

| split | simulations | sequences | pairs |
| --- | ---: | ---: | ---: |
{splits}

Splits go by simulation: all sequences of one motion are in the same one, and no two motions show the same
micro-grains{texture}.

- Licence: {licence}.
- Hash of the values (`manifest.json`): `{digest}`.
- {megabytes:.1f} MB in `sequences/`, {frame_megabytes:.2f} MB a picture with its truth.

## How it was made

`softbed sweep {sweep_file} OUT`: the scene `{scene}` (`{base_file}`), the design `{design}` of {count}
points, seed {seed}. Settled beds: {beds}; simulated motions: {simulations}. softbed {softbed}, Python
{python}, numpy {numpy}, scipy {scipy}, taichi {taichi}, OpenCV {opencv}; the same sweep and versions give
the same values.

| varied | values | meaning |
| --- | --- | --- |
{varied}

`{members_file}` has the values of every member, `{failures_file}` what could not be made, and why.

## What is in a folder `sequences/NAME`

NAME is the beginning of the hash of `scene.toml`, the member's scene with every number. `sequence.toml`:
pictures in order, pictures a second, metres per pixel. `frames/`: the pictures. `facts.json`: statistics,
hash of the values. `truth.nc` (netCDF-4): the truth of each pair, on the first picture's pixels, x right,
y down; displacements are px, forward.

| variable | type | unit | meaning |
| --- | --- | --- | --- |
{variables}

`recordings/SIMULATION.nc` has the states of grains and implement that pictures were taken of.

## Statistics

Of up to {looked_at} pairs of each sequence. Moving: above 1 px in the inertial frame. Complex:
within 3 px of the implement or of a true gradient of motion above 0.1 px/px. Mixed: the pixel holds motions
more than 0.1 px apart. Moving, complex and mixed are shares of the soil. Displacement is in the
inertial frame, too: without the camera's motion, which `u` and `v` hold.

| split | soil in view | moving | complex | mixed | displacement, median | 95 % | grey, mean | at its ends |
| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
{statistics}

![Displacement of soil, and grey levels]({statistics_file})

![A picture of some of the sequences]({sheet_file})
"""


def write_card(
    folder: DataSetFolder, told: "Told", facts: "dict[str, Facts]", manifest: dict[str, Any]
) -> None:
    """Write `data_card.md`, `statistics.png` and `picture_sheet.jpg`."""
    members = [member for member in told.membership.members if member.name in facts]
    if members:
        folder.write(SHEET_FILE, draw_sheet(folder, members))
        folder.write(STATISTICS_FILE, draw_statistics(members, facts))
    folder.write(CARD_FILE, _card(told, members, facts, manifest))


def _card(told: "Told", members: list[Member], facts: "dict[str, Facts]", manifest: dict[str, Any]) -> str:
    sweep, versions = told.sweep, manifest["versions"]
    frames = sum(one["frame_count"] for one in facts.values())
    own_texture = told.base.picture_seed is None and "picture_seed" not in sweep.vary
    return _CARD.format(
        name=sweep.name,
        description=f"{sweep.description.rstrip('.')}. " if sweep.description else "",
        made=len(members),
        pairs=manifest["pair_count"],
        incomplete=_incomplete(manifest),
        splits="\n".join(_split_row(split, members, facts) for split in SPLITS),
        texture="" if own_texture else ", unless `picture_seed` says so",
        licence=", ".join(sorted({m.scene.data_licence for m in members})) or told.base.data_licence,
        digest=manifest["digest"],
        megabytes=manifest["bytes"] / 1e6,
        frame_megabytes=manifest["bytes"] / 1e6 / max(frames, 1),
        sweep_file=SWEEP_FILE,
        base_file=BASE_FILE,
        members_file=MEMBERS_FILE,
        failures_file=FAILURES_FILE,
        scene=told.base.name,
        design=sweep.design.kind,
        count=len(told.membership.members) + told.membership.repeated + len(told.membership.impossible),
        seed=sweep.seed,
        beds=manifest["bed_count"],
        simulations=manifest["simulation_count"],
        opencv=versions["opencv-python-headless"],
        varied="\n".join(_varied_row(key, told) for key in sweep.vary),
        variables="\n".join(_variable_rows()),
        looked_at=PAIRS_LOOKED_AT,
        statistics="\n".join(_statistics_row(split, members, facts) for split in SPLITS),
        sheet_file=SHEET_FILE,
        statistics_file=STATISTICS_FILE,
        **{name: versions[name] for name in ("softbed", "python", "numpy", "scipy", "taichi")},
    )


def _incomplete(manifest: dict[str, Any]) -> str:
    if manifest["complete"]:
        return ""
    missing = manifest["member_count"] - manifest["made_count"]
    return f" **It is not complete: {missing} of {manifest['member_count']} sequences are missing.**"


def _split_row(split: str, members: list[Member], facts: "dict[str, Facts]") -> str:
    own = [member for member in members if member.split == split]
    pairs = sum(facts[member.name]["frame_count"] - 1 for member in own)
    return f"| {split} | {len({member.simulation for member in own})} | {len(own)} | {pairs} |"


def _varied_row(key: str, told: "Told") -> str:
    values = [member.values[key] for member in told.membership.members]
    different = sorted(set(map(str, values)))
    numbers = [value for value in values if isinstance(value, int | float)]
    if len(different) > 6 and len(numbers) == len(values):
        shown = f"{min(numbers):.4g} to {max(numbers):.4g}, {len(different)} of them"
    else:
        shown = ", ".join(_short(value) for value in dict.fromkeys(map(_key, values)))
    return f"| `{key}` | {shown} | {meaning_of(told.membership.members[0].scene, key)} |"


def _key(value: Any) -> Any:
    return value if isinstance(value, int | float | str) else str(value)


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def meaning_of(scene: "AnyScene", key: str) -> str:
    """What a scene's key means, as its table says; empty where it says nothing."""
    table: Any = scene
    *path, name = key.split(".")
    for part in path:
        table = getattr(table, part, None)
    known = getattr(type(table), "model_fields", {})
    return (known[name].description or "") if name in known else ""


def _variable_rows() -> Iterable[str]:
    from synth.truth import CAMERA_VARIABLES, VARIABLES

    for name, (dtype, unit, meaning) in VARIABLES.items():
        yield f"| `{name}` | {dtype} | {unit} | {meaning} |"
    for name, (unit, meaning) in CAMERA_VARIABLES.items():
        yield f"| `{name}` | float64, one a pair | {unit} | {meaning} |"


def _statistics_row(split: str, members: list[Member], facts: "dict[str, Facts]") -> str:
    own = [facts[member.name] for member in members if member.split == split]
    if not own:
        return f"| {split} |" + " - |" * 8
    shares = [sum(one[name] for one in own) / len(own) for name in ("soil", "moving", "complex", "mixed")]
    displacement = summed(one["displacement"] for one in own)
    grey = summed(one["grey"] for one in own)
    levels = [(k + 0.5) / len(grey) for k in range(len(grey))]
    mean = sum(level * count for level, count in zip(levels, grey, strict=True)) / max(sum(grey), 1)
    extreme = (grey[0] + grey[-1]) / max(sum(grey), 1)
    cells = [f"{100 * share:.1f} %" for share in shares]
    cells += [f"{quantile(displacement, share)} px" for share in (0.5, 0.95)]
    cells += [f"{100 * mean:.0f} % of full scale", f"{100 * extreme:.1f} %"]
    return f"| {split} | " + " | ".join(cells) + " |"


def summed(histograms: Iterable[list[int]]) -> list[int]:
    """The bins of several histograms, added up."""
    return [sum(bins) for bins in zip(*histograms, strict=True)]


def quantile(counts: list[int], share: float) -> str:
    """The bin of `EDGES` that a quantile is in, in words."""
    wanted, reached = share * sum(counts), 0
    for low, high, count in zip(EDGES, (*EDGES[1:], None), counts, strict=True):
        reached += count
        if reached >= wanted:
            return f"{low:g} to {high:g}" if high is not None else f"above {low:g}"
    return "-"
