"""Vertices from the factored form: entries at the corners, checked and assembled."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import sympy as sp

from takagi.models.arrays import Floats
from takagi.models.equations.derivation_step import Step
from takagi.models.equations.equations import Equations, Factored
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number
from takagi.models.ranges.expression_range import expression_range
from takagi.models.ranges.symbolic_steps import with_exponentials_as_symbols
from takagi.models.sector.terms import terms_of
from takagi.models.ts.model import Derivation, TSModel
from takagi.models.ts.premise import Premise
from takagi.models.ts.vertex_arrays import VertexProduct

if TYPE_CHECKING:
    from takagi.models.ranges.cell_search import Cell
    from takagi.models.ranges.expression_range import Domain
    from takagi.models.ts.model import SymbolicForm


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
    if value.is_Rational:
        return Fraction(int(value.p), int(value.q))
    rational = sp.Rational(sp.N(value, DIGITS))
    return Fraction(int(rational.p), int(rational.q))


POINTS = 12
DENOMINATOR = 997  # of the points' coordinates; a prime avoids special angles
SMALLEST = Fraction(1, 10**20)  # the widest ball that is evidence for zero
LONGEST = 150  # most operations for sympy's simplify: about a second


def check_exact(
    rows: Sequence[tuple[str, sp.Expr, sp.Expr]], sides: Mapping[sp.Symbol, Interval]
) -> str:
    """Return how wanted = written was checked, in every row (place, wanted, written).

    First by expansion, over a common denominator too; then at random rational points in ball
    arithmetic, where a ball without 0 refutes; then by sympy's ``simplify`` if the difference is
    short.  The remaining entries agree at the points, and the sentence says that this is no proof.

    ``sides`` : range of each variable; a variable without one is tried in [-1, 1].

    Raises
    ------
    ModelError : a row that is refuted, or one that can neither be shown nor tried at points.
    """
    tried = [
        row_name
        for row_name, expected, written in rows
        if not _row(row_name, expected, written, sides)
    ]
    if not tried:
        return "checked symbolically"
    return (
        f"{', '.join(tried)} checked in ball arithmetic at {POINTS} random rational points only, "
        "which is no proof; the others symbolically"
    )


def _row(
    row_name: str, expected: sp.Expr, written: sp.Expr, sides: Mapping[sp.Symbol, Interval]
) -> bool:
    """Return whether the row is shown symbolically; False when it only agrees at the points."""
    difference = sp.expand(expected - written)
    # The sum of terms keeps each denominator in one piece, so that long ones cancel too.
    if difference == 0 or not terms_of(expected - written):
        return True
    if difference.count_ops() <= 4 * LONGEST:
        joined = with_exponentials_as_symbols(sp.together, difference)
        if sp.expand(sp.fraction(joined)[0]) == 0:
            return True
    agrees = _agrees(row_name, difference, sides)
    short = difference.count_ops() <= LONGEST or agrees is None
    simple = with_exponentials_as_symbols(sp.simplify, difference) if short else difference
    if simple == 0:
        return True
    if agrees is None or not simple.free_symbols:
        raise ModelError(
            f"{row_name}: the factored form misses the plant by {simple}, which does not simplify "
            "to 0; correct the entries of that row"
        )
    return False


def _agrees(row_name: str, difference: sp.Expr, sides: Mapping[sp.Symbol, Interval]) -> bool | None:
    """Return True when the balls at the points contain 0 and are small; None if none could tell."""
    chance = random.Random(difference.count_ops())  # the same points each time
    symbols = sorted(difference.free_symbols, key=str)
    decided = 0
    for _ in range(POINTS):
        point = {}
        for s in symbols:
            side = sides.get(s, Interval.of(-1, 1))
            share = Fraction(chance.randrange(1, DENOMINATOR), DENOMINATOR)
            point[s] = side.lower + side.width * share
        try:
            ball = expression_range(difference, {s: Interval(v, v) for s, v in point.items()}).outer
        except ModelError:
            continue
        if not ball.contains(0):
            at = ", ".join(f"{s} = {float(v):.4g}" for s, v in point.items())
            raise ModelError(
                f"{row_name}: the factored form misses the plant by {difference}, which is "
                f"{float(ball.centre):.4g} at {at or 'every point'}; correct the entries of that "
                "row"
            )
        decided += ball.width <= SMALLEST
    return True if decided == POINTS else None


MOST_LISTED = 16  # the most rules whose corners and vertices are written out


def rule_steps(
    premises: Sequence[Premise], products: Mapping[str, VertexProduct], *, discrete: bool = False
) -> tuple[Step, ...]:
    """Return the steps from proved ranges to vertices; empty for a model without premises.

    Up to 16 rules are listed with their matrices, to six digits; of more the numbering alone.
    """
    varying = [premise for premise in premises if len(premise.corners) > 1]
    if not varying:
        return ()
    corners = list(product(*(range(len(p.corners)) for p in varying)))
    steps = [
        Step("Weights of the premises.", r" \\ ".join(_weights(premise) for premise in varying)),
        _numbering(varying, len(corners), products, discrete),
    ]
    if len(corners) <= MOST_LISTED:
        steps.append(_listed(varying, corners))
        stacks = {letter: letter_product.stack() for letter, letter_product in products.items()}
        steps += [_vertex(rule, stacks) for rule in range(len(corners))]
    steps[0] = Step(steps[0].title, rf"\begin{{gathered}}{steps[0].latex}\end{{gathered}}")
    return tuple(steps)


def _weights(premise: Premise) -> str:
    z = premise.latex
    lower, upper = (f"{float(end):.9g}" for end in premise.corners)
    width = f"{float(premise.upper - premise.lower):.9g}"
    minus = f"- {lower}" if premise.lower >= 0 else f"+ {lower.removeprefix('-')}"
    first = rf"w_{{{z},0}} = \frac{{{upper} - {z}}}{{{width}}}"
    return first + rf", \quad w_{{{z},1}} = \frac{{{z} {minus}}}{{{width}}}"


def _numbering(
    varying: Sequence[Premise], count: int, products: Mapping[str, VertexProduct], discrete: bool
) -> Step:
    names = ", ".join(premise.name for premise in varying)
    weights = r"\, ".join(f"w_{{{p.latex},c_{{i,{k}}}}}" for k, p in enumerate(varying, start=1))
    pairs = (("A", "x"), ("B", "u"), ("E", "w"))
    terms = " + ".join(f"{m}_i {v}" for m, v in pairs if m in products and products[m].columns)
    left_side = "x^+" if discrete else r"\dot x"
    return Step(
        f"Memberships of the {count} rules; c counts the corners (0 lower, 1 upper) of {names}, "
        "the last changing first.",
        rf"h_i = {weights}, \qquad {left_side} = \sum_{{i=1}}^{{{count}}} h_i \left({terms}\right)",
    )


def _listed(varying: Sequence[Premise], corners: Sequence[tuple[int, ...]]) -> Step:
    head = " & ".join(["i", *(premise.latex for premise in varying)])
    rows = []
    for i, rule in enumerate(corners, start=1):
        values = [f"{float(p.corners[c]):.6g}" for p, c in zip(varying, rule, strict=True)]
        rows.append(" & ".join([str(i), *values]))
    body = r" \\ ".join([head + r" \\ \hline " + rows[0], *rows[1:]])
    columns = "c|" + "c" * len(varying)
    return Step("Rules and their corners.", rf"\begin{{array}}{{{columns}}}{body}\end{{array}}")


def _vertex(rule: int, stacks: Mapping[str, Floats]) -> Step:
    matrices = []
    for letter, stack in stacks.items():
        if stack.size:
            body = r"\\".join(" & ".join(_decimal(x, 6) for x in row) for row in stack[rule])
            array = rf"\begin{{pmatrix}}{body}\end{{pmatrix}}"
            matrices.append(rf"{letter}_{{{rule + 1}}} = " + array)
    return Step(f"Vertex {rule + 1}.", r",\quad ".join(matrices))


MOST_SHOWN = 4


def domain_steps(domain: Domain | None) -> tuple[Step, ...]:
    """Return the steps of the derivation about a band or a union of cells; none for a box."""
    if domain is None:
        return ()
    count = len(domain.cells)
    cell_texts = [_cell(cell) for cell in domain.cells[:MOST_SHOWN]]
    title = "Domain: the bounds hold there, not on the whole box around it"
    title += f"; {count} cells" if count > 1 else ""
    title += f", the first {MOST_SHOWN} of them are shown." if count > MOST_SHOWN else "."
    return (Step(title, r"\begin{gathered}" + r" \\ ".join(cell_texts) + r"\end{gathered}"),)


def _cell(cell: Cell) -> str:
    formulas = [
        rf"{sp.latex(s)} \in [{float(side.lower):.6g},\ {float(side.upper):.6g}]"
        for s, side in cell.box.items()
    ]
    formulas += [f"{sp.latex(s)} = {sp.latex(expression)}" for s, expression in cell.places.items()]
    return r",\ ".join(formulas)


def assemble(
    plant: Equations,
    factored: Factored,
    premises: Sequence[Premise],
    *,
    steps: Sequence[Step] = (),
    names: Mapping[str, Sequence[str]],
    box: Mapping[str, tuple[Number, Number]],
    sides: Mapping[sp.Symbol, Interval] | None = None,
    form: SymbolicForm | None = None,
    name: str,
    source: str,
) -> TSModel:
    """Return the TSModel with the entries' values at every corner of the premises.

    Parameters
    ----------
    premises : one per symbol of ``factored.premises``, in that order.
    steps : put between the plant and its factored form in the derivation.
    names : states, inputs, outputs, disturbances.
    sides : range of each variable, for the check of exactness at points.
    form : kept in the derivation, which then ends with weights, rules and vertices.

    Raises
    ------
    ModelError : the factored form is not exact, or an entry is not multilinear in the premises.
    """
    exactness = check_exact(factored.pairs(plant), dict(sides or {}))
    corners = [premise.corners for premise in premises]
    products = {
        letter: vertex_product(
            matrix, list(factored.premises), corners, constants=factored.constants, letter=letter
        )
        for letter, matrix in factored.matrices.items()
        if letter == "A" or 0 not in matrix.shape
    }
    derivation = replace(_derivation(plant, factored, premises, steps, exactness), form=form)
    if form is not None:
        further_steps = rule_steps(premises, products, discrete=plant.sample_time is not None)
        derivation = replace(derivation, steps=(*derivation.steps, *further_steps))
    return TSModel(
        products["A"],
        products.get("B"),
        C=products.get("C"),
        D=products.get("D"),
        E=products.get("E"),
        states=names["states"],
        inputs=names["inputs"],
        outputs=names["outputs"],
        disturbances=names["disturbances"],
        premises=premises,
        box=box,
        sample_time=plant.sample_time,
        name=name,
        source=source,
        derivation=derivation,
    )


def _derivation(
    plant: Equations,
    factored: Factored,
    premises: Sequence[Premise],
    between: Sequence[Step],
    exactness: str,
) -> Derivation:
    symbols = {s: sp.Symbol(p.latex) for s, p in zip(factored.premises, premises, strict=True)}
    mark = r"\dot{{{}}}" if plant.sample_time is None else "{}^+"
    left_side = _matrix(sp.Matrix([sp.Symbol(mark.format(sp.latex(s))) for s in plant.states]))
    terms = [
        _matrix(factored.matrices[letter].subs(symbols)) + _matrix(sp.Matrix(vector))
        for letter, vector in (("A", plant.states), ("B", plant.inputs), ("E", plant.disturbances))
        if vector
    ]
    steps = [
        Step("Plant.", left_side + " = " + _matrix(sp.Matrix(plant.f))),
        *between,
        Step(
            f"Factored form, equal to the plant: {exactness}.",
            left_side + " = " + " + ".join(terms),
        ),
    ]
    if factored.constants:
        values = [rf"{sp.latex(s)} = {_decimal(v)}" for s, v in factored.constants.items()]
        steps.append(Step("Constants, in SI units.", r",\quad ".join(values)))
    expressions = factored.premises.values()
    steps += [_premise_step(p, e) for p, e in zip(premises, expressions, strict=True)]
    sampled = [premise.name for premise in premises if premise.sampled]
    doubt = f"; bounds of {', '.join(sampled)} sampled, which is no proof" if sampled else ""
    return Derivation(tuple(steps), exactness=exactness + doubt)


def _premise_step(premise: Premise, expression: sp.Expr) -> Step:
    unit = "" if premise.unit == "-" else rf"\ \mathrm{{[{premise.unit}]}}"
    bounds = rf"{_decimal(premise.lower)} \le {premise.latex} \le {_decimal(premise.upper)}"
    return Step(
        f"Premise {premise.name}; bounds: {premise.evidence}.",
        rf"{premise.latex} = {sp.latex(expression)}, \qquad {bounds}{unit}",
    )


def _matrix(matrix: sp.Matrix) -> str:
    return str(sp.latex(matrix, mat_delim="", mat_str="pmatrix"))


def _decimal(value: Number, digits: int = 12) -> str:
    text = f"{float(value):.{digits}g}"
    if "e" in text:
        mantissa, exponent = text.split("e")
        return rf"{mantissa} \cdot 10^{{{int(exponent)}}}"
    return text
