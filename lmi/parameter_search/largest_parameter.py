r"""The largest or smallest value of a parameter at which a condition can be satisfied.

The condition is given as pencils (F_k, G_k) in the parameter theta, with G_k(x) >= 0 for every
feasible x.  The search for theta is then a generalised eigenvalue problem.  Each step keeps theta
and solves for

    the largest t with F_k(x, theta) >= t tau (G_k(x_last) + a small multiple of I).

Then it moves theta to the largest value that the new x allows, which follows from eigenvalues.
Since G_k(x) is close to G_k(x_last), theta grows by about tau t, and the steps converge
superlinearly; bisection would converge linearly.  All steps share one set of cone data and one
solver.  If the condition has several unknown matrices, G at the next x may differ much from G at
the last one, and the steps become short.  After a few steps the search therefore changes to leaps:
the leap doubles while the condition is feasible, and the remaining interval is halved afterwards.

Source: Boyd and El Ghaoui (1993), Linear Algebra and its Applications 188-189, for the problem;
Crouzeix, Ferland and Schaible (1985), JOTA 47, for the steps (here with matrices for fractions).

The values of a parameter that the multipliers of a homogeneous condition exclude.

Let X > 0 be the only unknown, symmetric, and let the LMIs sign F_k(X, theta) > 0 have no constant
terms.  For multipliers Z_k >= 0,

    sum_k <sign F_k(X, theta), Z_k> = <S0 + theta S1, X>.

If S0 + theta S1 <= 0, no X satisfies the condition: the LMIs make the sum positive, but X > 0 makes
the right-hand side at most zero.  If -S1 >= 0, this holds for all theta from the largest eigenvalue
of the pencil (S0, -S1) on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from takagi.lmi.answer import Try
from takagi.lmi.argument_checks import number
from takagi.lmi.condition.evaluate import margin
from takagi.lmi.condition.term import LMI, Condition, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import decide, first_weighed
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.parameter_search.parameter_pencil import WORST, ParameterPencil, Values
from takagi.lmi.solver.solve import Session
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError

# A direction without multipliers gives no bound.  Its eigenvalue is raised to this share of the
# largest one, so that the division stays finite.
SMALLEST_EIGENVALUE = 1e-13


def excluded_from(
    condition: Condition, name: str, multipliers: Mapping[str, Floats], *, largest: bool
) -> float:
    """Return the value of the parameter beyond which no unknown satisfies the condition.

    All larger values (smaller ones if ``largest`` is False) are excluded, to the accuracy with
    which the multipliers are semidefinite.  The result is inf (-inf) if the multipliers exclude no
    value, or if this argument does not apply.
    """
    d = 1.0 if largest else -1.0
    never = d * np.inf
    if len(condition.unknowns) != 1 or not multipliers:
        return never
    X = condition.unknowns[0]
    if X.count != 1 or not X.symmetric:
        return never
    S0, S1 = np.zeros((X.rows, X.rows)), np.zeros((X.rows, X.rows))
    positive = False
    for lmi in condition.lmis:
        if not lmi.strict:
            continue
        if lmi.constants:
            return never
        positive = positive or _says_positive(lmi, X)
        plain, slope = adjoint(condition, lmi, name, multipliers[lmi.name])
        if (
            not slope.any()
            and np.linalg.eigvalsh(plain)[0] >= -SMALLEST_EIGENVALUE * np.abs(plain).max()
        ):
            # Such an LMI, X > 0 for example, restricts X but excludes no theta.
            continue
        S0, S1 = S0 + plain, S1 + slope
    growths, vectors = np.linalg.eigh(-d * S1)
    if not positive or growths[-1] <= 0 or growths[0] < -1e-9 * growths[-1]:
        return never
    root = vectors / np.sqrt(np.maximum(growths, SMALLEST_EIGENVALUE * growths[-1]))
    return d * float(np.linalg.eigvalsh(root.T @ S0 @ root)[-1])


def _says_positive(lmi: LMI, X: Unknown) -> bool:
    """Return whether the LMI is L' X L > 0 with L regular, from which X > 0 follows."""
    if len(lmi.terms) != 1 or lmi.sign != 1 or lmi.size != X.rows:
        return False
    term = lmi.terms[0]
    if term.right is None:
        # A scalar unknown.
        return term.parameter is None and bool((term.left[0] > 0).all())
    if term.parameter is not None or term.items is not None:
        return False
    L, R = term.left[0].astype(np.float64), term.right[0].astype(np.float64)
    square = L.shape == (X.rows, X.rows) and np.array_equal(L.T, R)
    return square and int(np.linalg.matrix_rank(L)) == X.rows


def adjoint(condition: Condition, lmi: LMI, name: str, Z: Floats) -> tuple[Floats, Floats]:
    """Return (S0, S1): sum_k <sign F_k(X, theta), Z_k> = <S0 + theta S1, X>, theta being ``name``.

    ``Z`` : (count, size, size), one symmetric multiplier an item.
    """
    X = lmi.terms[0].unknown
    sums = [np.zeros((X.rows, X.cols)), np.zeros((X.rows, X.cols))]
    for term in lmi.terms:
        factor = 1.0
        if term.parameter not in (None, name):
            factor = condition.parameters[term.parameter]
        share = lmi.sign * factor * _adjoint(term, lmi, Z)
        sums[int(term.parameter == name)] += share
    return (sums[0] + sums[0].T) / 2, (sums[1] + sums[1].T) / 2


def _adjoint(term: Term, lmi: LMI, Z: Floats) -> Floats:
    """Return sum_t L_t' Z R_t', twice where a mirror image or a transpose is implied."""
    item, _, left, right = term.spread(lmi.count)
    rows, columns = lmi.spans(term.at)
    block = Z[item][:, rows, columns]
    if right is None:
        total = np.array([[np.sum(left * block)]])
    else:
        total = (left.transpose(0, 2, 1) @ block @ right.transpose(0, 2, 1)).sum(axis=0)
    return 2.0 * total if rows != columns or term.plus_transpose else total


STEPS = 60
# The number of steps before leaps; and the largest distance between value and bound, in tolerances,
# at which the search counts as converged.
PATIENCE, CLOSE = 5, 100.0
# The number of solvers that a leap may try if the first one gives no answer.
FEW_SOLVERS = 4
# Distances beyond the value, in tolerances, at which the search looks for feasible unknowns.  It
# stops at the first distance where none exist.
STEPS_BEYOND = (1.0, 10.0, 100.0, 1e3, 1e4)
# If the bound on t is below this, the condition counts as infeasible there: a smaller bound is
# within the solver's tolerances.
NOTHING = 1e-5
# The bound on theta assumes that G at other unknowns is at least G at the best ones over this.
LESS = 2.0
# Reciprocal condition numbers below which no conclusion is drawn: from t about G, and from one
# infeasible value about all larger ones.
DEFINITE, REGULAR = 1e-4, 1e-4


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Extreme(ShortRepr):
    """The best value of a parameter that was found.

    Attributes
    ----------
    value : the value that the unknowns in ``best`` allow, recomputed from them; inf (-inf) if the
        parameter is not limited; nan without a candidate.
    bound : no value beyond it is feasible, to solver accuracy.  Multipliers show this; or, if the
        best unknowns are well conditioned, the bound on t (for unknowns with at least half of their
        G) or an infeasible condition shows it.  Otherwise inf (-inf).  A margin that the solver
        cannot distinguish from zero counts as none.  With several unknowns the bound may therefore
        be too small by about 1e-5 of its value, and by 1e-3 if they are ill conditioned.
    best : the unknowns that allow the value.
    outcome : unknowns with the largest margin at a value one tolerance before ``value``, in scalar
        weights; if there are none, the reason.
    condition : the condition at that value, to which ``outcome`` belongs.
    converged : True if the search found nothing feasible beyond the value, or a bound within a
        hundred tolerances of it.  False if the steps ran out or no solver gave an answer beyond the
        value; the true value may then lie anywhere up to the bound.
    """

    value: float
    bound: float
    best: Values
    outcome: Outcome
    condition: Condition
    converged: bool = False

    @property
    def found(self) -> bool:
        """Return whether there is a value."""
        return self.outcome.status == "candidate"


def extreme_parameter(
    condition: Condition,
    name: str,
    *,
    largest: bool = True,
    start: Values | None = None,
    tolerance: float = 1e-6,
    step: Callable[[float], float] | None = None,
    limit: float | None = None,
    steps: int = STEPS,
    worst: float = WORST,
    centre: bool = True,
) -> Extreme:
    """Return the largest (smallest) value of a parameter at which the condition is feasible.

    Parameters
    ----------
    condition : in which what the parameter multiplies makes the LMIs harder as it rises (falls),
        on all that is feasible: unknowns stay feasible at every smaller (larger) value.  Not
        checked.
    name : the parameter; its value in the condition is where the search begins.
    start : unknowns to begin with, feasible at some value; None decides at the condition's own.
    tolerance : relative to the distance from the condition's own value, or to a thousandth of the
        natural size of the parameter when that is larger.
    step : value -> difference that does not matter; in the place of ``tolerance``.
    limit : stop when the value has passed it.
    steps : stop after this many.
    worst : reciprocal condition of the unknowns, as far as an LMI bounds it, below which they
        are not used: near a value that is approached but not attained they degenerate.
    centre : return the unknowns of largest margin slightly before the value; without, those
        that allow it, with no margin left.

    Raises
    ------
    ModelError : no such parameter in the condition, a tolerance that is not positive, or unknowns
        to start from that are feasible at no value.

    Not promised: a finite ``bound``; and a value that is approached only as the unknowns
    degenerate is approached as far as ``worst`` lets them.
    """
    pencil = ParameterPencil.of(condition, name, largest=largest, worst=worst)
    tolerance = float(number("tolerance", tolerance, at_least=1e-12))
    origin, tries = condition.parameters[name], list[Try]()
    if start is None:
        first = decide(condition)
        if first.status != "candidate":
            return Extreme(np.nan, np.nan, {}, first, condition)
        start, tries = first.values, list(first.tries)
    value = pencil.allowed(start, origin)
    if np.isnan(value):
        raise ModelError(
            f"condition {condition.name}: the unknowns to start from are feasible at no value of "
            f"{name}; leave start out, or give some that are"
        )
    pencil_size = pencil.size(start, origin) or 1.0

    def near_enough(at: float) -> float:
        return tolerance * max(abs(at - origin), 1e-3 * pencil_size)

    step_size = step or near_enough
    # The size of the sum at this value, not of its terms, which may cancel there.
    tau = max(pencil.size(start, value), 1e-4 * pencil_size) if np.isfinite(value) else pencil_size
    ascent = _Ascent(pencil, tau, step_size, limit, tries)
    value, best, bound, converged = ascent.run(value, start, steps)
    if centre and np.isfinite(value):
        extreme = _centred(pencil, value, bound, best, step_size(value), tries)
        return replace(extreme, converged=converged)
    at = pencil.at(value) if np.isfinite(value) else condition
    plain = Outcome("candidate", best, 0.0, np.inf, {}, tuple(tries))
    return Extreme(value, bound, best, plain, at, converged)


def _centred(
    pencil: ParameterPencil,
    value: float,
    bound: float,
    best: Values,
    step_size: float,
    tries: list[Try],
) -> Extreme:
    """Return the result with the unknowns of largest margin, if they allow as much."""
    aim = value - pencil.d * step_size
    condition = pencil.at(aim)
    centred = decide(condition, assembled=replace(pencil.data, condition=condition))
    allowed = pencil.allowed(centred.values, aim) if centred.status == "candidate" else np.nan
    if not pencil.d * (allowed - aim) >= 0:
        checked_margin = margin(condition, best)
        centred = replace(
            centred, status="candidate", values=best, margin=checked_margin, bound=np.inf
        )
    outcome = replace(centred, tries=(*tries, *centred.tries))
    return Extreme(value, bound, best, outcome, condition)


@dataclass(frozen=True, slots=True, eq=False)
class _Ascent:
    """One search, with the solver kept between the steps; ``tries`` grows.

    A score is d times the parameter, so that larger is better.
    """

    pencil: ParameterPencil
    tau: float
    near_enough: Callable[[float], float]
    limit: float | None
    tries: list[Try]
    session: Session = field(default_factory=Session)

    def run(self, value: float, best: Values, steps: int) -> tuple[float, Values, float, bool]:
        """Return the value, its unknowns, the bound, and whether the search came to its end."""
        d = self.pencil.d
        # Where a step gained nothing the value is the largest as far as is known, and a look is
        # taken beyond it.
        score, bound, finished, at_largest = d * value, np.inf, False, False
        for _ in range(min(steps, PATIENCE)):
            if self.passed(score):
                return d * score, best, d * np.inf, True
            step_size = self.near_enough(d * score)
            attempt = self.beyond if at_largest else self.at
            new_score, new_values, no = attempt(score, best, step_size)
            bound, gained = min(bound, no), new_score - score
            if gained > 0:
                score, best = new_score, new_values
            finished = bound - score <= step_size or (at_largest and not gained > 0)
            if finished:
                break
            at_largest = not at_largest and not gained > step_size
        if not finished and steps > PATIENCE:
            reach = max(score - d * value, step_size)
            score, best, bound = self.leap(score, best, reach, steps - PATIENCE)
        at_largest = bound - score <= CLOSE * self.near_enough(d * score)
        at_end = finished or at_largest or self.passed(score)
        return d * score, best, d * max(bound, score), at_end

    def passed(self, score: float) -> bool:
        return score == np.inf or (self.limit is not None and score >= self.pencil.d * self.limit)

    def leap(
        self, score: float, best: Values, reach: float, steps: int
    ) -> tuple[float, Values, float]:
        """Return the score, its unknowns, and a score that was found infeasible; or inf."""
        high = bound = np.inf
        for _ in range(steps):
            if self.passed(score) or high - score <= self.near_enough(self.pencil.d * score):
                break
            at = score + reach if high == np.inf else (score + high) / 2
            new_score, new_values, no = self.decide(at, best, most=FEW_SOLVERS)
            if new_score > score:
                score, best, reach = new_score, new_values, 2.0 * reach
            if new_score < at:
                high, bound = at, min(bound, no)
        return score, best, bound if bound > score else np.inf

    def at(self, score: float, best: Values, step_size: float) -> tuple[float, Values, float]:
        """Search for unknowns that allow a larger value than the best ones so far."""
        return self.solve(score, best)

    def beyond(self, score: float, best: Values, step_size: float) -> tuple[float, Values, float]:
        """Look just beyond the value: either nothing is there, or better unknowns."""
        attempt = self.solve if self.bounded(best) else self.decide
        for multiple in STEPS_BEYOND:
            new_score, new_values, no = attempt(score + multiple * step_size, best)
            if new_score > score or no <= score + 2 * multiple * step_size:
                return new_score, new_values, no
        return -np.inf, best, np.inf

    def decide(self, score: float, best: Values, most: int = 1) -> tuple[float, Values, float]:
        """Return the same of the condition itself, where t tells nothing of other unknowns' G."""
        pencil, d = self.pencil, self.pencil.d
        condition = pencil.at(d * score)
        outcome = decide(condition, assembled=replace(pencil.data, condition=condition), most=most)
        self.tries.extend(outcome.tries)
        settled = outcome.status == "infeasible" and pencil.conditioning(best) > REGULAR
        return self.shown(outcome, score), outcome.values or best, score if settled else np.inf

    def solve(self, score: float, best: Values) -> tuple[float, Values, float]:
        """Return what the unknowns of the largest t allow, them, and the bound that t sets."""
        pencil, d = self.pencil, self.pencil.d
        data = pencil.weighed(best, self.tau, d * score)
        outcome = first_weighed(data, self.session)
        self.tries.extend(outcome.tries)
        bound = d * excluded_from(data.condition, pencil.name, outcome.multipliers, largest=d > 0)
        if outcome.bound < NOTHING and self.bounded(best):
            bound = min(bound, score + LESS * max(outcome.bound, 0.0) * self.tau)
        return self.shown(outcome, score), outcome.values or best, bound

    def bounded(self, best: Values) -> bool:
        """Return whether t bounds what the parameter can gain, for G that is not much smaller."""
        return len(self.pencil.condition.unknowns) == 1 and (
            self.pencil.definiteness(best) > DEFINITE
        )

    def shown(self, outcome: Outcome, score: float) -> float:
        """Return the score that the outcome's unknowns allow; -inf where none exists."""
        if not outcome.values:
            return -np.inf
        score_allowed = self.pencil.d * self.pencil.allowed(outcome.values, self.pencil.d * score)
        return -np.inf if np.isnan(score_allowed) else score_allowed
