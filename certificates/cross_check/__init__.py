"""A second checker, written independently, which uses FLINT.

    kernel/     the file, exact matrices, and the conditions to decide
    loop/       claims about the loop of model and gains
    plant/      a plant is contained in its model
    turbine/    claims about a turbine's loop
    opinion     its verdicts on a file; ``audit.two_checkers`` compares both checkers

It imports FLINT and the standard library alone: an error in the first checker, in the models or in
the solver cannot be repeated here by sharing their code.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.cross_check.kernel.obligation import Definite, Fact
    from takagi.certificates.cross_check.kernel.reading import Refusal, loads
    from takagi.certificates.cross_check.opinion import Opinion, judge, judge_document

__all__ = ["Definite", "Fact", "Opinion", "Refusal", "judge", "judge_document", "loads"]

_HOME = {
    "Definite": "kernel.obligation",
    "Fact": "kernel.obligation",
    "Opinion": "opinion",
    "Refusal": "kernel.reading",
    "judge": "opinion",
    "judge_document": "opinion",
    "loads": "kernel.reading",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.certificates.cross_check.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
