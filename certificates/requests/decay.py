r"""Requests decay, or poles in a region, by one quadratic function; or evidence that none exists.

Quadratic functions of a single matrix, and a test in floats that rejects hopeless candidates.

Cholesky's factorisation of S + c I in floats breaks down only where S is not positive semidefinite,
for c = (gamma / (1 - gamma)) tr |S| with gamma = (n + 1) u and the unit roundoff u; c is increased
by the possible error of the entries of S.  So a breakdown shows that an exact proof would fail.
Nothing else is concluded: a candidate that passes the test is still decided in exact arithmetic.

Source: Rump (2006), Verification of positive definiteness, BIT Numerical Mathematics 46, theorem
2.3, with the opposite sign of the shift; cited from memory.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.document.model_data import DIGITS, rounded_down, short
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.weight_pieces import Point, points_of, weights_at
from takagi.certificates.requests.request import Attempt, Request, first_proved, require_rate
from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer
    from takagi.lmi.condition.region import EigenvalueRegion

LARGEST = 1e38
# Fractions of the rate found, tried in order until the rounded numbers prove the claim.
BACK_OFF = (0.999, 0.99, 0.9, 0.5, 0.0)


@dataclass(frozen=True, slots=True)
class Decay(Request):
    """V = x'Px decays as exp(-2 alpha t); ``decay_rate`` alpha [1/s], None takes what is found."""

    decay_rate: float | None = None

    def __post_init__(self) -> None:
        require_rate(self.decay_rate)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``decay``; where no P is found, ``no-common-decay`` if it is proved."""
        answer = common_function(loop, self.decay_rate)
        solver = str(answer.solver.get("status", ""))
        rates = rates_to_claim(answer, self.decay_rate)
        kind = {"name": _name(loop), "kind": "decay"}
        functions = [] if answer.P is None else [np.asarray(answer.P)]
        if self.decay_rate is not None:
            functions += _of_one_blend(loop, self.decay_rate)
        # Larger numbers are not written to a certificate.
        functions = [P for P in functions if np.abs(P).max() < LARGEST]
        if not functions or (self.decay_rate is None and (answer.decay_rate or 0.0) <= 0):
            disproof = no_common_decay(loop, self.decay_rate or 0.0, answer)
            if self.decay_rate is None or disproof.checked.verdict is Verdict.DISPROVED:
                return disproof
            fastest = faster_function(loop, self.decay_rate)
            if fastest is None:
                return disproof
            attempt = first_proved(loop, decay_claims(kind, [fastest], rates), solver)
            tried = (*disproof.tried, "P of the fastest rate", *attempt.tried)
            return replace(attempt, tried=tried)
        A = loop.A

        def cannot_hold(claim: Mapping[str, Any]) -> bool:
            P = np.array(claim["P"])
            return cannot_decrease(A, P, claim["decay_rate"], loop.sample_time)

        claims = list(decay_claims(kind, functions, rates))
        attempt = first_proved(loop, claims, solver, cannot_hold=cannot_hold)
        if attempt.proved or answer.P is not None:
            return attempt
        disproof = no_common_decay(loop, self.decay_rate or 0.0, answer)
        return replace(disproof, tried=attempt.tried + disproof.tried)


def common_function(loop: ClaimedLoop, decay_rate: float | None = None) -> Answer:
    """Return the candidate P for a rate, or for the largest rate found; sought once for a loop."""
    A = loop.A
    key = A.tobytes(), decay_rate
    if key not in loop.functions:
        loop.functions[key] = function_along(A, decay_rate, loop.sample_time)
    return loop.functions[key]


def function_along(A: Floats, rate: float | None, step: float | None) -> Answer:
    """Return P that decreases along A (N, n, n) at a rate, or at the largest that is found."""
    from takagi.lmi import common_lyapunov
    from takagi.lmi.analysis.decay_rate import fast_decay

    if rate is None:
        return fast_decay(A, sample_time=step)
    return common_lyapunov(A, decay_rate=rate, sample_time=step)


def rates_to_claim(answer: Answer, rate: float | None) -> list[float]:
    """Return the rate that is asked for; for None, rates below the largest that was found."""
    if rate is not None:
        return [rate]
    # A loop that reaches the equilibrium in one step has an infinite rate.
    largest = min(answer.decay_rate or 0.0, 1e6)
    return [rounded_down(share * largest) for share in BACK_OFF]


def faster_function(loop: ClaimedLoop, rate: float) -> Floats | None:
    """Return the candidate P of the largest rate [1/s] found, if it exceeds ``rate``.

    If gains are far larger than the states they act on, the margin at one rate is lost in rounding,
    and the solver finds no P. The search for the fastest rate still succeeds.
    """
    answer = common_function(loop)
    return None if answer.P is None or not (answer.decay_rate or 0.0) > rate else answer.P


def _of_one_blend(loop: ClaimedLoop, rate: float) -> list[Floats]:
    """Return functions that show the rate of a single matrix up to its slowest eigenvalue."""
    if len(loop.A) > 1:
        return []
    G = loop.A[0]
    functions = (modal_function(G), equation_function(G, rate, loop.sample_time))
    return [P for P in functions if P is not None]


def decay_claims(
    kind: Mapping[str, Any], functions: list[Floats], rates: list[float]
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield (words, claim) of a kind of claim that V = x'Px decays, the fastest rate first."""
    for rate in rates:
        for P in functions:
            for digits in DIGITS:
                claim = {**kind, "decay_rate": rate, "P": short(P, digits).tolist()}
                yield f"decay rate {rate:.9g} 1/s, P to {digits} digits", claim


def _name(loop: ClaimedLoop) -> str:
    return f"common quadratic decay of {loop.model.name or 'the model'}"


@dataclass(frozen=True, slots=True)
class Poles(Request):
    """Eigenvalues of every blend in ``region``, a ``takagi.lmi.EigenvalueRegion``, in 1/s.

    In discrete time they are the eigenvalues of the matrix itself, without a unit: a stable loop
    has them inside the unit circle.  L and M are written as decimals, and the claim is about these.
    """

    region: EigenvalueRegion

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``region``; without a candidate the checker answers UNDECIDED.

        Raises
        ------
        ModelError : no region was given.
        """
        from takagi.lmi import d_stability

        answer = d_stability(loop.A, self.region, sample_time=loop.sample_time)
        solver = str(answer.solver.get("status", ""))
        regions = [
            {"L": np.asarray(L, dtype=float).tolist(), "M": np.asarray(M, dtype=float).tolist()}
            for L, M in (region.matrices for region in self.region.parts)
        ]
        modal = modal_function(loop.A[0]) if len(loop.A) == 1 else None
        functions = [np.asarray(P) for P in (answer.P, modal) if P is not None]
        kind = {"name": f"poles in {self.region}", "kind": "region", "parts": regions}
        claims = [
            (f"{kind['name']}, P to {digits} digits", {**kind, "P": short(P, digits).tolist()})
            for P in functions or [np.eye(loop.A.shape[1])]
            for digits in DIGITS
        ]
        attempt = first_proved(loop, claims, solver)
        if attempt.proved or answer.found:
            return attempt
        return replace(attempt, tried=(answer.diagnosis, *attempt.tried))


def no_common_decay(loop: ClaimedLoop, rate: float, answer: Answer) -> Attempt:
    """Return DISPROVED with evidence that no common P exists at this rate, else UNDECIDED."""
    solver = str(answer.solver.get("status", ""))
    tried = [answer.diagnosis or "no candidate P"]
    for words, evidence in _evidence(loop, rate, answer.coordinates):
        tried.append(words)
        kind = {"name": "no common quadratic function", "kind": "no-common-decay"}
        claim = {**kind, "decay_rate": rate, **evidence}
        checked = loop.replay(claim)
        if checked.verdict is Verdict.DISPROVED:
            return Attempt(claim, checked, tuple(tried), solver)
    identity = np.eye(loop.A.shape[1]).tolist()
    unproved = {"name": _name(loop), "kind": "decay", "decay_rate": rate, "P": identity}
    tried.append("no exact reason against one was found")
    return Attempt(unproved, loop.replay(unproved), tuple(tried), solver)


def _evidence(
    loop: ClaimedLoop, rate: float, coordinates: Floats | None
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield evidence from blends that the loop takes alone: its points, or its rules.

    There is none for a law with its own weights, because its blends are not known.
    """
    if len(loop.exact.K) > 1 and not loop.exact.shared_weights:
        return
    points = loop.points or points_of(loop.exact)
    A = loop.at(points).A
    for k in _slowest(A, rate, loop.sample_time):
        P = equation_function(A[k], rate, loop.sample_time)
        if P is not None and np.abs(P).max() < LARGEST:
            # A loop without premises has one rule, and a point without rows.
            blended = any(max(row) > 1 for row in points[k])
            words = "one blend alone" if blended else "one rule alone"
            yield words, {"blend": _named(loop, points[k]), "P": short(P, 9).tolist()}
    # If the Lyapunov equation does not exclude a single matrix, that matrix decays or is a limiting
    # case. So multipliers are searched for two or more matrices only.
    s = np.ones(A.shape[1]) if coordinates is None else coordinates
    Z = _multipliers(A * s / s[:, None], rate, loop.sample_time) if len(A) > 1 else None
    if Z is not None:
        values, vectors = np.linalg.eigh(Z / np.abs(Z).max())
        factors = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :] * s[:, None]
        # Multipliers that are zero up to rounding are left out, so that the file names few rules.
        blends = [k for k, value in enumerate(values[:, -1]) if value > 1e-9 * values.max()]
        if not blends or not np.abs(factors).max() < LARGEST:
            return
        for digits in (6, 9, 12):
            listed = [
                {"blend": _named(loop, points[k]), "factor": _rounded(factors[k], s, digits)}
                for k in blends
            ]
            yield f"multipliers of {len(blends)} blends, {digits} digits", {"multipliers": listed}


def _named(loop: ClaimedLoop, point: Point) -> int | list[list[int]]:
    """Return a blend as the claim states it: the number of a rule, or shares."""
    h = weights_at(loop.exact, point)
    return h.index(Fraction(1)) if 1 in h else [list(row) for row in point]


def _slowest(A: Floats, rate: float, step: float | None) -> list[int]:
    """Return the blend with the slowest eigenvalue, if that blend alone misses the rate."""
    poles = np.linalg.eigvals(A)
    if step is None:
        excess = poles.real.max(axis=1) + rate
    else:
        excess = np.abs(poles).max(axis=1) - np.exp(-rate * step)
    worst = int(excess.argmax())
    return [worst] if excess[worst] > 0 else []


def _multipliers(A: Floats, rate: float, step: float | None) -> Floats | None:
    """Return Z_k >= 0 in floats; their sum is positive definite on the states that they use.

    If some states act on no others, multipliers of these states alone suffice. There may be no
    others: a further state that decays by itself prevents a definite sum over all states.
    """
    from takagi.lmi.analysis.common_quadratic import impossibility_multipliers

    for states in _closed_sets(A):
        submatrices = A[:, states][:, :, states]
        Z = impossibility_multipliers(submatrices, decay_rate=rate, sample_time=step)
        if Z is not None:
            multipliers = np.zeros_like(A)
            multipliers[np.ix_(range(len(A)), states, states)] = Z
            return multipliers
    return None


def _closed_sets(A: Floats) -> list[list[int]]:
    """Return all states, then the sets of those that one state acts on, directly or not."""
    n = A.shape[1]
    acts = (A != 0).any(axis=0) | np.eye(n, dtype=bool)
    for _ in range(n):
        acts = (acts.astype(int) @ acts.astype(int)) > 0
    columns = {tuple(np.flatnonzero(acts[:, j]).tolist()) for j in range(n)}
    smaller = sorted((set_ for set_ in columns if 1 < len(set_) < n), key=len)
    return [list(range(n)), *map(list, smaller)]


def _rounded(factor: Floats, s: Floats, digits: int) -> list[list[float]]:
    """Return the factor with so many decimals, relative to each state's size."""
    decimals = np.clip(digits - np.round(np.log10(s)), -30, 30).astype(int).tolist()
    return [
        [round(float(entry), count) for entry in row]
        for row, count in zip(factor, decimals, strict=True)
    ]


# A solution with larger numbers is dominated by rounding errors.
LARGEST_SOLUTION = 1e14
FASTEST = 30.0


def modal_function(G: Floats) -> Floats | None:
    """Return P = T^-* T^-1, T the eigenvectors: x'Px is the sum of the squared modes.

    This P proves every region that contains the eigenvalues, up to the region's edge. None if the
    matrix of eigenvectors is nearly singular.
    """
    balanced, s = _balanced(G)
    vectors = np.linalg.eig(balanced)[1]
    if np.linalg.cond(vectors) > np.sqrt(LARGEST_SOLUTION):
        return None
    inverse = np.linalg.inv(vectors)
    return _in_states(np.real(inverse.conj().T @ inverse), s)


def equation_function(G: Floats, rate: float, step: float | None) -> Floats | None:
    """Return P with G'P + PG + 2 alpha P = -Q, or G'PG - rho^2 P = -Q; None where there is none.

    Q = I in balanced states.  P is positive definite exactly when G decays faster than alpha [1/s].
    """
    from scipy.linalg import LinAlgError, solve_continuous_lyapunov, solve_discrete_lyapunov

    balanced, s = _balanced(G)
    identity = np.eye(len(G))
    try:
        # SciPy warns of nearly singular equations; the checker decides about the result anyway.
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            if step is None:
                P = solve_continuous_lyapunov((balanced + rate * identity).T, -identity)
            else:
                # If all eigenvalues exceed rho, the function is valid for every smaller rho too.
                P = solve_discrete_lyapunov(
                    (balanced * np.exp(min(rate * step, FASTEST))).T, identity
                )
    except (LinAlgError, np.linalg.LinAlgError, ValueError):
        return None
    size = np.abs(P).max()
    if not (np.isfinite(P).all() and 0 < size < LARGEST_SOLUTION):
        return None
    return _in_states(np.asarray(P / size, dtype=np.float64), s)


def _balanced(G: Floats) -> tuple[Floats, Floats]:
    """Return S^-1 G S with rows and columns of similar size, and the powers of two s."""
    from scipy.linalg import matrix_balance

    # The permutation, which is not used, is made of integers that very large scales overflow.
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        balanced, (s, _) = matrix_balance(G, permute=False, separate=True)
    if not (np.isfinite(balanced).all() and np.isfinite(s).all() and s.min() > 0):
        return G, np.ones(len(G))
    return np.asarray(balanced, dtype=np.float64), np.asarray(s, dtype=np.float64)


def _in_states(P: Floats, s: Floats) -> Floats:
    """Return S^-1 P S^-1, scaled to a size around 1."""
    function = (P + P.T) / 2 / s / s[:, None]
    diagonal = np.abs(np.diag(function))
    middle = np.sqrt(diagonal.max()) * np.sqrt(diagonal[diagonal > 0].min(initial=diagonal.max()))
    return np.asarray(function / np.exp2(np.round(np.log2(middle)))) if middle > 0 else function


ROUNDOFF = float(np.finfo(np.float64).eps)


def cannot_be_definite(stack: Floats, entry_error: float = 0.0) -> bool:
    """Return whether one of (N, n, n) symmetric matrices is certainly not positive definite.

    ``entry_error`` : bound on the distance of every entry from its exact value.
    """
    n = stack.shape[1]
    gamma = (n + 1) * ROUNDOFF
    trace = np.abs(np.diagonal(stack, axis1=1, axis2=2)).sum(axis=1)
    shift = gamma / (1 - gamma) * trace + n * entry_error
    try:
        np.linalg.cholesky(stack + 2 * shift[:, None, None] * np.eye(n))
    except np.linalg.LinAlgError:
        return True
    return False


def cannot_decrease(A: Floats, P: Floats, rate: float, step: float | None) -> bool:
    """Return whether P certainly fails ``decay`` for one of A, (N, n, n), at alpha [1/s]."""
    n = len(P)
    PA = P @ A
    sizes = np.abs(P) @ np.abs(A)
    if step is None:
        stack = -(PA + PA.transpose(0, 2, 1) + 2 * rate * P)
        size = 2 * sizes.max() + 2 * rate * np.abs(P).max()
    else:
        stack = np.exp(-2 * rate * step) * P - A.transpose(0, 2, 1) @ PA
        size = np.abs(P).max() + (np.abs(A).transpose(0, 2, 1) @ sizes).max()
    return cannot_be_definite(stack, (4 * n + 8) * ROUNDOFF * float(size))
