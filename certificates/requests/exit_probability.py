"""Requests a bound on the probability that white noise drives the loop out of a set."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.document.model_data import (
    floats,
    rounded_down,
    rounded_up,
    short,
    stack_of,
)
from takagi.certificates.requests.channel_norms import entrance_of
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.set_level import box_rows
from takagi.certificates.requests.request import Attempt, Request, first_proved, require_positive
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.analysis.disturbance.exit_exponent import ExitFunction, NoisyVertices

DIGITS = (6, 9, 12)
# Relative margins of the box, the multipliers, the exponent and the probability.
ROOM, AROUND, INSIDE, ABOVE = 1e-9, 1e-4, 1e-6, 1e-6
# Claimed where the bound is less: the file's numbers go to 1e-48.
LEAST_PROBABILITY = 1e-40
# Fractions of the rate with which a given P is tried.
SLOWER = (1.0, 0.999, 0.99, 0.97, 0.94, 0.9)


@dataclass(frozen=True, slots=True, eq=False)
class ExitProbability(Request):
    """P(x'Px reaches 1 within the horizon) <= probability, for a set in the model's box.

    Attributes
    ----------
    noise : (q,) root of the intensity (two-sided spectral density) of each disturbance, in its
        unit times sqrt(s); 0 for one that is not white noise.
    horizon : T in s.
    start : V = x'Px at the start is at most this, from 0 to below 1.
    disturbance_bounds : (q,) of disturbances that are only bounded; None for none.
    probability : p of the claim; None takes slightly more than the least that is found.
    state_limits : name or label of a state -> largest deviation, in addition to the box.
    disturbance : "disturbances" (E) or "inputs" (added to u); None takes the first that exists.
    rate : a in 1/s; None searches it.
    P : (n, n), the shape of the set up to a factor, if there are no bounded disturbances; None
        searches it.
    """

    includes_decay: ClassVar[bool] = True

    noise: ArrayLike
    horizon: float
    start: float = 0.0
    disturbance_bounds: ArrayLike | None = None
    probability: float | None = None
    state_limits: Mapping[str, float] = field(default_factory=dict)
    disturbance: str | None = None
    rate: float | None = None
    P: ArrayLike | None = None

    def __post_init__(self) -> None:
        require_positive(horizon=self.horizon, rate=self.rate)
        if not 0 <= self.start < 1:
            raise ModelError(f"start = {self.start!r} was given; a number from 0 to below 1")
        if self.probability is not None and not 0 < self.probability < 1:
            raise ModelError(f"probability = {self.probability!r}: a number between 0 and 1")

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``exit-probability``.

        Raises
        ------
        ModelError : discrete time, no such disturbance, sizes that do not fit, no set to leave.
        """
        from takagi.lmi.analysis.disturbance.exit_exponent import exit_function

        evidence = self._evidence(loop)
        system = self._system(loop, evidence)
        if self.P is not None:
            function = self._given(system)
        else:
            function = exit_function(system, self.horizon, start=self.start, rate=self.rate)
        if function is None:
            reason = "no function was found: a vertex is not stable, or there is no common one"
            return first_proved(loop, [(reason, self._idle(loop, evidence))])
        claims = self._claims(evidence, system, function)
        words = (
            f"the bound is not below 1 (exponent {function.exponent:.3g} at rate "
            f"{function.rate:.3g} 1/s); a smaller horizon, less noise or a larger set may be proved"
        )
        return first_proved(loop, claims, idle=(words, self._idle(loop, evidence)))

    def _given(self, system: NoisyVertices) -> ExitFunction | None:
        """Return the function of the given shape, with the largest set, at about the best rate."""
        P = np.asarray(self.P, dtype=np.float64)
        n = system.A.shape[1]
        symmetric = P.shape == (n, n) and np.allclose(P, P.T, atol=1e-9 * np.abs(P).max())
        if not symmetric or not np.isfinite(largest_reach(system.rows, P)):
            raise ModelError(f"P has shape {P.shape}; ({n}, {n}), symmetric, positive, is needed")
        if system.D.shape[2]:
            raise ModelError("P and disturbance_bounds were given; leave one out")
        P = P * largest_reach(system.rows, P)
        slowest = -2 * float(np.linalg.eigvals(system.A).real.max())
        # A solver's P is at the limit of its rate; a smaller rate leaves a margin for rounding.
        rates = [self.rate * share for share in SLOWER] if self.rate else []
        rates = rates or list(slowest * np.geomspace(0.01, 1, 60))
        tried = (with_exponent(system, P, float(a), np.zeros(0)) for a in rates if a > 0)
        functions = [function for function in tried if function is not None]
        return min(functions, key=lambda f: f.logarithm(self.horizon, self.start), default=None)

    def _evidence(self, loop: ClaimedLoop) -> dict[str, Any]:
        exact = loop.exact
        if exact.is_discrete:
            raise ModelError("white noise as it is meant here enters loops in continuous time")
        entrance = entrance_of(loop, self.disturbance)
        q = (exact.E if entrance == "disturbances" else exact.B)[0].shape[1]
        sizes = {"noise": self.noise}
        if self.disturbance_bounds is not None:
            sizes["disturbance_bounds"] = self.disturbance_bounds
        evidence: dict[str, Any] = {"disturbance": entrance}
        for name, value in sizes.items():
            row = np.asarray(value, dtype=np.float64)
            if row.shape != (q,) or not np.all(np.isfinite(row) & (row >= 0)):
                raise ModelError(f"{name} = {value!r}: {q} numbers >= 0 are needed")
            evidence[name] = row.tolist()
        if not any(evidence["noise"]):
            raise ModelError("noise: all entries are 0; give at least one intensity above 0")
        return evidence

    def _system(self, loop: ClaimedLoop, evidence: dict[str, Any]) -> NoisyVertices:
        from takagi.lmi.analysis.disturbance.exit_exponent import NoisyVertices

        rows = np.concatenate([box_rows(loop), self._limits(loop)])
        if not len(rows):
            raise ModelError(
                f"model {loop.model.name!r} has no box of states, so there is no set to leave; "
                "give state_limits"
            )
        stack = loop.exact.E if evidence["disturbance"] == "disturbances" else loop.exact.B
        E = np.array([floats(blend.of(stack)) for blend in loop.searched.blends()])
        noise = np.array(evidence["noise"])
        bounds = np.array(evidence.get("disturbance_bounds", np.zeros_like(noise)))
        A = stack_of(blend.A for blend in loop.searched.blends())
        return NoisyVertices(A, E[:, :, bounds > 0] * bounds[bounds > 0],
                             E[:, :, noise > 0] * noise[noise > 0], rows)  # fmt: skip

    def _limits(self, loop: ClaimedLoop) -> Floats:
        names = list(loop.exact.states)
        short_names = [name.split(" ")[0] for name in names]
        rows = np.zeros((len(self.state_limits), loop.exact.order))
        for row, (name, limit) in zip(rows, self.state_limits.items(), strict=True):
            if name not in names and name not in short_names:
                raise ModelError(f"state_limits: there is no state {name!r}; {', '.join(names)}")
            if not (np.isfinite(limit) and limit > 0):
                raise ModelError(f"state_limits: {name} = {limit!r}; a positive number is needed")
            row[names.index(name) if name in names else short_names.index(name)] = 1 / limit
        return rows

    def _claims(
        self, evidence: dict[str, Any], system: NoisyVertices, function: ExitFunction
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        reach = largest_reach(system.rows, function.P)
        rate = rounded_down(function.rate, 4)
        for digits in DIGITS:
            # The margin covers the rounding, so that the set still lies in the box.
            P = short(function.P * reach * (1 + ROOM + 2 * 10.0 ** (1 - digits)), digits)
            if largest_reach(system.rows, P) > 1:
                continue
            b = [rounded_up(multiplier * (1 + AROUND), 4) for multiplier in function.multipliers]
            rounded_function = with_exponent(system, P, rate, np.array(b))
            if rounded_function is None:
                continue
            bound = float(np.exp(min(rounded_function.logarithm(self.horizon, self.start), 1.0)))
            above = max(bound * (1 + ABOVE), LEAST_PROBABILITY)
            probability = self.probability or rounded_up(above, 4)
            if probability >= 1 or bound > probability:
                continue
            claim = self._claim(evidence, P, rounded_function, probability)
            yield f"probability {probability:.4g}, P to {digits} digits", claim

    def _claim(
        self, evidence: dict[str, Any], P: Floats, function: ExitFunction, probability: float
    ) -> dict[str, Any]:
        b = function.multipliers.tolist()
        return {
            "name": "probability of leaving a set under white noise",
            "kind": "exit-probability",
            **evidence,
            "P": P.tolist(),
            "rate": function.rate,
            "exponent": function.factor,
            **({"multipliers": b} if b else {}),
            "start": self.start,
            "horizon": self.horizon,
            "probability": probability,
        }

    def _idle(self, loop: ClaimedLoop, evidence: dict[str, Any]) -> dict[str, Any]:
        """Return the requested claim with evidence that proves nothing."""
        from takagi.lmi.analysis.disturbance.exit_exponent import ExitFunction

        count = sum(bound > 0 for bound in evidence.get("disturbance_bounds", ()))
        identity = np.eye(loop.exact.order)
        function = ExitFunction(identity, 1.0, self.rate or 1.0, np.ones(count), 1.0)
        return self._claim(evidence, identity, function, self.probability or 0.5)


def largest_reach(rows: Floats, P: Floats) -> float:
    """Return max_j h_j P^-1 h_j', the largest |h_j x|^2 where x'Px <= 1; inf without P > 0."""
    unit = unit_diagonal(P)
    if unit is None:
        return np.inf
    scaled = rows * unit
    return float(np.einsum("ji,ij->j", scaled, np.linalg.solve(_in(P, unit), scaled.T)).max())


def unit_diagonal(P: Floats) -> Floats | None:
    """Return s of x = s xhat in which P has a diagonal of ones; None where P is not definite."""
    if P.diagonal().min() <= 0:
        return None
    unit = np.asarray(1 / np.sqrt(P.diagonal()))
    return unit if np.linalg.eigvalsh(_in(P, unit)).min() > 0 else None


def _in(P: Floats, unit: Floats) -> Floats:
    return np.asarray(P * unit * unit[:, None])


def with_exponent(
    system: NoisyVertices, P: Floats, rate: float, multipliers: Floats
) -> ExitFunction | None:
    """Return the function with the largest k that P, a and b allow, slightly less; None for none.

    k = 1 / (2 max_i lambda_max(S'P X^-1 P S)), X = -(He(P A) + a P) - P D diag(b)^-1 D'P > 0.
    """
    from takagi.lmi.analysis.disturbance.exit_exponent import ExitFunction

    unit = unit_diagonal(P)
    if unit is None or (len(multipliers) and multipliers.min() <= 0):
        return None
    scaled, Q = system.in_states(np.diag(unit)), _in(P, unit)
    PA, PD, PS = Q @ scaled.A, Q @ scaled.D, Q @ scaled.S
    X = -(PA + PA.transpose(0, 2, 1)) - rate * Q
    if len(multipliers):
        X = X - (PD / multipliers) @ PD.transpose(0, 2, 1)
    if np.linalg.eigvalsh(X).min() <= 0:
        return None
    through = PS.transpose(0, 2, 1) @ np.linalg.solve(X, PS)
    largest = float(np.linalg.eigvalsh((through + through.transpose(0, 2, 1)) / 2).max())
    trace = float(np.einsum("nij,nij->n", scaled.S, PS).max())
    factor = rounded_down((1 - INSIDE) / (2 * largest), 6)
    return ExitFunction(P, factor, rate, multipliers, float(multipliers.sum()) + trace)
