"""Certificates about the running loop that were changed: hashes made again, and the verdict."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.certificates.kinds.claims import resealed, verdicts

Change = Callable[[Any], None]


def entry(*path: Any, factor: float = 1.0, value: Any = None) -> Change:
    """Return a change of one number of a document, or of the numbers it is given."""

    def change(document: Any) -> None:
        at = document
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = at[path[-1]] * factor if value is None else value

    return change


def sealed(document: dict[str, Any]) -> dict[str, Any]:
    """Return the document with the hashes of what it and its controller now say."""
    return resealed(document, "controller")


def verdict(document: dict[str, Any]) -> str:
    """Return the verdict on the first claim; REFUSED where the file is not read to its end."""
    return verdicts(sealed(document))[0]


def everywhere(*path: Any, value: Any) -> Change:
    """Return a change of the filters, in claim and controller alike."""

    def change(document: Any) -> None:
        for one in (document["claims"][0], document["controller"]):
            entry("measurement", *path, value=value)(one)

    return change
