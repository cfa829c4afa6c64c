"""Options that verbs share: their declaration, which of them were given, their text as typed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any

import typer

from takagi.models.errors import ModelError

Options = tuple[Parameter, ...]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, for machines.")]
# Which processes compute many tasks.
WORKERS_HELP = "Processes; as many as there are cores unless given."
SCHEDULER_HELP = (
    "A Dask scheduler, such as tcp://127.0.0.1:8786, whose workers compute in place of processes "
    "here; needs takagi[cluster]."
)
Workers = Annotated[int | None, typer.Option(metavar="N", help=WORKERS_HELP)]
Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help=SCHEDULER_HELP)]
OutFolder = Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write.")]
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


def option(
    declared: str,
    words: str,
    kind: Any = str,
    *,
    default: Any = None,
    callback: Callable[..., Any] | None = None,
    alias: str = "",
) -> Parameter:
    """Return the declaration of an option as a parameter, which ``run_command`` reads.

    Parameters
    ----------
    declared : name of the parameter, and behind a space what stands for its value in the help.
    words : the help;  kind : the type of its value, bool for one without.
    alias : another spelling, an earlier one.
    """
    name, _, metavar = declared.partition(" ")
    if kind is bool:
        default = False
    taken = kind if default is not None else kind | None
    spellings = (option_of(name), alias) if alias else (option_of(name),)
    stated = typer.Option(*spellings, metavar=metavar or None, help=words, callback=callback)
    annotated: Any = Annotated
    annotation = annotated[taken, stated]
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def group(title: str, *options: Parameter) -> Options:
    """Return the options, which the help lists below the title."""
    for stated in options:
        stated.annotation.__metadata__[0].rich_help_panel = title
    return options


# Turbines and plants both have one, with words of their own.
(OBJECTIVE,) = group(
    "Turbines and plants: what is made best",
    option(
        "objective NAME",
        "Turbines: what the one-step search improves: balanced (wind limits, and some decay), "
        "wind-class (the limits alone) or decay; --one-step alone means balanced. The wind limits "
        "are no narrower than those of the two-step gains, on average and at the weakest wind. "
        "Effort-sharing law. Plants: what is made best beside all that is asked: hinf, h2 or peak "
        "(a norm from --disturbances to --performance), decay, or effort (the share of the "
        "inputs' limits that is used from --initial).",
    ),
)


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
