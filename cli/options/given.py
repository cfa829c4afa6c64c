"""Which options of a verb were given, found from their declarations, and their text as typed."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from takagi.models.errors import ModelError

# Functions whose parameters declare options.
Groups = tuple[Callable[..., None], ...]
# Options of a certificate for given gains; all other options of a design concern making gains.
_OF_GIVEN_GAINS = (
    "inertia",
    "power_coefficient",
    "equilibrium_wake",
    "choice",
    "solve_rest",
    "sample_time",
    "noise",
    "horizon",
)


def option_of(name: str) -> str:
    """Return the option of a parameter as it is typed: --decay-rate of ``decay_rate``."""
    return "--" + name.replace("_", "-")


def defaults_of(groups: Groups) -> dict[str, Any]:
    """Return option -> default of groups of options."""
    return {p.name: p.default for g in groups for p in inspect.signature(g).parameters.values()}


def as_typed(options: Mapping[str, object]) -> str:
    """Return the options that are not at their default, as a user would type them."""
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
    """Refuse options about designing gains next to --gains; ignoring them would mislead."""
    for name, value in options.items():
        left = value is None or value is False or value in ("coherent", [])
        if name not in _OF_GIVEN_GAINS and not left:
            raise ModelError(
                f"option {option_of(name)} is about designing gains, but --gains gives them; "
                "leave out one of the two"
            )
