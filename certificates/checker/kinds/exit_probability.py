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
If S differs between the rules, the stochastic integral is that of Ito.

Proof.  By Schur's complement the matrix says, for all x and |d_k| <= 1,

    x'(A'P + PA)x + 2 x'PDd + 2k |S'Px|^2 <= -aV + sum b_k d_k^2 <= -aV + sum b_k.

Ito's formula gives f the drift

    k f [x'(A'P + PA)x + 2 x'PDd + tr(S'PS) + 2k |S'Px|^2] <= k f (c - aV) = g(V).

g has the derivative k exp(kV) (k (c - aV) - a), positive below V* = c/a - 1/k and negative above.
So g <= g(V*) = a exp(k c/a - 1) everywhere; where k c <= a, V* <= 0 and g <= g(0) = k c for
V >= 0.  Let tau be the first time with V = 1.  Until tau the process is in the box, so its equation
holds.  N_t = f(x(t ^ tau)) + m (T - t ^ tau), where ^ is the lesser of two, has a drift of at most
0, and the integrand of its stochastic integral, 2k f x'PS, is bounded until tau: N is a
supermartingale, and N >= f > 0.  Where tau <= T it reaches at least exp(k).  By Ville's inequality
P(sup N >= exp(k)) <= E N_0 / exp(k), and E N_0 <= exp(k v0) + m T.

The theorem is about every process with this equation.  There is one where weights and d are
functions of state and time that are locally Lipschitz in the state: the coefficients have Lipschitz
extensions outside {V <= 1}, and the solution is strong and unique up to tau.  Where they are only
continuous there are weak solutions, and the bound holds for each.  A blend of pairs of rules has
the same weights for A, D and S.

Evidence: ``disturbance`` as in ``disturbance_channel``; for each disturbance ``noise``, the root of
its intensity (two-sided spectral density), and ``disturbance_bounds`` (left out where all are 0);
``P``, ``rate`` = a, ``exponent`` = k, ``multipliers`` = b_k, for the bounds that are not 0;
``start`` = v0, ``horizon`` = T, ``probability`` = p.

Source: Kushner (1967), Stochastic Stability and Control, chapter 3 (recalled), for the bound by a
supermartingale; Ville (1939) and Doob (1953) for the inequality.  The matrix with d, and m, are
derived here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import ClassVar

from takagi.certificates.checker.arithmetic.exponential import exp_above
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Obligations,
    never,
    nonnegative,
    positive,
)
from takagi.certificates.checker.kernel.reader import numbers as read_numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.disturbance_channel import entrance
from takagi.certificates.checker.kinds.loop_claim import NOT_DEFINITE, LoopClaim, matrix, number
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.box_of_validity import disturbances_in_range, inside_box
from takagi.certificates.checker.loop.polytopic_loop import Stack, bounded
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.ellipsoid_size import rounded_size
from takagi.certificates.checker.words.rounded import at_least, at_most

ONE = Fraction(1)


@dataclass(frozen=True)
class Noise:
    """The disturbance of the claim.

    ``source`` : "disturbances" or "inputs"; ``E`` : the matrices through which w enters.
    ``sizes``, ``bounds`` : for each w_k the root of its intensity and its bound, 0 for none.
    ``multipliers`` : b_k of the bounds that are not 0.
    """

    source: str
    E: Stack
    sizes: list[Fraction]
    bounds: list[Fraction]
    multipliers: list[Fraction]


@dataclass(frozen=True)
class ExitProbability(LoopClaim):
    """Under white noise V reaches 1 with probability ``probability`` at most; see the module."""

    asks: ClassVar[tuple[str, ...]] = ("disturbance", "noise", "start")
    P: Matrix = matrix("n", "n")
    rate: Fraction = number("1/s", positive=True)
    exponent: Fraction = number(positive=True)
    start: Fraction = number()
    horizon: Fraction = number("s", better="larger", positive=True)
    probability: Fraction = number(
        better="smaller", label="probability of leaving the set", positive=True
    )

    def obligations(self) -> Obligations:
        loop, P = self.loop, self.P
        if loop.is_discrete:
            raise CertificateError(f"{self.where}: the claim is about loops in continuous time")
        if not (0 <= self.start < 1 and self.probability < 1):
            raise CertificateError(f"{self.where}: 0 <= start < 1, probability < 1 are needed")
        noise = self.noise()
        yield positive(P, NOT_DEFINITE)
        yield from self._inside_model(noise)
        noisy, pushed = _columns(noise.sizes), _columns(noise.bounds)
        pushed_and_noisy = Matrix.blocks([[pushed, noisy]]) if noise.multipliers else noisy
        weights = [1 / (2 * self.exponent)] * noisy.shape[1]
        corner = Matrix.diagonal([*noise.multipliers, *weights])
        blends = blends_of(replace(loop, extra_stacks=(noise.E,)), self.claim, self.where)
        bounded(len(blends), loop.order + len(corner.rows))
        largest_trace = Fraction(0)
        for blend in blends:
            E = blend.of(blend.loop.extra_stacks[0])
            PA, side, S = P @ blend.A, P @ (E @ pushed_and_noisy), E @ noisy
            falling = -(PA + PA.T) - self.rate * P
            yield nonnegative(
                Matrix.blocks([[falling, -side], [-side.T, corner]]),
                f"the inequality fails at {blend.label}",
            )
            largest_trace = max(largest_trace, (S.T @ (P @ S)).trace)
        bound = exit_bound(
            rate=self.rate,
            exponent=self.exponent,
            level=sum(noise.multipliers, Fraction(0)) + largest_trace,
            start=self.start,
            horizon=self.horizon,
        )
        failure = "the bound of the probability is above the claim's"
        yield never(failure) if bound is None else nonnegative(self.probability - bound, failure)

    def noise(self) -> Noise:
        """Return the disturbance of the claim.

        Raises
        ------
        CertificateError : sizes that do not fit, that are negative, or all 0.
        """
        claim, where = self.claim, self.where
        source, E = entrance(claim, self.loop, where)
        q = E[0].shape[1]
        sizes, bounds = read_numbers(claim, "noise", where, q), [Fraction(0)] * q
        if "disturbance_bounds" in claim:
            bounds = read_numbers(claim, "disturbance_bounds", where, q)
        count = sum(bound > 0 for bound in bounds)
        multipliers = read_numbers(claim, "multipliers", where, count) if count else []
        if any(size < 0 for size in (*sizes, *bounds, *multipliers)) or not any(sizes):
            raise CertificateError(
                f"{where}: noise, bounds and multipliers >= 0, some noise above 0"
            )
        return Noise(source, E, sizes, bounds, multipliers)

    def _inside_model(self, noise: Noise) -> Obligations:
        """Yield what makes the model the plant on {V <= 1} under this noise."""
        loop, added = self.loop, noise.source == "inputs"
        names = loop.inputs if added else loop.disturbances
        limited = {*(loop.other_box or {}), *(loop.scheduled_by or ())}
        for name, size in zip(names, noise.sizes, strict=bool(names)):
            if size and name in limited:
                yield never(f"{name} is white noise, which has no range and may be in no premise")
        idle = (Fraction(0),) * len(loop.disturbances)
        yield from disturbances_in_range(loop, idle if added else noise.bounds)
        yield from inside_box(loop, self.P, ONE, noise.bounds if added else ())

    def sentence(self) -> str:
        loop, noise = self.loop, self.noise()
        begins = f"x'Px <= {at_least(self.start, 6)}" if self.start else "x = 0"
        model = "the model's disturbance" if noise.source == "disturbances" else "w added to u"
        alone = ", without the model's disturbance" if noise.source == "inputs" and loop.E else ""
        inside = ", inside the model's box" if words.while_valid(loop) else ""
        return (
            f"the probability that x'Px reaches 1 within {at_least(self.horizon, 6)} s is at most "
            f"{at_most(self.probability, 6)}, from {begins} at the start, along {words.about(loop)}"
            f"{words.unforeseeing(loop)}; {model} is {self._disturbance(noise)}"
            f"{words.in_which_sense(loop, noise.E)}{alone}"
            f"{words.granted(loop, disturbances_too=False)}"
            f"; the set is x'Px <= 1{inside}{rounded_size(self.P, ONE, loop.states)}"
            f"{words.deviations(loop, 'x' + ('w' if noise.source == 'disturbances' else ''))}"
        )

    def _disturbance(self, noise: Noise) -> str:
        """Return which w_k are white noise, with their intensities, and which are bounded."""
        names = self.loop.disturbances if noise.source == "disturbances" else self.loop.inputs
        names = names or tuple(f"w_{k + 1}" for k in range(len(noise.sizes)))
        sizes = list(zip(names, noise.sizes, noise.bounds, strict=True))
        white = [f"{at_least(size, 6)}^2 for {name}" for name, size, _ in sizes if size]
        beside = [f"{name} moves by at most {at_least(b, 6)} besides" for name, _, b in sizes if b]
        at_rest = [f"{name} is at rest" for name, size, b in sizes if not size and not b]
        return ", ".join(
            [f"white noise, independent, of intensity {', '.join(white)}", *beside, *at_rest]
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


def _columns(sizes: list[Fraction]) -> Matrix:
    """Return the columns of diag(sizes) that are not zero; one row for each size."""
    nonzero = [k for k, size in enumerate(sizes) if size]
    return Matrix.of(
        [[size if i == k else Fraction(0) for k in nonzero] for i, size in enumerate(sizes)]
    )
