r"""The largest level of a polynomial function that is shown to lie in the region of attraction.

For x' = f(x) with f(0) = 0, and V with V(0) = 0, both polynomials,

    r(x) (V - c) - lambda(x) V'(x) = m(x)' S m(x)        for all x,
    lambda(x) = l(x)' Lambda l(x),   S >= 0,   Lambda >= 0,   c > 0,
    V(x) = v(x)' W v(x),  W > 0,

and c largest: equalities of coefficients and LMIs in S, Lambda, W and c together.  The weight r is
known and never negative (``decrease``): (x'x)^k if the linearisation decays.  Where V < c and r is
not 0, the first line says lambda V' <= r (V - c) < 0, so lambda > 0 and V' < 0; where r is 0, V'
<= 0 because it is continuous.  W > 0 with a power of each state in v gives V > 0 and bounded
levels.  Therefore

    invariance : no solution from {V < c} leaves it;
    attraction : if r > 0 except at 0, or 0 is the only solution that stays where r is 0, every
                 solution from {V < c} also tends to 0 (Lyapunov, LaSalle).

Every level is shown at once if -r - lambda V' = m(x)' S m(x).  The conditions contain no product of
unknowns, because c is multiplied by a known polynomial.

Monomials that S cannot hold are left out of m.  Where exact multipliers Z show that the LMIs can
still only be touched, S Z = 0, and m is reduced to the null space of Z (facial reduction).

There is no version for discrete time: V(f(x)) has the degree of V times that of f.

Source: Chesi (2011), Domain of Attraction, sections 3.3 and 4.1 (the level by a squares program);
Parrilo (2000), thesis, section 7.3; Tan and Packard (2008), IEEE Trans. Automatic Control 53, for
the multipliers; Borwein and Wolkowicz (1981), Permenter and Parrilo (2018), Mathematical
Programming 171, for facial reduction.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from types import MappingProxyType

import numpy as np

from takagi.lmi.answer import Status, Try
from takagi.lmi.condition.statements import lmi_of, pose
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.decision.decide import decide, optimise
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.equalities import ExactSolution, exact_solution, parametrised
from takagi.lmi.refutation.exact_algebra import is_definite, is_semidefinite, over_one_denominator
from takagi.lmi.refutation.refutation import Alternative, exact_no
from takagi.lmi.solver.solve import quick
from takagi.lmi.solver.time_limit import limited
from takagi.lmi.sums_of_squares.polynomial import (
    Decrease,
    StatePolynomial,
    _asked,
    identity,
    monomials,
    without_idle,
)
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError

SOURCE = "Chesi (2011), Domain of Attraction, sections 3.3 and 4.1; Parrilo (2000), section 7.3"
# The level is lowered by these shares until the rounded Gram matrices are exactly definite; by the
# last ones only if no bound of the level is known.
BACK_OFF = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
FURTHER = (0.5, 0.9, 0.99, 0.999, 1 - 1e-4, 1 - 1e-6, 1 - 1e-8)
# A level nearer to its upper bound than this share is called the largest.
LARGEST_GAP = 0.02
# How often the monomials are reduced by multipliers.
FACES = 4

Bases = Mapping[str, tuple[StatePolynomial, ...]]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class AttractionLevel(ShortRepr):
    """c with {V < c} inside the region of attraction, and the sums of squares for it.

    Attributes
    ----------
    status : "candidate" when ``level`` was found; "infeasible" when no c > 0 satisfies the
        condition, by ``ray`` or by ``no`` in exact arithmetic, which does not say that 0 attracts
        nothing; "unknown" otherwise.
    level : c, recomputed so that ``exact`` holds where ``proved``; inf if every solution tends to
        0.  None unless a candidate.  A larger one may exist, unless ``largest``.
    invariant_level : c for which exact arithmetic proves that no solution leaves
        {V < c}, which is bounded, and that V does not rise in it.  If ``level`` is None, it is not
        proved that solutions tend to 0.
    bound : upper bound of c by this condition, to solver accuracy; inf if none is known.
    function, field : V and f.
    multiplier_degree : of lambda.
    proved : whether exact arithmetic proves that every solution from {V < level} tends to 0.
    condition : what was solved.
    orders : axis i of I -> the power L_i in r.
    bases : the polynomials m, l and v by the name of their Gram matrix, in the coordinates of
        ``decrease``.
    exact : the unknowns as rationals at ``invariant_level``; None unless proved.
    ray : a direction d, exact: for all small t > 0, V(t d) <= 0 or V'(t d) > 0.
    no : exact multipliers that exclude every c > 0 with these degrees, for the polynomials that
        the exact reduction leaves.
    diagnosis : why there is no level, or why it is only a lower bound of the largest.
    tries : every solver call.
    """

    status: Status
    level: float | None = None
    invariant_level: float | None = None
    bound: float = np.inf
    function: StatePolynomial
    field: tuple[StatePolynomial, ...]
    multiplier_degree: int
    proved: bool = False
    condition: Condition | None = None
    orders: Mapping[int, int] = dataclasses.field(default_factory=dict)
    bases: Bases = dataclasses.field(default_factory=dict)
    exact: ExactSolution | None = None
    ray: tuple[Fraction, ...] | None = None
    no: Alternative | None = None
    diagnosis: str = ""
    tries: tuple[Try, ...] = ()

    @property
    def found(self) -> bool:
        """Return whether there is a level."""
        return self.status == "candidate"

    @property
    def largest(self) -> bool:
        """Return whether the level is the largest of this condition, to solver accuracy."""
        return self.level is not None and self.level >= (1 - LARGEST_GAP) * self.bound

    def fault(self) -> str:
        """Return why nothing proves ``invariant_level``, and ``level`` if there is one; or "".

        Everything is worked out again from V, f and the Gram matrices by expanding polynomials over
        the rationals, without the condition that was solved.
        """
        c = self.invariant_level
        if self.exact is None or c is None:
            return "there are no exact sums of squares"
        case = replace(Decrease.of(self.field, self.function), orders=dict(self.orders))
        values, n = self.exact.values, self.function.n
        if not self.orders or any(power % 2 or power < 2 for power in self.orders.values()):
            return "r is not a sum of even powers"
        for name, test in (("S", is_semidefinite), ("Lambda", is_semidefinite), ("W", is_definite)):
            G = values[name][0]
            if np.any(G != G.T) or not test(G):
                return f"{name} is not positive {'definite' if name == 'W' else 'semidefinite'}"
        squares = {name: _expanded(values[name][0], basis) for name, basis in self.bases.items()}
        level = case.function + StatePolynomial(n, {(0,) * n: -Fraction(c)}) if c < np.inf else None
        difference = _weight(case, self.multiplier_degree, level is None)
        difference = difference.times(-1) if level is None else difference * level
        if (difference + (squares["Lambda"] * case.slope + squares["S"]).times(-1)).terms:
            return "the identity of the polynomials does not hold"
        if (case.function + squares["W"].times(-1)).terms:
            return "V is not the polynomial of its Gram matrix"
        function_basis = self.bases["W"]
        if any(len(m.terms) != 1 for m in function_basis) or {
            k for m in function_basis for a in m.terms for k in range(n) if a[k] == sum(a) > 0
        } != set(range(n)):
            return "the monomials of V have no power of each state"
        if self.level is not None and self.level > min(c, case.attraction_end()):
            return "it is not shown that solutions tend to 0"
        return ""


def attraction_level_condition(
    field: Sequence[object],
    function: object,
    *,
    states: Sequence[str],
    multiplier_degree: int | None = None,
) -> Condition:
    """Pose the module's identity and LMIs; the objective is -c.

    Parameters
    ----------
    field, function, states, multiplier_degree : as for ``attraction_level``.

    Returns
    -------
    The condition with equalities, and the unknowns ``S``, ``Lambda``, ``W`` and ``c``.  Nothing is
    solved.

    Raises
    ------
    ModelError : as ``attraction_level``; V has no level, which a ray shows.

    Source: Chesi (2011), Domain of Attraction, sections 3.3 and 4.1.
    """
    f, V, degree = _asked(field, function, states, multiplier_degree)
    case = Decrease.of(f, V)
    if why := _without_level(case):
        raise ModelError(why)
    return _condition(case, degree, _bases(case, degree, False), False)


@limited
def attraction_level(
    field: Sequence[object],
    function: object = None,
    *,
    states: Sequence[str],
    multiplier_degree: int | None = None,
    time_limit: float | None = None,
) -> AttractionLevel:
    """Return the largest c for which {V < c} is shown to lie in the region of attraction of 0.

    Parameters
    ----------
    field : f_1, ..., f_n of x' = f(x), f(0) = 0: texts or sympy expressions, polynomials with
        rational coefficients; a decimal in a text is that decimal.
    function : V, a polynomial of even degree without terms below degree 2; (n, n) P for x'Px; None
        for the quadratic function of the linearisation, A'P + P A = -I, to six digits.
    states : names of the variables, in order.
    multiplier_degree : degree of lambda, even; None takes that of f less one, made even.  A larger
        degree never gives a smaller level.
    time_limit : seconds for all solver calls together.

    Returns
    -------
    An ``AttractionLevel``.  ``proved`` says that every solution from {V < level} tends to 0, by an
    identity and sums of squares in exact arithmetic, for the numbers in ``level`` and ``exact``;
    ``fault()`` decides it anew by expanding the polynomials.  ``level`` is inf where this is proved
    for every level.  If only invariance is proved, as for V' = -y^2 where LaSalle's theorem does
    not apply, ``invariant_level`` has the number and ``level`` is None.

    Raises
    ------
    ModelError : no polynomials, f(0) other than 0, V of odd degree or with linear terms, degrees
        that are not even, a linearisation that is not stable where V is left out.

    Source: Chesi (2011), Domain of Attraction, sections 3.3 and 4.1; Tan and Packard (2008).
    """
    f, V, degree = _asked(field, function, states, multiplier_degree)
    # V in units of its largest coefficient, a power of two, which rounds nothing.
    largest = max(abs(c) for c in V.terms.values())
    size = Fraction(float(nearest_power(np.array([float(largest)]))[0]))
    case = Decrease.of(f, V.times(1 / size))
    none = AttractionLevel(status="unknown", function=V, field=f, multiplier_degree=degree)
    if why := _without_level(case):
        status: Status = "unknown" if case.ray is None else "infeasible"
        return replace(none, status=status, ray=case.ray, diagnosis=why)
    result = none
    for every in (False,) if case.seems_to_rise() else (True, False):
        answers = []
        for weighted_case in case.with_other_weights():
            result = replace(none, orders=weighted_case.orders, tries=result.tries)
            answers.append(_sought(result, weighted_case, size, every))
            result = answers[-1]
            if result.invariant_level is not None:
                return result
    order: tuple[Status, ...] = ("candidate", "unknown", "infeasible")
    best = min(answers, key=lambda answer: order.index(answer.status))
    return replace(best, tries=result.tries)


def _sought(
    result: AttractionLevel, case: Decrease, size: Fraction, every: bool
) -> AttractionLevel:
    """Return what is shown of every level, or of the largest, with V in units of ``size``."""
    condition, bases, outcome, no = _solved(case, result.multiplier_degree, every)
    result = replace(result, condition=condition, bases=bases, tries=result.tries + outcome.tries)
    values = outcome.values if outcome.status == "candidate" else outcome.feasible
    if every:
        exact = exact_solution(condition, values) if values else None
        return result if exact is None else _shown(result, case, exact, size, np.inf)
    if values:
        # The bound of multipliers that are far from any solution bounds nothing.
        bound = -outcome.lower_bound * float(size) if outcome.status == "candidate" else np.inf
        return _proved(replace(result, bound=bound), case, values["c"].item(), size)
    if no is None:
        advice = "take another multiplier degree, another V, or states of like size"
        return replace(result, diagnosis=outcome.unsettled(advice))
    excluded = "W > 0 of V" if _title("c") not in no.multipliers else "c > 0 with these degrees"
    why = (
        f"exact multipliers exclude every {excluded}; take another V, or a larger multiplier degree"
    )
    return replace(result, status="infeasible", no=no, diagnosis=why)


def _without_level(case: Decrease) -> str:
    """Return why no level needs to be sought; empty if one does."""
    if case.ray is None:
        return "" if case.orders else "V' is 0 along every axis of the states; take another V"
    reason = "V rises" if case.rises else "V is not positive"
    along = ", ".join(str(entry) for entry in case.ray)
    return f"{reason} from 0 along the ray ({along}), so it has no level; take another V"


def _solved(
    case: Decrease, degree: int, every: bool
) -> tuple[Condition, Bases, Outcome, Alternative | None]:
    """Return the condition with a solution, or exact multipliers if none exists, if found."""
    bases = _bases(case, degree, every)
    for _ in range(FACES):
        condition = _condition(case, degree, bases, every)
        outcome = (
            decide(condition, most=quick())
            if every
            else optimise(condition, slack=1e-6, most=quick())
        )
        if outcome.status == "candidate" or outcome.feasible:
            return condition, bases, outcome, None
        smaller, no = _reduced(condition, outcome.multipliers, bases)
        if smaller is None:
            break
        bases = smaller
    return condition, bases, outcome, no


def _reduced(
    condition: Condition, multipliers: Mapping[str, Floats], bases: Bases
) -> tuple[Bases | None, Alternative | None]:
    """Return fewer polynomials for S and Lambda, or a proof that no solution exists."""
    free = parametrised(condition)
    no = None if free is None else exact_no(free.condition, multipliers)
    if no is None or not no.multipliers:
        return None, None
    # The proof that counts lets S and Lambda be singular.
    touched = tuple(
        replace(lmi, weight=0.0) if lmi.name in (_title("S"), _title("Lambda")) else lmi
        for lmi in no.condition.lmis
    )
    weaker = Alternative(condition=replace(no.condition, lmis=touched), multipliers=no.multipliers)
    if weaker.holds:
        return None, weaker
    smaller = dict(bases)
    for name in ("S", "Lambda"):
        if _title(name) in no.multipliers:
            smaller[name] = _of_null_space(no.multipliers[_title(name)][0], bases[name])
    return (smaller if all(smaller.values()) else None), None


def _of_null_space(Z: Array, basis: tuple[StatePolynomial, ...]) -> tuple[StatePolynomial, ...]:
    """Return the combinations u'm with Z u = 0."""
    import flint

    integers, _ = over_one_denominator(Z)
    vectors, count = flint.fmpz_mat(integers.tolist()).nullspace()
    columns = [[int(vectors[i, j]) for i in range(len(basis))] for j in range(count)]
    zero = StatePolynomial(basis[0].n, {})
    return tuple(
        sum(
            (
                m.times(Fraction(u, max(map(abs, null_vector))))
                for m, u in zip(basis, null_vector, strict=True)
            ),
            zero,
        )
        for null_vector in columns
    )


def _shown(
    result: AttractionLevel, case: Decrease, exact: ExactSolution, size: Fraction, c: float
) -> AttractionLevel:
    """Return what exact numbers prove at a level in units of ``size``; nothing if they do not."""
    units = {"S": size, "W": size} if c < np.inf else {"Lambda": 1 / size, "W": size}
    values = {name: value * units.get(name, 1) for name, value in exact.values.items()}
    solution = ExactSolution(condition=exact.condition, values=MappingProxyType(values))
    shown = replace(result, invariant_level=c * float(size), exact=solution)
    if shown.fault():
        return result
    end = case.attraction_end()
    if end <= 0:
        why = (
            "no solution leaves {V < invariant_level}; that solutions tend to 0 is not shown, "
            "because V' may be 0 away from 0: take another V"
        )
        return replace(shown, diagnosis=why)
    shown = replace(shown, status="candidate", level=shown.invariant_level, proved=True)
    if end < c:
        why = "the level ends where V' is 0 and solutions may stay; {V < invariant_level} is kept"
        level = float(end) * (1 - BACK_OFF[0]) * float(size)
        shown = replace(shown, level=level, bound=float(end * size), diagnosis=why)
    if shown.largest:
        return shown
    why = "a lower bound: neither every level nor an upper bound was proved; raise the degree"
    return replace(shown, diagnosis=f"the level is {why} of the multiplier")


def _proved(
    result: AttractionLevel, case: Decrease, best: float, size: Fraction
) -> AttractionLevel:
    """Return a level slightly below the best, at which the rounded Gram matrices are definite."""
    assert result.condition is not None
    for share in BACK_OFF if result.bound < np.inf else (*BACK_OFF, *FURTHER):
        c = best * (1 - share)
        fixed = _at_level(result.condition, c)
        inside = decide(fixed, most=quick())
        result = replace(result, tries=result.tries + inside.tries)
        exact = exact_solution(fixed, inside.values) if inside.status == "candidate" else None
        if exact is not None:
            shown = _shown(result, case, exact, size, c)
            if shown.invariant_level is not None:
                return shown
    why = "the sums of squares did not hold in exact arithmetic: take states of like size"
    if result.bound < np.inf and case.attraction_end() >= best:
        level = best * (1 - BACK_OFF[-1]) * float(size)
        return replace(result, status="candidate", level=level, diagnosis=why)
    return replace(result, diagnosis=why)


def _at_level(condition: Condition, c: float) -> Condition:
    """Return the condition at a fixed level."""
    C = next(unknown for unknown in condition.unknowns if unknown.name == "c")
    fixed = pose((C == np.array([[c]])).named("level")).equalities
    return replace(condition, objective={}, equalities=(*condition.equalities, *fixed))


def _condition(case: Decrease, degree: int, bases: Bases, every: bool) -> Condition:
    """Return the identity and the LMIs for the largest level, or for every level."""
    V, r = case.function, _weight(case, degree, every)
    S, Lambda, W = (
        Unknown(name, len(bases[name]), len(bases[name]), symmetric=True, latex=latex)
        for name, latex in (("S", "S"), ("Lambda", r"\Lambda"), ("W", "W"))
    )
    c = Unknown("c", 1, 1)
    unit = V.power(0)
    summands = [(S, bases["S"], unit), (Lambda, bases["Lambda"], case.slope)]
    level = (
        identity("every level", summands, r.times(-1))
        if every
        else identity("level set", [*summands, (c, (unit,), r)], r * V)
    )
    unknowns = (S, Lambda, W) if every else (S, Lambda, W, c)
    return Condition(
        name=f"level of a function of degree {V.degree} in the region of attraction",
        unknowns=unknowns,
        lmis=tuple(lmi_of((unknown >> 0).named(_title(unknown.name))) for unknown in unknowns),
        equalities=(level, identity("function", [(W, bases["W"], unit)], V)),
        objective={} if every else {"c": -np.ones((1, 1, 1))},
        source=SOURCE,
    )


def _title(name: str) -> str:
    return f"{name} positive" if name == "c" else f"{name} positive definite"


def _weight(case: Decrease, multiplier: int, every: bool) -> StatePolynomial:
    """Return r, for one level with the least k with which r V has the degree of lambda V'."""
    if every:
        return case.weight(1)
    highest = [max(a[i] for a in case.function.terms if a[i] == sum(a)) for i in case.orders]
    short = case.slope.degree + multiplier - min(highest) - min(case.orders.values())
    return case.weight(1 + max(0, -(-short // 2)))


def _bases(case: Decrease, multiplier: int, every: bool) -> Bases:
    """Return the monomials m, l and v that the sums of squares can hold."""
    V, n = case.function, case.function.n
    r = _weight(case, multiplier, every)
    l = monomials(n, range(multiplier // 2 + 1))  # noqa: E741
    products = {tuple(p + q for p, q in zip(a, b, strict=True)) for a in l for b in l}
    support = set(r.terms) | set(() if every else (r * V).terms)
    support |= {
        tuple(p + q for p, q in zip(a, b, strict=True)) for a in products for b in case.slope.terms
    }
    highest = max(sum(a) for a in support) // 2
    bases = {
        "S": without_idle(monomials(n, range(1, highest + 1)), support),
        "Lambda": l,
        "W": without_idle(monomials(n, range(1, V.degree // 2 + 1)), V.terms),
    }
    return {
        name: tuple(StatePolynomial(n, {a: Fraction(1)}) for a in basis)
        for name, basis in bases.items()
    }


def _expanded(G: Array, basis: Sequence[StatePolynomial]) -> StatePolynomial:
    total = StatePolynomial(basis[0].n, {})
    for i, a in enumerate(basis):
        for j, b in enumerate(basis):
            if G[i, j]:
                total = total + (a * b).times(G[i, j])
    return total
