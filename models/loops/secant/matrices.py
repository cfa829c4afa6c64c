"""Data types of the matrix families that contain a closed loop: factors, vertices, export."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any, TypeAlias

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

Exact: TypeAlias = tuple[tuple[Fraction, ...], ...]
MOST_VERTICES = 1024


@dataclass(frozen=True, slots=True)
class SecantFactor:
    """A bounded number theta in one or more entries [A, E]_ij = constant + d_ij theta.

    Attributes
    ----------
    expression : the function whose values theta averages, as text.
    bounds : proved bounds of theta, rounded outward.
    entries : (row, column) of [A, E] -> d_ij.
    evidence : how the bounds were proved.
    """

    expression: str
    bounds: Interval
    entries: Mapping[tuple[int, int], Fraction]
    evidence: str


@dataclass(frozen=True, slots=True)
class SecantCell:
    """x' - x*' = A (x - x*) + E (w - w*) + residual - reference_rate p' on one cell.

    For every x, w and p of the cell there are theta_m in their bounds with
    [A, E] = constant + sum_m theta_m D_m.  All entries of a factor use the same theta_m.

    Attributes
    ----------
    name : name of the cell.
    box : variable -> range.
    reference : variable -> x*, w* as text; it may depend on the exogenous variables.
    constant : (n, n + q) rational part of [A, E].
    factors : the theta_m with their bounds and matrices D_m.
    residual : (n,) enclosure of f(x*, w*), or of f(x*, w*) - x* in discrete time.
    reference_rate : (n, exogenous) enclosure of dx*/dp, in continuous time.
    """

    name: str
    box: Mapping[str, Interval]
    reference: Mapping[str, str]
    constant: Exact
    factors: tuple[SecantFactor, ...]
    residual: tuple[Interval, ...]
    reference_rate: tuple[tuple[Interval, ...], ...]

    @property
    def vertex_count(self) -> int:
        """Return 2^(number of factors)."""
        return int(2 ** len(self.factors))

    @property
    def entries(self) -> tuple[tuple[Interval, ...], ...]:
        """Return the interval matrix [A, E], (n, n + q), without common factors."""
        found = [[Interval(entry, entry) for entry in row] for row in self.constant]
        for factor in self.factors:
            for (row, column), coefficient in factor.entries.items():
                found[row][column] += coefficient * factor.bounds
        return tuple(tuple(row) for row in found)

    def exact_vertices(self, *, most: int = MOST_VERTICES) -> tuple[Exact, ...]:
        """Return [A, E] at every corner of the factors, in rationals; the last factor
        changes fastest.

        [A, E] is affine in the factors, so the cell's family is the convex hull of the vertices.

        Raises
        ------
        ModelError : there are more than ``most``; the message lists the narrowest factor first.
        """
        if self.vertex_count > most:
            ranked = "; ".join(
                f"{factor.expression} in {factor.bounds}"
                for factor in sorted(self.factors, key=lambda factor: factor.bounds.width)
            )
            raise ModelError(
                f"cell {self.name}: {len(self.factors)} factors make {self.vertex_count} vertices, "
                f"more than most = {most}; use the interval matrix, or carry a narrow factor as an "
                f"uncertainty: {ranked}"
            )
        ends = [(factor.bounds.lower, factor.bounds.upper) for factor in self.factors]
        return tuple(self._at(corner) for corner in product(*ends))

    def _at(self, corner: tuple[Fraction, ...]) -> Exact:
        found = [list(row) for row in self.constant]
        for factor, theta in zip(self.factors, corner, strict=True):
            for (row, column), coefficient in factor.entries.items():
                found[row][column] += coefficient * theta
        return tuple(tuple(row) for row in found)


@dataclass(frozen=True, slots=True)
class SecantEmbedding:
    """A closed loop as one family of matrices for each cell; see ``secant_embedding``.

    Attributes
    ----------
    states, disturbances, exogenous : labels with units; A has a column for each state, E one for
        each disturbance that is not exogenous.
    cells : the families.
    sample_time : in s; None in continuous time.
    form : "slope", "derivative" or "jacobian".
    """

    states: tuple[str, ...]
    disturbances: tuple[str, ...]
    exogenous: tuple[str, ...]
    cells: tuple[SecantCell, ...]
    sample_time: float | None
    form: str

    def vertex_arrays(self, *, most: int = MOST_VERTICES) -> tuple[Floats, Floats]:
        """Return (A, E), (N, n, n) and (N, n, q): the vertices of all cells in floats.

        The entries are rounded to nearest, so they are for a solver only.  Proofs use
        ``exact_vertices``.

        Raises
        ------
        ModelError : a cell has more than ``most`` vertices.
        """
        stack = np.array(
            [vertex for cell in self.cells for vertex in cell.exact_vertices(most=most)],
            dtype=np.float64,
        )
        n = len(self.states)
        return stack[:, :, :n], stack[:, :, n:]

    def as_data(self) -> dict[str, Any]:
        """Return the embedding in lists, strings and mappings, every number a rational "p/q".

        ``{"states", "disturbances", "exogenous": [label], "sample_time": "p/q" or None,
        "form", "cells": [{"name", "box": {variable: [lower, upper]}, "reference": {variable:
        text}, "constant": [[n + q columns]], "factors": [{"expression", "bounds": [lower, upper],
        "entries": [[row, column, d]], "evidence"}], "residual": [[lower, upper]],
        "reference_rate": [[[lower, upper]]]}]}``; rows and columns count from 0, and the
        columns of A precede those of E.
        """
        step = None if self.sample_time is None else str(Fraction(repr(self.sample_time)))
        return {
            "states": list(self.states),
            "disturbances": list(self.disturbances),
            "exogenous": list(self.exogenous),
            "sample_time": step,
            "form": self.form,
            "cells": [_cell_data(cell) for cell in self.cells],
        }


def _cell_data(cell: SecantCell) -> dict[str, Any]:
    return {
        "name": cell.name,
        "box": {name: _ends(side) for name, side in cell.box.items()},
        "reference": dict(cell.reference),
        "constant": [[str(entry) for entry in row] for row in cell.constant],
        "factors": [
            {
                "expression": factor.expression,
                "bounds": _ends(factor.bounds),
                "entries": [[row, col, str(d)] for (row, col), d in factor.entries.items()],
                "evidence": factor.evidence,
            }
            for factor in cell.factors
        ],
        "residual": [_ends(side) for side in cell.residual],
        "reference_rate": [[_ends(side) for side in row] for row in cell.reference_rate],
    }


def _ends(side: Interval) -> list[str]:
    return [str(side.lower), str(side.upper)]
