"""The registry of the kinds of claims, and the verdict on one claim.

A kind is a class of its name in a file of its name (``class_of``), which is imported only when a
certificate has such a claim. So a verdict loads only the code that it needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.obligation import Decider, decided_exactly
from takagi.certificates.checker.kernel.refusal import CertificateError

if TYPE_CHECKING:
    from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop

# Claims about the loop of model and gains, each in a file of ``kinds/``.
KINDS = (
    "decay no-common-decay fuzzy-decay fuzzy-l2-gain region gain-rounding l2-gain h2-norm "
    "exit-probability peak invariant-ellipsoid input-limits observer observed-feedback "
    "observed-loop transient sampled-loop"
).split()
# Claims about a plant, which read model and gains in their own way, each in a file of ``plant/``.
PLANT_KINDS = (
    "effort-blend sector-embedding secant-embedding tracking slope-embedding attraction-region"
).split()
# Claims about a conic problem, which no loop is behind, each in a file of ``problem/``.
PROBLEM_KINDS = "feasible-point optimum-bound no-solution unbounded".split()
# Claims about a turbine's loop, which read the whole file and the verdicts on earlier claims.
TURBINE_KINDS = {
    "coherent-loop": "turbine.effort_sharing.loop_claim.EffortSharingLoop",
    "paper-loop": "turbine.published.loop_claim.PublishedLoop",
    "running-loop": "turbine.running_loop.running_claim.RunningLoop",
    "wind-rate": "turbine.effort_sharing.wind_rate.WindRate",
    "set-points": "turbine.effort_sharing.set_points.SetPoints",
    "bumpless": "turbine.effort_sharing.bumpless.Bumpless",
}
READ = {*KINDS, *PLANT_KINDS, *PROBLEM_KINDS, *TURBINE_KINDS}


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
    elif kind in (*PLANT_KINDS, *PROBLEM_KINDS) and data is not None:
        claims = [class_of(kind).read(claim, data, where)]
    elif kind == "bumpless" and data is not None:
        # Imported here: no other kind is about three sorts of loops.
        from takagi.certificates.checker.replay.bumpless_of import read_bumpless

        claims = [read_bumpless(claim, data, earlier, where)]
    elif kind in TURBINE_KINDS and data is not None:
        claims = [class_of(kind).read(claim, data, earlier, where)]
    else:
        raise CertificateError(f"{where}.kind: {kind!r} is not one that this checker replays")
    outcomes = (Outcome(read, read.failure(holds)) for read in claims)
    return next((outcome for outcome in outcomes if outcome.failure), Outcome(claims[0]))


def class_of(kind: str) -> Any:
    """Return the class of a kind of claims: of "l2-gain" it is ``kinds.l2_gain.L2Gain``."""
    path = TURBINE_KINDS.get(kind)
    if path is None:
        room = "plant" if kind in PLANT_KINDS else "problem" if kind in PROBLEM_KINDS else "kinds"
        path = f"{room}.{kind.replace('-', '_')}.{kind.title().replace('-', '')}"
    module, _, name = path.rpartition(".")
    return getattr(import_module(f"takagi.certificates.checker.{module}"), name)
