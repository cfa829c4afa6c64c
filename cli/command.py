"""Runs a typer command as a verb, so that all verbs parse, fail and exit alike."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

import typer

from takagi.cli.errors import guard

__all__ = ["run_command"]


def run_command(name: str, function: Callable[..., int], arguments: Sequence[str]) -> int:
    """Parse ``arguments`` by the signature of ``function``, call it, return its exit status.

    The docstring of ``function`` is the help of ``takagi <name> --help``.  Misuse prints the usage
    and returns 2.
    """

    @functools.wraps(function)
    def command(*args: object, **options: object) -> None:
        # The boundary stands inside typer, which has its own ideas about interrupts and pipes.
        raise typer.Exit(guard(lambda: function(*args, **options)))

    application = typer.Typer(
        add_completion=False,
        rich_markup_mode=None,  # plain text, the same in `check`, which does without typer
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    )
    application.command(name)(command)
    try:
        application(args=list(arguments), prog_name=f"takagi {name}")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    return 0
