"""Runs a typer command as a verb, so that all verbs parse, fail and exit alike."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

import typer

from takagi.cli.errors import guard


def run_command(
    name: str,
    function: Callable[..., int],
    arguments: Sequence[str],
    *,
    groups: Sequence[Callable[..., None]] = (),
) -> int:
    """Parse ``arguments`` by the signature of ``function``, call it, return its exit status.

    The docstring of ``function`` is the help of ``takagi <name> --help``.  Misuse prints the usage
    and returns 2.

    Parameters
    ----------
    groups : signatures that several verbs share; what they declare is taken by the ``**options``
        of ``function``, and stands in the help before its keyword-only parameters.
    """
    signature = _joined(function, groups)

    def command(**given: object) -> None:
        # The error handling is inside typer, which would handle interrupts and pipes in its own
        # way.
        raise typer.Exit(guard(lambda: function(**given)))

    # typer reads the parameters from here.
    described: Any = command
    described.__name__, described.__doc__ = function.__name__, function.__doc__
    described.__signature__ = signature
    described.__annotations__ = {p.name: p.annotation for p in signature.parameters.values()}
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


def _joined(
    function: Callable[..., int], groups: Sequence[Callable[..., None]]
) -> inspect.Signature:
    """Return the parameters of the function with those of the groups, all by keyword."""
    own = list(inspect.signature(function, eval_str=True).parameters.values())
    shared = [
        p for group in groups for p in inspect.signature(group, eval_str=True).parameters.values()
    ]
    first = [p for p in own if p.kind is p.POSITIONAL_OR_KEYWORD]
    last = [p for p in own if p.kind is p.KEYWORD_ONLY]
    return inspect.Signature([p.replace(kind=p.KEYWORD_ONLY) for p in (*first, *shared, *last)])
