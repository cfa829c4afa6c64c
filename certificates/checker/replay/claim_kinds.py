"""Which function replays which kind of claim.

Modules are listed by name and imported only when a certificate has such a claim. So a verdict loads
only the code that it needs.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Outcome, Verdict

if TYPE_CHECKING:
    from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop

# Claims about the loop of model and gains.
KINDS = {
    "decay": "kinds.decay.check_decay",
    "no-common-decay": "kinds.no_common_decay.check_no_common_decay",
    "fuzzy-decay": "kinds.fuzzy_decay.check_fuzzy_decay",
    "fuzzy-l2-gain": "kinds.fuzzy_l2_gain.check_fuzzy_l2_gain",
    "region": "kinds.region.check_region",
    "gain-rounding": "kinds.gain_rounding.check_gain_rounding",
    "l2-gain": "kinds.l2_gain.check_l2_gain",
    "h2-norm": "kinds.h2_norm.check_h2_norm",
    "exit-probability": "kinds.exit_probability.check_exit_probability",
    "peak": "kinds.peak.check_peak",
    "invariant-ellipsoid": "kinds.invariant_ellipsoid.check_invariant_ellipsoid",
    "input-limits": "kinds.input_limits.check_input_limits",
    "observer": "kinds.observer.check_observer",
    "observed-feedback": "kinds.observer.check_observed_feedback",
    "observed-loop": "kinds.observed_loop.check_observed_loop",
    "transient": "kinds.transient.check_transient",
    "sampled-loop": "kinds.sampled_loop.check_sampled_loop",
}
# Claims that something does not exist.
AGAINST = {"no-common-decay"}
# Claims that read model and gains in their own way.
OWN_READING = {
    "coherent-loop": "turbine.effort_sharing.loop_claim.check_effort_sharing",
    "paper-loop": "turbine.published.loop_claim.check_published",
    "effort-blend": "plant.effort_blend.check_effort_blend",
    "sector-embedding": "plant.sector_embedding.check_embedding",
    "secant-embedding": "plant.secant_embedding.check_secant_embedding",
    "tracking": "plant.tracking.check_tracking",
    "slope-embedding": "plant.slope_embedding.check_slope_embedding",
}
# Claims that also read the file's member ``controller``: they get the whole file.
WHOLE_FILE = {
    "running-loop": "turbine.running_loop.running_claim.check_running_loop",
}
# Claims that depend on an earlier claim: they get the whole file and the earlier verdicts.
RESTING = {
    "wind-rate": "turbine.effort_sharing.wind_rate.check_wind_rate",
    "actuator-rates": "turbine.effort_sharing.actuator_rates.check_actuator_rates",
}

READ = {*KINDS, *OWN_READING, *WHOLE_FILE, *RESTING}


def replay(
    claim: Any, data: Any, loop: PolytopicLoop | None, found: list[Outcome], where: str
) -> Outcome:
    """Return the verdict on one claim of a file.

    Parameters
    ----------
    data : the whole file; claims of ``KINDS`` do not need it, all others do.
    loop : the loop of model and gains; needed for claims of ``KINDS``.
    found : the verdicts on the claims before this one.

    Raises
    ------
    CertificateError : a kind that is not known, or a claim that is malformed.
    """
    kind = claim["kind"]
    if kind in RESTING and data is not None:
        place, given = RESTING[kind], [data, found]
    elif kind in WHOLE_FILE and data is not None:
        place, given = WHOLE_FILE[kind], [data]
    elif kind in OWN_READING and data is not None:
        place, given = OWN_READING[kind], [data["model"], data.get("gains")]
    elif kind in KINDS and loop is not None:
        place, given = KINDS[kind], [loop]
        if loop.at_other_ends and kind in AGAINST:
            why = "a loop with numbers that are no fractions: tried at their ends alone"
            return Claim(claim["name"], Verdict.UNDECIDED, f"not shown: {why}")
    else:
        raise CertificateError(f"{where}.kind: {kind!r} is not one that this checker replays")
    module, _, name = place.rpartition(".")
    function = getattr(import_module(f"takagi.certificates.checker.{module}"), name)
    outcome: Outcome = function(claim, *given, where)
    for other in loop.at_other_ends if kind in KINDS and loop is not None else ():
        if outcome.verdict is Verdict.PROVED:
            shown: Outcome = function(claim, other, where)
            outcome = outcome if shown.verdict is Verdict.PROVED else shown
    if module.startswith("turbine."):
        # Imported here: other claims need no list of their members.
        from takagi.certificates.checker.turbine.members import refuse_unread

        listed = f"takagi.certificates.checker.{module.rpartition('.')[0]}.members"
        refuse_unread(import_module(listed).OF, claim, data, where)
    return outcome
