"""The options of a turbine's design, declared once for all verbs, and the names of its laws."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from takagi.cli.options.given import Options, declared

# What each law is called in gain files and certificates; these names may be typed too.
IN_FILES = {"effort-sharing": "coherent", "schulte": "paper"}
_REFERENCE = {"reference": "baseline"}
# Former names, which may still be typed.
_ALIASES = {"published": "paper"}

Model = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A built-in name (see `takagi models`) or the path of a TOML file.",
        show_default=False,
    ),
]

ModelOrFolder = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A built-in name, the path of a TOML file, or the folder of a design.",
        show_default=False,
    ),
]
Folder = Annotated[
    Path, typer.Argument(metavar="DIR", help="A folder of `takagi design`.", show_default=False)
]


def law_in_files(given: Any) -> Any:
    """Return the names that files have of the laws that were typed; others are left as they are."""
    if isinstance(given, list):
        return [law_in_files(name) for name in given]
    return given if given is None else (IN_FILES | _REFERENCE | _ALIASES).get(given, given)


def typed_name(law: str) -> str:
    """Return the name to type for a law of the files, for messages and tables."""
    return {filed: name for name, filed in (IN_FILES | _REFERENCE).items()}.get(law, law)


TURBINE_OPTIONS: Options = declared("turbine", "objective", callback=law_in_files)
