"""A rounded answer that satisfies the equalities; every LMI is decided over the rationals.

Elimination of equalities: the unknowns as affine functions of free numbers.

The equalities are linear in the entries x of the unknowns, M x + c = 0 with rationals M and c (a
float counts as the dyadic number it stores).  Elimination over the rationals splits the entries
into dependent and free ones,

    x = x_0 + sum_k z_k d_k,     z_k the free entries themselves,

or shows that the equalities contradict one another.  Every LMI is then one in z.  Nothing is
rounded: values of z, rounded in any way, give unknowns that satisfy the equalities exactly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.linalg import qr

from takagi.lmi.condition.evaluate import (
    exact_difference,
    exact_matrices,
    exact_terms,
    fractions,
    lmi_value,
)
from takagi.lmi.condition.statements import StatedCondition, condition_of
from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.refutation.exact_algebra import adjoint, is_definite, is_semidefinite
from takagi.models.arrays import Floats, Indices, ShortRepr
from takagi.models.errors import ModelError

# The dependent entries are chosen by the pivots of a QR decomposition.  A pivot below this share of
# the first counts as zero.
PIVOT = 1e-10


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class Parametrised(ShortRepr):
    """All unknowns that satisfy the equalities of a condition.

    Attributes
    ----------
    original : the condition with equalities.
    condition : the same LMIs, by the same names, in ``free`` and in the unknowns that are in no
        equality; its objective is less than the original's by ``offset``.
    free : (K,) unknown 1 x 1, the entries that may be chosen; None where the equalities leave
        none.
    bound : the unknowns that occur in equalities.
    places : (K,) indices of the free entries among the numbers of the bound unknowns.
    base, directions : (numbers,) and (K, numbers) of Fractions: x_0 and d_k.
    offset : the objective at x_0, exactly.
    """

    original: Condition
    condition: Condition
    free: Unknown | None
    bound: tuple[Unknown, ...]
    places: Indices
    base: Array
    directions: Array
    offset: Fraction

    def lifted(self, values: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return values of the original's unknowns from values of the condition's, in floats."""
        z = np.zeros(0) if self.free is None else values[self.free.name].ravel()
        numbers = self.base.astype(np.float64) + z @ self.directions.astype(np.float64)
        given = {unknown.name for unknown in self.condition.unknowns if unknown is not self.free}
        others = {name: value for name, value in values.items() if name in given}
        return {**others, **_split(self.bound, numbers)}

    def exact(self, values: Mapping[str, Any]) -> dict[str, Array]:
        """Return Fractions near the given values of the original that satisfy the equalities.

        The free entries and the other unknowns are taken as they are given, a float as the dyadic
        number it stores; the dependent entries are computed from the free ones.
        """
        exact_values = {
            unknown.name: fractions(values[unknown.name]) for unknown in self.original.unknowns
        }
        if not self.bound:
            return exact_values
        entries = np.concatenate(
            [unknown.numbers(exact_values[unknown.name]) for unknown in self.bound]
        )
        numbers = self.base.copy()
        for entry, direction in zip(self.places, self.directions, strict=True):
            nonzero = direction != 0
            numbers[nonzero] += entries[entry] * direction[nonzero]
        return {**exact_values, **_split(self.bound, numbers)}


def parametrised(condition: Condition) -> Parametrised | None:
    """Return the condition without its equalities, solved exactly; None where they contradict.

    A condition without equalities, too, is returned with the exact values that it stores.  Named
    parameters in LMIs with an unknown of an equality are replaced by their values.  None is a proof
    that no unknowns satisfy the equalities, for the numbers as they are stored.  Where decimals are
    meant, give them as strings or Fractions.
    """
    spoken = {term.unknown for equality in condition.equalities for term in equality.terms}
    bound = tuple(unknown for unknown in condition.unknowns if unknown in spoken)
    base, directions, free_entries = _solutions(condition, bound)
    if base is None:
        return None
    names = {unknown.name for unknown in condition.unknowns}
    name = "free"
    while name in names:
        name += "_"
    free = Unknown(name, 1, 1, count=len(free_entries), latex="z") if len(free_entries) else None
    unbound = tuple(unknown for unknown in condition.unknowns if unknown not in bound)
    steps = [_split(bound, direction) for direction in directions] if condition.objective else []
    lmis = tuple(_in_free(lmi, condition, bound, free, base, directions) for lmi in condition.lmis)
    costs = {
        u.name: fractions(condition.objective[u.name])
        for u in bound
        if u.name in condition.objective
    }
    objective: dict[str, Array] = {
        key: cost for key, cost in condition.objective.items() if key not in costs
    }
    if free is not None and costs:
        objective[name] = np.array(
            [[[float(_cost(costs, step))]] for step in steps], dtype=np.float64
        )
    posed = Condition(
        name=condition.name,
        unknowns=unbound if free is None else (*unbound, free),
        lmis=lmis,
        objective=objective,
        parameters=condition.parameters,
        source=condition.source,
    )
    return Parametrised(
        original=condition,
        condition=posed,
        free=free,
        bound=bound,
        places=free_entries,
        base=base,
        directions=directions,
        offset=Fraction(_cost(costs, _split(bound, base))),
    )


def _solutions(
    condition: Condition, bound: tuple[Unknown, ...]
) -> tuple[Array | None, Array, Indices]:
    """Return x_0, the d_k and the free places; x_0 is None where there is no solution."""
    import flint

    frames = tuple(equality.frame() for equality in condition.equalities)
    read = adjoint(Condition(name=condition.name, unknowns=bound, lmis=frames))
    # Every off-diagonal entry of a frame counts twice in the adjoint, the constant too.
    columns: list[int] = []
    for block in read.blocks:
        p = condition.equalities[block.lmi].shape[0]
        columns += block.index[:p, p:].ravel().tolist()
    equation = {column: k for k, column in enumerate(columns)}
    numbers = read.rows
    rows = [[0] * (numbers + 1) for _ in columns]
    for row, column, value in zip(read.row, read.column, read.value, strict=True):
        if int(column) in equation:
            rows[equation[int(column)]][int(row)] += int(value)
    for column, k in equation.items():
        rows[k][numbers] = int(read.constant[column])
    if not rows:
        return np.zeros(0, dtype=object), np.zeros((0, 0), dtype=object), np.arange(0)
    order = _favoured(rows, numbers)
    reduced, denominator, rank = flint.fmpz_mat(
        [[row[k] for k in order] + [row[numbers]] for row in rows]
    ).rref()
    pivots = [next(k for k in range(numbers + 1) if reduced[i, k] != 0) for i in range(rank)]
    if pivots and pivots[-1] == numbers:
        return None, np.zeros((0, numbers), dtype=object), np.zeros(0, dtype=np.intp)
    loose = sorted(set(range(numbers)) - set(pivots))
    base = np.full(numbers, Fraction(0), dtype=object)
    directions = np.full((len(loose), numbers), Fraction(0), dtype=object)
    for i, pivot in enumerate(pivots):
        base[order[pivot]] = Fraction(-int(reduced[i, numbers]), int(denominator))
        for k, entry in enumerate(loose):
            directions[k, order[pivot]] = Fraction(-int(reduced[i, entry]), int(denominator))
    for k, entry in enumerate(loose):
        directions[k, order[entry]] = Fraction(1)
    return base, directions, np.array([order[entry] for entry in loose], dtype=np.intp)


def _favoured(rows: list[list[int]], numbers: int) -> list[int]:
    """Return all entries, those first that are best computed from the others."""
    largest = [max((abs(number) for number in row[:numbers]), default=0) or 1 for row in rows]
    matrix = np.array(
        [
            [number / row_size for number in row[:numbers]]
            for row, row_size in zip(rows, largest, strict=True)
        ]
    ).reshape(len(rows), numbers)
    _, triangular, order = qr(matrix, mode="economic", pivoting=True)
    size = np.abs(np.diag(triangular))
    rank = int((size > PIVOT * size[0]).sum()) if len(size) else 0
    first = sorted(int(k) for k in order[:rank])
    return first + sorted(set(range(numbers)) - set(first))


def _split(bound: tuple[Unknown, ...], numbers: Array) -> dict[str, Any]:
    members, start = {}, 0
    for unknown in bound:
        members[unknown.name] = unknown.value(numbers[start : start + unknown.length])
        start += unknown.length
    return members


def _cost(costs: Mapping[str, Array], values: Mapping[str, Array]) -> Fraction:
    return sum((Fraction(np.sum(cost * values[key])) for key, cost in costs.items()), Fraction(0))


def _in_free(
    lmi: LMI,
    condition: Condition,
    bound: tuple[Unknown, ...],
    free: Unknown | None,
    base: Array,
    directions: Array,
) -> LMI:
    """Return the LMI with its bound unknowns written in the free numbers."""
    mine = tuple(term for term in lmi.terms if term.unknown in bound)
    if not mine:
        return lmi
    spoken = replace(lmi, terms=mine, constants=(), sign=1, labels=())
    read = adjoint(
        Condition(name=lmi.name, unknowns=bound, lmis=(spoken,), parameters=condition.parameters)
    )
    index = np.stack([block.index for block in read.blocks])
    # In the sum of products an entry off the diagonal counts twice.
    share = fractions(1 + np.eye(lmi.size)) / (2 * read.denominator)

    def matrices_at(numbers: Array) -> tuple[list[int], Array]:
        """Return the items that are not zero at these numbers, with their matrices."""
        moved = np.flatnonzero(numbers[read.row] != 0)
        z = np.full(read.columns, Fraction(0), dtype=object)
        np.add.at(z, read.column[moved], read.value[moved] * numbers[read.row[moved]])
        touched = np.unique(read.column[moved] // triangle(lmi.size))
        return touched.tolist(), z[index[touched]] * share

    fixed = exact_terms(replace(lmi, terms=(), constants=lmi.constants))
    constant = lmi_value(fixed, {}, {}, Fraction(0))
    items, matrices = matrices_at(base)
    constant[items] += matrices
    terms = [term for term in lmi.terms if term.unknown not in bound]
    items, members, values = [], [], []
    for number, direction in enumerate(directions):
        touched, matrices = matrices_at(direction)
        items += touched
        members += [number] * len(touched)
        values += list(matrices)
    if values and free is not None:
        terms.append(
            Term(
                unknown=free,
                left=np.array(values, dtype=object),
                at=None,
                items=np.array(items, dtype=np.intp),
                members=np.array(members, dtype=np.intp),
                symbol="z_k",
                latex=("", "D_k"),
                factor=r"\textstyle\sum_k",
            )
        )
    constants = (Constant(value=constant, at=None, latex="D_0"),) if (constant != 0).any() else ()
    return replace(lmi, terms=tuple(terms), constants=constants)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class ExactSolution(ShortRepr):
    """Unknowns in rational numbers, with the test that they satisfy a condition.

    The test is about the numbers that the condition stores: a float counts as its binary value.

    Attributes
    ----------
    condition : the condition.
    values : unknown name -> (count, rows, cols) of Fractions.
    """

    condition: Condition
    values: Mapping[str, Array]

    @property
    def holds(self) -> bool:
        """Return whether all equalities and LMIs hold, exactly; each call tests them again."""
        return not self.fault()

    def fault(self) -> str:
        """Return the first equality or LMI that does not hold, in words; empty if all do."""
        for unknown in self.condition.unknowns:
            value = self.values[unknown.name]
            if unknown.symmetric and np.any(value != value.transpose(0, 2, 1)):
                return f"{unknown.name} is not symmetric"
        for equality in self.condition.equalities:
            gap = exact_difference(equality, self.values)
            for item, matrix in enumerate(gap):
                if (matrix != 0).any():
                    return f"{equality.frame().label(item)}: the two sides differ"
        for lmi in self.condition.lmis:
            test = is_definite if lmi.strict else is_semidefinite
            for item, F in enumerate(exact_matrices(self.condition, lmi, self.values)):
                if np.any(F != F.T):
                    return f"{lmi.label(item)}: the matrix is not symmetric"
                if not test(F):
                    need = "definite" if lmi.strict else "semidefinite"
                    return f"{lmi.label(item)}: the matrix is not {need}"
        return ""

    def __str__(self) -> str:
        fault = self.fault()
        if fault:
            return f"{self.condition.name}: not shown by these unknowns ({fault})"
        return (
            f"{self.condition.name}: holds in exact arithmetic, {len(self.condition.equalities)} "
            f"equalities and {sum(lmi.count for lmi in self.condition.lmis)} inequalities"
        )


def exact_solution(condition: StatedCondition, values: Mapping[str, Any]) -> ExactSolution | None:
    """Return rational unknowns next to the given ones that satisfy every equality exactly.

    ``values`` : unknown name -> (count, rows, cols), as in ``Outcome.values``.  Entries that the
    equalities leave free are kept as they are, the others are computed from them.

    Returns the unknowns with their test, ``holds``, which decides the LMIs too; None where the
    equalities contradict one another.

    Raises ModelError: an unknown without a value, or of another shape.
    """
    condition = condition_of(condition, "exact_solution")
    for unknown in condition.unknowns:
        shape = (unknown.count, unknown.rows, unknown.cols)
        if unknown.name not in values or np.shape(values[unknown.name]) != shape:
            shape_given = (
                "nothing" if unknown.name not in values else f"{np.shape(values[unknown.name])}"
            )
            raise ModelError(f"unknown {unknown.name}: {shape_given} is given; {shape} is needed")
    free = parametrised(condition)
    if free is None:
        return None
    return ExactSolution(condition=condition, values=MappingProxyType(free.exact(values)))
