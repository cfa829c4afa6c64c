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
from takagi.lmi.analysis.tracking import tracking_function
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant
from takagi.models.tracking import EquilibriumLine, equilibrium_line, signals_of

# Shares of the largest decay rate that are tried for the function.
SHARES = (0.9, 0.6, 0.35, 0.15)
QUICK = (0.5, 0.15)
# Evidence with this share of the largest jump is taken if its decay rate is larger.
NEARLY = 0.9
# Shares of the set for the residuals; the least is for residuals that are rounding only.
LEFT = (0.02, 0.1, 0.3, 0.6)
DIGITS = (6, 9, 12)
# Relative margin that is added to norms and residuals computed in floating point.
SLACK = 1 + 1e-6
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
    """

    kind: Literal["jumps", "rate"] = "jumps"
    slower: bool = False

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the best attempt.

        Raises
        ------
        ModelError : the model has no references, or there are no gains.
        """
        plant = _plant_of(loop)
        return _Search(loop, plant, equilibrium_line(plant, _gain(loop)), self).attempt()

    def candidate(self, loop: ClaimedLoop) -> dict[str, Any] | None:
        """Return evidence that holds in floating point alone; None for none.

        Raises
        ------
        ModelError : as ``attempt``.
        """
        plant = _plant_of(loop)
        return _Search(loop, plant, equilibrium_line(plant, _gain(loop)), self).evidence(quick=True)


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


def decay_limit(A: Floats) -> float:
    """Return the largest rate [1/s] of one quadratic function for all vertices, 0 for none."""
    from takagi.lmi import max_decay_rate

    found = max_decay_rate(A).decay_rate
    return 0.0 if found is None else max(float(found), 0.0)


class _Search:
    def __init__(
        self, loop: ClaimedLoop, plant: Plant, line: EquilibriumLine, asked: Tracking
    ) -> None:
        self.loop, self.plant, self.line, self.asked = loop, plant, line, asked
        self.K = _gain(loop)
        self.A = np.asarray(loop.model.A - loop.model.B @ self.K, dtype=np.float64)
        self.rows = self._rows()
        self.integrals = [
            [v.name for v in plant.states].index(one.integral) for one in plant.references
        ]
        self.C = [
            np.unique(np.asarray(loop.model.A[:, row, :], dtype=np.float64), axis=0)
            for row in self.integrals
        ]
        names = [v.name for v in signals_of(plant)]
        self.references = [names.index(one.name) for one in plant.references]
        self.rates = np.zeros(len(names))
        for place, one in zip(self.references, plant.references, strict=True):
            self.rates[place] = float(one.rate or 0)
        self.top = decay_limit(self.A)

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

    def attempt(self) -> Attempt:
        """Return the checker's verdict on the best evidence."""
        best = self.evidence()
        if best is None:
            tried = "no function was found whose set lies in the ranges"
            best = self._idle()
        else:
            tried = f"the best of {len(SHARES)} decay rates: {best['decay_rate']:g} 1/s"
        claim = {"name": self._name(), "kind": "tracking", **best}
        return Attempt(claim, self._replay(claim), (tried,))

    def evidence(self, *, quick: bool = False) -> dict[str, Any] | None:
        """Return the best evidence that holds in floats; None for none."""
        for share in SLOWER if self.asked.slower else (1.0,):
            found = [
                one
                for part in (QUICK if quick else SHARES)
                for left in self._left()
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

    def _left(self) -> tuple[float, ...]:
        """Return the shares of the set for the residuals of the equations."""
        small = 1e-6 * np.abs(self.A @ self.line.D).sum() + 1e-9
        return LEFT if np.any(self.line.residuals > small) else LEFT[:1]

    def _at(self, alpha: float, share: float, left: float) -> Iterator[dict[str, Any]]:
        if alpha <= 0:
            return
        P = self._function(alpha, share, left)
        if P is not None:
            yield from islice(self._evidence(P, alpha, share), 1)

    def _name(self) -> str:
        pairs = ", ".join(f"{one.follows} follows {one.name}" for one in self.plant.references)
        return pairs if self.asked.kind == "jumps" else f"{pairs} while it moves"

    def _function(self, alpha: float, share: float, left: float) -> Floats | None:
        D, residuals = self.line.D, self.line.residuals
        counted = [k for k, e in enumerate(residuals) if e > 0]
        pushes = [np.eye(len(D))[k] * residuals[k] * len(counted) / (alpha * left) for k in counted]
        widths = np.array([high - low for low, high in self.line.sides])
        if self.asked.kind == "jumps":
            rows = np.array(pushes).reshape(-1, len(D))
            jumps = (D * widths).T[self.references]
            return tracking_function(self.A, alpha, self.rows, rows, jumps=jumps)
        moving = np.count_nonzero(self.rates) * share * self.rates / (alpha * (1 - left))
        pushes += [D[:, j] * speed for j, speed in enumerate(moving) if speed]
        rows = np.array(pushes).reshape(-1, len(D))
        return tracking_function(self.A, alpha, self.rows, rows, errors=np.vstack(self.C))

    def _evidence(self, P: Floats, alpha: float, share: float) -> Iterator[dict[str, Any]]:
        """Yield evidence that holds in floating point, with few digits first."""
        rates = share * self.rates if self.asked.kind == "rate" else 0 * self.rates
        rates = np.array([float(f"{rate:.4g}") for rate in rates])
        D = self.line.D
        for digits in DIGITS:
            P_ = short(P, digits)
            if np.linalg.eigvalsh(P_)[0] <= 0:
                continue
            inverse = np.linalg.inv(P_)
            reach = np.sqrt(np.einsum("hi,ij,hj->h", self.rows, inverse, self.rows))
            radius = rounded_down(1 / (reach.max() * (1 + 1e-9)), 6) if len(reach) else 1e6
            residuals = np.array([rounded_up(e * SLACK + 1e-12, 4) for e in self.line.residuals])
            norm = float(np.sqrt(residuals @ np.abs(P_) @ residuals))
            slopes = np.sqrt(np.maximum(np.einsum("nj,nm,mj->j", D, P_, D), 0))
            factors = [
                float(np.sqrt(np.einsum("ki,ij,kj->k", C, inverse, C).max())) for C in self.C
            ]
            push = norm + float(slopes @ rates)
            falls = self._falls(P_)
            if falls < alpha or falls * radius < push * SLACK:
                continue
            yield {
                "decay_rate": alpha,
                "P": P_.tolist(),
                "radius": radius,
                "slope": D.tolist(),
                "residuals": residuals.tolist(),
                "residual_norm": rounded_up(norm * SLACK, 6),
                "slope_norms": [rounded_up(d * SLACK, 6) for d in slopes],
                "rates": rates.tolist(),
                "error_factors": [rounded_up(c * SLACK, 6) for c in factors],
            }

    def _falls(self, P: Floats) -> float:
        from takagi.lmi.analysis.invariant_ellipsoid import decay_rates

        return float(decay_rates(P, self.A).min())

    def _worth(self, evidence: dict[str, Any]) -> float:
        """Return the least jump over the ranges' widths, or minus the largest error."""
        if self.asked.kind == "jumps":
            return min(jump_shares(self.plant, evidence))
        push = evidence["residual_norm"] + float(np.dot(evidence["slope_norms"], evidence["rates"]))
        return -max(float(c * push / evidence["decay_rate"]) for c in evidence["error_factors"])

    def _idle(self) -> dict[str, Any]:
        """Return evidence that says why nothing is proved."""
        n, count = self.line.D.shape
        return {
            "decay_rate": max(rounded_down(0.5 * self.top, 4), 1e-6),
            "P": np.eye(n).tolist(),
            "radius": 1.0,
            "slope": self.line.D.tolist(),
            "residuals": [rounded_up(e * SLACK + 1e-12, 4) for e in self.line.residuals],
            "residual_norm": 0.0,
            "slope_norms": [0.0] * count,
            "rates": self.rates.tolist(),
            "error_factors": [0.0] * len(self.references),
        }

    def _replay(self, claim: dict[str, Any]) -> Claim:
        data = read_text(
            json.dumps({"model": self.loop.model_data, "gains": self.loop.gains_data}), "claim"
        )
        read = read_text(json.dumps(claim), "claim")
        return in_words(replay(read, data, self.loop.exact, [], "claim"))


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
