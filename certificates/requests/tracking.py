"""Requests that outputs follow references: at rest after jumps, and while the references move."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any, Literal

import numpy as np

from takagi.certificates.document.model_data import rounded_down, rounded_up, short
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt
from takagi.lmi.analysis.start_set import tracking_function
from takagi.models.arrays import Floats
from takagi.models.equilibrium_line import (
    ConstantObserver,
    EquilibriumLine,
    equilibrium_line,
    placed_gain,
)
from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant
from takagi.models.tracking import signals_of

# Shares of the largest decay rate that are tried for the function.
SHARES = (0.9, 0.6, 0.35, 0.15)
QUICK_SHARES = (0.5, 0.15)
# Evidence with this share of the largest jump is taken if its decay rate is larger.
NEARLY_BEST = 0.9
# Shares of the set for the residuals; the least is for residuals that are rounding only.
RESIDUAL_SHARES = (0.02, 0.1, 0.3, 0.6)
DIGITS = (6, 9, 12)
MOST_SIGNALS = 4  # of a quadratic function: the corners of their ranges double with each
# Relative margin that is added to norms and residuals computed in floating point.
SLACK = 1 + 1e-6
# Residuals with no more than this share of the set's square are claimed as large as that: a bound
# at the level of rounding costs the checkers many boxes.
SPARE = 1e-6
# The weights of the residuals are claimed larger by this factor than they were found.
WEIGHT_FACTOR = 1 + 1e-4
# Shares of a rate that are tried if the whole rate is not proved.
RATE_SHARES = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.001)


@dataclass(frozen=True, slots=True, eq=False)
class Tracking:
    """Request that outputs converge to their references, within all ranges.

    Attributes
    ----------
    kind : "jumps" for the largest jumps of constant references; "rate" for the least error while
        they move at their rates.
    slower : for "rate", whether smaller rates may be claimed.
    observer : of a law with measured outputs; None for a law of all states.
    """

    kind: Literal["jumps", "rate"] = "jumps"
    slower: bool = False
    observer: ConstantObserver | None = None

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the best attempt.

        Raises
        ------
        ModelError : the model has no references, or there are no gains.
        """
        search = self._search(loop)
        evidence = search.evidence()
        if evidence is None:
            evidence = search.nearest()
            tried = "no set was found in which outputs follow their references, within the ranges"
        else:
            tried = f"the best of {len(SHARES)} decay rates: {evidence['decay_rate']:g} 1/s"
        claim = {"name": search.name(), "kind": "tracking", **evidence}
        return Attempt(claim, loop.replay(claim, of_plant=True), (tried,))

    def candidate(self, loop: ClaimedLoop) -> dict[str, Any] | None:
        """Return evidence that holds in floating point alone; None for none.

        Raises
        ------
        ModelError : as ``attempt``.
        """
        return self._search(loop, quick=True).evidence(quick=True)

    def _search(self, loop: ClaimedLoop, *, quick: bool = False) -> _Search:
        """Return the search about a linear function of the signals, or a quadratic one.

        The largest rate of one function for all vertices takes the longest to find; the slowest
        pole of the vertices bounds it, and is enough for what is not claimed.
        """
        plant = _plant_of(loop)
        line = equilibrium_line(plant, _gain(loop), self.observer)
        search = _Search(loop, plant, line, self, quick=quick)
        if search.leaves_residuals and len(line.sides) <= MOST_SIGNALS:
            line = equilibrium_line(plant, _gain(loop), self.observer, curved=True)
            return _Search(loop, plant, line, self, quick=quick, top=search.top)
        return search


def _plant_of(loop: ClaimedLoop) -> Plant:
    form = None if loop.model.derivation is None else loop.model.derivation.form
    if form is None or not form.plant.references or loop.gains is None:
        raise ModelError(
            f"model {loop.model.name!r}: it has no references or no gains; a plant file says by "
            "[reference] what follows what"
        )
    return form.plant


def _gain(loop: ClaimedLoop) -> Floats:
    assert loop.gains is not None  # asked before
    return np.asarray(loop.gains[0], dtype=np.float64)


def observer_data(observer: ConstantObserver | None) -> dict[str, Any]:
    """Return the member ``observer`` of a law with references; none for a law of all states."""
    if observer is None:
        return {}
    matrices = {key: getattr(observer, key).tolist() for key in "ABCL"}
    return {"observer": {"weights": "constant", "measured": list(observer.measured), **matrices}}


def _vertices(
    plant: Plant, loop: ClaimedLoop, observer: ConstantObserver | None
) -> tuple[Floats, Floats]:
    """Return A (N, n, n) and B (N, n, m) of z' = A z + B (u - u*), z = X or (X, s)."""
    A, B = (np.asarray(stack, dtype=np.float64) for stack in (loop.model.A, loop.model.B))
    if observer is None:
        return A, B
    r, n, k = len(A), A.shape[1], len(observer.A)
    names = [y.name for y in plant.outputs]
    C = np.asarray(loop.model.C, dtype=np.float64)[:, [names.index(y) for y in observer.measured]]
    inner = np.broadcast_to(observer.A - observer.L @ observer.C, (r, k, k))
    A = np.block([[A, np.zeros((r, n, k))], [observer.L @ C, inner]])
    return A, np.concatenate([B, np.broadcast_to(observer.B, (r, *observer.B.shape))], axis=1)


class _Search:
    def __init__(
        self,
        loop: ClaimedLoop,
        plant: Plant,
        line: EquilibriumLine,
        request: Tracking,
        *,
        quick: bool,
        top: float | None = None,
    ) -> None:
        from takagi.lmi import max_decay_rate

        self.loop, self.plant, self.line, self.request = loop, plant, line, request
        self.K = placed_gain(plant, _gain(loop), request.observer)
        free, B = _vertices(plant, loop, request.observer)
        self.A = free - B @ self.K
        self.rows = self._rows()
        states = [v.name for v in plant.states]
        integrals = [states.index(reference.integral) for reference in plant.references]
        self.C = [np.unique(free[:, row, :], axis=0) for row in integrals]
        names = [v.name for v in signals_of(plant)]
        self.references = [names.index(reference.name) for reference in plant.references]
        self.rates = np.zeros(len(names))
        for index, reference in zip(self.references, plant.references, strict=True):
            self.rates[index] = float(reference.rate or 0)
        if top is None:
            poles = float(np.linalg.eigvals(self.A).real.max())
            # The largest rate of one function for all vertices, which none may have.
            top = -poles if quick else max_decay_rate(self.A).decay_rate or 0.0
        self.top = max(float(top), 0.0)
        rounding_size = 1e-6 * np.abs(self.A @ line.D).sum() + 1e-9
        self.leaves_residuals = bool(np.any(line.residuals > rounding_size))

    def _rows(self) -> Floats:
        """Return rows h_i with |h_i' z| <= 1 inside the ranges, about every Xhat(s)."""
        rows = []
        kinds = ((self.loop.model.states, np.eye(len(self.K[0]))), (self.loop.model.inputs, self.K))
        ranges = (self.line.state_range, self.line.input_range)
        for (labels, unit_rows), ends in zip(kinds, ranges, strict=True):
            for k, label in enumerate(labels):
                if label not in self.loop.model.box:
                    continue
                low, high = (float(end) for end in self.loop.model.box[label])
                room = min(high - ends[k][1], ends[k][0] - low)
                if room <= 0:
                    raise ModelError(
                        f"plant {self.plant.name!r}: {label} has no room beside the references' "
                        "rests; narrow their ranges"
                    )
                rows.append(unit_rows[k] / room)
        return np.array(rows).reshape(-1, len(self.K[0]))

    def evidence(self, *, quick: bool = False) -> dict[str, Any] | None:
        """Return the best evidence that holds in floats; None for none."""
        residual_shares = RESIDUAL_SHARES[2 if quick else 0 :]
        if not self.leaves_residuals:
            residual_shares = RESIDUAL_SHARES[:1]
        candidates: list[dict[str, Any]] = []
        for rate_share in RATE_SHARES if self.request.slower else (1.0,):
            candidates = [
                candidate
                for decay_share in (QUICK_SHARES if quick else SHARES)
                for residual_share in residual_shares
                for candidate in self._at(decay_share, rate_share, residual_share)
            ]
            if candidates:
                break
        best = max(candidates, key=self._worth, default=None)
        if best is None or self.request.kind == "rate":
            return best
        # Of about the largest jumps the fastest is taken.
        least_worth = NEARLY_BEST * self._worth(best)
        nearly_best = [c for c in candidates if self._worth(c) >= least_worth]
        return max(nearly_best, key=lambda c: float(c["decay_rate"]), default=best)

    def _at(self, decay: float, rate: float, residual: float) -> Iterator[dict[str, Any]]:
        """Yield the evidence at these shares of the decay rate, of the rates and of the set."""
        alpha = rounded_down(decay * self.top, 4)
        if alpha <= 0:
            return
        function = self._function(alpha, rate, residual)
        if function is not None:
            yield from islice(self._evidence(*function, alpha, rate), 1)

    def name(self) -> str:
        """Return what follows what."""
        pairs = ", ".join(f"{r.follows} follows {r.name}" for r in self.plant.references)
        return pairs if self.request.kind == "jumps" else f"{pairs} while it moves"

    def _function(
        self, alpha: float, share: float, residual_share: float
    ) -> tuple[Floats, Floats | None] | None:
        """Return P, and weights u of the residuals where they are more than rounding."""
        D, residuals = self.line.D, self.line.residuals
        pushes: list[Floats] = []
        weighed: dict[str, Any] = {}
        if self.leaves_residuals:
            weighed = {"residuals": self._counted(), "left": residual_share}
        else:
            unbalanced = [k for k, e in enumerate(residuals) if e > 0]
            pushes = [
                np.eye(len(D))[k] * residuals[k] * len(unbalanced) / (alpha * residual_share)
                for k in unbalanced
            ]
        widths = np.array([high - low for low, high in self.line.sides])
        if self.request.kind == "jumps":
            rows = np.array(pushes).reshape(-1, len(D))
            jumps = np.vstack([self.line.slopes(j) * widths[j] for j in self.references])
            return tracking_function(self.A, alpha, self.rows, rows, jumps=jumps, **weighed)
        moving = np.count_nonzero(self.rates) * share * self.rates / (alpha * (1 - residual_share))
        pushes += [
            slope * speed
            for j, speed in enumerate(moving)
            if speed
            for slope in self.line.slopes(j)
        ]
        rows = np.array(pushes).reshape(-1, len(D))
        errors = np.vstack(self.C)
        return tracking_function(self.A, alpha, self.rows, rows, errors=errors, **weighed)

    def _counted(self) -> Floats:
        """Return the residuals, none of them 0, so that each has a finite weight."""
        size = np.abs(self.A).max(axis=0) @ np.abs(self.line.D).max(axis=1)
        return np.asarray(np.maximum(self.line.residuals * SLACK + 1e-12, 1e-9 * size), np.float64)

    def _evidence(
        self, P: Floats, u: Floats | None, alpha: float, share: float
    ) -> Iterator[dict[str, Any]]:
        """Yield evidence that holds in floating point, with few digits first."""
        rates = share * self.rates if self.request.kind == "rate" else 0 * self.rates
        rates = np.array([float(f"{rate:.4g}") for rate in rates])
        for digits in DIGITS:
            P_ = short(P, digits)
            if np.linalg.eigvalsh(P_)[0] <= 0:
                continue
            evidence = self._filled(P_, alpha, rates, u)
            push = evidence["residual_norm"] + float(np.dot(evidence["slope_norms"], rates))
            rate_in_floats = self._falls(P_, evidence.get("residual_weights"), alpha)
            if rate_in_floats >= alpha and rate_in_floats * evidence["radius"] >= push * SLACK:
                yield evidence

    def _filled(
        self, P: Floats, alpha: float, rates: Floats, u: Floats | None = None
    ) -> dict[str, Any]:
        """Return the claim's numbers for a function, with the largest set in the ranges."""
        inverse = np.linalg.inv(P)
        reach = np.sqrt(np.einsum("hi,ij,hj->h", self.rows, inverse, self.rows))
        radius = rounded_down(1 / (reach.max() * (1 + 1e-9)), 6) if len(reach) else 1e6
        residuals = np.array([rounded_up(e * SLACK + 1e-12, 4) for e in self.line.residuals])
        norm, weighed = float(np.sqrt(residuals @ np.abs(P) @ residuals)), {}
        if u is not None:
            weights = [rounded_up(w * WEIGHT_FACTOR, 6) for w in u / self._counted() ** 2]
            spare = 2 * alpha * SPARE * radius**2 / len(residuals)
            residuals = np.maximum(residuals, [rounded_up(np.sqrt(spare / w), 4) for w in weights])
            norm = float(np.sqrt(alpha * (weights @ residuals**2) / 2))
            weighed = {"residual_weights": weights}
        slopes = [self.line.slopes(j) for j in range(len(self.line.sides))]
        norms = [float(np.sqrt(np.einsum("kn,nm,km->k", g, P, g).max())) for g in slopes]
        factors = [float(np.sqrt(np.einsum("ki,ij,kj->k", C, inverse, C).max())) for C in self.C]
        curved = {} if self.line.Q is None else {"curvature": self.line.Q.tolist()}
        return {
            "decay_rate": alpha,
            "P": P.tolist(),
            "radius": radius,
            "slope": self.line.D.tolist(),
            **curved,
            **weighed,
            "residuals": residuals.tolist(),
            "residual_norm": rounded_up(norm * SLACK, 6),
            "slope_norms": [rounded_up(d * SLACK, 6) for d in norms],
            "rates": rates.tolist(),
            "error_factors": [rounded_up(c * SLACK, 6) for c in factors],
        }

    def _falls(self, P: Floats, u: list[float] | None, alpha: float) -> float:
        """Return the decay rate of P in floats; 0 where the residuals' weights do not hold."""
        from takagi.lmi.analysis.invariant_ellipsoid import decay_rates

        if u is None:
            return float(decay_rates(P, self.A).min())
        falls = -(self.A.transpose(0, 2, 1) @ P + P @ self.A + 2 * alpha * P)
        falls = falls - P @ np.diag(1 / np.array(u)) @ P
        return alpha if np.linalg.eigvalsh(falls).min() > 0 else 0.0

    def _worth(self, evidence: dict[str, Any]) -> float:
        """Return the least jump over the ranges' widths, or minus the largest error."""
        if self.request.kind == "jumps":
            return min(jump_shares(self.plant, evidence))
        push = evidence["residual_norm"] + float(np.dot(evidence["slope_norms"], evidence["rates"]))
        return -max(float(c * push / evidence["decay_rate"]) for c in evidence["error_factors"])

    def nearest(self) -> dict[str, Any]:
        """Return the numbers of a function that falls, in a set that is too small; not proved."""
        alpha = max(rounded_down(QUICK_SHARES[0] * self.top, 4), 1e-6)
        none = np.zeros((0, len(self.A[0])))
        jumps = np.vstack([self.line.slopes(j) for j in self.references])
        function = tracking_function(self.A, alpha, self.rows, none, jumps=jumps)
        P = _of_the_middle(self.A.mean(axis=0)) if function is None else function[0]
        return self._filled(short(P, DIGITS[0]), alpha, self.rates)


def _of_the_middle(A: Floats) -> Floats:
    """Return P of A'P + P A = -I, for the loop in the middle of its slopes; else the identity."""
    from scipy.linalg import solve_continuous_lyapunov

    unit = np.eye(len(A))
    if np.linalg.eigvals(A).real.max() >= 0:
        return unit
    P = np.asarray(solve_continuous_lyapunov(A.T, -unit), dtype=np.float64)
    return P if np.linalg.eigvalsh(P)[0] > 0 else unit


def jump_shares(plant: Plant, claim: Mapping[str, Any]) -> list[float]:
    """Return, for each reference, the largest jump from rest over the width of its range."""
    signals = {v.name: (k, v.range) for k, v in enumerate(signals_of(plant))}
    residual_radius = claim["residual_norm"] / claim["decay_rate"]
    shares = []
    for reference in plant.references:
        index, side = signals[reference.name]
        assert side is not None  # a reference has one
        step = claim["slope_norms"][index] * float(side.width)
        shares.append((claim["radius"] - residual_radius) / max(step, 1e-300))
    return shares
