"""Tables of docs/wheel_law.md: what `softbed identify` found."""

from typing import Any

from kept import Row, document

from synth.scene import load_scene
from validation.identification.plan import SCENE
from validation.markdown_tables import markdown_table


def found() -> dict[str, Any]:
    """What the command found."""
    return document("identification.json")


def constants() -> str:
    """Constants fitted to wheels in the granular bin."""
    return _constants(found()["estimates"])


def rig_constants() -> str:
    """Constants fitted to the driven half of the rig's trials."""
    return _constants(found()["rig"]["estimates"])


def _constants(estimates: dict[str, dict[str, float]]) -> str:
    told = {
        "scale": ("scale [MPa/m]", 1e-6, ".2f"),
        "surface_friction": ("surface friction", 1, ".2f"),
        "shear_share": ("stiffness along the surface / normal one", 1, ".2g"),
    }
    rows = []
    for name, (words, unit, form) in told.items():
        value, low, high = (format(unit * estimates[name][key], form) for key in ("value", "low", "high"))
        rows.append([words, value, f"{low} to {high}"])
    return markdown_table(["constant", "found", "95 % interval"], rows, words=1)


def steady() -> str:
    """Steady rolling in the grains, and by the law that was fitted to it."""
    head = ["load [N]", "slip", "pull / load: grains", "law", "torque / (load x radius): grains", "law"]
    rows = [[f"{run['load']:g}", f"{run['slip']:g}", *_steady(run)] for run in found()["steady"]]
    return markdown_table([*head, "sinkage [mm]: grains", "law"], rows, words=0)


def rover_wheel() -> str:
    """The rover's wheel in the grains, and by the law that was fitted to the small one."""
    cells = _steady(found()["rover_wheel"])
    head = ["", "pull / load", "torque / (load x radius)", "sinkage [mm]"]
    rows = [["grains", *cells[::2]], ["law, fitted to the small wheel", *cells[1::2]]]
    return markdown_table(head, rows, words=1)


def _steady(run: Row) -> list[str]:
    """Of each quantity, what the grains gave, with its error, and the law."""
    units = {
        "drawbar_pull": (1 / run["load"], ".3f"),
        "torque": (1 / (run["load"] * run["radius"]), ".3f"),
        "sinkage": (1000, ".1f"),
    }
    cells = []
    for name, (unit, form) in units.items():
        value, error, law = (unit * run[key] for key in (name, f"{name}_error", f"{name}_law"))
        cells += [f"{value:{form}} +- {error:{form}}", f"{law:{form}}"]
    return cells


def foretold() -> str:
    """Phases of the runs that the law was not fitted to."""
    load = load_scene(SCENE).implement.normal_load
    head = ["run", "phase", "force along x / load: grains", "law", "sinkage [mm]: grains", "law"]
    rows = [
        [
            row["run"].replace("-", " "),
            row["phase"],
            f"{row['force_x'] / load:.2f}",
            f"{row['force_x_law'] / load:.2f}",
            f"{1000 * row['sinkage']:.1f}",
            f"{1000 * row['sinkage_law']:.1f}",
        ]
        for row in found()["foretold"]
    ]
    return markdown_table(head, rows, words=2)


def rig() -> str:
    """The rig's trials, the law fitted to the driven ones, and the law with its published scale."""
    ways = ("", "_law", "_unfitted_law")
    head = ["slip", "load [N]", "fitted", "pull / load: measured", "law", "published"]
    rows = [
        [
            f"{one['slip']:z.2f}",
            f"{one['load']:.1f}",
            one["fitted"],
            *(f"{one[f'drawbar_pull{way}'] / one['load']:.2f}" for way in ways),
            *(f"{1000 * one[f'sinkage{way}']:.1f}" for way in ways),
        ]
        for one in found()["rig"]["trials"]
    ]
    return markdown_table([*head, "sinkage [mm]: measured", "law", "published"], rows, words=0)


def rig_at_sinkage() -> str:
    """What the law gives a wheel that is held at the sinkage that was measured, up to no slip."""
    head = ["slip", "sinkage [mm]", "pull [N]: measured", "law", "load borne [N]: measured", "law"]
    rows = [
        [
            f"{one['slip']:z.2f}",
            f"{1000 * one['sinkage']:.1f}",
            f"{one['drawbar_pull']:.1f}",
            f"{one['drawbar_pull_at_sinkage_law']:.1f}",
            f"{one['load']:.1f}",
            f"{one['load_at_sinkage_law']:.1f}",
        ]
        for one in found()["rig"]["trials"]
        if one["slip"] < 0.01
    ]
    return markdown_table(head, rows, words=0)


TABLES = {
    "identified-constants": constants,
    "identified-steady": steady,
    "identified-foretold": foretold,
    "identified-rover-wheel": rover_wheel,
    "rig-constants": rig_constants,
    "rig-trials": rig,
    "rig-at-sinkage": rig_at_sinkage,
}
