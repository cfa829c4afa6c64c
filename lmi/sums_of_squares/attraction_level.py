r"""The largest level of a polynomial function that is shown to lie in the region of attraction.

For x' = f(x) with f(0) = 0, and V with V(0) = 0, both polynomials,

    (x'x)^k (V - c) - lambda(x) V'(x) = m(x)' S m(x)        for all x,
    lambda(x) = l(x)' Lambda l(x),   S >= 0,   Lambda >= 0,
    V(x) = v(x)' W v(x),  W > 0,

and c largest: equalities of coefficients and LMIs in S, Lambda, W and c together.  Then, where
V < c and x is not 0, the first line says lambda V' <= (x'x)^k (V - c) < 0, so lambda > 0 and V'
< 0. W > 0 with all monomials of the degrees 1 to d in v gives V > 0 and bounded levels.  So every
solution from {V < c} stays in it and tends to 0 (Lyapunov, LaSalle).  The condition contains no
product of unknowns, because c is multiplied by a known polynomial.

There is no version for discrete time: V(f(x)) has the degree of V times that of f.

Source: Chesi (2011), Domain of Attraction, sections 3.3 and 4.1 (the level by a squares program);
Parrilo (2000), thesis, section 7.3; Tan and Packard (2008), IEEE Trans. Automatic Control 53, for
the multipliers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from types import MappingProxyType

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from takagi.lmi.answer import Status, Try
from takagi.lmi.argument_checks import number
from takagi.lmi.condition.term import LMI, Condition, Constant, Equality, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.decision.decide import decide, optimise
from takagi.lmi.equalities.exact_solution import ExactSolution, exact_solution
from takagi.lmi.refutation.indefinite import is_definite, is_semidefinite
from takagi.lmi.solver.solve import quick
from takagi.lmi.solver.time_limit import limited
from takagi.lmi.sums_of_squares.polynomial import Exponent, StatePolynomial, identity, monomials
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

SOURCE = "Chesi (2011), Domain of Attraction, sections 3.3 and 4.1; Parrilo (2000), section 7.3"
# The level is lowered by these shares until the rounded Gram matrices are exactly definite.
BACK_OFF = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class AttractionLevel:
    """c with {V < c} inside the region of attraction, and the sums of squares for it.

    Attributes
    ----------
    status : "candidate" when c was found; "infeasible" or "unknown" as of an ``Answer``.
    level : c, recomputed so that ``exact`` holds where ``proved``; None unless a candidate.
    bound : upper bound of c with these degrees, to solver accuracy.
    function, field : V and f.
    multiplier_degree : of lambda.
    proved : whether the identity and every sum of squares hold in exact arithmetic at ``level``.
    condition : what was solved.
    exact : the unknowns as rationals at ``level``; None unless proved.
    diagnosis : why there is none.
    tries : every solver call.
    """

    status: Status
    level: float | None
    bound: float
    function: StatePolynomial
    field: tuple[StatePolynomial, ...]
    multiplier_degree: int
    proved: bool = False
    condition: Condition
    exact: ExactSolution | None = None
    diagnosis: str = ""
    tries: tuple[Try, ...] = ()

    @property
    def found(self) -> bool:
        """Return whether there is a level."""
        return self.status == "candidate"

    def fault(self) -> str:
        """Return why the sums of squares do not prove ``level``; empty if they do.

        Everything is worked out again from V, f and the Gram matrices by expanding polynomials over
        the rationals, without the condition that was solved.
        """
        if self.exact is None or self.level is None:
            return "there are no exact sums of squares"
        n, values = self.function.n, self.exact.values
        k, low, high, inner = _degrees(self.function, self.field, self.multiplier_degree)
        grams = {
            "S": (values["S"][0], monomials(n, range(low, high + 1))),
            "Lambda": (values["Lambda"][0], monomials(n, range(inner + 1))),
            "W": (values["W"][0], monomials(n, range(1, self.function.degree // 2 + 1))),
        }
        shown = {name: _expanded(G, basis, n) for name, (G, basis) in grams.items()}
        level = StatePolynomial(n, {(0,) * n: -Fraction(self.level)})
        left = _radius(n).power(k) * (self.function + level)
        left = left + (shown["Lambda"] * self.function.along(self.field)).times(-1)
        if (left + shown["S"].times(-1)).terms:
            return "the identity of the polynomials does not hold"
        if (self.function + shown["W"].times(-1)).terms:
            return "V is not the polynomial of its Gram matrix"
        for name, test in (("S", is_semidefinite), ("Lambda", is_semidefinite), ("W", is_definite)):
            G = grams[name][0]
            if np.any(G != G.T) or not test(G):
                return f"{name} is not positive {'definite' if name == 'W' else 'semidefinite'}"
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
    ModelError : as ``attraction_level``.

    Source: Chesi (2011), Domain of Attraction, sections 3.3 and 4.1.
    """
    f, V, degree = _asked(field, function, states, multiplier_degree)
    return _condition(f, V, degree)


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
    An ``AttractionLevel``.  ``proved`` says that the identity and the sums of squares hold in exact
    arithmetic, for the numbers in ``level`` and ``exact``; ``fault()`` decides it anew by expanding
    the polynomials.

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
    condition = _condition(f, V.times(1 / size), degree)
    outcome = optimise(condition, slack=1e-6, most=quick())
    values = outcome.values if outcome.status == "candidate" else outcome.feasible
    found = AttractionLevel(
        status="candidate" if values else outcome.status,
        level=None,
        bound=-outcome.least * float(size) if np.isfinite(outcome.least) else np.inf,
        function=V,
        field=f,
        multiplier_degree=degree,
        condition=condition,
        tries=outcome.tries,
    )
    if not values:
        return _none(
            found, outcome.unsettled("take another multiplier degree, or states of like size")
        )
    best = float(values["c"][0, 0, 0])
    if best <= 0:
        return _none(found, "no positive level: V does not fall near 0; take another V")
    return _proved(found, condition, best, size)


def _none(found: AttractionLevel, why: str) -> AttractionLevel:
    status: Status = "unknown" if found.status == "candidate" else found.status
    return replace(found, status=status, diagnosis=why)


def _proved(
    found: AttractionLevel, condition: Condition, best: float, size: Fraction
) -> AttractionLevel:
    """Return a level slightly below the best, at which the rounded Gram matrices are definite."""
    tries = found.tries
    for share in BACK_OFF:
        c = best * (1 - share)
        fixed = _at_level(condition, c)
        inside = decide(fixed, most=quick())
        tries += inside.tries
        if inside.status != "candidate":
            continue
        exact = exact_solution(fixed, inside.values)
        if exact is None or not exact.holds:
            continue
        scaled = {
            name: value * (size if name in ("S", "W") else 1)
            for name, value in exact.values.items()
        }
        solution = ExactSolution(condition=fixed, values=MappingProxyType(scaled))
        done = replace(
            found,
            level=c * float(size),
            exact=solution,
            tries=tries,
        )
        if not done.fault():
            return replace(done, proved=True)
    return replace(
        found,
        level=best * (1 - BACK_OFF[-1]) * float(size),
        tries=tries,
        diagnosis="the sums of squares did not hold in exact arithmetic: take states of like size",
    )


def _at_level(condition: Condition, c: float) -> Condition:
    """Return the condition at a fixed level, S with a margin."""
    C = next(unknown for unknown in condition.unknowns if unknown.name == "c")
    one = np.ones((1, 1, 1))
    level = Term(unknown=C, left=one, right=one, at=(0, 1))
    fixed = Equality(
        name="level",
        shape=(1, 1),
        terms=(level,),
        constants=(Constant(value=-c * one, at=(0, 1), latex=f"-{c:.6g}"),),
    )
    return replace(condition, objective={}, equalities=(*condition.equalities, fixed))


def _condition(f: Sequence[StatePolynomial], V: StatePolynomial, degree: int) -> Condition:
    n = V.n
    k, low, high, inner = _degrees(V, f, degree)
    outer, within = monomials(n, range(low, high + 1)), monomials(n, range(inner + 1))
    own = monomials(n, range(1, V.degree // 2 + 1))
    S = Unknown("S", len(outer), len(outer), symmetric=True)
    Lambda = Unknown("Lambda", len(within), len(within), symmetric=True, latex=r"\Lambda")
    W = Unknown("W", len(own), len(own), symmetric=True)
    c = Unknown("c", 1, 1)
    radius = _radius(n).power(k)
    one = {(0,) * n: Fraction(1)}
    level = identity(
        "level set",
        [
            (S, outer, one),
            (Lambda, within, V.along(f).terms),
            (c, ((0,) * n,), radius.terms),
        ],
        (radius * V).terms,
    )
    function = identity("function", [(W, own, one)], V.terms)
    return Condition(
        name=f"level of a function of degree {V.degree} in the region of attraction",
        unknowns=(S, Lambda, W, c),
        lmis=tuple(_square(unknown) for unknown in (S, Lambda, W)),
        equalities=(level, function),
        objective={"c": -np.ones((1, 1, 1))},
        source=SOURCE,
    )


def _square(G: Unknown) -> LMI:
    one = np.eye(G.rows)[None]
    return LMI(
        name=f"{G.name} positive definite",
        blocks=(G.rows,),
        terms=(Term(unknown=G, left=one, right=one),),
    )


def _degrees(
    V: StatePolynomial, f: Sequence[StatePolynomial], multiplier: int
) -> tuple[int, int, int, int]:
    """Return k, the least and largest degree of the monomials m, and the degree of l.

    k is the least with which (x'x)^k V has the degree of lambda V'.
    """
    moved = V.along(f).degree + multiplier
    k = max(1, -(-(moved - V.degree) // 2))
    return k, 1, (2 * k + V.degree) // 2, multiplier // 2


def _radius(n: int) -> StatePolynomial:
    """Return x'x."""
    return StatePolynomial(
        n, {tuple(2 * int(j == k) for j in range(n)): Fraction(1) for k in range(n)}
    )


def _expanded(G: Floats, basis: Sequence[Exponent], n: int) -> StatePolynomial:
    found: dict[Exponent, Fraction] = {}
    for i, a in enumerate(basis):
        for j, b in enumerate(basis):
            place = tuple(p + q for p, q in zip(a, b, strict=True))
            found[place] = found.get(place, Fraction(0)) + G[i, j]
    return StatePolynomial(n, {a: value for a, value in found.items() if value})


def _asked(
    field: Sequence[object], function: object, states: Sequence[str], degree: int | None
) -> tuple[tuple[StatePolynomial, ...], StatePolynomial, int]:
    n = len(states)
    if isinstance(field, str) or len(field) != n or not n or len(set(states)) != n:
        raise ModelError(
            f"field has {len(field)} entries for the states {list(states)}; one polynomial for "
            "each of different states is needed"
        )
    f = tuple(StatePolynomial.of(entry, states) for entry in field)
    for name, motion in zip(states, f, strict=True):
        if motion.terms.get((0,) * n):
            raise ModelError(
                f"{name}' is {float(motion.terms[(0,) * n]):g} at 0; shift the states so that the "
                "equilibrium is 0"
            )
    V = _function(function, f, states)
    if V.degree % 2 or V.degree < 2 or V.least_degree < 2:
        raise ModelError(
            f"V has terms of degree {V.least_degree} to {V.degree}; an even degree is needed, and "
            "no term below degree 2"
        )
    most = max(p.degree for p in f)
    if degree is None:
        degree = max(0, most - 1 + (most - 1) % 2)
    number("multiplier_degree", degree, at_least=0)
    if degree % 2:
        raise ModelError(f"multiplier_degree is {degree}; an even number is needed")
    return f, V, int(degree)


def _function(
    given: object, f: Sequence[StatePolynomial], states: Sequence[str]
) -> StatePolynomial:
    n = len(states)
    if given is None:
        units = [tuple(int(j == k) for j in range(n)) for k in range(n)]
        A = np.array([[float(p.terms.get(unit, 0)) for unit in units] for p in f])
        if np.linalg.eigvals(A).real.max() >= 0:
            raise ModelError(
                "the linearisation at 0 is not stable, so it has no quadratic function; give V"
            )
        P = solve_continuous_lyapunov(A.T, -np.eye(n))
        short = [[f"{value:.6g}" for value in row] for row in (P + P.T) / 2]
        return StatePolynomial.quadratic(np.array(short))
    if isinstance(given, (list, tuple, np.ndarray)):
        if np.shape(given) != (n, n):
            raise ModelError(f"V is a matrix of shape {np.shape(given)}; ({n}, {n}) is needed")
        return StatePolynomial.quadratic(given)
    return StatePolynomial.of(given, states)
