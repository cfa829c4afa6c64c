"""The table of verbs: what `takagi --help` prints, and the module of each verb."""

from __future__ import annotations

from typing import NamedTuple


class Verb(NamedTuple):
    """A verb of the command line.  Its module has ``run(arguments: Sequence[str]) -> int``."""

    name: str
    module: str
    help: str  # one line, without a full stop
    example: str = ""  # what `takagi --help` shows under "First steps", without the word takagi


VERBS = (
    Verb("models", "takagi.cli.verbs.models", "List the built-in models", "models"),
    Verb(
        "design",
        "takagi.cli.verbs.design",
        "Design a controller, prove what is claimed of it, and report",
        "design nrel5mw --out build/nrel5mw",
    ),
    Verb(
        "check",
        "takagi.cli.verbs.check",
        "Check a certificate in exact arithmetic, trusting nothing else in it",
        "check build/nrel5mw/certificate.json",
    ),
    Verb(
        "certify",
        "takagi.cli.verbs.certify",
        "Write a certificate for given gains, or for new ones",
    ),
    Verb("compare", "takagi.cli.verbs.compare", "Compare two certificates, or two gain files"),
    Verb(
        "sweep",
        "takagi.cli.verbs.sweep",
        "Map where a turbine's law is proved, over a grid of its parameters",
    ),
    Verb(
        "export",
        "takagi.cli.verbs.export",
        "Write a law as code for other tools, or a certificate's matrices for a proof assistant",
    ),
    Verb("report", "takagi.cli.verbs.report", "Write the report and its figures alone"),
    Verb(
        "appendix", "takagi.cli.verbs.appendix", "Write the design as a LaTeX appendix for a paper"
    ),
    Verb(
        "simulate",
        "takagi.cli.verbs.simulate",
        "Simulate laws on the nonlinear plant: a turbine's side by side in winds, another's alone",
        "simulate nrel5mw --out build/simulation",
    ),
)
