"""Which function replays which kind of claim."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from takagi.certificates.checker.kernel.family import Family
from takagi.certificates.checker.kernel.result import Claim
from takagi.certificates.checker.kinds.box_enlargement import check_box_enlargement
from takagi.certificates.checker.kinds.decay import check_decay
from takagi.certificates.checker.kinds.fuzzy_decay import check_fuzzy_decay
from takagi.certificates.checker.kinds.gain_rounding import check_gain_rounding
from takagi.certificates.checker.kinds.h2_norm import check_h2_norm
from takagi.certificates.checker.kinds.input_limits import check_input_limits
from takagi.certificates.checker.kinds.invariant_ellipsoid import check_invariant_ellipsoid
from takagi.certificates.checker.kinds.l2_gain import check_l2_gain
from takagi.certificates.checker.kinds.no_common_decay import check_no_common_decay
from takagi.certificates.checker.kinds.observer import check_observed_feedback, check_observer
from takagi.certificates.checker.kinds.peak import check_peak
from takagi.certificates.checker.kinds.quadratic import check_impossibility, check_quadratic
from takagi.certificates.checker.kinds.region import check_region
from takagi.certificates.checker.kinds.transient import check_transient
from takagi.certificates.checker.plant.effort_blend import check_effort_blend
from takagi.certificates.checker.plant.secant_embedding import check_secant_embedding
from takagi.certificates.checker.plant.sector_embedding import check_embedding
from takagi.certificates.checker.turbine.actuator_rates import check_actuator_rates
from takagi.certificates.checker.turbine.coherent import check_coherent
from takagi.certificates.checker.turbine.equilibrium import check_equilibrium
from takagi.certificates.checker.turbine.paper import check_paper
from takagi.certificates.checker.turbine.wind_rate import check_wind_rate

__all__ = ["KINDS", "OWN_READING", "RESTING", "own_reading"]

# Claims about the loop that model and gains make.
KINDS: dict[str, Callable[[Any, Family, str], Claim]] = {
    "decay": check_decay,
    "no-common-decay": check_no_common_decay,
    "fuzzy-decay": check_fuzzy_decay,
    "region": check_region,
    "gain-rounding": check_gain_rounding,
    "box-enlargement": check_box_enlargement,
    "l2-gain": check_l2_gain,
    "h2-norm": check_h2_norm,
    "peak": check_peak,
    "invariant-ellipsoid": check_invariant_ellipsoid,
    "input-limits": check_input_limits,
    "observer": check_observer,
    "observed-feedback": check_observed_feedback,
    "transient": check_transient,
}
# Claims with a reading of model and gains of their own, and those that hold their own matrices.
OWN_READING: dict[str, Callable[[Any, Any, Any, str], Claim]] = {
    "coherent-loop": check_coherent,
    "paper-loop": check_paper,
    "equilibrium": check_equilibrium,
    "effort-blend": check_effort_blend,
    "sector-embedding": check_embedding,
    "secant-embedding": check_secant_embedding,
    "quadratic-decay": lambda claim, _model, _gains, where: check_quadratic(claim, where),
    "no-common-quadratic": lambda claim, _model, _gains, where: check_impossibility(claim, where),
}
# Claims that rest on an earlier one: given the whole file and the verdicts before them.
RESTING: dict[str, Callable[[Any, Any, list[Claim], str], Claim]] = {
    "wind-rate": check_wind_rate,
    "actuator-rates": check_actuator_rates,
}


def own_reading(claim: Any, data: Any, found: list[Claim], where: str) -> Claim:
    """Return the verdict on a claim of ``OWN_READING`` or ``RESTING``."""
    kind = claim["kind"]
    if kind in RESTING:
        return RESTING[kind](claim, data, found, where)
    return OWN_READING[kind](claim, data["model"], data.get("gains"), where)
