"""Commands about scenes."""

from pathlib import Path
from typing import Annotated

import typer

from validation.cli.app import app
from validation.cli.options import Debug, Json
from validation.terminal import Terminal


@app.command()
def scenes(json: Json = False, debug: Debug = False) -> None:
    """List the shipped scenes."""
    from synth import load_scene, scene_names

    terminal = Terminal(json=json)
    with terminal.working():
        shipped = [load_scene(name) for name in scene_names()]
    widest = max(len(scene.name) for scene in shipped)
    terminal.show("\n".join(f"{scene.name:{widest}}  {scene.description}" for scene in shipped))
    rows = [{"name": scene.name, "kind": scene.kind, "description": scene.description} for scene in shipped]
    terminal.give({"schema_version": 1, "scenes": rows})


@app.command("new-scene")
def new_scene(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The TOML file to write; must not exist.")],
    source: Annotated[
        str, typer.Option("--from", metavar="SCENE", help="The shipped scene to start from.")
    ] = "rolling_wheel",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Write a commented scene file to change and run."""
    from validation.scene_template import write_template

    terminal = Terminal(json=json)
    with terminal.working():
        write_template(file, source)
    terminal.show(f"{file}: written; change it, then: softbed run {file} OUT")
    terminal.give({"schema_version": 1, "file": str(file), "from": source})
