"""What the claims about the loop that runs state alike: the loop, and functions at winds."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.reader import listed, matrix, member, number
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop.inputs import (
    Machine,
    other_than_the_controller,
)
from takagi.certificates.checker.turbine.running_loop.signals import Rows

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


def stated_functions(claim: Any, order: int, where: str) -> dict[Fraction, Rows]:
    """Return P by its wind; refuses a wind that stands twice and a P of another size."""
    found: dict[Fraction, Rows] = {}
    for i, stated in enumerate(listed(claim, "functions", where, 2, 2 * MOST_CELLS)):
        place = f"{where}.functions[{i}]"
        wind, P = number(stated, "wind", place), matrix(stated, "P", place)
        if len(P) != order or len(P[0]) != order:
            raise CertificateError(f"{place}.P: {order} rows of {order} numbers are needed")
        if wind in found:
            raise CertificateError(f"{place}.wind: two functions at one wind")
        found[wind] = P
    return found
