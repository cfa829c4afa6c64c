"""The loop that the model and the gains of a certificate make, by the kind of model."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.loop.stated_matrices import closed_by, vertices


def read_model_loop(model: Any, gains: Any, where: str = "model") -> PolytopicLoop:
    """Return the loop of a certificate's ``model`` and ``gains``, every number as written.

    Raises
    ------
    CertificateError : a kind that is not known, shapes that do not fit, gains of another model.
    """
    kind = reader.member(model, "kind", where)
    if kind == "takagi-sugeno":
        plain = vertices(model, where)
    elif kind == "plant":
        # Imported here: matrices alone need nothing of what is known about plants.
        from takagi.certificates.checker.plant.sector_embedding import plant_loop

        plain = plant_loop(model, where)
    else:
        raise CertificateError(f"{where}.kind: {kind!a} has no vertices for this claim")
    if gains is None:
        return plain
    at_other_ends = tuple(_closed(loop, model, gains) for loop in plain.at_other_ends)
    return replace(_closed(plain, model, gains), at_other_ends=at_other_ends)


def _closed(plain: PolytopicLoop, model: Any, gains: Any) -> PolytopicLoop:
    loop = closed_by(plain, gains, "gains")
    if "observer" not in gains:
        return loop
    # Imported here: most laws have the states, and no observer.
    from takagi.certificates.checker.loop.observer_law import observed_by

    return observed_by(loop, model, gains)
