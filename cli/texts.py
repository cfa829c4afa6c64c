"""What the help says, as the TOML files of the rooms hold it."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any


@cache
def _texts(name: str) -> Mapping[str, Any]:
    # A file of a room is found without the room: help must load nothing that it does not need.
    return tomllib.loads(files("takagi.cli").joinpath(name).read_text(encoding="utf-8"))


def option_words(group: str) -> Mapping[str, Any]:
    """Return the options of a verb or a group, as ``options.toml`` declares them; {} for none."""
    words: Mapping[str, Any] = _texts("options/options.toml").get(group, {})
    return words


def verb_text(name: str) -> str | None:
    """Return what the help of a verb says first; None for a verb of which a line says it all."""
    text: str | None = _texts("verbs/verbs.toml").get(name)
    return text
