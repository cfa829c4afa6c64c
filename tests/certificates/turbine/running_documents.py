"""Certificates about the running loop that were changed: hashes made again, and the verdict."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.certificates.kinds.claims import resealed, verdicts

Change = Callable[[Any], None]


def entry(*path: Any, factor: float = 1.0, value: Any = None) -> Change:
    def change(document: Any) -> None:
        at = document
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = at[path[-1]] * factor if value is None else value

    return change


def sealed(document: dict[str, Any]) -> dict[str, Any]:
    return resealed(document, "controller")


def verdict(document: dict[str, Any]) -> str:
    return verdicts(sealed(document))[0]
