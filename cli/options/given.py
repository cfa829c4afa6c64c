"""Which options of a verb were given: by their declarations, and as they would be typed."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from takagi.models.errors import ModelError

# Functions whose parameters declare options.
Groups = tuple[Callable[..., None], ...]
# What may be asked of a certificate for gains that exist; the rest is about making gains.
_OF_GIVEN_GAINS = (
    "inertia",
    "power_coefficient",
    "equilibrium_wake",
    "choice",
    "solve_rest",
    "sample_time",
)


def option_of(name: str) -> str:
    """Return the option of a parameter, as it is typed."""
    return "--" + name.replace("_", "-")


def defaults_of(groups: Groups) -> dict[str, Any]:
    """Return option -> default of groups of options."""
    return {p.name: p.default for g in groups for p in inspect.signature(g).parameters.values()}


def as_typed(options: Mapping[str, object]) -> str:
    """Return the options that are not left at their default, as they would be typed."""
    shown = []
    for name, value in options.items():
        if value is None or value is False or value == [] or (name, value) == ("law", "coherent"):
            continue
        option = option_of(name)
        if isinstance(value, list):
            shown += [f"{option} {one}" for one in value]
            continue
        words = [] if value is True else value if isinstance(value, tuple) else [value]
        shown.append(" ".join([option, *map(str, words)]))
    return ", ".join(shown)


def refuse_designing(options: Mapping[str, object]) -> None:
    """Refuse options about designing gains beside --gains: ignored, they would mislead."""
    for name, value in options.items():
        left = value is None or value is False or value in ("coherent", [])
        if name not in _OF_GIVEN_GAINS and not left:
            raise ModelError(
                f"option {option_of(name)} is about designing gains, but --gains gives them; "
                "leave out one of the two"
            )
