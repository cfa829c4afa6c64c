"""Requests that outputs follow references: at rest after jumps, and while the references move."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any, Literal

import numpy as np

from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.result import Claim
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.words.saying import in_words
from takagi.certificates.requests.loop.decimals import rounded_down, rounded_up, short
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
QUICK = (0.5, 0.15)
# Evidence with this share of the largest jump is taken if its decay rate is larger.
NEARLY = 0.9
# Shares of the set for the residuals; the least is for residuals that are rounding only.
LEFT = (0.02, 0.1, 0.3, 0.6)
DIGITS = (6, 9, 12)
MOST_SIGNALS = 4  # of a quadratic function: the corners of their ranges double with each
# Relative margin that is added to norms and residuals computed in floating point.
SLACK = 1 + 1e-6
# Residuals with no more than this share of the set's square are claimed as large as that: a bound
# at the level of rounding costs the checkers many boxes.
SPARE = 1e-6
# The weights of the residuals are claimed larger by this factor than they were found.
WIDER = 1 + 1e-4
# Shares of a rate that are tried if the whole rate is not proved.
SLOWER = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.001)


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
        found = self._found(loop, quick=False)
        if found is not None:
            search, best = found
            tried = f"the best of {len(SHARES)} decay rates: {best['decay_rate']:g} 1/s"
        else:
            search = self._search(loop)
            best = search.nearest()
            tried = "no set was found in which outputs follow their references, within the ranges"
        claim = {"name": search.name(), "kind": "tracking", **best}
        return Attempt(claim, search.replay(claim), (tried,))

    def candidate(self, loop: ClaimedLoop) -> dict[str, Any] | None:
        """Return evidence that holds in floating point alone; None for none.

        Raises
        ------
        ModelError : as ``attempt``.
        """
        found = self._found(loop, quick=True)
        return None if found is None else found[1]

    def _found(self, loop: ClaimedLoop, *, quick: bool) -> tuple[_Search, dict[str, Any]] | None:
        """Return evidence about a linear function of the signals, else about a quadratic one."""
        search = self._search(loop, quick=quick)
        best = search.evidence(quick=quick)
        return None if best is None else (search, best)

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
    if form is None or form.plant is None or not form.plant.references or loop.gains is None:
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
    A, B = (np.asarray(part, dtype=np.float64) for part in (loop.model.A, loop.model.B))
    if observer is None:
        return A, B
    r, n, k = len(A), A.shape[1], len(observer.A)
    names = [y.name for y in plant.outputs]
    C = np.asarray(loop.model.C, dtype=np.float64)[:, [names.index(y) for y in observer.measured]]
    inner = np.broadcast_to(observer.A - observer.L @ observer.C, (r, k, k))
    A = np.block([[A, np.zeros((r, n, k))], [observer.L @ C, inner]])
    return A, np.concatenate([B, np.broadcast_to(observer.B, (r, *observer.B.shape))], axis=1)


def decay_limit(A: Floats) -> float:
    """Return the largest rate [1/s] of one quadratic function for all vertices, 0 for none."""
    from takagi.lmi import max_decay_rate

    found = max_decay_rate(A).decay_rate
    return 0.0 if found is None else max(float(found), 0.0)


class _Search:
    def __init__(
        self,
        loop: ClaimedLoop,
        plant: Plant,
        line: EquilibriumLine,
        asked: Tracking,
        *,
        quick: bool,
        top: float | None = None,
    ) -> None:
        self.loop, self.plant, self.line, self.asked = loop, plant, line, asked
        self.K = placed_gain(plant, _gain(loop), asked.observer)
        free, B = _vertices(plant, loop, asked.observer)
        self.A = free - B @ self.K
        self.rows = self._rows()
        self.integrals = [
            [v.name for v in plant.states].index(one.integral) for one in plant.references
        ]
        self.C = [np.unique(free[:, row, :], axis=0) for row in self.integrals]
        names = [v.name for v in signals_of(plant)]
        self.references = [names.index(one.name) for one in plant.references]
        self.rates = np.zeros(len(names))
        for place, one in zip(self.references, plant.references, strict=True):
            self.rates[place] = float(one.rate or 0)
        if top is None:
            poles = float(np.linalg.eigvals(self.A).real.max())
            top = max(-poles, 0.0) if quick else decay_limit(self.A)
        self.top = top
        small = 1e-6 * np.abs(self.A @ line.D).sum() + 1e-9
        self.leaves_residuals = bool(np.any(line.residuals > small))

    def _rows(self) -> Floats:
        """Return rows h_i with |h_i' z| <= 1 inside the ranges, about every Xhat(s)."""
        rows = []
        kinds = ((self.loop.model.states, np.eye(len(self.K[0]))), (self.loop.model.inputs, self.K))
        ranges = (self.line.state_range, self.line.input_range)
        for (labels, found), ends in zip(kinds, ranges, strict=True):
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
                rows.append(found[k] / room)
        return np.array(rows).reshape(-1, len(self.K[0]))

    def evidence(self, *, quick: bool = False) -> dict[str, Any] | None:
        """Return the best evidence that holds in floats; None for none."""
        for share in SLOWER if self.asked.slower else (1.0,):
            found = [
                one
                for part in (QUICK if quick else SHARES)
                for left in self._left(quick=quick)
                for one in self._at(rounded_down(part * self.top, 4), share, left)
            ]
            if found:
                return self._best(found)
        return None

    def _best(self, found: list[dict[str, Any]]) -> dict[str, Any]:
        """Return the evidence with the least error, or the fastest with about the largest jumps."""
        best = max(found, key=self._worth)
        if self.asked.kind == "rate":
            return best
        near = [one for one in found if self._worth(one) >= NEARLY * self._worth(best)]
        return max(near, key=lambda one: float(one["decay_rate"]), default=best)

    def _left(self, *, quick: bool) -> tuple[float, ...]:
        """Return the shares of the set for the residuals of the equations."""
        if not self.leaves_residuals:
            return LEFT[:1]
        return LEFT[2:] if quick else LEFT

    def _at(self, alpha: float, share: float, left: float) -> Iterator[dict[str, Any]]:
        if alpha <= 0:
            return
        found = self._function(alpha, share, left)
        if found is not None:
            yield from islice(self._evidence(*found, alpha, share), 1)

    def name(self) -> str:
        """Return what follows what."""
        pairs = ", ".join(f"{one.follows} follows {one.name}" for one in self.plant.references)
        return pairs if self.asked.kind == "jumps" else f"{pairs} while it moves"

    def _function(
        self, alpha: float, share: float, left: float
    ) -> tuple[Floats, Floats | None] | None:
        """Return P, and weights u of the residuals where they are more than rounding."""
        D, residuals = self.line.D, self.line.residuals
        pushes: list[Floats] = []
        weighed: dict[str, Any] = {}
        if self.leaves_residuals:
            weighed = {"residuals": self._counted(), "left": left}
        else:
            some = [k for k, e in enumerate(residuals) if e > 0]
            pushes = [np.eye(len(D))[k] * residuals[k] * len(some) / (alpha * left) for k in some]
        widths = np.array([high - low for low, high in self.line.sides])
        if self.asked.kind == "jumps":
            rows = np.array(pushes).reshape(-1, len(D))
            jumps = np.vstack([self.line.slopes(j) * widths[j] for j in self.references])
            return tracking_function(self.A, alpha, self.rows, rows, jumps=jumps, **weighed)
        moving = np.count_nonzero(self.rates) * share * self.rates / (alpha * (1 - left))
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
        rates = share * self.rates if self.asked.kind == "rate" else 0 * self.rates
        rates = np.array([float(f"{rate:.4g}") for rate in rates])
        for digits in DIGITS:
            P_ = short(P, digits)
            if np.linalg.eigvalsh(P_)[0] <= 0:
                continue
            found = self._filled(P_, alpha, rates, u)
            push = found["residual_norm"] + float(np.dot(found["slope_norms"], rates))
            falls = self._falls(P_, found.get("residual_weights"), alpha)
            if falls >= alpha and falls * found["radius"] >= push * SLACK:
                yield found

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
            weights = [rounded_up(w * WIDER, 6) for w in u / self._counted() ** 2]
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
        if self.asked.kind == "jumps":
            return min(jump_shares(self.plant, evidence))
        push = evidence["residual_norm"] + float(np.dot(evidence["slope_norms"], evidence["rates"]))
        return -max(float(c * push / evidence["decay_rate"]) for c in evidence["error_factors"])

    def nearest(self) -> dict[str, Any]:
        """Return the numbers of a function that falls, in a set that is too small; not proved."""
        alpha = max(rounded_down(QUICK[0] * self.top, 4), 1e-6)
        none = np.zeros((0, len(self.A[0])))
        jumps = np.vstack([self.line.slopes(j) for j in self.references])
        found = tracking_function(self.A, alpha, self.rows, none, jumps=jumps)
        P = _of_the_middle(self.A.mean(axis=0)) if found is None else found[0]
        return self._filled(short(P, DIGITS[0]), alpha, self.rates)

    def replay(self, claim: dict[str, Any]) -> Claim:
        """Return the checker's verdict."""
        data = read_text(
            json.dumps({"model": self.loop.model_data, "gains": self.loop.gains_data}), "claim"
        )
        read = read_text(json.dumps(claim), "claim")
        return in_words(replay(read, data, self.loop.exact, [], "claim"))


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
    rest = claim["residual_norm"] / claim["decay_rate"]
    found = []
    for one in plant.references:
        place, side = signals[one.name]
        assert side is not None  # a reference has one
        step = claim["slope_norms"][place] * float(side.width)
        found.append((claim["radius"] - rest) / max(step, 1e-300))
    return found
