"""Runs a design for a verb; a requirement that no design meets is an answer, not a misuse."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from takagi.cli.errors import UNPROVED
from takagi.cli.progress import Tell

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.design import TurbineDesign

__all__ = ["Unprovable", "answered", "asked_for", "design_asked"]

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True)
class Unprovable:
    """No design was found that meets what was asked; ``reason`` names condition, wind and cure."""

    reason: str

    def tell(self, *, as_json: bool = False) -> int:
        """Print the reason, and return the exit status for it.  Nothing was written."""
        if as_json:
            print(json.dumps({"verdict": "UNDECIDED", "reason": self.reason}, indent=2))
        else:
            print(f"Not proved, nothing written: {self.reason}", file=sys.stderr)
        return UNPROVED


def design_asked(model: str, tell: Tell, **options: object) -> TurbineDesign | Unprovable:
    """Return the finished design of ``model`` for the options of the command line.

    Raises
    ------
    ModelError : misuse: no such model, a malformed file, an option that makes no sense.
    """
    from takagi.cli.options.design_options import design_settings
    from takagi.models.turbine.loader import load_turbine, model_files

    turbine = load_turbine(model)
    settings = design_settings(turbine, **options)  # type: ignore[arg-type]
    files = model_files(model)

    def work(noted: Tell) -> TurbineDesign:
        from takagi.certificates.design.turbine.design import design_turbine

        return design_turbine(turbine, settings, files=files, tell=noted)

    return answered(work, tell, options)


def answered(
    work: Callable[[Tell], Value], tell: Tell, options: Mapping[str, object]
) -> Value | Unprovable:
    """Return what ``work`` returns, or why it cannot be had.

    Misuse was refused before, when options and model were read: a ``ModelError`` of the work is a
    condition that cannot be met.  It is told with its step, and with the options that could be
    relaxed.
    """
    from takagi.models.errors import ModelError

    step = ""

    def noted(text: str, done: float | None = None) -> None:
        nonlocal step
        step = text
        tell(text, done)

    try:
        return work(noted)
    except ModelError as error:
        return Unprovable(_reason(step, str(error), asked_for(options)))


def _reason(step: str, words: str, given: str) -> str:
    # The step's name may open the message already.
    place = "" if not step or words.startswith(step.split(" of ")[0]) else f"{step}: "
    relax = f"\nAsked for beyond the defaults: {given}; relax that first." if given else ""
    return f"{place}{words}{relax}"


def asked_for(options: Mapping[str, object]) -> str:
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
