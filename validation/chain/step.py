"""Steps of the chain: how each is done or skipped, and from what its key is made."""

from dataclasses import dataclass

from validation.manifest import RunFolderError
from validation.run_folder import RunFolder
from validation.terminal import Terminal
from validation.versions import package_version


@dataclass(frozen=True)
class Work:
    """How the work is done; results do not depend on it.

    Attributes
    ----------
    device : {"cpu", "cuda"}
        Where kernels run.
    threads : int or None
        None: every core.
    processes : int
        That analyze pairs of pictures, and share the threads.
    """

    device: str = "cpu"
    threads: int | None = None
    processes: int = 1


def skips(run: RunFolder, step: str, key: str, terminal: Terminal, *, never: str | None = None) -> bool:
    """Whether a step need not be done; says so, or why it is done again.

    Parameters
    ----------
    never : str, optional
        Why it is done in any case.
    """
    reason = run.why_do(step, key)
    if reason is None and never is None:
        terminal.say(f"{step}: done before, its files are whole: skipped")
        return True
    if step in run.manifest.steps:
        terminal.say(f"{step}: {reason or never}: doing it again")
    return False


def require_step(run: RunFolder, step: str, key: str, command: str) -> None:
    """Refuse to go on without the result of an earlier step, which `command` would make.

    Raises
    ------
    RunFolderError
        It is missing, damaged, or made from something else.
    """
    reason = run.why_do(step, key)
    if reason is not None:
        raise RunFolderError(f"{run.path}: {step}: {reason}: run `{command}` first")


def made_by(*packages: str) -> dict[str, str]:
    """Versions of this program and of the packages whose numbers a step's result is made of."""
    return {name: package_version(name) for name in ("softbed", *packages)}
