"""Ellipsoids that bounded disturbances do not leave, of vertices and of interval matrices.

For x' = A x + d with (A, d) in the hull of the vertices (A_k, d_k), the set {x' P x <= 1} is
invariant when for each k some alpha_k > 0 gives

    [ A_k' P + P A_k + alpha_k P   P d_k   ]
    [ d_k' P                      -alpha_k ]  < 0,

for then V' < 0 wherever V >= 1.  It lies inside |h_i' x| <= sqrt(eta) for each direction when
[[P, h_i], [h_i', eta]] >= 0.  With alpha fixed both are LMIs in (P, eta); alpha and P are improved
in turn.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.1.3 (bounded peak inputs), with the
disturbance taken at the corners of its box.

Quadratic functions for interval families of matrices, without listing their corners.

For A = M + D with |D_ij| <= R_ij and any weights w_ij > 0,

    P D + D' P <= E = sum_ij R_ij (w_ij P e_i e_i' P + e_j e_j' / w_ij),

since each entry gives 2 R |a b| <= R (w a^2 + b^2 / w); taken here: w_ij = 1/sqrt(P_ii), which is
right where the set touches |x_j| <= 1.  So with N = -(M'P + PM) - E

    N - 2 rho P > 0                               V = x'Px decays at 2 rho for every A,
    [[N - alpha P, -P d], [-d'P, alpha]] > 0      {V <= 1} is invariant under x' = A x + d,
                                                  at the corners of |d_i| <= delta_i.

One inequality for 2^n^2 corners; the weights are free, so that rounding them costs nothing but
room.  Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.1 and 6.1.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from takagi.lmi.analysis.common_quadratic import common_lyapunov
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import optimise
from takagi.lmi.expressions.expression import Expression, He, block, matrix
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError

Groups = Indices

FIRST, ADDED, ROUNDS = 60, 60, 25
MULTIPLIERS = np.geomspace(5e-4, 0.8, 60)
# How often the grid around its best multiplier is refined, and into how many intervals.
FINER, BETWEEN = 3, 9


@dataclass(frozen=True, slots=True, eq=False)
class Ellipsoid:
    """A candidate {x' P x <= 1} that is invariant under ``scale`` times the disturbances.

    Attributes
    ----------
    P : (n, n), or None where no common P was found.
    multipliers : (G,) alpha per group of vertices.
    scale : the factor on the stated disturbance for which it is invariant and inside the bounds.
    diagnosis : why there is none, in words.
    words : the solver's status in the last step.
    """

    P: Floats | None
    multipliers: Floats
    scale: float
    diagnosis: str
    words: str


def invariant_ellipsoid_condition(
    A: Floats, d: Floats, alpha: Floats, directions: Floats
) -> Condition:
    """Pose the invariance LMIs with [[P, h_i], [h_i', eta]] >= 0 and eta least.

    ``A`` : (N, n, n);  d : (N, n), the disturbance at a corner of its box;  alpha : (N,).
    ``directions`` : (D, n) rows h_i.

    Raises ModelError: sizes that do not fit, or a multiplier that is not positive.
    """
    count, n = d.shape
    if A.shape != (count, n, n) or alpha.shape != (count,) or directions.shape[1:] != (n,):
        raise ModelError(
            f"vertices {A.shape}, disturbances {d.shape}, multipliers {alpha.shape}, directions "
            f"{directions.shape}: (N, n, n), (N, n), (N,) and (D, n) are needed"
        )
    if np.any(alpha <= 0):
        raise ModelError(f"multiplier {alpha.min():.4g} of vertex {alpha.argmin()}: give alpha > 0")
    P = Unknown("P", n, n, symmetric=True)
    eta = Unknown("eta", 1, 1, symmetric=True, latex=r"\eta")
    A_k, d_k = matrix(A, "A_{k}"), matrix(d[:, :, None], "d_{k}")
    alpha_k = matrix(alpha[:, None, None], r"\alpha_{k}")
    invariant = block([[He(P @ A_k) + alpha_k * P, P @ d_k], [None, -alpha_k]]) << 0
    inside = bordered(P, directions, "h_{i}", eta) >> 0
    return pose(
        invariant.named("invariance", rf"k = 1, \dots, {count}"),
        inside.named("inside the bounds", rf"i = 1, \dots, {len(directions)}"),
        minimise=eta,
        name="invariant ellipsoid",
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.1.3",
    )


def bordered(P: Unknown, rows: Floats, latex: str, corner: object) -> Expression:
    """Return [[P, h'], [h, corner]] for each row h."""
    return block([[P, matrix(rows[:, :, None], latex)], [None, corner]])


def diagonal_of(u: Unknown) -> Expression:
    """Return diag(u_1, ..., u_n) of the n members of a scalar unknown."""
    total = u.member(0) * matrix(np.diag(np.eye(u.count)[0]), r"e_{1} e_{1}^\top")
    for k in range(1, u.count):
        e = rf"e_{{{k + 1}}}"
        total += u.member(k) * matrix(np.diag(np.eye(u.count)[k]), rf"{e} {e}^\top")
    return total if u.count > 1 else u.as_expression()


def invariant_ellipsoid(
    A: Floats,
    d: Floats,
    groups: Groups,
    directions: Floats,
    *,
    speed: Floats | None = None,
    rounds: int = 5,
) -> Ellipsoid:
    """Return a candidate ellipsoid inside |h_i' x| <= 1 under the largest scale of d.

    Parameters
    ----------
    A : (N, n, n) vertices;  d : (N, n) disturbances at scale 1.
    groups : (N,) group of each vertex, 0 ... G-1; vertices of one group share one multiplier.
    directions : (D, n) rows h_i, so scaled that the bound is 1.
    speed : (N,) time scale of each vertex [1/s]; the first P weighs every vertex by it.
    rounds : how often P and the multipliers are improved in turn.

    Source: the module's.
    """
    count = int(groups.max()) + 1
    pace = np.ones(len(A)) if speed is None else speed
    first = common_lyapunov(A / pace[:, None, None])
    if first.P is None:
        return Ellipsoid(None, np.zeros(count), 0.0, first.diagnosis, first.status)
    P = np.asarray(first.P)
    alpha = -0.5 * _worst(-2 * decay_rates(P, A), groups, count)
    scale, words = 0.0, ""
    # In these coordinates the set is about a unit ball, so the solver's numbers are near one.
    units = 1 / np.abs(directions).max(axis=0)
    scaled_A, scaled_d, h = A * units / units[:, None], d / units, directions * units
    for _ in range(rounds):
        step = _step(scaled_A, scaled_d, alpha[groups], h)
        if step is None:
            break
        better, eta, words = step
        P = better / np.outer(units, units) * eta
        scale = eta**-0.5
        alpha = _multipliers(P, A, d * scale, groups, count)
    if scale == 0.0:
        return Ellipsoid(None, alpha, 0.0, "the invariance condition found no P", words)
    return Ellipsoid(P, alpha, scale, "", words)


def _step(A: Floats, d: Floats, alpha: Floats, h: Floats) -> tuple[Floats, float, str] | None:
    """Return (P, eta) with least eta for fixed multipliers, adding violated vertices in rounds."""
    chosen = np.unique(np.linspace(0, len(A) - 1, min(FIRST, len(A))).astype(np.intp))
    for _ in range(ROUNDS):
        condition = invariant_ellipsoid_condition(A[chosen], d[chosen], alpha[chosen], h)
        outcome = optimise(condition, slack=1e-3)
        if outcome.status != "candidate":
            return None
        P, eta = outcome.values["P"][0], float(outcome.values["eta"][0, 0, 0])
        worst = slacks(P, A, d, alpha)
        fresh = np.setdiff1d(np.nonzero(worst >= 0)[0], chosen)
        if len(fresh) == 0:
            return P, eta, outcome.tries[-1].solver if outcome.tries else ""
        chosen = np.union1d(chosen, fresh[np.argsort(-worst[fresh])[:ADDED]])
    return None


def slacks(P: Floats, A: Floats, d: Floats, alpha: Floats) -> Floats:
    """Return (N,): largest eigenvalue of each invariance matrix over its alpha; negative holds."""
    count, n = d.shape
    M = np.zeros((count, n + 1, n + 1))
    PA = P @ A
    M[:, :n, :n] = PA + PA.transpose(0, 2, 1) + alpha[:, None, None] * P
    M[:, :n, n] = d @ P
    M[:, n, :n] = M[:, :n, n]
    M[:, n, n] = -alpha
    # Congruence by the root of diag(P) puts speeds, efforts and integrals on one scale.
    root = 1 / np.sqrt(np.append(np.diag(P), 1.0))
    M *= root[:, None] * root
    return np.asarray(np.linalg.eigvalsh(M)[:, -1] / alpha, dtype=np.float64)


def decay_rates(P: Floats, A: Floats) -> Floats:
    """Return (N,): the largest rate with A_k' P + P A_k + 2 rate P <= 0 [1/s]."""
    inverse = np.linalg.inv(np.linalg.cholesky(P))
    PA = P @ A
    H = inverse @ (PA + PA.transpose(0, 2, 1)) @ inverse.T
    return np.asarray(-np.linalg.eigvalsh(H)[:, -1] / 2, dtype=np.float64)


def largest_scale(
    P: Floats, A: Floats, fixed: Floats, scaled: Floats, *, limit: float = 1e3
) -> tuple[float, float]:
    """Return (s, alpha): the largest s for which ``fixed + s scaled`` keeps the unit ellipsoid.

    With N = -(A'P + PA + alpha P) > 0 the invariance LMI is d' P N^-1 P d < alpha, a quadratic
    inequality in s for each vertex.  In coordinates where P = I the eigenvectors of A + A' make N
    diagonal at every alpha at once; alpha is sought on a grid, then between the best one's
    neighbours.

    ``A``, ``fixed``, ``scaled`` : (N, n, n), (N, n), (N, n) of vertices that share one multiplier.
    ``limit`` : the largest s that is looked for.

    s = 0 with its alpha when even ``fixed`` alone is too much.
    """
    factor = np.linalg.cholesky(P).T
    inner = factor @ A @ np.linalg.inv(factor)
    rates, axes = np.linalg.eigh(inner + inner.transpose(0, 2, 1))
    f, g = (np.einsum("ni,ij,nja->na", d, factor.T, axes) for d in (fixed, scaled))
    alphas = MULTIPLIERS
    for _ in range(1 + FINER):
        scales = _scales_at(alphas, rates, f, g)
        best = int(np.argmax(scales))
        scale, alpha = float(scales[best]), float(alphas[best])
        beside = alphas[max(best - 1, 0)], alphas[min(best + 1, len(alphas) - 1)]
        alphas = np.append(np.geomspace(*beside, BETWEEN), alpha)
        alphas.sort()
    return min(max(scale, 0.0), limit), alpha


def _scales_at(alphas: Floats, rates: Floats, f: Floats, g: Floats) -> Floats:
    """Return the largest s at each alpha, -1 for none.

    ``rates`` : (N, n) eigenvalues of A + A';  f, g : (N, n) disturbances along the eigenvectors.
    """
    N = -(rates + alphas[:, None, None])
    feasible = N.min(axis=(1, 2)) > 0
    share = 1 / np.where(feasible[:, None, None], N, 1.0)
    a, b = (g * g * share).sum(axis=2), (f * g * share).sum(axis=2)
    c = (f * f * share).sum(axis=2) - alphas[:, None]
    feasible &= c.max(axis=1) < 0
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    # The stable form of the larger root of a s^2 + 2 b s + c = 0 with c < 0.
    roots = np.where(a > 0, -c / np.maximum(b + root, 1e-300), np.inf)
    return np.asarray(np.where(feasible, roots.min(axis=1), -1.0), dtype=np.float64)


def _multipliers(P: Floats, A: Floats, d: Floats, groups: Groups, count: int) -> Floats:
    """Return (G,): per group the multiplier whose worst vertex has most room."""
    table = np.stack(
        [_worst(slacks(P, A, d, np.full(len(A), a)), groups, count) for a in MULTIPLIERS]
    )
    return np.asarray(MULTIPLIERS[table.argmin(axis=0)], dtype=np.float64)


def _worst(values: Floats, groups: Groups, count: int) -> Floats:
    out = np.full(count, -np.inf)
    np.maximum.at(out, groups, values)
    return out


RATE_SHARES = (0.3, 0.6, 0.9, 0.1)
SHIFTS = (0.0, 0.5, 0.85)
# A proof in floats needs a margin: this share of alpha is kept in reserve.
ROOM = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Contraction:
    """What one P shows of a family: decay rate rho and multiplier alpha [1/s]."""

    decay_rate: float
    multiplier: float


def contraction(P: Floats, low: Floats, high: Floats, disturbance: Floats) -> Contraction | None:
    """Return rate and multiplier for which {x'Px <= 1} is invariant, or None.

    ``low``, ``high`` : (corners, n, n), the ranges of each corner of the family.
    ``disturbance`` : (n,) delta.
    """
    lower = np.linalg.cholesky(P)
    inverse = np.linalg.inv(lower)
    middle, radius = (low + high) / 2, (high - low) / 2
    decreases = [_spare(P, m, r) for m, r in zip(middle, radius, strict=True)]
    rate = min(float(np.linalg.eigvalsh(inverse @ N @ inverse.T)[0]) for N in decreases) / 2
    if rate <= 0:
        return None
    signs = np.array(
        [(1.0, *signs_behind) for signs_behind in product((1.0, -1.0), repeat=len(P) - 1)]
    )
    push = (signs * disturbance) @ P
    for share in RATE_SHARES:
        alpha = 2 * rate * share
        if all(_invariant(N - alpha * P, push, alpha) for N in decreases):
            return Contraction(rate, alpha)
    return None


def lyapunov_candidates(corners: Floats) -> list[Floats]:
    """Return P from Lyapunov equations of the mean of the corners, for several weights.

    ``corners`` : (corners, n, n).
    """
    from scipy.linalg import solve_continuous_lyapunov

    mean = corners.mean(axis=0)
    slowest = -float(np.linalg.eigvals(mean).real.max())
    if slowest <= 0:
        return []
    eye = np.eye(len(mean))
    candidates = [solve_continuous_lyapunov((mean + s * slowest * eye).T, -eye) for s in SHIFTS]
    modes = np.linalg.inv(np.linalg.eig(mean)[1])
    candidates.append((modes.conj().T @ modes).real)
    return [(P + P.T) / 2 for P in candidates if np.all(np.linalg.eigvalsh(P + P.T) > 0)]


def _spare(P: Floats, middle: Floats, radius: Floats) -> Floats:
    """Return N."""
    PM = P @ middle
    weights = 1 / np.sqrt(np.diag(P))[:, None]
    rows = (radius * weights).sum(axis=1)
    columns = (radius / weights).sum(axis=0)
    return np.asarray(-(PM + PM.T) - (P * rows) @ P - np.diag(columns))


def _invariant(decrease: Floats, push: Floats, alpha: float) -> bool:
    if np.linalg.eigvalsh(decrease)[0] <= 0:
        return False
    demanded = (push * np.linalg.solve(decrease, push.T).T).sum(axis=1)
    return bool(demanded.max() < alpha * (1 - ROOM))
