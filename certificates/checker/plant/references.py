"""The references of a certificate's plant: signals, integral states, following expressions.

The member ``references`` of the model lists signal, integral state xi, and the expression h that
follows:  xi' = h(x) - r.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from takagi.certificates.checker.kernel.reader import canonical, member, text
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.plant.expression import read_expression
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.reading import PlantNodes, Variable


@dataclass(frozen=True)
class Following:
    """One reference.

    ``column`` is the index of the signal among the disturbances, ``row`` that of xi among the
    states; ``follow`` is the node of h as stated in the member.
    """

    signal: Variable
    column: int
    row: int
    follow: int


def read_references(model: Any, plant: PlantNodes, where: str) -> list[Following]:
    """Return the references.

    Raises
    ------
    CertificateError : none, a name that is not there or is used twice, a signal without a range, or
        one that is an uncertain parameter.
    """
    listed = member(model, "references", where)
    if not listed or not isinstance(listed, list):
        raise CertificateError(f"{where}.references: a list is needed")
    signals = [v.name for v in plant.disturbances]
    states = [v.name for v in plant.states]
    references = []
    for k, entry in enumerate(listed):
        entry_place = f"{where}.references[{k}]"
        name, integral = text(entry, "reference", entry_place), text(entry, "integral", entry_place)
        if name not in signals or integral not in states:
            raise CertificateError(f"{entry_place}: a signal and a state of the model are needed")
        column, row = signals.index(name), states.index(integral)
        signal = plant.disturbances[column]
        if signal.side is None or signal.unknown:
            raise CertificateError(
                f"{entry_place}: the reference needs a range, and the law knows it"
            )
        written = member(entry, "follow", entry_place)
        node = read_expression(written, plant.graph, plant.scope, f"{entry_place}.follow")
        references.append(Following(signal, column, row, node))
    count = len(references)
    if len({f.column for f in references}) < count or len({f.row for f in references}) < count:
        raise CertificateError(f"{where}.references: each has a signal and an integral of its own")
    return references


def check_following(plant: PlantNodes, follow: list[Following], algebra: Algebra) -> None:
    """Prove xi' = h(x) - r with the h that is written, in states that are no integrals."""
    # In discrete time the row gives xi(t + T), and a mass matrix may add other rates to xi'.
    if plant.sample_time is not None or plant.mass is not None:
        raise Refused("an integral xi' = h - r is of x' = f, without a mass matrix")
    g = plant.graph
    integrals = {f.row for f in follow}
    measured = {v.symbol for i, v in enumerate(plant.states) if i not in integrals}
    for f in follow:
        if not g.variables(f.follow) <= measured:
            raise Refused(f"what follows {f.signal.name} depends on more than the plant's states")
        if not algebra.equal(plant.f[f.row], g.subtract(f.follow, plant.value_of(f.signal))):
            raise Refused(f"the integral of {f.signal.name} is not that of h - r")
        for i, row in enumerate(plant.entries["E"]):
            if g.value(row[f.column]) != (-1 if i == f.row else 0):
                raise Refused(f"{f.signal.name} is in other equations than that of its integral")
    inner = {plant.states[k].symbol for k in integrals}
    for i, node in enumerate(plant.f):
        if i not in integrals and inner & g.variables(node):
            raise Refused("the plant depends on an integral")


def check_followed(model: Any, plant: PlantNodes, gains: Any, algebra: Algebra) -> None:
    """Refuse a law whose integrals are not states of the model.

    A law with references computes its integral states.  Every claim about the loop needs them to be
    those of the model, also where nothing is claimed of the references.

    Raises
    ------
    CertificateError : the model has other references, or none.
    Refused : an integral of the model is another.
    """
    if canonical(model.get("references")) != canonical(gains["references"]):
        raise CertificateError("gains.references are not the model's: the law follows others")
    check_following(plant, read_references(model, plant, "model"), algebra)
