"""A second checker, written separately, with FLINT: what another reading says of a certificate.

    reading, exact        the file; exact matrices, definite by their characteristic polynomials
    loop, plant           what claims are about: vertices, gains, mixtures; a plant's own vertices
    pieces                the weights cut into pieces
    obligation            a matrix that must be definite, a fact that must hold
    decay, disturbed, limits, observing, fuzzy      claims about loops, as obligations
    expression, algebra, interval, embedding        a plant is the blend of its vertices
    coherent              the matrix inequalities of the turbine's claim
    coherent_ranges, coherent_schedule      its ranges enclose the turbine, cell by cell
    coherent_surface, coherent_numbers      the coefficient surface; the turbine, law and box
    wind_rate, actuator_rates      what rests on the turbine's claim
    opinion               what it says of a file; ``two_checkers`` puts it beside the first one's

It imports FLINT and the standard library, and nothing of the first checker, of models or solver.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.cross_check.obligation import Definite, Fact
    from takagi.certificates.cross_check.opinion import Opinion, judge, judge_document
    from takagi.certificates.cross_check.reading import Refusal

__all__ = ["Definite", "Fact", "Opinion", "Refusal", "judge", "judge_document"]

_HOME = {
    "Definite": "obligation",
    "Fact": "obligation",
    "Opinion": "opinion",
    "Refusal": "reading",
    "judge": "opinion",
    "judge_document": "opinion",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.certificates.cross_check.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
