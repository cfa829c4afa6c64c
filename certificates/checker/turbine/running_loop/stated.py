"""The loop that a claim about the loop as it runs states: plant, law, observer and filters."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.reader import member
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop.inputs import (
    Machine,
    other_than_the_controller,
)

MOST_CELLS = 500


def stated_loop(claim: Any, data: Any, where: str) -> tuple[Plant, Law, Machine]:
    """Return plant, law, and observer and filters of a claim; ``data`` is the whole file.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be; also an observer or filters
        that are not those of the certificate's ``controller``.
    """
    model, gains = member(data, "model", "certificate"), member(data, "gains", "certificate")
    plant, law = Plant.read(model), Law.read(gains)
    if (plant.pitch_min, plant.pitch_max) != (law.pitch_min, law.pitch_max):
        raise CertificateError("gains: pitch limits differ from the model's")
    machine = Machine.read(claim, model, gains, where)
    if other := other_than_the_controller(claim, data, where):
        raise CertificateError(f"{where}.{other}")
    return plant, law, machine
