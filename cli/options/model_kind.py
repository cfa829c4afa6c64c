"""What a MODEL is, a turbine or another plant, and which options are about it."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, Literal, TypeAlias

from takagi.cli.options.design_options import turbine_options
from takagi.cli.options.plant_options import plant_options

__all__ = [
    "DESIGN_OPTIONS",
    "Kind",
    "defaults_of",
    "design_options_of",
    "model_kind",
    "refuse_options",
]

Kind: TypeAlias = Literal["plant", "turbine"]
# The groups of options of every verb that designs.
DESIGN_OPTIONS: tuple[Callable[..., None], ...] = (turbine_options, plant_options)
_WORDS = {"plant": "a plant", "turbine": "a wind turbine"}
# What to use in the place of an option, where that is not plain.
_INSTEAD = {
    "law": "a plant's law is by rules: --relaxation and [design] of its file say how it is designed"
}


def model_kind(model: str) -> Kind:
    """Return what the built-in name or TOML file is.

    A file that says neither is taken for a turbine's: the turbine's reader names file and line.

    Raises
    ------
    ModelError : no such model, or a file that is not TOML.
    """
    from takagi.models.files.library import resolve_model
    from takagi.models.files.toml_document import read_document

    kind = read_document(resolve_model(model)).data.get("kind")
    return "plant" if kind == "plant" else "turbine"


def design_options_of(model: str, options: Mapping[str, Any]) -> tuple[Kind, dict[str, Any]]:
    """Return what MODEL is, and those of the parsed design options that are about it.

    Raises
    ------
    ModelError : as ``model_kind``; an option about the other kind of model was given.
    """
    kind = model_kind(model)
    own, other = defaults_of(turbine_options), defaults_of(plant_options)
    if kind == "plant":
        own, other = other, own
    refuse_options(model, kind, {name: options[name] for name in other}, other)
    return kind, {name: options[name] for name in own}


def refuse_options(
    model: str, kind: Kind, given: Mapping[str, Any], defaults: Mapping[str, Any]
) -> None:
    """Refuse options that are about the other kind of model: ignored, they would mislead.

    Parameters
    ----------
    kind : what ``model`` is.
    given, defaults : option -> value, of the options that this kind does not have.

    Raises
    ------
    ModelError : one of them was given.
    """
    from takagi.models.errors import ModelError

    other = "turbine" if kind == "plant" else "plant"
    for name, value in given.items():
        if value != defaults[name] and value != []:
            raise ModelError(
                f"option --{name.replace('_', '-')} is about {_WORDS[other]}, but model {model} is "
                f"{_WORDS[kind]}{_instead(name)}; leave it out, or choose another model"
            )


def _instead(name: str) -> str:
    return f" ({_INSTEAD[name]})" if name in _INSTEAD else ""


def defaults_of(group: Callable[..., None]) -> dict[str, Any]:
    """Return option -> default of a group of options."""
    return {p.name: p.default for p in inspect.signature(group).parameters.values()}
