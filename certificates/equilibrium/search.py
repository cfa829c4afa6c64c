"""Finds the number of equilibria of a turbine's closed loop, wind cell by wind cell."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.equilibria.equilibrium_claim import (
    RestReader,
    equilibrium_reader,
)
from takagi.certificates.claims.turbine.published import published_law_data
from takagi.certificates.document.certificate_file import effort_sharing_law_data, turbine_data
from takagi.certificates.equilibrium.answers import ClosedLoopEquilibria, EquilibriumCell
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import exact
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.turbine.data import Turbine

Tell = Callable[[str], None]
NARROWEST = 0.01
DECIMALS = 9


def closed_loop_equilibria(
    turbine: Turbine,
    law: EffortSharingLaw | PublishedLaw,
    *,
    winds: tuple[float, float] | None = None,
    narrowest: float = NARROWEST,
    tell: Tell | None = None,
) -> ClosedLoopEquilibria:
    """Return the number of equilibria at every constant wind, with an exact wind estimate.

    Each answer is proved, in outward rounded arithmetic about the emitted decimals, for all winds
    of its cell; "unknown" where no proof was found.  See docs/equilibria.md for what is counted.

    Parameters
    ----------
    winds : range [m/s]; None takes all that the law knows.
    narrowest : a cell without an answer is halved down to this width [m/s].
    tell : called with a word before each m/s.

    Raises
    ------
    ModelError : a law of another kind, winds outside those that the law knows, or a width that is
        not positive.
    """
    model, gains = _emitted(turbine, law)
    read = read_text(json.dumps({"model": model, "gains": gains}), "loop")
    name, known, answer = equilibrium_reader(read["model"], read["gains"])
    low, high = winds or (float(known[0]), float(known[1]))
    if not float(known[0]) <= low < high <= float(known[1]):
        raise ModelError(
            f"winds {low:.6g} to {high:.6g} m/s were given; an increasing range within "
            f"{float(known[0]):.6g} to {float(known[1]):.6g} m/s is needed"
        )
    if not narrowest > 0:
        raise ModelError(f"narrowest cell {narrowest!r} m/s was given; it must be positive")
    cells: list[EquilibriumCell] = []
    for first, last in pairwise(_nodes(gains, low, high)):
        if tell is not None:
            tell(f"rests at {first:.4g} to {last:.4g} m/s")
        cells += _cells(answer, first, last, narrowest)
    return ClosedLoopEquilibria(name, tuple(cells), model, gains)


def _emitted(
    turbine: Turbine, law: EffortSharingLaw | PublishedLaw
) -> tuple[dict[str, Any], dict[str, Any]]:
    if isinstance(law, EffortSharingLaw):
        return turbine_data(turbine, []), effort_sharing_law_data(law)
    if isinstance(law, PublishedLaw):
        return turbine_data(turbine, []), published_law_data(law)
    raise ModelError(
        f"a law of type {type(law).__name__} was given; the rests of an EffortSharingLaw or "
        "a PublishedLaw can be counted"
    )


def _nodes(gains: dict[str, Any], low: float, high: float) -> Sequence[float]:
    """Return the winds at which a table of the law bends, and both ends."""
    tables = [gains] if "wind" in gains else [gains["partial"], gains["full"]]
    inner = {float(v) for table in tables for v in table["wind"] if low < float(v) < high}
    return sorted({low, high, *inner})


def _cells(
    answer: RestReader, low: float, high: float, narrowest: float
) -> Iterator[EquilibriumCell]:
    try:
        yield EquilibriumCell((low, high), answer((exact(low), exact(high))))
        return
    except Refused as error:
        reason = str(error)
    middle = round((low + high) / 2, DECIMALS)
    if high - low <= narrowest or not low < middle < high:
        yield EquilibriumCell((low, high), "unknown", reason)
        return
    yield from _cells(answer, low, middle, narrowest)
    yield from _cells(answer, middle, high, narrowest)
