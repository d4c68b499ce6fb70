"""The command line: `softbed`.

One module holds a group of commands; they are listed in the order of their import here. Heavy libraries are
imported inside commands, so that `softbed --help` is instant.
"""

# isort: off
from validation.cli import scenes, simulation, flow, calibrate_camera, figures, files  # noqa: F401
from validation.cli import compare, physics, bench, gate, study, suite, findings, identify, drawbar, sweep  # noqa: F401
from validation.cli.app import app, main, run_command

# isort: on
__all__ = ["app", "main", "run_command"]
