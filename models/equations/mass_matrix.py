"""From M(x) x' = f to x' = adj(M) f / det M, after a proof that det M has no zero on the box."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.models.equations.equations import Step
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.plant.plant import Plant
from takagi.models.ranges.domain import Domain

if TYPE_CHECKING:
    import sympy as sp

LARGEST_BLOCK = 5  # rows that hang together; the adjugate of a full 6 x 6 has 720 products an entry


def explicit(
    mass: sp.Matrix, f: tuple[sp.Expr, ...], plant: Plant, domain: Domain | None = None
) -> tuple[tuple[sp.Expr, ...], tuple[Step, ...]]:
    """Return (M^-1 f, steps of the derivation); the denominators det are kept in one piece.

    Rows that M does not couple are solved apart, so that each has the smallest determinant.

    Parameters
    ----------
    domain : where det M must have no zero, in the plant's variables; None for the plant's box.

    Raises
    ------
    ModelError : det M contains 0 on the domain or cannot be bounded, M depends on an input or a
        disturbance, or more rows are coupled than can be solved in symbols.
    """
    import sympy as sp

    over = Domain.of_box(plant.box) if domain is None else domain
    symbols = {v.symbol for v in (*plant.states, *plant.uncertain)}
    symbols |= {p.symbol for p in plant.parameters}
    strange = mass.free_symbols - symbols
    if strange:
        names = ", ".join(sorted(map(str, strange)))
        raise ModelError(
            f"plant {plant.name!r}: the mass matrix depends on {names}; it may depend on states "
            "and parameters only"
        )
    rows = list(f)
    steps = []
    for block in _blocks(mass):
        block_matrix = mass.extract(block, block)
        labels = ", ".join(plant.states[k].name for k in block)
        if len(block) > LARGEST_BLOCK:
            raise ModelError(
                f"plant {plant.name!r}: the mass matrix couples {len(block)} rows ({labels}); up "
                f"to {LARGEST_BLOCK} are solved in symbols, solve the others by hand"
            )
        det = sp.factor_terms(sp.trigsimp(sp.expand(block_matrix.det(method="berkowitz"))))
        bounds = _bounded_away(det, plant, labels, over)
        solved = block_matrix.adjugate() * sp.Matrix([f[k] for k in block])
        for position, k in enumerate(block):
            rows[k] = sp.expand(solved[position]) / det
        if bounds is not None:
            words = f"Determinant of the mass matrix in {labels}: no zero, bounds by "
            steps.append(Step(words + "ball arithmetic.", _line(det, bounds)))
    return tuple(rows), tuple(steps)


def _blocks(mass: sp.Matrix) -> list[list[int]]:
    """Return the sets of rows that hang together through entries off the diagonal."""
    from scipy.sparse.csgraph import connected_components

    joined = np.array([[entry != 0 for entry in mass.row(k)] for k in range(mass.rows)])
    count, group = connected_components(joined, directed=False)
    return sorted([k for k, g in enumerate(group) if g == number] for number in range(count))


def _bounded_away(det: sp.Expr, plant: Plant, labels: str, domain: Domain) -> Interval | None:
    """Return proved bounds of det without 0; None for a number."""
    from fractions import Fraction

    from takagi.models.ranges.expression_range import expression_range

    advice = "shrink the ranges, or remove the state whose mass vanishes"
    if not det.free_symbols:
        if det == 0:
            raise ModelError(
                f"plant {plant.name!r}: the mass matrix is singular everywhere in the rows of "
                f"{labels}; {advice}"
            )
        return None
    try:
        det_range = expression_range(det, domain, tolerance=Fraction(1, 10**4))
    except ModelError as error:
        raise ModelError(
            f"plant {plant.name!r}: the determinant of the mass matrix in the rows of {labels}, "
            f"{det}, cannot be bounded: {error}"
        ) from error
    if det_range.outer.contains(0):
        where = _zero(det, plant) if domain.rectangle is not None else ""
        raise ModelError(
            f"plant {plant.name!r}: the mass matrix may be singular: its determinant in the rows "
            f"of {labels}, {det}, has the range {det_range.outer} on the box{where}; {advice}"
        )
    return det_range.outer


def _zero(det: sp.Expr, plant: Plant) -> str:
    """Return e.g. ``" (smallest near theta = 1.57)"`` from samples; words only, no proof."""
    import itertools

    import sympy as sp

    symbols = sorted(det.free_symbols, key=str)
    shares = range(0, 17)
    if len(symbols) > 3:
        return ""
    grids = [[plant.box[s].lower + plant.box[s].width * k / 16 for k in shares] for s in symbols]
    value = sp.lambdify(symbols, det)
    smallest = min(
        itertools.product(*grids), key=lambda point: abs(float(value(*map(float, point))))
    )
    at = ", ".join(f"{s} = {float(v):.4g}" for s, v in zip(symbols, smallest, strict=True))
    return f", nearest to 0 around {at}"


def _line(det: sp.Expr, bounds: Interval) -> str:
    import sympy as sp

    lower, upper = bounds.outward(6).outward_floats()
    return rf"\det M = {sp.latex(det)} \in [{lower:.6g},\ {upper:.6g}]"
