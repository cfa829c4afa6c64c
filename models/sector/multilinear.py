"""Entries in premise symbols as multi-affine polynomials, and their values at the corners."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.vertex_arrays import VertexProduct

if TYPE_CHECKING:
    import sympy as sp

MultiAffine: TypeAlias = Mapping[tuple[int, ...], Fraction]
"""Premise numbers -> coefficient of their product; () is the constant term."""

DIGITS = 60  # of an irrational coefficient such as sqrt(2), before the entry is rounded


def vertex_product(
    matrix: sp.Matrix,
    symbols: Sequence[sp.Symbol],
    corners: Sequence[tuple[Fraction, ...]],
    *,
    constants: Mapping[sp.Symbol, Fraction] | None = None,
    letter: str = "A",
) -> VertexProduct:
    """Return the matrix at every corner of the premises, each entry rounded once.

    Parameters
    ----------
    matrix : entries multi-affine in the symbols.
    symbols, corners : one per premise; a constant premise has one corner.
    constants : values of other symbols that appear in the entries.
    letter : names the matrix in messages.

    Raises
    ------
    ModelError : an entry that is not multi-affine in the symbols, with its place.
    """
    entries = {}
    for index, entry in enumerate(matrix):
        if entry == 0:
            continue
        where = f"{letter}[{index // matrix.cols}, {index % matrix.cols}] = {entry}"
        polynomial = multi_affine(entry, symbols, constants=constants, where=where)
        entries[divmod(index, matrix.cols)] = corner_values(polynomial, corners)
    sizes = tuple(len(values) for values in corners)
    return VertexProduct(sizes, int(matrix.rows), int(matrix.cols), entries)


def multi_affine(
    entry: sp.Expr,
    symbols: Sequence[sp.Symbol],
    *,
    constants: Mapping[sp.Symbol, Fraction] | None = None,
    where: str = "",
) -> MultiAffine:
    """Return sum_S c_S prod_{k in S} z_k, the entry as a polynomial of degree <= 1 in each z_k.

    Products of weights interpolate exactly such entries, and no others.

    Raises
    ------
    ModelError : another symbol in the entry, or a premise that enters otherwise.
    """
    import sympy as sp

    where = where or str(entry)
    numbers_known = {s: sp.Rational(*v.as_integer_ratio()) for s, v in (constants or {}).items()}
    written = entry.xreplace(numbers_known)
    strange = written.free_symbols - set(symbols)
    if strange:
        names = ", ".join(sorted(map(str, strange)))
        raise ModelError(
            f"{where} still contains {names}; replace it by a premise, or give its value as a "
            "parameter"
        )
    premise_numbers = [
        number for number, symbol in enumerate(symbols) if symbol in written.free_symbols
    ]
    if not premise_numbers:
        return {(): _rational(written)}
    generators = [symbols[number] for number in premise_numbers]
    polynomial = written.as_poly(*generators) or sp.cancel(written).as_poly(*generators)
    for position, symbol in enumerate(generators):
        if polynomial is None or polynomial.degree(position) > 1:
            culprit = symbol if polynomial is not None else ", ".join(map(str, generators))
            raise ModelError(
                f"{where} is not linear in the premise {culprit}; make the whole entry a premise"
            )
    return {
        tuple(
            number for number, power in zip(premise_numbers, powers, strict=True) if power
        ): _rational(c)
        for powers, c in polynomial.terms()
    }


def corner_values(
    polynomial: MultiAffine, corners: Sequence[tuple[Fraction, ...]]
) -> tuple[tuple[int, ...], Floats]:
    """Return (premises, values): the polynomial at all corners of the premises it depends on.

    Each value is the exact rational, rounded once to the nearest float.
    """
    axes = tuple(sorted({n for members in polynomial for n in members if len(corners[n]) > 1}))
    premise_numbers = sorted({number for members in polynomial for number in members})
    common = {k: math.lcm(*(corner.denominator for corner in corners[k])) for k in premise_numbers}
    scale = math.lcm(*(c.denominator for c in polynomial.values()), 1)
    total = np.zeros(tuple(len(corners[k]) for k in premise_numbers), dtype=object)
    for members, coefficient in polynomial.items():
        term = np.array(int(coefficient * scale), dtype=object)
        for position, k in enumerate(premise_numbers):
            shape = [1] * len(premise_numbers)
            # In integers over the common denominator, so that no step but the last one rounds.
            factor = [int(v * common[k]) for v in corners[k]] if k in members else [common[k]]
            shape[position] = len(factor)
            term = term * np.array(factor, dtype=object).reshape(shape)
        total = total + term
    denominator = scale * math.prod(common.values())
    # Python divides integers with one correct rounding.
    values = np.array([int(v) / denominator for v in np.ravel(total)], dtype=np.float64)
    return axes, values.reshape(tuple(len(corners[axis]) for axis in axes))


def _rational(value: sp.Expr) -> Fraction:
    import sympy as sp

    if value.is_Rational:
        return Fraction(int(value.p), int(value.q))
    rational = sp.Rational(sp.N(value, DIGITS))
    return Fraction(int(rational.p), int(rational.q))
