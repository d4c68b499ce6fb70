"""What a suite measures: motions, the pictures taken of them, and the methods that look at these."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.manifest import key_of

if TYPE_CHECKING:
    from synth.scene import AnyScene
    from validation.suites.execution import Failure
    from validation.suites.table import Line


_PICTURE_SEEDS = 1000
"""More than there are sets of pictures of one motion."""


@dataclass(frozen=True)
class Motion:
    """One simulation, or one motion by formula.

    Attributes
    ----------
    scene : str
        A shipped scene.
    seed : int
    quick : bool
        Its smaller version.
    changes : tuple of (str, str, value)
        Keys with other values than the scene's: table, key, value.
    label : str
        What the changes are called, part of the name.
    """

    scene: str
    seed: int = 0
    quick: bool = False
    changes: tuple[tuple[str, str, Any], ...] = ()
    label: str = ""

    @property
    def name(self) -> str:
        """Of its folder."""
        parts = [self.scene, self.label, "quick" if self.quick else "", f"seed{self.seed}"]
        return "-".join(part for part in parts if part)

    def load(self) -> "AnyScene":
        """The resolved scene."""
        return self._scene

    @cached_property
    def _scene(self) -> "AnyScene":
        from synth import load_scene
        from synth.scene import parse_scene

        scene = load_scene(self.scene, quick=self.quick, seed=self.seed)
        return parse_scene(with_changes(scene.to_dict(), self.changes)) if self.changes else scene


@dataclass(frozen=True)
class Realisation:
    """Pictures taken of a motion.

    Attributes
    ----------
    motion : Motion
    picture_seed : int
        Of texture, noise and nuisances.
    severity : str
        Name of a set of nuisances, `clean` for none.
    first, pair_count, stride : int
        Frames (first, first + stride), (first + stride, first + 2 stride), ...: so many pairs.
    changes : tuple of (str, str, value)
        Keys of tables that only pictures depend on, with other values.
    label : str
        What the changes are called, part of the name.
    """

    motion: Motion
    picture_seed: int = 0
    severity: str = "clean"
    first: int = 0
    pair_count: int = 4
    stride: int = 1
    changes: tuple[tuple[str, str, Any], ...] = ()
    label: str = ""

    @property
    def name(self) -> str:
        """Of its results."""
        stride = f"stride{self.stride}" if self.stride != 1 else ""
        parts = [self.motion.name, self.label, self.severity, stride, f"pictures{self.picture_seed}"]
        return "-".join(part for part in parts if part)

    def scene(self) -> "AnyScene":
        """The resolved scene of the pictures."""
        return self._scene

    @cached_property
    def _scene(self) -> "AnyScene":
        # Every measurement's key asks for it, several times a suite.
        from synth.scene import parse_scene
        from validation.suites.severities import severity_changes

        tables = self.motion.load().to_dict()
        # Other pictures for another motion, too: a plate turns alike with any seed.
        tables["picture_seed"] = _PICTURE_SEEDS * self.motion.seed + self.picture_seed
        return parse_scene(with_changes(tables, (*severity_changes(self.severity, tables), *self.changes)))

    @property
    def is_usual(self) -> bool:
        """Whether the scene is seen as it is, frame after frame, at whatever severity."""
        return not self.label and self.stride == 1

    @property
    def frames(self) -> range:
        """Of the recording."""
        return range(self.first, self.first + self.pair_count * self.stride + 1, self.stride)


@dataclass(frozen=True)
class Look:
    """One method looking at a realisation.

    Attributes
    ----------
    realisation : Realisation
    method : str
        As `soft.analyze` takes it.
    pair_count : int or None
        Only so many pairs, from the first on; None: all.
    further : tuple of str
        What else is measured, `package.module:function` each; see `validation.suites.measurement.Further`.
    """

    realisation: Realisation
    method: str
    pair_count: int | None = None
    further: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Of its result."""
        from validation.methods import Method

        return f"{self.realisation.name}--{Method(self.method).slug}"

    def key(self, made_by: dict[str, str]) -> str:
        """SHA-256 over all that its result depends on, hexadecimal."""
        frames = self.realisation.frames
        return key_of(
            step="suite measurement",
            made_by=made_by,
            scene=self.realisation.scene().hash,
            frames=[frames.start, frames.stop, frames.step],
            method=self.method,
            pair_count=self.pair_count,
            **({"further": list(self.further)} if self.further else {}),
        )


@dataclass(frozen=True)
class Suite:
    """A list of pictures and of methods.

    Attributes
    ----------
    name, about : str
    realisations : tuple of Realisation
    methods : tuple of str
        As `soft.analyze` takes them.
    slow_methods : tuple of str
        Methods that take long: they see only the first pair of every realisation with `picture_seed` 0.
    """

    name: str
    about: str
    realisations: tuple[Realisation, ...]
    methods: tuple[str, ...]
    slow_methods: tuple[str, ...] = ()

    def with_methods(self, methods: Sequence[str]) -> "Suite":
        """The suite with further methods."""
        from dataclasses import replace

        return replace(self, methods=(*self.methods, *(m for m in methods if m not in self.methods)))

    def write_own_page(
        self, out: Path, failures: "Sequence[Failure]", *, command: str
    ) -> dict[str, Any] | None:
        """Write a page of its own from the measurements in OUT; return what the suite's JSON says of it.

        None: it has none, and the page that suites usually have tells it.
        """
        return None

    def write_more(self, lines: "Sequence[Line]", out: Path) -> None:
        """Write what this suite is for besides table and page; called once all of it is measured."""

    @property
    def looks(self) -> tuple[Look, ...]:
        """Every method at every realisation, in order."""
        return tuple(look for realisation in self.realisations for look in self._looks_at(realisation))

    def _looks_at(self, realisation: Realisation) -> list[Look]:
        slow = self.slow_methods if realisation.picture_seed == 0 else ()
        return [
            *(Look(realisation, method) for method in self.methods),
            *(Look(realisation, method, pair_count=1) for method in slow),
        ]


def with_changes(tables: dict[str, Any], changes: Sequence[tuple[str, str, Any]]) -> dict[str, Any]:
    """Tables of a scene with other values; the given ones stay as they are."""
    changed = dict(tables)
    for table, key, value in changes:
        changed[table] = {**changed.get(table, {}), key: value}
    return changed
