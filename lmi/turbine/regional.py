r"""Gains of the two regions from LMIs: decay rate, and actuators kept within their limits.

Partial load, states (speed error, integral), command dT: the torque T* + dT stays within
0..T_max at every wind of the region.  Full load, states (speed error, pitch deviation, integral),
command d_ref: the pitch reference stays above the smallest pitch, and the rate that it demands of
the drive, (d_ref - delta_beta)/tau, within the pitch rate limit.

All this holds on the ellipsoid V = x' P x <= 1, which contains the stated operating set, lies in
the box where the model is exact, and is invariant: V decays at constant wind, v = v_hat.  So the
operating set is "every state that is reached from these errors at a constant wind".  A moving wind
and an integral that starts elsewhere are not part of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from takagi.lmi.analysis.decay_rate import rate_of
from takagi.lmi.answer import Status, Try
from takagi.lmi.condition.term import Condition
from takagi.lmi.decision.decide import decide, optimise
from takagi.lmi.decision.outcome import Outcome, binding_items
from takagi.lmi.turbine.region_request import (
    FULL_LOAD,
    PARTIAL_LOAD,
    RegionRequest,
    Requirement,
    region_request,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.region_models import WIND_ESTIMATE, full_load_model, partial_load_model

BISECTIONS = 8


def why_none(task: RegionRequest, condition: Condition, outcome: Outcome) -> str:
    """Return the sentence that names condition, region, winds, and each single change."""
    low, high = (float(end) for end in task.model.box[WIND_ESTIMATE])
    names = [lmi.name for lmi in condition.lmis]
    requirement = task.requirement
    sentence = (
        f"{task.region}, {low:.4g} to {high:.4g} m/s: no gains were found ({outcome.status}) with "
        f"decay rate {requirement.decay_rate:.4g} 1/s from speed errors up to "
        f"{requirement.speed_error:.4g} rad/s and pitch errors up to "
        f"{requirement.pitch_error:.4g} rad"
    )
    if outcome.multipliers:
        sentence += f": {binding_items(condition, outcome.multipliers, *names)}"
    slower = _largest_share(
        task, lambda s: replace(requirement, decay_rate=s * requirement.decay_rate)
    )
    smaller = _largest_share(
        task,
        lambda s: replace(
            requirement,
            speed_error=s * requirement.speed_error,
            pitch_error=s * requirement.pitch_error,
        ),
    )
    free = decide(task.condition(requirement, bounded=False)).status == "candidate"
    unboxed = decide(task.condition(requirement, boxed=False)).status == "candidate"
    advice = (
        [f"lower the decay rate to {slower * requirement.decay_rate:.3g} 1/s"] if slower else []
    )
    if smaller:
        advice.append(f"shrink the operating set to {smaller:.0%}")
    if free:
        advice.append("widen the actuator limits (without them there are gains)")
    if unboxed:
        advice.append(
            "give the model wider bands, if its bounds allow (the ellipsoid does not fit into them)"
        )
    advice.append("narrow the wind range, so that the rules differ less")
    return f"{sentence}; relax one of these: {', or '.join(advice)}"


def _largest_share(task: RegionRequest, scaled: Callable[[float], Requirement]) -> float:
    """Return the largest share, in steps, at which there are gains; 0 for none down to 1/32."""
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if decide(task.condition(scaled(middle))).status == "candidate":
            low = middle
        else:
            high = middle
        if high < 1 / 32:
            return 0.0
    return low


RELAXATION = "none needed: one input matrix in all rules"
# The least demand is approached to this share. At the least value itself no inequality has a
# margin.
OBJECTIVE_SLACK = 1e-2


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class RegionGains:
    """Gains of one region with the published signs, or why there are none.

    Attributes
    ----------
    region : "partial load" or "full load".
    model : the regional model, its rules in the order of the gains.
    requirement : what was asked.
    status : "candidate" (the LMIs held by eigenvalues; floating point, not a proof),
        "infeasible" or "unknown".
    k_x : (r, n - 1), on speed error [rad/s] (and pitch [rad]); u = -k_x dx + k_I x_I.
    k_I : (r,), on x_I = int (omega_ref - omega) [rad]; K_I = -k_I in u = -K x.
    P : (n, n); the bounds hold on x' P x <= 1.
    margin : room of the decay inequalities in scaled coordinates; not above 0 without gains.
    decay_rate : the rate that P shows for the closed rules [1/s], at least the one asked.
    bounds : name -> (limit, largest value on the ellipsoid), SI units.
    relaxation : of the double sum.
    condition, tries : the solved condition, in scaled coordinates, and the record of all solver
        calls.
    diagnosis : condition, region, winds, and what to relax; empty for a candidate.
    """

    region: str
    model: TSModel
    requirement: Requirement
    status: Status
    margin: float
    condition: Condition
    tries: tuple[Try, ...]
    k_x: Floats | None = None
    k_I: Floats | None = None
    P: Floats | None = None
    decay_rate: float | None = None
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    relaxation: str = RELAXATION
    diagnosis: str = ""

    @property
    def found(self) -> bool:
        """Whether there are gains."""
        return self.status == "candidate"

    @property
    def gains(self) -> Floats:
        """K, (r, 1, n), for u = -sum h_i K_i x; ModelError with the diagnosis without gains."""
        k_x, k_I = self.require()
        return np.concatenate([k_x, -k_I[:, None]], axis=1)[:, None, :]

    def require(self) -> tuple[Floats, Floats]:
        """Return (k_x, k_I); ModelError with the diagnosis when there are none."""
        if self.k_x is None or self.k_I is None:
            raise ModelError(self.diagnosis)
        return self.k_x, self.k_I


@dataclass(frozen=True, slots=True, eq=False)
class RegionalGains:
    """The gains of partial and full load."""

    partial: RegionGains
    full: RegionGains

    @property
    def found(self) -> bool:
        """Whether both regions have gains."""
        return self.partial.found and self.full.found

    @property
    def diagnosis(self) -> str:
        """Why a region has none; empty when both have."""
        return "; ".join(
            region.diagnosis for region in (self.partial, self.full) if region.diagnosis
        )


def regional_gains(
    turbine: Turbine,
    *,
    partial_load: Requirement = PARTIAL_LOAD,
    full_load: Requirement = FULL_LOAD,
    partial_model: TSModel | None = None,
    full_model: TSModel | None = None,
    speed_setpoint: float | None = None,
) -> RegionalGains:
    """Return the gains of both regions; a region without any carries a diagnosis.

    Parameters
    ----------
    partial_load, full_load : decay rate and operating set of each region.
    partial_model, full_model : regional models; None makes them with their default bands.
    speed_setpoint : de-rated rotor speed [rad/s], the one of the models; None takes the rated.

    Raises
    ------
    ModelError : misuse only (a set outside the model's box, a model of something else).
    """
    low = partial_model or partial_load_model(turbine, speed_setpoint=speed_setpoint)
    high = full_model or full_load_model(turbine, speed_setpoint=speed_setpoint)
    return RegionalGains(
        region_gains(turbine, low, partial_load, speed_setpoint=speed_setpoint),
        region_gains(turbine, high, full_load, speed_setpoint=speed_setpoint),
    )


def region_gains(
    turbine: Turbine,
    model: TSModel,
    requirement: Requirement,
    *,
    speed_setpoint: float | None = None,
) -> RegionGains:
    """Return the gains of the region that a model describes.

    Of all gains that meet the requirement, these need the least actuator effort on the ellipsoid:
    the smallest torque (partial load), the smallest pitch reference (full load).

    Raises
    ------
    ModelError : the operating set is not inside the model's box, or the input matrix varies.
    """
    task = region_request(turbine, model, requirement, speed_setpoint)
    condition = task.condition(requirement)
    outcome = optimise(condition, slack=OBJECTIVE_SLACK)
    without = RegionGains(
        region=task.region,
        model=model,
        requirement=requirement,
        status=outcome.status,
        margin=outcome.margin,
        condition=condition,
        tries=outcome.tries,
    )
    if outcome.status != "candidate":
        reason = f"{task.region}: gains keep the limits, but {outcome.reason}"
        return replace(
            without, diagnosis=reason if outcome.feasible else why_none(task, condition, outcome)
        )
    Q, M = outcome.values["Q"][0], outcome.values["M"][:, 0, :]
    K = np.linalg.solve(Q, M.T).T * task.unit / task.scales
    P = np.linalg.inv(Q) / np.outer(task.scales, task.scales)
    return replace(
        without,
        k_x=K[:, :-1],
        k_I=-K[:, -1],
        P=P,
        decay_rate=rate_of(model.A - model.B @ K[:, None, :], P),
        bounds={b.name: (b.limit, _largest(P, K + b.offset)) for b in task.bounds},
    )


def _largest(P: Floats, rows: Floats) -> float:
    """Return max |row x| over the rows and x' P x <= 1."""
    return float(np.sqrt(np.einsum("ij,ji->i", rows, np.linalg.solve(P, rows.T)).max()))
