"""Entries that are multi-affine in the premises, and their exact values at the corners.

A polynomial of degree at most one in each premise is the blend of its values at the corners; the
weights are products of w_k = (upper - z)/(upper - lower) and 1 - w_k.  Polynomial and blend are
both affine in each premise and agree at the corners, hence they are equal.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import product

from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.reading import PlantNodes, Premise

MOST_NUMBERS = 1 << 20  # of all vertices together
MultiAffine = dict[frozenset[str], Fraction]


def multi_affine_entries(plant: PlantNodes) -> dict[str, list[list[MultiAffine]]]:
    """Return A, B, ..., each entry as a dictionary: set of premises -> factor of their product.

    Raises
    ------
    CertificateError : an entry is not a polynomial with rational coefficients and degree at most
        one in each premise.
    """
    algebra = Algebra(plant.graph)
    return {
        letter: [
            [
                _multi_affine(algebra, node, f"embedding.{letter}[{i}][{j}]")
                for j, node in enumerate(row)
            ]
            for i, row in enumerate(rows)
        ]
        for letter, rows in plant.entries.items()
    }


def _multi_affine(algebra: Algebra, node: int, where: str) -> MultiAffine:
    try:
        polynomial = algebra.polynomial(node)
    except Refused as error:
        raise CertificateError(f"{where}: {error}") from error
    if any(power > 1 for monomial in polynomial for _, power in monomial):
        raise CertificateError(f"{where}: a premise stands in it with a power above one")
    return {frozenset(name for name, _ in monomial): c for monomial, c in polynomial.items()}


def entry_node(graph: Graph, entry: MultiAffine, premise_nodes: Mapping[str, int]) -> int:
    """Return an entry with its premises replaced by nodes, as a sum of products.

    The identity with the equations is shown for this polynomial, which also defines the vertices,
    and not for the text of the entry: ``z*q/q`` would be undefined where the premise q vanishes.
    """
    total = graph.constant(0)
    for members, c in entry.items():
        term = graph.constant(c)
        for name in sorted(members):
            term = graph.multiply(term, premise_nodes[name])
        total = graph.add(total, term)
    return total


def corners_of(premises: list[Premise]) -> list[dict[str, tuple[int, Fraction]]]:
    """Return for each rule: premise -> (0 for lower or 1 for upper, value).

    The last premise changes first.  A premise with equal bounds has one corner.
    """
    ends = [[p.lower] if p.lower == p.upper else [p.lower, p.upper] for p in premises]
    return [
        {p.name: pick for p, pick in zip(premises, picks, strict=True)}
        for picks in product(*(list(enumerate(values)) for values in ends))
    ]


def vertex_stack(
    rows: list[list[MultiAffine]],
    corners: list[dict[str, tuple[int, Fraction]]],
    numbers: Mapping[str, tuple[int, Fraction]] = {},
) -> list[list[list[Fraction]]]:
    """Return a matrix for each corner, or a single matrix if no entry varies.

    ``numbers`` have the same value at all corners.
    """
    varying = any(members - numbers.keys() for row in rows for entry in row for members in entry)
    corners = [{**corner, **numbers} for corner in corners]
    distinct = corners if varying else corners[:1]
    if len(distinct) * len(rows) * len(rows[0]) > MOST_NUMBERS:
        raise CertificateError(f"{len(distinct)} vertices: too many")
    values = [[_values(entry, distinct) for entry in row] for row in rows]
    return [[[entry[k] for entry in row] for row in values] for k in range(len(distinct))]


def _values(entry: MultiAffine, corners: list[dict[str, tuple[int, Fraction]]]) -> list[Fraction]:
    """Return an entry at every corner; each combination of its premises' ends is computed once."""
    names = sorted(set().union(*entry))
    computed: dict[tuple[int, ...], Fraction] = {}
    values = []
    for corner in corners:
        picks = tuple(corner[name][0] for name in names)
        if picks not in computed:
            computed[picks] = _value(entry, corner)
        values.append(computed[picks])
    return values


def _value(entry: MultiAffine, corner: dict[str, tuple[int, Fraction]]) -> Fraction:
    total = Fraction(0)
    for members, c in entry.items():
        for name in members:
            c *= corner[name][1]
        total += c
    return total
