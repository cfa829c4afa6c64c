"""What a claim ``bumpless`` is about: a plant, or the loop of one of a turbine's two laws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from takagi.certificates.checker.kernel.claim_kind import ClaimKind, Outcome


def read_bumpless(claim: Any, data: Any, earlier: Sequence[Outcome], where: str) -> ClaimKind:
    """Return the claim, of the class that model and law decide.

    Raises
    ------
    CertificateError : the claim, the model or the law is malformed.
    """
    # Each is imported here: a file needs one of them.
    model, gains = data.get("model"), data.get("gains")
    if isinstance(model, dict) and model.get("kind") == "plant":
        from takagi.certificates.checker.plant.bumpless import PlantBumpless

        return PlantBumpless.read(claim, data, where)
    if isinstance(gains, dict) and gains.get("name") == "paper":
        from takagi.certificates.checker.turbine.published.bumpless import PublishedBumpless

        return PublishedBumpless.read(claim, data, earlier, where)
    from takagi.certificates.checker.turbine.effort_sharing.bumpless import Bumpless

    return Bumpless.read(claim, data, earlier, where)
