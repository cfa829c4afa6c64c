"""Requests decay, or an energy gain, by a quadratic function that is scheduled by the weights.

Searches P(h) at single blends, and the pieces of the weights on which it is proved.

The coefficients of a double sum may have the wrong sign at every practical degree of Polya's
relaxation, although P(h) is valid at every blend.  So P(h) is searched at single blends of the
loop, and the simplex of weights is halved until all coefficients have the right sign on each
piece.  A corner of a piece at which P(h) fails is added to the blends of the search.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.fuzzy_decay import FuzzyDecay as CheckedFuzzyDecay
from takagi.certificates.checker.kinds.simplex_polynomial import Polynomial
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.document.model_data import DIGITS, as_read, rounded_down, rounded_up, short
from takagi.certificates.requests.channel_norms import Output, channel_evidence
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.weight_pieces import (
    Corners,
    Point,
    corners_of,
    grid,
    halved_corners,
    point_at,
)
from takagi.certificates.requests.request import (
    Attempt,
    Request,
    first_proved,
    require_positive,
    require_rate,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer
    from takagi.lmi.polynomials import PolynomialLyapunov

BACK_OFF = (1.0, 0.99, 0.9, 0.5, 0.0)
POLYA = (0, 1, 2, 4, 7)
# Blends whose weights are multiples of 1/4, at most this many; and how often the blends at which
# P(h) failed are added to them.
SHARE_DENOMINATOR, MOST_POINTS, MOST_ROUNDS = 4, 81, 10


@dataclass(frozen=True, slots=True, eq=False)
class FuzzyDecay(Request):
    """V = x'P(h)x decays as long as the weights change no faster than the given rates.

    Attributes
    ----------
    rate_bounds : of |dz_k/dt| for each premise, by name or in order, in its unit per second;
        without premises of |dh_i/dt| in 1/s.  One number holds for all; inf means no bound.  In
        discrete time the weights may jump, and this attribute is not used.
    decay_rate : alpha [1/s].
    degree : of P in the weights of each premise, or of the rules.
    """

    rate_bounds: ArrayLike | Mapping[str, float] = np.inf
    decay_rate: float = 0.0
    degree: int | Sequence[int] = 1

    def __post_init__(self) -> None:
        require_rate(self.decay_rate)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``fuzzy-decay``; the rate is reduced until the claim is proved.

        If the coefficients of P(h) do not prove it, pieces of the weights are tried.

        If no candidate is found, the claim has a common P, and the checker answers UNDECIDED.

        Raises
        ------
        ModelError : a secant embedding, whose weights cannot be evaluated; a model without
            premises, which has no weights to schedule with.
        """
        refuse_without_weights(loop, "FuzzyDecay", "Decay")
        from takagi.lmi import fuzzy_lyapunov

        for polya in POLYA:
            answer = fuzzy_lyapunov(
                loop.model,
                rate_bounds=np.inf if loop.sample_time is not None else self.rate_bounds,
                degree=self.degree,
                decay_rate=self.decay_rate,
                relaxation=f"polya-{polya}",
                gains=loop.gains,
            )
            if answer.found:
                break
        solver = str(answer.solver.get("status", ""))
        if answer.lyapunov_function is None:
            return self._on_pieces(loop, (answer.diagnosis, "no P(h) was found"))
        attempt = first_proved(loop, self._claims(loop, answer, polya), solver)
        if attempt.proved:
            return attempt
        on_pieces = self._on_pieces(loop, attempt.tried)
        return on_pieces if on_pieces.proved else attempt

    def _on_pieces(self, loop: ClaimedLoop, tried: tuple[str, ...]) -> Attempt:
        """Return the attempt with P(h) from single blends, on pieces of the weights.

        Not used if P may not depend on any weight: ``Decay`` covers this and has its own pieces.
        """
        from takagi.lmi.varying.parameter_condition import function_at_points

        idle = self._claim(loop, None, 0.0, DIGITS[0], 0)
        solver = ""
        points = grid(loop.exact, SHARE_DENOMINATOR, MOST_POINTS)
        for _ in range(MOST_ROUNDS if points else 0):
            answer = function_at_points(
                loop.model,
                [[count / sum(row) for row in point for count in row] for point in points],
                rate_bounds=self.rate_bounds,
                degree=self.degree if isinstance(self.degree, int) else tuple(self.degree),
                decay_rate=self.decay_rate,
                gains=loop.gains,
            )
            solver = str(answer.solver.get("status", ""))
            if answer.lyapunov_function is None or not any(answer.lyapunov_function.basis.degrees):
                tried = (*tried, f"no P(h) at {len(points)} blends of the loop")
                break
            claim = self._claim(loop, answer.lyapunov_function, self.decay_rate, DIGITS[-1], 0)
            halvings, failed = cut(claim, loop.exact)
            words = f"P(h) from {len(points)} blends of the loop"
            if halvings:
                claim["halvings"] = halvings
                words += f", on {halvings.count([])} pieces of the weights"
                return Attempt(claim, loop.replay(claim), (*tried, words), solver)
            tried = (*tried, words)
            failed = [p for p in dict.fromkeys(failed) if p not in points]
            if not failed:
                break
            points = [*points, *failed]
        return Attempt(idle, loop.replay(idle), tried, solver)

    def _claims(
        self, loop: ClaimedLoop, answer: Answer, polya: int
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        for share in BACK_OFF if self.decay_rate else BACK_OFF[:1]:
            rate = self.decay_rate if share == 1.0 else rounded_down(share * self.decay_rate)
            for digits in DIGITS[1:]:
                for raised in sorted({polya, polya + 1}):
                    words = f"decay rate {rate:.6g} 1/s, P(h) to {digits} digits, raised {raised}"
                    yield words, self._claim(loop, answer.lyapunov_function, rate, digits, raised)

    def _claim(
        self,
        loop: ClaimedLoop,
        function: PolynomialLyapunov | None,
        rate: float,
        digits: int,
        polya: int,
    ) -> dict[str, Any]:
        return {
            "name": f"decay of {loop.model.name or 'the model'} by a scheduled function",
            "kind": "fuzzy-decay",
            "decay_rate": rate,
            **scheduled_function(loop, function, self.rate_bounds, digits=digits, polya=polya),
        }


MOST_PIECES = 400


def refuse_without_weights(loop: ClaimedLoop, name: str, instead: str) -> None:
    """Refuse a request for P(h) of weights that cannot be evaluated, or that the model has not."""
    loop.refuse_averages("function")
    if loop.exact.corners is not None and not loop.exact.corners[0]:
        raise ModelError(
            f"{name} was asked for, but the model has no premises, so that a function of the "
            f"weights is a common one: ask for {instead}"
        )


def cut(claim: dict[str, Any], exact: PolytopicLoop) -> tuple[list[list[int]], list[Point]]:
    """Return the pieces that prove a claim ``fuzzy-decay``, none if none were found.

    And the blends at which P(h) fails.  The longest edges are cut first.
    """
    try:
        read = CheckedFuzzyDecay.read(as_read(claim, "claim"), exact, "claim")
        conditions = [X for X, _ in read.conditions()]
    except CertificateError:
        return [], []
    tree: list[list[int]] = []
    pieces = [(conditions, corners_of(exact))]
    while pieces and len(tree) < MOST_PIECES:
        conditions, corners = pieces.pop()
        undecided = [
            X for X in conditions if not all(M.is_positive_definite for _, M in X.coefficients())
        ]
        if not undecided:
            tree.append([])
            continue
        if rules := list(_failing_rules(undecided, exact)):
            return [], [point_at(exact, corners, rule) for rule in rules]
        premise, i, j = _longest(corners)
        tree.append([premise, i, j])
        for fixed, halved in ((j, i), (i, j)):
            # A coefficient that is positive on a piece is positive on its halves.
            half = [X.halved(premise, fixed, halved) for X in undecided]
            pieces.append((half, halved_corners(corners, premise, fixed, halved)))
    return ([] if pieces else tree), []


def _failing_rules(conditions: list[Polynomial], exact: PolytopicLoop) -> Iterator[int]:
    """Yield the corners of a piece, as rules, at which an inequality fails by itself."""
    corners = exact.corners or tuple((i,) for i in range(exact.rules))
    for rule, corner in enumerate(corners):
        for X in conditions:
            exponent = tuple(
                tuple(degree * (c == chosen) for c in range(size))
                for size, degree, chosen in zip(X.sizes, X.degrees, corner, strict=True)
            )
            if exponent not in X.terms or not X.terms[exponent].is_positive_definite:
                yield rule
                break


def _longest(corners: Corners) -> tuple[int, int, int]:
    """Return the premise and the two corners that are furthest apart."""
    edges = [
        (sum((a - b) ** 2 for a, b in zip(rows[i], rows[j], strict=True)), -premise, -i, -j)
        for premise, rows in enumerate(corners)
        for i, j in combinations(range(len(rows)), 2)
    ]
    _, premise, i, j = max(edges)
    return -premise, -i, -j


def scheduled_function(
    loop: ClaimedLoop,
    function: PolynomialLyapunov | None,
    rate_bounds: ArrayLike | Mapping[str, float],
    *,
    digits: int,
    polya: int,
) -> dict[str, Any]:
    """Return degrees, raised degree and coefficients of P(h), and in continuous time the rates.

    Without a function, P = I is stated, which the checker answers with UNDECIDED.  The other
    arguments are as for ``FuzzyDecay``; coefficients are rounded to ``digits``.
    """
    from takagi.lmi.varying.parameter_space import membership_rates, space_of

    space = space_of(loop.model, len(loop.model.A))
    if function is None:
        degrees = [0] * len(space.sizes)
        rows = [([[0] * size for size in space.sizes], np.eye(loop.A.shape[1]))]
    else:
        degrees = list(function.basis.degrees)
        starts = np.cumsum([0, *space.sizes])
        rows = [
            ([a[s:e].tolist() for s, e in zip(starts[:-1], starts[1:], strict=True)], P)
            for a, P in zip(function.basis.exponents, function.members, strict=True)
        ]
    members: dict[str, Any] = {
        "degrees": degrees,
        "polya": polya,
        "P": [{"powers": a, "matrix": short(P, digits).tolist()} for a, P in rows],
    }
    if loop.sample_time is None:
        # A bound must be a number in a JSON file: a premise without one has None, not infinity.
        members["rates"] = [
            [rounded_up(float(bound)) for bound in row] if np.isfinite(row).all() else None
            for row in membership_rates(space, rate_bounds)
        ]
    return members


# Relative margins above the least gain; they are tried until the rounded numbers prove the claim.
MARGINS = (1e-4, 1e-3, 1e-2, 0.1)
# Exponents of Polya's theorem that are tried, one after another.
GAIN_POLYA = (0, 1, 2)


@dataclass(frozen=True, slots=True, eq=False)
class FuzzyL2Gain(Request):
    """|y|_2 <= gain |w|_2 from rest, by V = x'P(h)x, while the weights keep the given rates.

    Attributes
    ----------
    gain : in units of y over those of w; None takes slightly more than the least gain found.
    rate_bounds : as for ``FuzzyDecay``: of |dz_k/dt| for each premise, of |dh_i/dt| without
        premises; in discrete time the weights may jump, and this attribute is not used.
    degree : of P in the weights of each premise, or of the rules.
    disturbance, output : the channel, as for ``L2Gain``.
    """

    gain: float | None = None
    rate_bounds: ArrayLike | Mapping[str, float] = np.inf
    degree: int | Sequence[int] = 1
    disturbance: str | None = None
    output: Output | None = None

    def __post_init__(self) -> None:
        require_positive(gain=self.gain)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``fuzzy-l2-gain``; a common P, left open, where no P(h) was found.

        Raises
        ------
        ModelError : a secant embedding, whose weights cannot be evaluated; a model without
            premises to schedule with; rules whose output or input matrices make the closed loop
            no blend of vertices that P(h) is searched for.
        """
        refuse_without_weights(loop, "FuzzyL2Gain", "L2Gain")
        evidence = channel_evidence(loop, self.disturbance, self.output)
        tried: list[str] = []
        solver = ""
        for polya in GAIN_POLYA:
            answer = self._searched(loop, evidence, polya)
            solver = str(answer.solver.get("status", ""))
            if answer.lyapunov_function is None or answer.gain is None:
                tried.append(answer.diagnosis or "no P(h) was found")
                continue
            attempt = first_proved(loop, self._claims(loop, evidence, answer, polya), solver)
            if attempt.proved:
                return attempt
            tried += attempt.tried
        idle = self._claim(loop, evidence, None, self.gain or 1.0, DIGITS[0], 0)
        return Attempt(idle, loop.replay(idle), tuple(tried), solver)

    def _searched(self, loop: ClaimedLoop, evidence: dict[str, Any], polya: int) -> Answer:
        """Return P(h) of the closed loop's channel, from the LMIs of ``robust_hinf_norm``."""
        from takagi.lmi.varying.robust_gain import robust_hinf_norm

        return robust_hinf_norm(
            loop.model,
            loop.gains,
            _channel(loop, evidence),
            degree=self.degree if isinstance(self.degree, int) else tuple(self.degree),
            polya=polya,
            rate_bounds=np.inf if loop.sample_time is not None else self.rate_bounds,
        )

    def _claims(
        self, loop: ClaimedLoop, evidence: dict[str, Any], answer: Answer, polya: int
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        assert answer.gain is not None  # asked before
        gains = [self.gain] if self.gain else [rounded_up(answer.gain * (1 + s)) for s in MARGINS]
        for gain in gains:
            for digits in DIGITS[1:]:
                words = f"energy gain {gain:.6g}, P(h) to {digits} digits, raised {polya}"
                yield words, self._claim(loop, evidence, answer, gain, digits, polya)

    def _claim(
        self,
        loop: ClaimedLoop,
        evidence: dict[str, Any],
        answer: Answer | None,
        gain: float,
        digits: int,
        polya: int,
    ) -> dict[str, Any]:
        function = None if answer is None else answer.lyapunov_function
        return {
            "name": "energy gain from disturbance to output, by a scheduled function",
            "kind": "fuzzy-l2-gain",
            **evidence,
            "gain": gain,
            **scheduled_function(loop, function, self.rate_bounds, digits=digits, polya=polya),
        }


def _channel(loop: ClaimedLoop, evidence: dict[str, Any]) -> tuple[Floats, Floats, Floats, Floats]:
    """Return E, C, D and F of the rules, (r, ., .) each: y = C x + D u + F w, before the law."""
    model, r = loop.model, len(loop.model.A)
    inputs = evidence["disturbance"] == "inputs"
    entering = np.asarray(model.B if inputs else model.E, dtype=np.float64)
    output = evidence.get("output", {})
    C = output.get("C", model.C)
    C = np.asarray(C, dtype=np.float64)
    m = 0 if model.B is None else model.B.shape[2]
    p, q = C.shape[1], entering.shape[2]
    D = output.get("D") if output else model.D
    D = np.zeros((r, p, m)) if D is None else np.asarray(D, dtype=np.float64)
    F = output.get("F")
    F = np.zeros((r, p, q)) if F is None else np.asarray(F, dtype=np.float64)
    C, D, F = (np.broadcast_to(stack, (r, *stack.shape[1:])) for stack in (C, D, F))
    return entering, C, D, F + D if inputs else F
