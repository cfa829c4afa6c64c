"""Requests bounds of the inputs along every solution from an invariant ellipsoid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kinds.input_rate import membership_corners, motion_rows
from takagi.certificates.requests.invariant_ellipsoid import candidate_set, claimed_sets
from takagi.certificates.requests.loop.decimals import floats, rounded_down, rounded_up
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.valid_level import input_bounds
from takagi.certificates.requests.request import Attempt, first_proved, or_else
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# The checker uses the rounded numbers of the file; this margin covers their rounding.
SPARE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class InputLimits:
    """|u_k| <= limits_k, and bounds of the rates of u, for all starts in an invariant ellipsoid.

    u = -K x is the deviation from the input's equilibrium value: an actuator from 0 to 6 V with
    equilibrium 5 V has the limit 1 V.

    Attributes
    ----------
    limits : (m,) on |u_k - u_k*|, in the units of the inputs; None takes the amplitudes that occur
        in the largest ellipsoid in the model's box.
    P, decay_rate, disturbance_bounds : of the ellipsoid, as in ``InvariantEllipsoid``.
    rates : True bounds |u_k'| (or the change in one sample) as well.
    membership_rates : (r,) |h_j'| <= phi_j in 1/s, where gains differ in continuous time.
    """

    limits: ArrayLike | None = None
    P: ArrayLike | None = None
    decay_rate: float | None = None
    disturbance_bounds: ArrayLike | None = None
    rates: bool = False
    membership_rates: ArrayLike | None = None

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``input-limits``.

        Raises
        ------
        ModelError : no gains, limits that do not fit, rates without membership rates.
        """
        if loop.gains is None:
            raise ModelError("limits are about u = -K x; give gains")
        m = loop.gains.shape[1]
        limits = None if self.limits is None else np.asarray(self.limits, dtype=np.float64)
        if limits is not None and (limits.shape != (m,) or not np.all(limits > 0)):
            raise ModelError(f"limits = {self.limits!r}: {m} positive numbers are needed")
        solver, P, found = candidate_set(
            loop, self.P, self.decay_rate, self.disturbance_bounds, limits
        )
        kind = {"name": "inputs within limits", "kind": "input-limits"}
        sets = claimed_sets(loop, P, self.disturbance_bounds) if P is not None else iter(())
        given = ((words, kind | self._limited(loop, claim, limits)) for words, claim in sets)
        idle = {"P": np.eye(loop.exact.order).tolist(), "level": 1.0, "multiplier": 1.0}
        none = {"input_limits": (np.zeros(m) if limits is None else limits).tolist()}
        why = found or "no set was found"
        return first_proved(loop, or_else(given, (why, kind | idle | none)), solver)

    def _limited(
        self, loop: ClaimedLoop, evidence: dict[str, Any], limits: Floats | None
    ) -> dict[str, Any]:
        """Return the evidence with limits; requested limits reduce its level."""
        P, level = np.array(evidence["P"]), float(evidence["level"])
        reach = input_bounds(loop, P, level)
        if limits is None:
            shown = [rounded_up(float(value) * (1 + SPARE), 4) for value in reach]
        else:
            shown = limits.tolist()
            share = float(np.min(limits / np.maximum(reach, 1e-300)))
            if share < 1:
                level = rounded_down((1 - SPARE) * level * share**2)
        found = evidence | {"level": level, "input_limits": shown}
        return found | self._rates(loop, found, P, level) if self.rates else found

    def _rates(
        self, loop: ClaimedLoop, evidence: dict[str, Any], P: Floats, level: float
    ) -> dict[str, Any]:
        assert loop.gains is not None
        rows = np.array([floats(row) for row in motion_rows(loop.exact, "the model")])
        motion = _rounded(_reach(rows, P, level))
        total = np.array(motion)
        if "disturbance_bounds" in evidence:
            push = np.abs(np.einsum("rmn,snq->rsmq", loop.gains, loop.model.E))
            total = total + (push @ np.array(evidence["disturbance_bounds"])).max(axis=(0, 1))
        shares: dict[str, Any] = {"motion": motion}
        moving: dict[str, Any] = {}
        if len(loop.exact.K) > 1 and loop.sample_time is None:
            phi = self._membership_rates(len(loop.gains))
            corners = np.array(
                [[float(d) for d in c] for c in membership_corners(phi, "membership_rates")]
            )
            shares["memberships"] = _rounded(
                _reach(np.tensordot(corners, loop.gains, axes=1), P, level)
            )
            total = total + shares["memberships"]
            moving = {"membership_rates": [float(rate) for rate in phi]}
        limits = [rounded_up(float(value) * (1 + SPARE), 4) for value in total]
        return {"rate_limits": limits, "rate_shares": shares, **moving}

    def _membership_rates(self, r: int) -> list[Any]:
        from fractions import Fraction

        given = None if self.membership_rates is None else np.asarray(self.membership_rates)
        if given is None or given.shape not in ((), (r,)):
            raise ModelError(
                "the gains differ from rule to rule, so the input moves with the memberships; "
                f"give membership_rates, {r} bounds on |h_j'| in 1/s"
            )
        return [Fraction(repr(float(rate))) for rate in np.broadcast_to(given, (r,))]


def _reach(rows: Floats, P: Floats, level: float) -> Floats:
    squares = np.einsum("tmi,ij,tmj->tm", rows, np.linalg.inv(P), rows)
    return np.asarray(np.sqrt(level * squares.max(axis=0)))


def _rounded(values: Floats) -> list[float]:
    return [rounded_up(float(value) * (1 + SPARE), 5) for value in values]
