"""The registry of the kinds of claims, and the verdict on one claim.

Modules are listed by name and imported only when a certificate has such a claim. So a verdict loads
only the code that it needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.claim_kind import Decided, Outcome
from takagi.certificates.checker.kernel.obligation import Decider, decided_exactly
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Verdict

if TYPE_CHECKING:
    from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop

# Claims about the loop of model and gains.
KINDS = {
    "decay": "kinds.decay.Decay",
    "no-common-decay": "kinds.no_common_decay.NoCommonDecay",
    "fuzzy-decay": "kinds.fuzzy_decay.FuzzyDecay",
    "fuzzy-l2-gain": "kinds.fuzzy_l2_gain.FuzzyEnergyGain",
    "region": "kinds.region.Region",
    "gain-rounding": "kinds.gain_rounding.GainRounding",
    "l2-gain": "kinds.l2_gain.EnergyGain",
    "h2-norm": "kinds.h2_norm.H2Norm",
    "exit-probability": "kinds.exit_probability.ExitProbability",
    "peak": "kinds.peak.Peak",
    "invariant-ellipsoid": "kinds.invariant_set.InvariantEllipsoid",
    "input-limits": "kinds.input_limits.InputLimits",
    "observer": "kinds.observer.Observer",
    "observed-feedback": "kinds.observer.ObservedFeedback",
    "observed-loop": "kinds.observed_loop.ObservedLoop",
    "transient": "kinds.transient.Transient",
    "sampled-loop": "kinds.sampled_loop.SampledLoop",
}
# Claims about a plant, which read model and gains in their own way.
PLANT_KINDS = {
    "effort-blend": "plant.effort_blend.EffortBlend",
    "sector-embedding": "plant.sector_embedding.SectorEmbedding",
    "secant-embedding": "plant.secant_embedding.SecantEmbedding",
    "tracking": "plant.tracking.Tracking",
    "slope-embedding": "plant.slope_embedding.SlopeEmbedding",
}
# Claims about a turbine's loop, which read the whole file and the verdicts on earlier claims.
TURBINE_KINDS = {
    "coherent-loop": "turbine.effort_sharing.loop_claim.EffortSharingLoop",
    "paper-loop": "turbine.published.loop_claim.PublishedLoop",
    "running-loop": "turbine.running_loop.running_claim.RunningLoop",
    "wind-rate": "turbine.effort_sharing.wind_rate.WindRate",
    "actuator-rates": "turbine.effort_sharing.actuator_rates.ActuatorRates",
}
READ = {*KINDS, *PLANT_KINDS, *TURBINE_KINDS}


def replay(
    claim: Any,
    data: Any,
    loop: PolytopicLoop | None,
    earlier: Sequence[Outcome],
    where: str,
    holds: Decider = decided_exactly,
) -> Outcome:
    """Return the verdict on one claim of a file.

    Parameters
    ----------
    data : the whole file; claims of ``KINDS`` do not need it, all others do.
    loop : the loop of model and gains; needed for claims of ``KINDS``.
    earlier : the verdicts on the claims before this one.
    holds : decides an obligation.

    Raises
    ------
    CertificateError : a kind that is not known, or a claim that is malformed.
    """
    kind = claim["kind"]
    if kind in KINDS and loop is not None:
        # A claim holds for the numbers of the plant, which lie between the ends of their bounds,
        # where it holds at all ends.
        loops = (loop, *loop.at_other_ends)
        claims = [class_of(kind).read(claim, at_ends, where) for at_ends in loops]
    elif kind in PLANT_KINDS and data is not None:
        claims = [class_of(kind).read(claim, data, where)]
    elif kind in TURBINE_KINDS and data is not None:
        claims = [class_of(kind).read(claim, data, earlier, where)]
    else:
        raise CertificateError(f"{where}.kind: {kind!r} is not one that this checker replays")
    for read in claims:
        if failure := read.failure(holds):
            return Claim(read.name, Verdict.UNDECIDED, failure, read.assumes)
    return Decided(claims[0])


def class_of(kind: str) -> Any:
    """Return the class of a kind of claims, e.g. ``kinds.decay.Decay`` for "decay"."""
    module, _, name = (KINDS | PLANT_KINDS | TURBINE_KINDS)[kind].rpartition(".")
    return getattr(import_module(f"takagi.certificates.checker.{module}"), name)
