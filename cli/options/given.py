"""Options that verbs share: their declaration, which of them were given, their text as typed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.models import OptionInfo

from takagi.cli.texts import option_words
from takagi.models.errors import ModelError

Options = tuple[Parameter, ...]
_KINDS: Mapping[str, Any] = {
    "": str,
    "flag": bool,
    "float": float,
    "int": int,
    "list": list[str],
    "pair": tuple[str, str],
    "path": Path,
}
_ANNOTATED: Any = Annotated
# Spellings other than the name's.
_SPELLED = {
    "out": ("--out", "-o"),
    "as_json": ("--json",),
    "every_claim": ("--all",),
    "wind": ("--wind", "--scenario"),
}
# Options of a certificate for given gains; all other options of a design concern making gains.
_OF_GIVEN_GAINS = (
    "inertia",
    "power_coefficient",
    "equilibrium_wake",
    "choice",
    "solve_rest",
    "safe_start",
    "sample_time",
    "noise",
    "horizon",
    "performance",
    "disturbances",
    "norm_below",
    "controller",
)
# Objectives of plants that are proved of given gains; the others are about searches for gains.
_NORMS = ("hinf", "h2", "peak")


def option_of(name: str) -> str:
    """Return the option of a parameter as it is typed: --decay-rate of ``decay_rate``."""
    return "--" + name.replace("_", "-")


def declared(*groups: str, callback: Callable[..., Any] | None = None) -> Options:
    """Return the options of groups of ``options.toml`` as parameters, which ``run_command`` reads.

    ``callback`` : what reads the value of --law.
    """
    options = []
    for group in groups:
        words = dict(option_words(group))
        title = words.pop("title", None)
        for key, stated in words.items():
            head, _, kind = key.partition(": ")
            name, _, metavar = head.partition(" ")
            default = False if kind == "flag" else None
            if not isinstance(stated, str):
                stated, default = stated["help"], stated["default"]
            taken = _KINDS[kind] if default is not None else _KINDS[kind] | None
            option = _option(name, metavar, stated, callback if name == "law" else None)
            option.rich_help_panel = title
            annotation = _ANNOTATED[taken, option]
            options.append(
                Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
            )
    return tuple(options)


def with_words(verb: str, parameter: Parameter) -> Parameter:
    """Return an option of a verb's function with its words in ``options.toml``."""
    if hasattr(parameter.annotation, "__metadata__"):
        return parameter
    stated_words = *option_words(verb).items(), *option_words("every-verb").items()
    for key, stated in stated_words:
        name, _, metavar = key.partition(" ")
        if name == parameter.name:
            option = _option(name, metavar, stated)
            annotation = _ANNOTATED[parameter.annotation, option]
            return parameter.replace(annotation=annotation)
    return parameter


def _option(
    name: str, metavar: str, words: str, callback: Callable[..., Any] | None = None
) -> OptionInfo:
    spellings = _SPELLED.get(name, (option_of(name),))
    option: OptionInfo = typer.Option(
        *spellings, metavar=metavar or None, help=words, callback=callback
    )
    return option


def defaults_of(options: Options) -> dict[str, Any]:
    """Return name -> default of options."""
    return {option.name: option.default for option in options}


def as_typed(options: Mapping[str, object]) -> str:
    """Return the options that are not at their default, as a user would type them."""
    shown = []
    for name, value in options.items():
        if value is None or value is False or value == [] or (name, value) == ("law", "coherent"):
            continue
        option = option_of(name)
        if isinstance(value, list):
            shown += [f"{option} {entry}" for entry in value]
            continue
        words = [] if value is True else value if isinstance(value, tuple) else [value]
        shown.append(" ".join([option, *map(str, words)]))
    return ", ".join(shown)


def refuse_designing(options: Mapping[str, object]) -> None:
    """Refuse options about designing gains next to --gains; ignoring them would mislead."""
    for name, value in options.items():
        left = value is None or value is False or value in ("coherent", [])
        left = left or (name == "objective" and value in _NORMS)
        if name not in _OF_GIVEN_GAINS and not left:
            raise ModelError(
                f"option {option_of(name)} is about designing gains, but --gains gives them; "
                "leave out one of the two"
            )
