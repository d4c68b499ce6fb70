"""The command line, asked what it takes."""

import typer

from validation.cli import app


def parse(words: list[str]) -> None:
    """Have the command line take the arguments of a command, without running it."""
    command, rest = _found(words)
    command.make_context(command.name, rest)


def parse_told(words: list[str]) -> None:
    """Have the command line take what running text tells of a command.

    It may leave out arguments, and the value of the option that it ends with; what it gives must be right.
    """
    told = {word.partition("=")[0] for word in words if word.startswith("--")}
    assert told <= options_of([word for word in words if not word.startswith("--")]), words
    try:
        parse(words)
    except Exception as error:
        # By name, as Typer brings classes of its own, which it does not show.
        if type(error).__name__ == "MissingParameter":
            return
        if type(error).__name__ != "BadOptionUsage" or not words[-1].startswith("--"):
            raise


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
