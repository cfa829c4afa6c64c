"""Premises with proved ranges; with given ones, contradicted or confirmed; sampled; and counted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Literal, TypeAlias

import sympy as sp

from takagi.models.equations.equations import Factored, unit_of
from takagi.models.equations.problem import Problem
from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import NoBound
from takagi.models.intervals.interval import Interval, Number
from takagi.models.ranges.expression_range import (
    RangeProof,
    SampledBounds,
    expression_range,
    expression_value,
    sampled_bounds,
)
from takagi.models.ranges.float_value import float_value
from takagi.models.ranges.tape import UnknownFunction
from takagi.models.ts.premise import Premise, round_outward

ROUGH = Fraction(1, 50)  # allowed excess of bounds that are only used to rank premises
MOST_TOLD = 8  # the most premises that a message names


@dataclass(frozen=True, slots=True, eq=False)
class RuleCount:
    """The rules that premises make: 2^k for the k that are not constant.

    Attributes
    ----------
    rules : number of vertices.
    premises : those that vary, sorted by width over size: the one with the least effect comes
        first.
    constant : those that cost no rule.
    """

    rules: int
    premises: tuple[Premise, ...]
    constant: tuple[Premise, ...]

    @property
    def words(self) -> str:
        """The first premises in that order: range, and width as a share of its size."""
        premise_texts = [
            f"{_named(p)} in {p.bounds}, width {100 * _relative(p):.3g} % of its size"
            for p in self.premises[:MOST_TOLD]
        ]
        further = len(self.premises) - len(premise_texts)
        return "; ".join(premise_texts) + (f"; and {further} more" if further else "")


def counted(premises: Sequence[Premise]) -> RuleCount:
    """Return the count of premises that are bounded already."""
    varying = [premise for premise in premises if len(premise.corners) > 1]
    constant = tuple(premise for premise in premises if len(premise.corners) == 1)
    return RuleCount(1 << len(varying), tuple(sorted(varying, key=_relative)), constant)


def _relative(premise: Premise) -> float:
    return float(premise.bounds.width / premise.bounds.magnitude)


def _named(premise: Premise) -> str:
    """Return e.g. ``z1 = sin(x)/x``: a number alone says nothing before there is a model."""
    return premise.name if premise.proof is None else f"{premise.name} = {premise.proof.expression}"


StatedBounds: TypeAlias = "tuple[Number, Number] | SampledBounds"

FINER = (Fraction(1, 10**6), Fraction(1, 10**9))  # tolerances at which given bounds are tried
SAMPLES = 10_000
MARGIN = Fraction(1, 100)


@dataclass(frozen=True, slots=True, eq=False)
class BoundsRequest:
    """The request for bounds: given ones, premises to sample, and the allowed excess."""

    given: Mapping[sp.Symbol, StatedBounds]
    sampled: frozenset[sp.Symbol]
    tolerance: Fraction


@dataclass(frozen=True, slots=True, eq=False)
class _Bounded:
    """Bounds, why they hold in words, and the proof if there is one."""

    bounds: Interval
    evidence: str
    proof: RangeProof | None = None
    sampled: bool = False


def counted_premises(
    problem: Problem, factored: Factored, request: BoundsRequest, most_rules: int
) -> list[Premise]:
    """Return the premises of a model of at most ``most_rules`` rules.

    Raises
    ------
    ModelError : more rules, with the premises ranked by what they cost; or as
        ``bounded_premises``.
    """
    if 2 ** len(factored.premises) > most_rules:
        # Rough bounds tell which premises are constant and rank the others.
        rough = BoundsRequest(request.given, request.sampled, max(request.tolerance, ROUGH))
        check_rule_count(bounded_premises(problem, factored, rough), most_rules)
    members = bounded_premises(problem, factored, request)
    check_rule_count(members, most_rules)
    return members


def bounded_premises(problem: Problem, factored: Factored, request: BoundsRequest) -> list[Premise]:
    """Return every premise with its bounds.

    Raises
    ------
    ModelError : bounds of a premise that does not exist, a premise that cannot be bounded, or given
        bounds that an attained value contradicts.
    """
    for kind, symbols in (("bounds", request.given), ("sampled bounds", request.sampled)):
        unknown = sorted(str(symbol) for symbol in symbols if symbol not in factored.premises)
        if unknown:
            names = ", ".join(map(str, factored.premises)) or "none"
            raise ModelError(f"{kind} of {', '.join(unknown)} were given; the premises are {names}")
    twice = sorted(str(symbol) for symbol in request.given if symbol in request.sampled)
    if twice:
        raise ModelError(f"bounds of {', '.join(twice)} are given and to be sampled; choose one")
    return [
        bounded_premise(
            symbol,
            expression,
            problem,
            "sampled" if symbol in request.sampled else request.given.get(symbol),
            request.tolerance,
        )
        for symbol, expression in factored.premises.items()
    ]


def bounded_premise(
    symbol: sp.Symbol,
    expression: sp.Expr,
    problem: Problem,
    stated: StatedBounds | Literal["sampled"] | None,
    tolerance: Fraction,
) -> Premise:
    """Return the premise with proved bounds, with given ones, or with those of its samples.

    Raises
    ------
    ModelError : it cannot be bounded, or an attained value contradicts the given bounds.
    """
    evaluate = _evaluation(expression.xreplace(problem.middles))
    if stated == "sampled":
        drawn = sampled_bounds(expression, problem.where, points=SAMPLES, margin=MARGIN)
        bounded = _Bounded(round_outward(drawn.bounds), drawn.evidence, sampled=True)
    elif isinstance(stated, SampledBounds):
        bounded = _Bounded(round_outward(stated.bounds), stated.evidence, sampled=True)
    elif stated is None:
        bounded = _proved(symbol, expression, problem, tolerance)
    else:
        bounded = _given(symbol, expression, problem, Interval.of(*stated), tolerance)
    units = problem.equations.units
    return Premise(
        symbol.name,
        bounded.bounds.lower,
        bounded.bounds.upper,
        unit=units[symbol] if symbol in units else unit_of(expression, units),
        latex=sp.latex(symbol),
        evidence=bounded.evidence + _over(expression, problem),
        evaluate=evaluate,
        proof=bounded.proof,
        sampled=bounded.sampled,
        domain=problem.domain,
    )


def _evaluation(expression: sp.Expr) -> Callable[..., float]:
    """Return the function of named values: in floats where they do, else in ball arithmetic.

    A simulation calls it some ten thousand times.
    """
    symbols = {symbol.name: symbol for symbol in expression.free_symbols}
    # Compiled when it is first called: most designs never do.
    compiled = cache(lambda: float_value(expression, tuple(symbols.values())))

    def evaluate(**point: float) -> float:
        in_floats = compiled()
        try:
            values = [float(point[name]) for name in symbols]
        except KeyError:
            in_floats = None  # The exact function names what is missing.
        if in_floats is not None:
            value = in_floats(values)
            if value is not None:
                return value
        return expression_value(expression, {s: point[n] for n, s in symbols.items() if n in point})

    return evaluate


def _proved(
    symbol: sp.Symbol, expression: sp.Expr, problem: Problem, tolerance: Fraction
) -> _Bounded:
    try:
        proved_range = expression_range(expression, problem.where, tolerance=tolerance)
    except NoBound as error:
        raise NoBound(f"premise {symbol} = {expression}: {error}") from error
    try:
        bounds = round_outward(proved_range.outer)
    except OverflowError as error:
        raise NoBound(
            f"premise {symbol} = {expression}: its range on the box is beyond all floats "
            "(1.8e308); shrink the box"
        ) from error
    if _of_balls_alone(expression, problem, bounds):
        # Tight bounds would ask the checker for all digits of a number that is 0.
        bounds = Interval(2 * bounds.lower, 2 * bounds.upper)
    proof = RangeProof(expression, problem.where, tolerance)
    return _Bounded(bounds, f"{proved_range.words}, rounded outward", proof)


def _of_balls_alone(expression: sp.Expr, problem: Problem, bounds: Interval) -> bool:
    """Return whether most of the range about 0 is what is not known of the rest."""
    if not bounds.contains(0) or not expression.free_symbols & set(problem.middles):
        return False
    settled = expression_range(expression.xreplace(problem.middles), problem.where).outer
    return settled.width < bounds.width / 2


def _given(
    symbol: sp.Symbol, expression: sp.Expr, problem: Problem, bounds: Interval, tolerance: Fraction
) -> _Bounded:
    """Return the given bounds, with a proof or with what is missing for it; or refuse them."""
    words, excess = "given by the user", Fraction(0)
    for share in (tolerance, *(finer for finer in FINER if finer < tolerance)):
        try:
            proved_range = expression_range(expression, problem.where, tolerance=share)
        except (UnknownFunction, NoBound):
            return _supported(symbol, expression, problem, bounds)
        if not bounds.contains(proved_range.inner):
            raise _contradicted(
                symbol, expression, bounds, f"values that it attains, {proved_range.inner}"
            )
        if bounds.contains(proved_range.outer):
            proof = RangeProof(expression, problem.where, share)
            return _Bounded(bounds, f"{words}, confirmed by {proved_range.words}", proof)
        excess = max(
            bounds.lower - proved_range.outer.lower, proved_range.outer.upper - bounds.upper
        )
    return _Bounded(
        bounds,
        f"{words}; no value outside was found, and ball arithmetic proves them but for "
        f"{float(excess):.1e} at an end",
    )


def _supported(
    symbol: sp.Symbol, expression: sp.Expr, problem: Problem, bounds: Interval
) -> _Bounded:
    """Return given bounds of a function that cannot be enclosed: samples may contradict them."""
    drawn = sampled_bounds(expression, problem.where, points=SAMPLES)
    if not bounds.contains(drawn.bounds):
        raise _contradicted(symbol, expression, bounds, f"sampled values, {drawn.bounds}")
    words = "given by the user for a function that cannot be enclosed; its values, "
    return _Bounded(bounds, f"{words}{drawn.evidence}, lie inside", sampled=True)


def _contradicted(
    symbol: sp.Symbol, expression: sp.Expr, bounds: Interval, left_out: str
) -> ModelError:
    return ModelError(
        f"premise {symbol} = {expression}: the given bounds {bounds} leave out {left_out}; widen "
        "them, or shrink the box"
    )


def _over(expression: sp.Expr, problem: Problem) -> str:
    """Return the variables that vary, with units: `` over q [rad], p [rad/s]``."""
    varying = sorted(expression.free_symbols - set(problem.middles), key=str)
    if not varying:
        return ""
    shape = "" if problem.domain is None else ", not on the whole box"
    return f", over {', '.join(problem.equations.named(varying))}{shape}"


def check_rule_count(premises: Sequence[Premise], most_rules: int) -> None:
    """Raise ModelError at more than ``most_rules`` rules, the premises ranked by what they cost."""
    count = counted(premises)
    if count.rules > most_rules:
        raise ModelError(
            f"{len(count.premises)} premises make {count.rules} rules, more than most_rules = "
            f"{most_rules}; each premise doubles them, and a narrow one is the cheapest to do "
            f"without (as an uncertainty, or by a smaller box): {count.words}"
        )
