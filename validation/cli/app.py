"""The application itself: how it is started, how it ends, and how errors are told."""

import os
import sys
import traceback
from collections.abc import Sequence
from typing import Annotated

import typer

from synth.disk import system_complaint
from validation.terminal import Terminal, error_line

CHECK_FAILED = 1
BAD_INPUT = 2
FAULT = 70
"""Exit status of a fault of this program itself; 1 is kept for checks that fail."""
INTERRUPTED = 130
_ROOMS = ("soft", "synth", "validation")

app = typer.Typer(
    help="A virtual glass-walled soil bin where every grain's motion is known, soil optical flow, its score.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)


def main() -> None:
    """Run the command line: 0 done, 1 a check failed, 2 bad input, 70 a fault, 130 interrupted."""
    sys.exit(run_command(sys.argv[1:]))


def run_command(arguments: Sequence[str]) -> int:
    """Run one command and return its exit status; every expected error is one line on standard error."""
    # What they warn of is said by our own line.
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    try:
        status = app(args=list(arguments), prog_name="softbed", standalone_mode=False)
    except KeyboardInterrupt:
        status = INTERRUPTED
    except Exception as error:
        if "--debug" in arguments or not _is_expected(error):
            traceback.print_exc()
            return BAD_INPUT if _is_expected(error) else FAULT
        _complain(_in_one_line(error), as_json="--json" in arguments)
        return BAD_INPUT
    if status == INTERRUPTED:
        _complain("interrupted; nothing half-written is left, the same command goes on", as_json=False)
    return status if isinstance(status, int) else 0


def _is_expected(error: Exception) -> bool:
    """Bad input and usage, as against faults of this program."""
    ours = type(error).__module__.partition(".")[0] in _ROOMS
    system = isinstance(error, OSError) or system_complaint(error) is not None
    return ours or system or isinstance(error, ValueError) or _is_usage_error(error)


def _is_usage_error(error: Exception) -> bool:
    # Which module defines it depends on typer's version; all of them can word themselves.
    return hasattr(error, "format_message")


def _in_one_line(error: Exception) -> str:
    if _is_usage_error(error):
        command = getattr(getattr(error, "ctx", None), "command_path", "softbed")
        said = error.format_message().replace("Value error, ", "")  # type: ignore[attr-defined]
        return " ".join(f"{said} (see {command} --help)".split())
    return error_line(error)


def _complain(line: str, *, as_json: bool) -> None:
    terminal = Terminal(json=as_json)
    terminal.say(f"softbed: {line}")
    terminal.give({"schema_version": 1, "error": line})


def _version(wanted: bool) -> None:
    if wanted:
        from validation.versions import package_version

        print(f"softbed {package_version('softbed')}")  # noqa: T201
        raise typer.Exit


@app.callback()
def _every_command(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version and end.")
    ] = False,
) -> None:
    pass
