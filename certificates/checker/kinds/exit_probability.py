r"""``exit-probability``: under white noise x'Px reaches 1 within T s with probability at most p.

    dx = (A x + D d) dt + S dW,     |d_k| <= 1,     W of independent Brownian motions

along the loop: at each instant (A, D, S) is a blend of the vertices; D has the columns of the
bounded disturbances times their bounds, S those of the noise times the roots of its intensities.
Let V = x'Px with P > 0, and a > 0, k > 0, b_k >= 0 be numbers with, for every blend,

    [ A'P + PA + aP   PD          PS        ]
    [ D'P             -diag(b_k)  0         ]  <= 0,        c = sum b_k + max tr(S'PS).
    [ S'P             0           -I / (2k) ]

Then f = exp(kV) drifts by at most k f (c - aV) (Ito's formula), and for all V that is at most

    m = k c  where k c <= a and V >= 0,      else m = a exp(k c/a - 1),

so that f + m (T - t), stopped where V reaches 1, is a supermartingale and not negative.  By Ville's
inequality, from V(0) <= v0,

    P(V reaches 1 within T) <= exp(-k (1 - v0)) + m T exp(-k) <= p.

The matrix is affine in (A, D, S), and tr(S'PS) is convex in S.  So the tested blends suffice, for
all weights that do not depend on future noise.  {V <= 1} must lie in the model's box.  Noise is not
bounded, so it must have no range in the box and occur in no premise; the plant is affine in it.
If S differs between the rules, the stochastic integral is that of Ito.  Theorem and proof:
docs/plant-theorems.md.

Evidence: ``disturbance`` as in ``disturbance_channel``; for each disturbance ``noise``, the root of
its intensity (two-sided spectral density), and ``disturbance_bounds`` (left out where all are 0);
``P``, ``rate`` = a, ``exponent`` = k, ``multipliers`` = b_k, for the bounds that are not 0;
``start`` = v0, ``horizon`` = T, ``probability`` = p.

Source: Kushner (1967), Stochastic Stability and Control, chapter 3 (recalled), for the bound by a
supermartingale; Ville (1939) for the inequality.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.exponential import exp_above
from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import number, numbers, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.disturbance_channel import entrance
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.box_of_validity import beyond_range, outside_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack, bounded


@dataclass(frozen=True)
class NoisyMotion:
    """The disturbances of the claim, and its function V.

    ``way`` : "disturbances" or "inputs"; ``E`` : the matrices through which w enters.
    ``noise``, ``bounds`` : for each w_k the root of its intensity and its bound, 0 for none.
    """

    P: Matrix
    rate: Fraction
    exponent: Fraction
    multipliers: list[Fraction]
    way: str
    E: Stack
    noise: list[Fraction]
    bounds: list[Fraction]

    def inequalities(
        self, loop: PolytopicLoop, claim: Any, where: str
    ) -> Iterator[tuple[str, Matrix, Fraction]]:
        """Yield label, minus the module's matrix, and tr(S'PS) of every blend."""
        noisy, pushed = _columns(self.noise), _columns(self.bounds)
        both = Matrix.blocks([[pushed, noisy]]) if self.multipliers else noisy
        q = noisy.shape[1]
        corner = _diagonal([*self.multipliers, *[1 / (2 * self.exponent)] * q])
        blends = blends_of(replace(loop, more=(self.E,)), claim, where)
        bounded(len(blends), loop.order + len(corner.rows))
        for blend in blends:
            E = blend.of(blend.loop.more[0])
            PA, side, S = self.P @ blend.A, self.P @ (E @ both), E @ noisy
            energy = S.T @ (self.P @ S)
            trace = sum((energy[k, k] for k in range(q)), Fraction(0))
            falling = -(PA + PA.T) - self.rate * self.P
            yield blend.label, Matrix.blocks([[falling, -side], [-side.T, corner]]), trace


def check_exit_probability(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return the verdict on a claim with the module's evidence."""
    name = text(claim, "name", where)
    moved = _read(claim, loop, where)
    start, horizon, probability = (
        number(claim, key, where) for key in ("start", "horizon", "probability")
    )
    if not (0 <= start < 1 and horizon > 0 and 0 < probability < 1):
        raise CertificateError(f"{where}: 0 <= start < 1, horizon > 0, 0 < probability < 1")
    if not moved.P.is_positive_definite:
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    if why := _beyond_model(moved, loop):
        return Claim(name, Verdict.UNDECIDED, why)
    largest = Fraction(0)
    for label, left, trace in moved.inequalities(loop, claim, where):
        if not left.is_positive_semidefinite:
            return Claim(name, Verdict.UNDECIDED, f"the inequality fails at {label}")
        largest = max(largest, trace)
    bound = exit_bound(
        rate=moved.rate,
        exponent=moved.exponent,
        level=sum(moved.multipliers, Fraction(0)) + largest,
        start=start,
        horizon=horizon,
    )
    if bound is None or bound > probability:
        return Claim(name, Verdict.UNDECIDED, "the bound of the probability is above the claim's")
    said = {"name": name, "loop": loop, "moved": moved, "start": start}
    return Found(
        Verdict.PROVED,
        "exit_probability",
        said | {"horizon": horizon, "probability": probability},
    )


def exit_bound(
    *, rate: Fraction, exponent: Fraction, level: Fraction, start: Fraction, horizon: Fraction
) -> Fraction | None:
    """Return exp(-k (1 - v0)) + m T exp(-k), rounded up; None where m exp(-k) is above a.

    Parameters
    ----------
    rate, exponent, level : a [1/s], k and c [1/s] of the module.
    start, horizon : v0 < 1, T [s].
    """
    first = exp_above(exponent * (1 - start))
    if exponent * level <= rate:
        return first + exponent * level * horizon * exp_above(exponent)
    less = 1 + exponent * (1 - level / rate)
    return None if less < 0 else first + rate * horizon * exp_above(less)


def _read(claim: Any, loop: PolytopicLoop, where: str) -> NoisyMotion:
    if loop.is_discrete:
        raise CertificateError(f"{where}: the claim is about loops in continuous time")
    way, E = entrance(claim, loop, where)
    q = E[0].shape[1]
    noise = numbers(claim, "noise", where, q)
    bounds = [Fraction(0)] * q
    if "disturbance_bounds" in claim:
        bounds = numbers(claim, "disturbance_bounds", where, q)
    count = sum(bound > 0 for bound in bounds)
    multipliers = numbers(claim, "multipliers", where, count) if count else []
    rate, exponent = number(claim, "rate", where), number(claim, "exponent", where)
    if any(size < 0 for size in (*noise, *bounds, *multipliers)) or not any(noise):
        raise CertificateError(f"{where}: noise, bounds and multipliers >= 0, some noise above 0")
    if rate <= 0 or exponent <= 0:
        raise CertificateError(f"{where}: a positive rate and a positive exponent are needed")
    P = read_matrix(claim, "P", where, (loop.order, loop.order))
    return NoisyMotion(P, rate, exponent, multipliers, way, E, noise, bounds)


def _beyond_model(moved: NoisyMotion, loop: PolytopicLoop) -> str:
    """Return why the model may not be the plant on {V <= 1} under this noise; empty if it is."""
    names = loop.disturbances if moved.way == "disturbances" else loop.inputs
    noisy = [name for name, size in zip(names, moved.noise, strict=bool(names)) if size]
    limited = {*(loop.other_box or {}), *(loop.scheduled_by or ())}
    if found := [name for name in noisy if name in limited]:
        return f"{found[0]} is white noise, which has no range and may be in no premise"
    added = moved.way == "inputs"
    idle = (Fraction(0),) * len(loop.disturbances)
    if why := beyond_range(loop, idle if added else moved.bounds):
        return why
    return outside_of(loop, moved.P, Fraction(1), moved.bounds if added else ())


def _columns(sizes: list[Fraction]) -> Matrix:
    """Return the columns of diag(sizes) that are not zero; one row for each size."""
    kept = [k for k, size in enumerate(sizes) if size]
    return Matrix.of(
        [[size if i == k else Fraction(0) for k in kept] for i, size in enumerate(sizes)]
    )


def _diagonal(values: list[Fraction]) -> Matrix:
    return Matrix.of(
        [[v if i == j else Fraction(0) for j in range(len(values))] for i, v in enumerate(values)]
    )
