"""Names of a turbine's laws on the command line, and in files."""

from __future__ import annotations

from typing import TypeVar

Given = TypeVar("Given", str, list[str], None)

# What each law is called in gain files, certificates and tables; these names may be typed too.
IN_FILES = {
    "effort-sharing": "coherent",
    "published": "paper",
    "published-two-integrators": "paper-two-integrators",
}


def law_in_files(given: Given) -> Given:
    """Return the names that files have of the laws that were typed; others are left as they are."""
    if isinstance(given, list):
        return [IN_FILES.get(name, name) for name in given]
    return given if given is None else IN_FILES.get(given, given)


def typed_name(law: str) -> str:
    """Return the name to type for a law of the files, for messages."""
    return {filed: name for name, filed in IN_FILES.items()}.get(law, law)
