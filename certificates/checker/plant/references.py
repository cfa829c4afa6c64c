"""The references of a certificate's plant: signals, integral states, following expressions.

The member ``references`` of the model lists signal, integral state xi, and the expression h that
follows:  xi' = h(x) - r.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from takagi.certificates.checker.kernel.reader import member, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.plant.blend import names_of
from takagi.certificates.checker.plant.expression import Scope, read_expression
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
    names = names_of(model, plant)
    tables = {name: table.arguments for name, table in plant.tables.items()}
    found = []
    for k, entry in enumerate(listed):
        place = f"{where}.references[{k}]"
        name, integral = text(entry, "reference", place), text(entry, "integral", place)
        if name not in signals or integral not in states:
            raise CertificateError(f"{place}: a signal and a state of the model are needed")
        column, row = signals.index(name), states.index(integral)
        signal = plant.disturbances[column]
        if signal.side is None or signal.unknown:
            raise CertificateError(f"{place}: the reference needs a range, and the law knows it")
        written = member(entry, "follow", place)
        node = read_expression(written, plant.graph, Scope(names, tables), f"{place}.follow")
        found.append(Following(signal, column, row, node))
    if len({f.column for f in found}) < len(found) or len({f.row for f in found}) < len(found):
        raise CertificateError(f"{where}.references: each has a signal and an integral of its own")
    return found
