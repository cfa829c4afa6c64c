"""Requests a bound on what a disturbance does to an output: energy gain, variance, or peak.

For a single vertex P comes from an equation, without a solver; where that proves nothing, and for
more vertices, from an LMI.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag

from takagi.certificates.checker.kinds.disturbance_channel import disturbance_channels
from takagi.certificates.checker.loop.box_of_validity import bounded_inputs
from takagi.certificates.document.model_data import as_read, floats, rounded_down, rounded_up, short
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.set_level import best_multiplier, input_bounds, largest_level
from takagi.certificates.requests.request import Attempt, Request, first_proved, require_positive
from takagi.lmi.analysis.disturbance.peak_to_peak import largest_eigenvalue
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer

Path: TypeAlias = tuple[Floats, Floats, Floats, Floats]
Output: TypeAlias = Sequence[ArrayLike | None]
"""(C, D, F) of y = C x + D u + F w, each (r, ., .) or (., .); D and F may be None or left out."""
Claims: TypeAlias = Iterator[tuple[str, dict[str, Any]]]
ENTRANCES = ("disturbances", "inputs")
DIGITS = (6, 9, 12, 15)


def channel_evidence(
    loop: ClaimedLoop,
    disturbance: str | None,
    output: Output | None,
    entering: Sequence[int] | None = None,
) -> dict[str, Any]:
    """Return what the claim states about the channel.

    Parameters
    ----------
    disturbance : "disturbances" (E), "inputs" (w is added to u); None takes the first
        that the model has.
    output : see ``Output``; None takes the model's.
    entering : numbers of the model's disturbances, the others at rest; None takes all.

    Raises
    ------
    ModelError : no such disturbance, no output, shapes; a matrix for each rule of a secant
        embedding.
    """
    model = loop.model
    evidence: dict[str, Any] = {"disturbance": entrance_of(loop, disturbance)}
    if entering is not None and len(entering) < len(loop.exact.disturbances):
        evidence["entering"] = [loop.exact.disturbances[k] for k in entering]
    if output is None:
        if not loop.exact.C:
            raise ModelError(
                f"model {model.name!r} has no output; give output=(C, D, F) for y = C x + D u + F w"
            )
        return evidence
    if not 1 <= len(output) <= 3:
        raise ModelError("output is (C, D, F), or its first one or two")
    matrices = dict(zip("CDF", output, strict=False))
    evidence["output"] = {
        letter: _stack(letter, value, len(model.A))
        for letter, value in matrices.items()
        if value is not None
    }
    if any(len(stack) > 1 for stack in evidence["output"].values()):
        loop.refuse_averages("output")
    return evidence


def entrance_of(loop: ClaimedLoop, disturbance: str | None) -> str:
    """Return where a disturbance enters, one of ``ENTRANCES``; None takes the model's first.

    Raises
    ------
    ModelError : the model has no such disturbance.
    """
    matrices = {"disturbances": loop.exact.E, "inputs": loop.exact.B}
    entrance = disturbance or next((name for name in ENTRANCES if matrices[name]), "disturbances")
    if not matrices.get(entrance):
        raise ModelError(
            f"disturbance {entrance!r}: the model {loop.model.name!r} has none such; it needs a "
            "matrix E ('disturbances') or B ('inputs') that is not zero"
        )
    return entrance


def _stack(letter: str, value: ArrayLike, rules: int) -> list[list[list[float]]]:
    array = np.asarray(value, dtype=np.float64)
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3 or len(array) not in (1, rules) or not np.isfinite(array).all():
        raise ModelError(
            f"output: {letter} has shape {np.shape(value)}; a matrix, or one for each of {rules} "
            "rules, is needed, all finite"
        )
    return array.tolist()  # type: ignore[no-any-return]


def _channel(
    loop: ClaimedLoop, request: L2Gain | H2Norm | Peak, kind: str
) -> tuple[dict[str, Any], Path]:
    """Return the first members of a claim, and A, B, C, D of the blends in the checker's order."""
    evidence = channel_evidence(loop, request.disturbance, request.output, request.entering)
    channels = list(disturbance_channels(as_read(evidence), loop.searched, "claim"))
    path = (
        np.array([floats(channel.A) for channel in channels]),
        np.array([floats(channel.B) for channel in channels]),
        np.array([floats(channel.C) for channel in channels]),
        np.array([floats(channel.through) for channel in channels]),
    )
    return {"name": request.name, "kind": kind, **evidence}, path


def _of_one_vertex(loop: ClaimedLoop, claims: Claims, equation: str) -> Attempt | None:
    """Return the attempt with the claims of an equation; None without any, or with none proved."""
    first = next(claims, None)
    attempt = first and first_proved(loop, chain([first], claims), equation)
    return attempt if attempt and attempt.proved else None


def _by_program(
    loop: ClaimedLoop, answer: Answer, claims: Claims, idle: dict[str, Any], without: str
) -> Attempt:
    """Return the attempt with the claims of an LMI, or the idle claim with the reason."""
    reason = without if answer.P is not None else answer.diagnosis or "no bound was found"
    return first_proved(loop, claims, str(answer.solver.get("status", "")), idle=(reason, idle))


def _by_norm(
    loop: ClaimedLoop,
    norm: Callable[..., Answer],
    path: Path,
    tolerances: Sequence[float],
    claims_of: Callable[[Floats, float], Claims],
    idle: dict[str, Any],
) -> Attempt:
    """Return the attempt with the P of a norm's LMI.

    Of a number that is given, little may be left: then P is looked for at the least one too.
    """
    answers = [norm(*path, sample_time=loop.sample_time, tolerance=t) for t in tolerances]
    claims = (
        claim
        for answer in answers
        if answer.P is not None and answer.gain is not None
        for claim in claims_of(np.asarray(answer.P), answer.gain)
    )
    idle |= {"P": np.eye(path[0].shape[1]).tolist()}
    return _by_program(loop, answers[0], claims, idle, "no bound was found")


# P is searched this far (relative) above the least gain, so that the rounded P keeps a margin.
INSIDE_GAIN, LEAST_GAIN = 2e-4, 1e-6
# The same for a single vertex, whose P comes from a Riccati equation.
GAIN_ROOM = (1e-4, 3e-4, 8e-4)
# Fractions added to the least gain found; each is tried until the rounded numbers prove the claim.
GAIN_BACK_OFF = (1e-4, 1e-3, 1e-2, 0.1, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class L2Gain(Request):
    """|y|_2 <= gain |w|_2 from rest.

    Attributes
    ----------
    gain : in units of y over those of w; None takes slightly more than the least gain found.
    energy_bound : W; for |w|_2 <= W no state leaves the box. "largest" takes the largest W, or
        none if the model has no box.
    disturbance, output, entering : the channel, as in ``channel_evidence``.
    name : of the claim.
    """

    includes_decay: ClassVar[bool] = True

    gain: float | None = None
    energy_bound: float | Literal["largest"] | None = None
    disturbance: str | None = None
    output: Output | None = None
    entering: tuple[int, ...] | None = None
    name: str = "energy gain from disturbance to output"

    def __post_init__(self) -> None:
        require_positive(gain=self.gain)
        if not isinstance(self.energy_bound, str):
            require_positive(energy_bound=self.energy_bound)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``l2-gain``."""
        from takagi.lmi import hinf_norm

        kind, path = _channel(loop, self, "l2-gain")
        of_one = _of_one_vertex(loop, self._by_equation(loop, kind, path), "Riccati equation")

        def claims(P: Floats, least: float) -> Claims:
            gains = [rounded_up(least * (1 + s)) for s in GAIN_BACK_OFF]
            return self._claims(loop, kind, P, gains)

        tolerances = (INSIDE_GAIN, LEAST_GAIN) if self.gain else (INSIDE_GAIN,)
        idle = kind | {"gain": self.gain or 1.0}
        return of_one or _by_norm(loop, hinf_norm, path, tolerances, claims, idle)

    def _by_equation(self, loop: ClaimedLoop, kind: dict[str, Any], path: Path) -> Claims:
        """Yield the claims with P of one vertex by its Riccati equation."""
        from takagi.lmi.analysis.disturbance.guessed_function import bounded_real
        from takagi.lmi.analysis.disturbance.loop_norm import largest_gain

        if len(path[0]) > 1 or loop.sample_time is not None:
            return
        A, B, C, D = (stack[0] for stack in path)
        for tolerance in (*GAIN_ROOM, LEAST_GAIN) if self.gain else GAIN_ROOM:
            P = bounded_real(A, B, C, D, tolerance=tolerance)
            if P is not None:
                gain = rounded_up(largest_gain(A, B, C, D).gain * (1 + tolerance))
                yield from self._claims(loop, kind, P, [gain])

    def _claims(
        self, loop: ClaimedLoop, kind: dict[str, Any], P: Floats, gains: list[float]
    ) -> Claims:
        for gain in [self.gain] if self.gain else gains:
            for digits in DIGITS:
                rounded = short(P, digits)
                claim = kind | {"gain": gain, "P": rounded.tolist()}
                bound = self._energy(loop, kind, P, gain)
                words = f"energy gain {gain:.6g}, P to {digits} digits"
                yield words, claim if bound is None else claim | {"energy_bound": bound}

    def _energy(
        self, loop: ClaimedLoop, kind: dict[str, Any], P: Floats, gain: float
    ) -> float | None:
        if self.energy_bound != "largest":
            return self.energy_bound
        if kind["disturbance"] == "inputs" and bounded_inputs(loop.exact):
            return None
        level = largest_level(loop, P)
        return rounded_down(0.999 * np.sqrt(level / gain), 4) if np.isfinite(level) else None


# As for a gain: the search above the least norm, and the fractions added to P.
INSIDE_NORM, LEAST_NORM = (1e-4, 4e-4), 5e-7
NORM_BACK_OFF = (1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
# The same for the P of a Lyapunov equation, which is accurate up to rounding.
NORM_SLIGHTLY = (0.0, 1e-5, 1e-4)
# For a requested norm: the part of the margin to it that the first inequality uses.
SHARES = (0.5, 0.1, 0.9)


@dataclass(frozen=True, slots=True, eq=False)
class H2Norm(Request):
    """The mean of E|y|^2 over time is at most norm^2 for unit white noise.

    Attributes
    ----------
    norm : None takes slightly more than the least norm found.
    disturbance, output, entering : the channel, as in ``channel_evidence``.
    name : of the claim.
    """

    includes_decay: ClassVar[bool] = True

    norm: float | None = None
    disturbance: str | None = None
    output: Output | None = None
    entering: tuple[int, ...] | None = None
    name: str = "variance of the output under white noise"

    def __post_init__(self) -> None:
        require_positive(norm=self.norm)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``h2-norm``."""
        from takagi.lmi import h2_norm

        kind, path = _channel(loop, self, "h2-norm")
        of_one = _of_one_vertex(loop, self._by_equation(loop, kind, path), "Lyapunov equation")

        def claims(P: Floats, least: float) -> Claims:
            return self._claims(kind, path, P, least, NORM_BACK_OFF)

        tolerances = (INSIDE_NORM[0], LEAST_NORM) if self.norm else INSIDE_NORM[:1]
        idle = kind | {"norm": self.norm or 1.0}
        return of_one or _by_norm(loop, h2_norm, path, tolerances, claims, idle)

    def _by_equation(self, loop: ClaimedLoop, kind: dict[str, Any], path: Path) -> Claims:
        """Yield the claims with P of one vertex by its Lyapunov equation."""
        from takagi.lmi.analysis.disturbance.guessed_function import gramian_with_room

        A, B, C, D = path
        if len(A) > 1 or (loop.sample_time is None and D.any()):
            return
        for tolerance in (*INSIDE_NORM, LEAST_NORM) if self.norm else INSIDE_NORM:
            P = gramian_with_room(
                A[0], B[0], C[0], sample_time=loop.sample_time, tolerance=2 * tolerance
            )
            if P is not None:
                variance = float(np.sum(B[0] * (P @ B[0])) + (D[0] ** 2).sum())
                yield from self._claims(kind, path, P, float(np.sqrt(variance)), NORM_SLIGHTLY)

    def _claims(
        self,
        kind: dict[str, Any],
        path: Path,
        P: Floats,
        least_norm: float,
        increases: tuple[float, ...],
    ) -> Claims:
        _, B, _, D = path
        if self.norm is not None:
            margin = (self.norm / least_norm) ** 2 - 1
            increases = tuple(share * max(margin, 0.0) for share in SHARES)
        for increase in increases:
            for digits in DIGITS:
                rounded = short((1 + increase) * P, digits)
                variance = np.einsum("ijk,jl,ilk->i", B, rounded, B) + (D**2).sum(axis=(1, 2))
                norm = self.norm or rounded_up(float(np.sqrt(variance.max())) * (1 + 1e-9))
                claim = kind | {"norm": norm, "P": rounded.tolist()}
                yield f"norm {norm:.6g} under white noise, P to {digits} digits", claim


# Fractions added to P or to the bound, tried in order until the rounded numbers prove the claim.
PEAK_BACK_OFF = (1e-5, 1e-4, 1e-3, 1e-2, 0.1)
# For one vertex: relative margins of the bound, and the reduction that is tried with each.
PEAK_ROOM, PEAK_SLIGHTLY = (1e-5, 1e-4, 1e-3), (1e-5, 1e-4)
# The relative increase of the bound that is accepted for fewer digits of P.
SHORT = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Peak(Request):
    """|y| <= gain b at all times, from rest, for every disturbance with |w|_2 <= b.

    Attributes
    ----------
    gain : None takes slightly more than the least gain found.
    disturbance_norm : b; None takes the largest that keeps the state in the model's box, but at
        most 1; without a box it takes 1.
    decay_rate : alpha [1/s] of the set; None searches the best one.
    disturbance, output, entering : the channel, as in ``channel_evidence``.
    name : of the claim.
    """

    includes_decay: ClassVar[bool] = True

    gain: float | None = None
    disturbance_norm: float | None = None
    decay_rate: float | None = None
    disturbance: str | None = None
    output: Output | None = None
    entering: tuple[int, ...] | None = None
    name: str = "peak of the output under bounded disturbance"

    def __post_init__(self) -> None:
        require_positive(gain=self.gain, disturbance_norm=self.disturbance_norm)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``peak``."""
        from takagi.lmi import peak_gain

        kind, path = _channel(loop, self, "peak")
        of_one = _of_one_vertex(loop, self._by_equation(loop, kind, path), "Lyapunov equation")
        if of_one is not None:
            return of_one
        answer = peak_gain(*path, sample_time=loop.sample_time, decay_rate=self.decay_rate)
        rate, step = answer.decay_rate or 0.0, loop.sample_time
        multiplier = 2.0 * rate if step is None else -float(np.expm1(-2.0 * rate * step))
        claims: Claims = iter(())
        if answer.P is not None:
            claims = self._claims(loop, kind, path, answer.P, multiplier, PEAK_BACK_OFF)
        sizes = (self.disturbance_norm or 1.0, self.gain or 1.0)
        idle = _peak(kind, np.eye(path[0].shape[1]), 1.0, 1.0, *sizes)
        return _by_program(loop, answer, claims, idle, "no set fits the model's box")

    def _by_equation(self, loop: ClaimedLoop, kind: dict[str, Any], path: Path) -> Claims:
        """Yield the claims with P of one vertex's Lyapunov equation."""
        from takagi.lmi.analysis.disturbance.guessed_function import OneVertex

        if len(path[0]) > 1:
            return
        vertex = OneVertex.of(*(stack[0] for stack in path), step=loop.sample_time)
        rate = vertex.best_rate() if self.decay_rate is None else self.decay_rate
        if rate is None:
            return
        for P in (vertex.with_room(rate, room) for room in PEAK_ROOM):
            if P is not None:
                sigma = vertex.sigma(rate)
                yield from self._claims(loop, kind, path, P, sigma, PEAK_SLIGHTLY)

    def _claims(
        self,
        loop: ClaimedLoop,
        kind: dict[str, Any],
        path: Path,
        P: Floats,
        multiplier: float,
        back_off: tuple[float, ...],
    ) -> Claims:
        A, B, C, D = path
        discrete = loop.sample_time is not None
        for increase in back_off:
            candidates = []
            for digits in DIGITS:
                rounded = short(P, digits)
                unit_level, s = best_multiplier(A, B, rounded, discrete=discrete, start=multiplier)
                if not np.isfinite(unit_level):
                    continue
                size = self.disturbance_norm or _fitting(loop, kind, rounded, unit_level)
                s, level = rounded_down(s, 9), rounded_up(unit_level * size**2 * (1 + increase), 9)
                if s <= 0 or size <= 0 or level <= 0:
                    continue
                least_gain, share = least_peak(C, D, rounded / level * size**2)
                gain = self.gain or rounded_up(least_gain * (1 + increase))
                claim = _peak(kind, rounded, level, s, size, gain)
                words = f"peak gain {gain:.6g} for |w| <= {size:.6g}, P to {digits} digits"
                candidates.append((least_gain, words, claim | ({"share": share} if share else {})))
            # Short numbers are preferred if they hardly increase the bound.
            accepted = min((gain for gain, _, _ in candidates), default=0.0)
            accepted *= 1 + max(increase, SHORT)
            yield from ((words, claim) for gain, words, claim in candidates if gain <= accepted)


def _peak(
    kind: dict[str, Any], P: Floats, level: float, multiplier: float, size: float, gain: float
) -> dict[str, Any]:
    return kind | {
        "disturbance_norm": size,
        "gain": gain,
        "level": level,
        "multiplier": multiplier,
        "P": P.tolist(),
    }


def least_peak(C: Floats, D: Floats, ellipsoid: Floats) -> tuple[float, float]:
    """Return (gamma, t) least with gamma^2 diag((1 - t) X, t I) >= [C D]'[C D] at every blend.

    C (N, p, n), D (N, p, q); the ellipsoid's X has x'Xx <= 1 for |w| <= 1.
    """
    spread = largest_eigenvalue(C @ np.linalg.solve(ellipsoid, C.transpose(0, 2, 1)))
    if not D.any():
        return float(np.sqrt(spread)), 0.0
    from scipy.optimize import minimize_scalar

    CD = np.concatenate([C, D], axis=2)
    q = D.shape[2]

    def gamma(t: float) -> float:
        weight = block_diag((1 - t) * ellipsoid, t * np.eye(q))
        return largest_eigenvalue(CD @ np.linalg.solve(weight, CD.transpose(0, 2, 1)))

    best = minimize_scalar(gamma, bounds=(1e-6, 1 - 1e-6), method="bounded")
    share = float(f"{best.x:.6g}")
    return float(np.sqrt(gamma(share))), share


def _fitting(loop: ClaimedLoop, kind: dict[str, Any], P: Floats, unit_level: float) -> float:
    """Return the largest b <= 1 whose set lies in the box; ``unit_level`` is c for b = 1."""
    exact, at_input = loop.exact, kind["disturbance"] == "inputs"
    limits = [1.0]
    if not at_input:
        limits += [
            float(min(-side[0], side[1]))
            for name, side in (exact.other_box or {}).items()
            if name in kind.get("entering", exact.disturbances)
            and loop.model.E[:, :, exact.disturbances.index(name)].any()
        ]
    sides = bounded_inputs(exact) if at_input and loop.gains is not None else {}
    for k, side in sides.items():
        # |K x|_k <= b reach, and the disturbance at the input adds b.
        reach = input_bounds(loop, P, unit_level)[k]
        limits.append(0.999 * float(min(-side[0], side[1])) / (reach + 1))
    level = largest_level(loop, P)
    if np.isfinite(level):
        limits.append(0.999 * float(np.sqrt(level / unit_level)))
    return rounded_down(min(limits), 4)
