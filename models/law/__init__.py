"""Controller laws as values: the protocol that they share, and one law a file."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.models.law.law import Command, Law, Measurement

__all__ = ["Command", "Law", "Measurement"]

_HOME = {"Command": "law", "Law": "law", "Measurement": "law"}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.models.law.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
