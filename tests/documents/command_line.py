"""The command line, asked what it takes."""

import typer

from validation.cli import app


def parse(words: list[str]) -> None:
    """Have the command line take the arguments of a command, without running it."""
    command, rest = _found(words)
    command.make_context(command.name, rest)


def options_of(words: list[str]) -> set[str]:
    """Every option of a command that is told of."""
    command, _ = _found(words)
    return {option for one in command.params for option in (*one.opts, *one.secondary_opts)} | {"--help"}


def _found(words: list[str]):
    command, rest = typer.main.get_command(app), list(words)
    while hasattr(command, "commands"):
        name, *rest = rest
        assert name in command.commands, f"there is no command {name}"
        command = command.commands[name]
    return command, rest
