"""Choosing among exact factored forms: fewest rules, or the smallest hull of vertices."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice, product
from math import prod

import numpy as np
import sympy as sp

from takagi.models.arrays import Floats
from takagi.models.equations.equations import BoundedNumber, Equations, Factored
from takagi.models.equations.problem import Problem
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.plant.design_settings import CHOICES, Choice
from takagi.models.ranges.expression_range import expression_range, moved_into
from takagi.models.ranges.float_value import float_function
from takagi.models.sector.common_denominator import denominator_forms, sum_quotients
from takagi.models.sector.factored_form import (
    EntryIndex,
    FactoredForm,
    forms_of,
    subtract,
    with_numbers_apart,
)
from takagi.models.sector.terms import Option, RowTerm, Sum, row_terms, terms_of
from takagi.models.ts.premise import round_outward


def with_quotients(
    rows: Sequence[sp.Expr], premises: Mapping[sp.Symbol, sp.Expr], states: Sequence[sp.Symbol]
) -> tuple[tuple[sp.Expr, ...], dict[sp.Symbol, sp.Expr]]:
    """Return the rows with N = z D for each wanted z = N/D, and the z that were used.

    sin(x + 2 y) becomes z x + 2 z y, whose terms go to x and y. A search term by term would not
    find this quotient, because sin(x + 2 y) does not vanish for x = 0 alone or y = 0 alone.  Done
    where D is a linear sum of two or more states and N appears in a row.
    """
    used_premises = {}
    written = tuple(rows)
    for symbol, premise in premises.items():
        numerator, denominator = premise.as_numer_denom()
        number, core = numerator.as_coeff_Mul()
        divisor = sp.expand(denominator / number)
        if not (divisor.is_Add and divisor.is_polynomial(*states)) or core.is_polynomial(*states):
            continue
        polynomial = sp.Poly(divisor, *states)
        if not polynomial.is_homogeneous or polynomial.total_degree() != 1:
            continue
        replaced = tuple(row.subs(core, symbol * divisor) for row in written)
        if replaced != written:
            written, used_premises[symbol] = replaced, premise
    return written, used_premises


def without_quotients(form: FactoredForm, quotients: Mapping[sp.Symbol, sp.Expr]) -> FactoredForm:
    """Return the form with each z written as its expression again."""
    if not quotients:
        return form
    back = dict(quotients)
    return FactoredForm(
        tuple(premise.xreplace(back) for premise in form.premises),
        {
            position: {
                tuple(member.xreplace(back) for member in members): c
                for members, c in polynomial.items()
            }
            for position, polynomial in form.entries.items()
        },
    )


SAMPLES = 400
DIRECTIONS = 64


class HullWidth:
    """Mean width of the convex hull of a form's vertices, in scaled entries.

    An entry is multiplied by half the range of its variable and divided by the largest |f_i| of
    its row, so that every entry is a share of its row; the mean is over fixed directions, drawn
    uniformly from the sphere of all entries.  A hull inside another one has the smaller width.

    The premises' ranges are SAMPLED here: the width chooses between forms that are all exact, and
    nothing is proved with it.
    """

    def __init__(self, problem: Problem) -> None:
        plant, box, chance = problem.equations, problem.sides, np.random.default_rng(20)
        self.columns = columns = _columns(plant)
        rows, shape = _rows(plant), _places(plant)
        self.symbols = list(
            dict.fromkeys([*box, *(s for letters in columns.values() for s in letters)])
        )
        self.half = {
            s: float(box[s].magnitude) if s in box and box[s].magnitude else 1.0
            for s in self.symbols
        }
        self.missing = set(self.symbols) - set(box)
        sides = [box.get(s, Interval.of(-1, 1)) for s in self.symbols]
        low = np.array([float(side.lower) for side in sides])
        high = np.array([float(side.upper) for side in sides])
        shares = chance.random((SAMPLES, len(sides)))
        # Half of the coordinates are at their ends, because extremes are there more often than
        # inside.
        shares[SAMPLES // 2 :] = np.round(shares[SAMPLES // 2 :])
        self.points = low + (high - low) * shares
        if problem.domain is not None:
            self.points = moved_into(problem.domain, self.symbols, self.points, chance)
        self.ranges: dict[sp.Expr, tuple[float, float] | None] = {}
        self.scale = {
            letter: [max(map(abs, self._range(row) or (1.0,))) or 1.0 for row in some]
            for letter, some in rows.items()
        }
        self.number = {position: index for index, position in enumerate(shape)}
        normals = chance.normal(size=(DIRECTIONS, len(shape)))
        self.directions = normals / np.linalg.norm(normals, axis=1, keepdims=True)

    def __call__(self, form: FactoredForm) -> float:
        """Return the width; infinite where a premise has no finite sampled range."""
        ranges = [self._range(premise) for premise in form.premises]
        if any(r is None for r in ranges):
            return float("inf")
        total: Floats = np.zeros((DIRECTIONS, *(2,) * len(ranges)))
        for position, polynomial in form.entries.items():
            letter, row, column = position
            scale = self.half[self.columns[letter][column]] / self.scale[letter][row]
            value: Floats = np.zeros((2,) * len(ranges))
            for members, coefficient in polynomial.items():
                middle = sum(self._range(coefficient) or (0.0, 0.0)) / 2
                term = np.full((1,) * len(ranges), middle * scale)
                for premise in members:
                    axis = form.premises.index(premise)
                    shape = [1] * len(ranges)
                    shape[axis] = 2
                    term = term * np.array(ranges[axis]).reshape(shape)
                value = value + term
            along = self.directions[:, self.number[position]]
            total += along.reshape(-1, *(1,) * len(ranges)) * value
        flat = total.reshape(DIRECTIONS, -1)
        return float(np.mean(flat.max(axis=1) - flat.min(axis=1)))

    def _range(self, expression: sp.Expr) -> tuple[float, float] | None:
        if expression not in self.ranges:
            self.ranges[expression] = self._sampled(expression)
        return self.ranges[expression]

    def _sampled(self, expression: sp.Expr) -> tuple[float, float] | None:
        if not expression.free_symbols:
            return (float(expression),) * 2
        value = float_function(self.symbols, expression)
        try:
            with np.errstate(all="ignore"):
                values = np.asarray(value(*self.points.T), dtype=np.float64)
        except (TypeError, ValueError, NameError):
            # A function without float evaluation, or a table that does not cover the box.
            return None
        finite = values[np.isfinite(values)]
        return (float(finite.min()), float(finite.max())) if finite.size else None


MOST_ASSIGNMENTS = 64  # the most assignments of terms to states that are compared
MOST_WIDTHS = 24  # the most forms whose hull is measured
MOST_PLAIN = 4  # with more premises, forms that keep denominators whole are compared too
WIDER = 1.05  # how many times as wide a form with numbers as coefficients may be
MOST_PREMISES = 12  # the most premises of a form whose hull is measured: 4096 vertices


def chosen_form(problem: Problem, choice: Choice) -> Factored:
    """Return A, B, C, D, E in premise symbols, f = A x + B u + E w, y = C x + D u.

    Compared are up to 64 ways to give each term to one of the states with which it vanishes, and
    for each the premises of ``forms_of``; where all of these have more than four premises, and
    none is wanted, those of ``denominator_forms`` too.

    ``choice`` : ``"fewest-rules"`` takes the fewest premises, and of those forms the one with the
    smallest hull; ``"least-conservative"`` the smallest hull (``HullWidth``), and of those
    the fewest premises.

    Raises
    ------
    ModelError : an unknown choice, an input that enters nonlinearly, terms that do not vanish at
        the origin, an output that depends on a disturbance, a wanted premise that is not found.

    Not promised: that no other form has fewer rules or a smaller hull.
    """
    if choice not in CHOICES:
        raise ModelError(f"choice {choice!r} was given; {' or '.join(map(repr, CHOICES))} is known")
    plant = problem.equations
    asked_premises = list(problem.premises.values())
    rows, quotients = with_quotients(plant.f, problem.premises, plant.states)
    in_symbols = [s if s in quotients else e for s, e in problem.premises.items()]
    forms = _forms(problem, rows, quotients, lambda entries: forms_of(entries, in_symbols))
    complete = [f for f in forms if set(asked_premises) <= set(f.premises)]
    if not complete:
        missing = [str(s) for s, e in problem.premises.items() if e not in forms[0].premises]
        raise ModelError(
            f"premise {', '.join(missing)} was not found in the factored entries; leave it out, or "
            "write it as it stands in the equations"
        )
    if not asked_premises and min(len(form.premises) for form in complete) > MOST_PLAIN:
        # Forms that keep denominators and quotients such as sin(x + y)/(x + y) whole.
        rows, quotients = with_quotients(
            plant.f, sum_quotients(plant.f, plant.states), plant.states
        )
        complete = [*_forms(problem, rows, quotients, denominator_forms), *complete]
    variables = {*plant.states, *plant.inputs, *plant.disturbances}
    apart = [with_numbers_apart(form, variables, asked_premises) for form in complete]
    apart = [form for form in apart if len(numbers_of(form)) <= MOST_NUMBERS]
    best = _best(complete, problem, choice)
    fewest = min(len(form.premises) for form in complete)
    if any(len(form.premises) < fewest for form in apart):
        # With numbers as coefficients another way to factor can have the fewest premises, and a
        # hull many times as large: its law has a small set.
        width = HullWidth(problem)
        fewer = _best(apart, problem, choice)
        if fewest > MOST_PREMISES or width(fewer) <= WIDER * width(best):
            best = fewer
    return _in_symbols(best, problem)


def _forms(
    problem: Problem,
    rows: tuple[sp.Expr, ...],
    quotients: Mapping[sp.Symbol, sp.Expr],
    forms: Callable[[dict[EntryIndex, Sum]], Iterable[FactoredForm]],
) -> list[FactoredForm]:
    """Return the forms of each assignment of the terms, with the quotients as expressions again."""
    return [
        without_quotients(form, quotients)
        for entries in _assignments(replace(problem.equations, f=rows), problem)
        for form in forms(entries)
    ]


def _best(forms: Sequence[FactoredForm], problem: Problem, choice: Choice) -> FactoredForm:
    by_count = sorted(forms, key=lambda form: len(form.premises))
    few = len(by_count[0].premises)
    if choice == "fewest-rules":
        by_count = [form for form in by_count if len(form.premises) == few]
    compared = _different(by_count)[:MOST_WIDTHS]
    if len(compared) == 1 or few > MOST_PREMISES:
        return compared[0]
    width = HullWidth(problem)
    measured = [form for form in compared if len(form.premises) <= MOST_PREMISES]
    # The width is rounded, so that equal hulls are told apart by their number of premises.
    return min(measured, key=lambda form: (float(f"{width(form):.6g}"), len(form.premises)))


def _different(forms: Sequence[FactoredForm]) -> list[FactoredForm]:
    form_of: dict[object, FactoredForm] = {}
    for form in forms:
        key = (
            frozenset(form.premises),
            frozenset(
                (place, frozenset(polynomial.items())) for place, polynomial in form.entries.items()
            ),
        )
        form_of.setdefault(key, form)
    return list(form_of.values())


def _assignments(plant: Equations, problem: Problem) -> Iterator[dict[EntryIndex, Sum]]:
    """Yield the entries of each way to choose an option for every term, the usual way first."""
    terms = [(("A", "B", "E"), term) for term in row_terms(plant.f, plant, problem.box)] + [
        (("C", "D", ""), term) for term in row_terms(plant.outputs, plant, problem.box)
    ]
    counts = [len(term.options) for _, term in terms]
    if prod(counts) <= MOST_ASSIGNMENTS:
        picks: Iterator[Sequence[int]] = product(*map(range, counts))
    else:
        picks = islice(_preferences(plant, [term for _, term in terms]), MOST_ASSIGNMENTS)
    for pick in picks:
        entries: dict[EntryIndex, Sum] = {}
        for (letters, term), number in zip(terms, pick, strict=True):
            for option in term.options[number]:
                place = _place(letters, term.row, option, plant)
                subtract(entries.setdefault(place, {}), sp.S.NegativeOne, option.coefficient)
        yield entries


def _preferences(plant: Equations, terms: Sequence[RowTerm]) -> Iterator[list[int]]:
    """Yield picks: the usual one, the last of each, and one that prefers each state in turn."""
    yield [0] * len(terms)
    yield [len(term.options) - 1 for term in terms]
    for state in plant.states:
        yield [
            next((k for k, o in enumerate(term.options) if o[0].variable == state), 0)
            for term in terms
        ]


def _place(letters: tuple[str, str, str], row: int, option: Option, plant: Equations) -> EntryIndex:
    for letter, symbols in zip(
        letters, (plant.states, plant.inputs, plant.disturbances), strict=True
    ):
        if option.variable in symbols:
            if not letter:
                raise ModelError(
                    f"output {row + 1} depends on the disturbance {option.variable}; "
                    "y = C x + D u has no such term"
                )
            return letter, row, symbols.index(option.variable)
    raise ModelError(f"{option.variable} is neither a state nor an input nor a disturbance")


def _columns(plant: Equations) -> dict[str, tuple[sp.Symbol, ...]]:
    x, u, w = plant.states, plant.inputs, plant.disturbances
    return {"A": x, "B": u, "C": x, "D": u, "E": w}


def _rows(plant: Equations) -> dict[str, tuple[sp.Expr, ...]]:
    f, y = plant.f, plant.outputs
    return {"A": f, "B": f, "C": y, "D": y, "E": f}


def _places(plant: Equations) -> list[EntryIndex]:
    columns, rows = _columns(plant), _rows(plant)
    return [
        (letter, row, column)
        for letter in columns
        for row in range(len(rows[letter]))
        for column in range(len(columns[letter]))
    ]


def _in_symbols(form: FactoredForm, problem: Problem) -> Factored:
    """Return the form with a symbol for each premise: the user's, or z1, z2, ..."""
    asked_symbols = {e: s for s, e in problem.premises.items()}
    plant = problem.equations
    names_taken = {
        s.name for s in (*asked_symbols.values(), *plant.states, *plant.inputs, *plant.disturbances)
    }
    fresh = (s for s in sp.numbered_symbols("z", start=1, real=True) if s.name not in names_taken)
    names = {e: asked_symbols.get(e) or next(fresh) for e in form.premises}
    rows, columns = _rows(plant), _columns(plant)
    matrices = {letter: sp.zeros(len(rows[letter]), len(columns[letter])) for letter in columns}
    symbols = sp.numbered_symbols("number", start=1, real=True)
    numbers = dict(zip(numbers_of(form), symbols, strict=False))
    for (letter, row, column), polynomial in form.entries.items():
        matrices[letter][row, column] = sp.Add(
            *(
                share * numbers.get(core, core) * sp.Mul(*(names[p] for p in members))
                for members, c in polynomial.items()
                for core, share in terms_of(c).items()
            )
        )
    bounded = {}
    for core, symbol in numbers.items():
        sides = {s: side for s, side in problem.sides.items() if s in core.free_symbols}
        bounds = round_outward(expression_range(core, sides).outer, digits=DIGITS)
        bounded[symbol] = BoundedNumber(core, bounds.lower, bounds.upper)
    constants = {symbol: number.middle for symbol, number in bounded.items()}
    return Factored(matrices, {s: e for e, s in names.items()}, constants, bounded)


DIGITS = 15  # of the bounds of a number
MOST_NUMBERS = 6  # the most that a certificate has


def numbers_of(form: FactoredForm) -> list[sp.Expr]:
    """Return the numbers in its coefficients that are no fractions, each once."""
    coefficients = [c for polynomial in form.entries.values() for c in polynomial.values()]
    cores = dict.fromkeys(core for c in coefficients for core in terms_of(c))
    return [core for core in cores if not core.is_Rational]
