"""The equilibria of a loop at constant winds, as a value and as a claim for the checker."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from takagi.certificates.checker.kernel.result import Checked
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.document.certificate_file import certificate_document
from takagi.models.laws.law_words import law_words


@dataclass(frozen=True, slots=True)
class EquilibriumCell:
    """The equilibria of the loop at every wind of a range.

    Attributes
    ----------
    wind : (v_1, v_2) [m/s].
    rests : "one", "one at the trim", "one off the trim", "none", "several", "continuum", or
        "unknown".
    reason : why it is unknown, else empty.
    """

    wind: tuple[float, float]
    rests: str
    reason: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class ClosedLoopEquilibria:
    """The cells in order of wind, and the model and law that they are about.

    Attributes
    ----------
    law : the law's name.
    cells : they follow each other without a gap.
    model, gains : the turbine and the law as they are emitted, which the answers are about.
    """

    law: str
    cells: tuple[EquilibriumCell, ...]
    model: Mapping[str, Any]
    gains: Mapping[str, Any]

    def spans(self) -> tuple[EquilibriumCell, ...]:
        """Return neighbouring cells with one answer as one."""
        found: list[EquilibriumCell] = []
        for cell in self.cells:
            if found and found[-1].rests == cell.rests and found[-1].wind[1] == cell.wind[0]:
                joined = (found[-1].wind[0], cell.wind[1])
                found[-1] = EquilibriumCell(joined, cell.rests, found[-1].reason)
            else:
                found.append(cell)
        return tuple(found)

    def claim(self) -> dict[str, Any]:
        """Return the claim of kind ``equilibrium`` about the cells that are decided."""
        return {
            "name": f"rests of the loop with the {law_words(self.law)}",
            "kind": "equilibrium",
            "cells": [
                {"wind": list(cell.wind), "rests": cell.rests}
                for cell in self.cells
                if cell.rests != "unknown"
            ],
        }

    def document(self) -> dict[str, Any]:
        """Return a certificate with this claim alone."""
        return certificate_document(
            model=self.model, gains=self.gains, claims=[self.claim()], provenance={}
        )

    def check(self) -> Checked:
        """Return the checker's verdict, replayed from the written document."""
        return check_document(self.document())
