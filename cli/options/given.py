"""Which options of a verb were given: by their declarations, and as they would be typed."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

__all__ = ["Groups", "as_typed", "defaults_of"]

# Functions whose parameters declare options.
Groups = tuple[Callable[..., None], ...]


def defaults_of(groups: Groups) -> dict[str, Any]:
    """Return option -> default of groups of options."""
    return {p.name: p.default for g in groups for p in inspect.signature(g).parameters.values()}


def as_typed(options: Mapping[str, object]) -> str:
    """Return the options that are not left at their default, as they would be typed."""
    shown = []
    for name, value in options.items():
        if value is None or value is False or value == [] or (name, value) == ("law", "coherent"):
            continue
        option = "--" + name.replace("_", "-")
        if isinstance(value, list):
            shown += [f"{option} {one}" for one in value]
            continue
        words = [] if value is True else value if isinstance(value, tuple) else [value]
        shown.append(" ".join([option, *map(str, words)]))
    return ", ".join(shown)
