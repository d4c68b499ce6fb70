"""What is simulated: wheels at steady slip to fit to, and motions to predict."""

from dataclasses import dataclass
from typing import Any

from synth.scene import SoilBinScene, parse_scene

SCENE = "studies/identify_wheel"
SLIPS = (0.0, 0.1, 0.2, 0.4, 0.6)
LOADS = (30.0, 45.0)
"""N on the half-width wheel."""
QUICK_SLIPS, QUICK_LOADS = (0.0, 0.2, 0.6), (30.0,)
_SPEED = 0.008
"""m/s, of what is pushed: the carriage's when it rolls at 20 % slip."""
ROVER_SCALE = 0.355 / 0.114
"""Radius of the rover's wheel / radius of the scene's."""
_ROVER_LOAD, _ROVER_WIDTH = 343.5, 0.09
"""N and m: half of the rover's wheel."""
_ROVER_GRAINS = 8.5e-3
"""m; finer against the wheel than the small one's: at the same ratio it would be the same simulation."""


@dataclass(frozen=True)
class Case:
    """A run; `fitted` tells whether the law is fitted to it."""

    label: str
    scene: SoilBinScene
    fitted: bool


def cases(scene: SoilBinScene, *, quick: bool, rover_wheel: bool) -> list[Case]:
    """Every run, in the order in which they are carried out."""
    loads, slips = (QUICK_LOADS, QUICK_SLIPS) if quick else (LOADS, SLIPS)
    steady = [Case(_label(load, slip), _steady(scene, load, slip), True) for load in loads for slip in slips]
    foretold = [
        Case("push", altered(scene, drive=_pushing(0.25), timing={"frame_count": 17}), False),
        Case(
            "push-rolled-in",
            altered(scene, drive=_pushing(0.2, rolled_in=0.05), timing={"frame_count": 17}),
            False,
        ),
        Case("cycle", altered(scene, drive=_cycle(), timing={"frame_count": 57}), False),
    ]
    rover = [Case("rover-wheel", rover_scene(scene), False)] if rover_wheel else []
    return steady + foretold + rover


def altered(scene: SoilBinScene, **tables: Any) -> SoilBinScene:
    """The scene with some values changed; a drive of another kind replaces it, the finest grains follow."""
    told = scene.to_dict()
    told["bed"].pop("fine", None)
    for table, values in tables.items():
        other_kind = "kind" in values and values["kind"] != told[table].get("kind")
        told[table] = values if other_kind else {**told[table], **values}
    other = parse_scene(told, source=f"{scene.name}, changed")
    assert isinstance(other, SoilBinScene)
    return other


def rover_scene(scene: SoilBinScene) -> SoilBinScene:
    """The rover's wheel under its load at 20 % slip: every length but the grains' scaled alike."""
    scale = ROVER_SCALE
    return altered(
        scene,
        bed={"width": 1.25, "depth": 0.4, "grain_diameter": _ROVER_GRAINS},
        contact={"normal_stiffness": 3.3e7},
        implement={"radius": 0.355, "width": _ROVER_WIDTH, "normal_load": _ROVER_LOAD, "moving_mass": 3.4},
        drive={"rim_speed": 0.03, "slip": 0.2, "start": 0.4, "run_in": 0.087},
        timing={"frame_count": 41, "speed_up": 9.0},
        camera={"metres_per_pixel": 0.2e-3 * scale, "centre_x": 0.09, "centre_z": 0.33},
    )


def _label(load: float, slip: float) -> str:
    return f"roll-{load:g}N-{round(100 * slip):02d}"


def _steady(scene: SoilBinScene, load: float, slip: float) -> SoilBinScene:
    """The carriage is the slower for the slip: as long a run takes as long a time."""
    assert scene.drive.kind == "rolling"
    run_in = scene.drive.run_in * (1 - slip)
    return altered(scene, implement={"normal_load": load}, drive={"slip": slip, "run_in": run_in})


def _pushing(start: float, **more: float) -> dict[str, Any]:
    return {"kind": "pushing", "speed": _SPEED, "start": start, "loading": 4.0, "rest": 0.5, **more}


def _cycle() -> dict[str, Any]:
    return {
        "kind": "push_rolling",
        "speed": _SPEED,
        "slip": 0.2,
        "start": 0.15,
        "loading": 4.0,
        "rest": 0.5,
        "rolled_in": 0.05,
        "pushed": 0.012,
    }
