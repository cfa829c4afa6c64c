"""The origin of a certificate: configuration, versions, the solver's messages."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from fractions import Fraction
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from takagi.models.intervals.interval import Interval

LIBRARIES = ("takagi", "numpy", "scipy", "sympy", "clarabel", "python-flint")


def provenance(settings: object, solver_words: Mapping[str, str]) -> dict[str, Any]:
    """Return configuration, versions and the solver's messages as plain data.

    No time stamp: the same inputs give the same file.
    """
    return {
        "configuration": plain(settings),
        "solver": dict(solver_words),
        "versions": {"python": platform.python_version(), **dict(_versions())},
    }


@cache
def _versions() -> tuple[tuple[str, str], ...]:
    """Return (library, version); read once, since each is a file to be parsed."""
    return tuple((name, _version(name)) for name in LIBRARIES)


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        # A source tree that is imported without installation has no metadata.
        return "not installed"


def plain(value: object) -> Any:
    """Return dataclasses, intervals and rationals as JSON values."""
    if isinstance(value, Interval):
        return [float(value.lower), float(value.upper)]
    if isinstance(value, Fraction):
        return float(value)
    if is_dataclass(value) and not isinstance(value, type):
        return {one.name: plain(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value
