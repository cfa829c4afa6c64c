"""The table of verbs: what `takagi --help` prints, and where each verb lives."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["VERBS", "Verb"]


class Verb(NamedTuple):
    """A verb of the command line.  Its module has ``run(arguments: Sequence[str]) -> int``."""

    name: str
    module: str
    help: str  # one line, without a full stop
    example: str = ""  # what `takagi --help` shows under "First steps", without the word takagi


VERBS = (
    Verb("models", "takagi.cli.models", "List the built-in models", "models"),
    Verb(
        "check",
        "takagi.cli.check",
        "Check a certificate in exact arithmetic, trusting nothing else in it",
        "check build/nrel5mw/certificate.json",
    ),
)
