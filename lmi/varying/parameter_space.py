"""Rules on a product of simplexes, and the answer in the model's states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.gain_pairs import gain_stack
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import (
    Vertices,
    corners_of,
    input_stack,
    sample_time_of,
    slow_vertex,
    vertex_stack,
)
from takagi.lmi.condition.evaluate import rate_of_values
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.cone.balance import state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import Outcome, advice_about_limit, binding_items
from takagi.lmi.polynomials import Basis, Degrees, Known, PolynomialLyapunov, marginals
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError, did_you_mean

# A bound for each premise, by name or in order, in its unit per second; or for each membership.
RateBounds: TypeAlias = ArrayLike | Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """Rule i is the corner corners[i] of the product: h_i = prod_k w^k_(corners[i, k]).

    Attributes
    ----------
    sizes : corners of each simplex: two for a premise, one where it is constant; all rules in a
        single simplex for a model without premises.
    corners : (r, K).
    premises : names of the premises; empty without.
    widths : (K,) upper - lower of each premise, in its unit; 1 without premises.
    """

    sizes: tuple[int, ...]
    corners: Indices
    premises: tuple[str, ...]
    widths: Floats

    @property
    def axes(self) -> tuple[str, ...]:
        """Return the names of all corners, ``"h1"`` or ``"(z low)"``; empty for constant ones."""
        if not self.premises:
            return tuple(f"h{c + 1}" for c in range(self.sizes[0]))
        ends = {1: ("",), 2: ("low", "high")}
        return tuple(
            f"({name} {end})" if end else ""
            for name, size in zip(self.premises, self.sizes, strict=True)
            for end in ends[size]
        )

    def known(self, vertices: Array) -> Known:
        """Return the polynomial of degree 1 in each simplex with these values at the rules."""
        return Known.of_vertices(self.sizes, self.corners, vertices)


def space_of(model: object, rules: int) -> Space:
    """Return the product of the model's premises, or one simplex with a corner for each rule."""
    corners = corners_of(model)
    if corners is None:
        return Space((rules,), np.arange(rules)[:, None], (), np.ones(1))
    premises = tuple(getattr(model, "premises", ()))
    return Space(
        tuple(len(premise.corners) for premise in premises),
        corners,
        tuple(premise.name for premise in premises),
        np.array([float(premise.upper - premise.lower) for premise in premises]),
    )


def degrees_of(space: Space, degree: int | Sequence[int]) -> Degrees:
    """Return the degree in each simplex; one number stands for all.

    Raises
    ------
    ModelError : not whole, negative, or not one for each.
    """
    degrees = tuple(degree) if isinstance(degree, Sequence) else (degree,) * len(space.sizes)
    if len(degrees) != len(space.sizes) or not all(
        isinstance(number, (int, np.integer)) and not isinstance(number, bool) and number >= 0
        for number in degrees
    ):
        needed = f"one for each of {', '.join(space.premises)}" if space.premises else "one number"
        raise ModelError(f"degree is {degree!r}; whole numbers from 0 are needed, {needed}")
    # A constant premise has nothing to be a polynomial of.
    return tuple(
        int(number) if size > 1 else 0 for number, size in zip(degrees, space.sizes, strict=True)
    )


def polya_of(polya: object) -> int:
    """Return a degree to raise by.

    Raises
    ------
    ModelError : not a whole number from 0.
    """
    if isinstance(polya, bool) or not isinstance(polya, (int, np.integer)) or polya < 0:
        raise ModelError(f"polya is {polya!r}; a whole number from 0 is needed")
    return int(polya)


def membership_rates(space: Space, bounds: RateBounds) -> tuple[Floats, ...]:
    """Return the bound of |dw^k_c/dt| in 1/s, (corners of simplex k,), for each simplex k.

    ``bounds`` : with premises, of |dz_k/dt| in the unit of z_k per second, by name or in order;
    without, of |dh_i/dt| in 1/s.  One number stands for all, inf is not a bound, 0 is constant.

    Raises ModelError: a premise missing or unknown, a wrong length, a negative number or NaN.
    """
    if isinstance(bounds, Mapping):
        bounds = _by_name(space, bounds)
    count = len(space.premises) or space.sizes[0]
    try:
        rates = np.asarray(bounds, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(f"rate_bounds cannot be read as real numbers ({error})") from error
    if rates.shape not in ((), (count,)):
        raise ModelError(
            f"rate_bounds has shape {rates.shape}; ({count},) is needed, one for each "
            f"{'premise' if space.premises else 'membership'}, or one number for all"
        )
    rates = np.broadcast_to(rates, (count,))
    if not (rates >= 0).all():
        raise ModelError(
            f"rate_bounds[{int(np.argmin(rates >= 0))}] is {rates[np.argmin(rates >= 0)]}; it must "
            "be 0, positive, or inf for no bound"
        )
    if not space.premises:
        return (rates.copy(),)
    return tuple(
        np.full(size, rate / width if size > 1 else 0.0)
        for rate, width, size in zip(rates, space.widths, space.sizes, strict=True)
    )


def _by_name(space: Space, bounds: Mapping[str, float]) -> list[float]:
    if not space.premises:
        raise ModelError(
            "rate_bounds is given by name, but the model has no premises; give one bound for "
            "each membership, in 1/s"
        )
    for name in bounds:
        if name not in space.premises:
            raise ModelError(
                f"rate_bounds: there is no premise {name!r}; there are {', '.join(space.premises)}"
                + did_you_mean(str(name), list(space.premises))
            )
    missing = [name for name in space.premises if name not in bounds]
    if missing:
        raise ModelError(
            f"rate_bounds: none is given for {', '.join(missing)}; give a bound for each premise, "
            "inf where there is none"
        )
    return [bounds[name] for name in space.premises]


@dataclass(frozen=True, slots=True, eq=False)
class VaryingLoop:
    """x' = A(h) x, or x' = (A(h) - B(h) K(h)) x where there are gains; x+ in discrete time.

    Attributes
    ----------
    A, B, K : (r, n, n), (r, n, m), (r, m, n); B and K are None without gains.
    space : of the memberships.
    sample_time : T in s; None for continuous time.
    """

    A: Array
    B: Array | None
    K: Array | None
    space: Space
    sample_time: float | None

    @property
    def matrix(self) -> Known:
        """Return the loop's matrix as a polynomial in h."""
        A = self.space.known(self.A)
        if self.B is None or self.K is None:
            return A
        return A - self.space.known(self.B) @ self.space.known(self.K)

    @property
    def corners(self) -> Array:
        """Return the loop's matrix at the rules, (r, n, n)."""
        return self.A if self.B is None or self.K is None else self.A - self.B @ self.K

    def units(self, scales: ArrayLike | None) -> Floats:
        """Return s, (n,): powers of two that balance the loop at its rules, or next to scales."""
        return state_units(self.corners.astype(np.float64), scales, step=self.sample_time)

    def scaled(self, s: Floats) -> VaryingLoop:
        """Return the loop in floating point, in states xhat = x / s."""
        A = self.A.astype(np.float64) * s / s[:, None]
        if self.B is None or self.K is None:
            return replace(self, A=A)
        B, K = self.B.astype(np.float64), self.K.astype(np.float64)
        return replace(self, A=A, B=B / s[:, None], K=K * s)

    def hopeless(self, alpha: float) -> str:
        """Return why no P(h) of any degree can be: a rule, or two in equal parts, too slow.

        Memberships may rest anywhere, so every blend has to decay by itself.  Empty when these do.
        """
        r, step = len(self.A), self.sample_time
        slow = slow_vertex(self.corners.astype(np.float64), alpha, step=step)
        if slow is not None:
            return self._said(f"rule {slow[0] + 1} of {r}", slow[1], alpha)
        i, j = np.triu_indices(r, 1)
        if not len(i):
            return ""
        h = (np.eye(r)[i] + np.eye(r)[j]) / 2
        matrix = self.matrix
        w = marginals(h, self.space.sizes, self.space.corners)
        blends = np.tensordot(matrix.basis.values(w), matrix.values.astype(np.float64), axes=1)
        slow = slow_vertex(blends, alpha, step=step)
        if slow is None:
            return ""
        a, b = int(i[slow[0]]), int(j[slow[0]])
        return self._said(f"the mean of rules {a + 1} and {b + 1} of {r}", slow[1], alpha)

    def _said(self, rules: str, eigenvalue: complex, alpha: float) -> str:
        size = "" if self.sample_time is None else f", of size {abs(eigenvalue):.6g},"
        return (
            f"{rules} alone rules it out: its eigenvalue {eigenvalue:.6g}{size} does not decay "
            f"faster than {alpha:g} 1/s; stabilise it, lower the decay rate, or shrink the box"
        )


def varying_loop(
    model: Vertices, gains: ArrayLike | None = None, sample_time: float | None = None
) -> VaryingLoop:
    """Return the loop of a model, or of vertices (r, n, n); with gains its B is needed.

    Raises
    ------
    ModelError : shapes, entries that are not finite, gains without inputs, a sample time that is
        not positive or not the model's.
    """
    A = vertex_stack(model)
    step = sample_time_of(model, sample_time)
    space = space_of(model, len(A))
    if gains is None:
        return VaryingLoop(A, None, None, space, step)
    B = input_stack(model, A)
    return VaryingLoop(A, B, gain_stack(gains, *(len(A), B.shape[2], A.shape[1])), space, step)


def decided_lyapunov(
    condition: Condition, loop: VaryingLoop, s: Floats, basis: Basis, advice: str
) -> Answer:
    """Return the answer of a condition that is posed in states xhat = x / s.

    ``basis`` : of P; the coefficients are the unknown ``P``.
    ``advice`` : what to do where none exists.
    """
    outcome = decide(condition)
    good = outcome.status == "candidate"
    return replace(
        outcome.as_answer(condition, s),
        lyapunov_function=lyapunov_in_states(outcome, loop, s, basis) if good else None,
        decay_rate=rate_of_values(condition, outcome.values, loop.sample_time) if good else None,
        diagnosis="" if good else _diagnosis(condition, outcome, advice),
    )


def lyapunov_in_states(
    outcome: Outcome, loop: VaryingLoop, s: Floats, basis: Basis, size: float | None = None
) -> PolynomialLyapunov:
    """Return P(h) in the model's states, times size; None makes the least eigenvalue about 1."""
    members = outcome.values["P"]
    family = PolynomialLyapunov(basis, members, loop.space.corners)
    if size is None:
        smallest = float(np.linalg.eigvalsh(family.vertices).min())
        size = float(np.exp2(-np.floor(np.log2(smallest))))
    return PolynomialLyapunov(basis, size * members / s / s[:, None], loop.space.corners)


def no_lyapunov(condition: Condition, s: Floats, why: str) -> Answer:
    """Return the no for a reason that needs no solver."""
    return Answer(
        status="infeasible",
        margin=-np.inf,
        bound=0.0,
        coordinates=s,
        condition=condition,
        diagnosis=why,
    )


def _diagnosis(condition: Condition, outcome: Outcome, advice: str) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled(f"{advice_about_limit(condition)}, or give scales")
    names = [lmi.name for lmi in condition.lmis if lmi.strict]
    binding = binding_items(condition, outcome.multipliers, *names[1:])
    return f"no P(h) by these LMIs, which says nothing of others: {binding}; {advice}"
