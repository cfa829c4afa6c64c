"""`takagi models`: list the built-in models."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Annotated

import typer

from takagi.cli.command import run_command
from takagi.cli.errors import PROVED

__all__ = ["list_models", "run"]


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("models", list_models, arguments)


def list_models(
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, for machines.")] = False,
) -> int:
    """List the built-in models, by the names that every other verb takes as MODEL.

    A model of your own is a TOML file: give its path in place of the name.
    """
    from takagi.models.library import built_in_models

    found = built_in_models()
    if as_json:
        print(json.dumps([{"name": name, "description": text} for name, text in found], indent=2))
        return PROVED
    width = max((len(name) for name, _ in found), default=0)
    for name, text in found:
        print(f"{name:<{width}}  {text}")
    return PROVED
