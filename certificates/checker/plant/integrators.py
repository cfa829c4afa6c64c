"""The states of a controller that has some of its own: integrators beside the plant.

A controller x_c' = A_c x_c + B_c (y - y*), u = u* - C_c x_c - D_c (y - y*) is a law of all states
of the plant with the integrators x_c' = v, and inputs (u, v); in discrete time x_c(t + T) = v.
The member ``integrators`` of model and law lists each x_c as ``state`` and its v as ``rate``.

Claims are about that plant.  They are about the file's plant under the law's program, which keeps
x_c and computes v, if and only if nothing else has x_c or v in it.
"""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.reader import canonical, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.plant.reading import PlantNodes, read_plant

MEMBER = "integrators"


def integrators_of(model: Any, gains: Any) -> dict[str, str]:
    """Return state -> rate of the law's integrators; {} where model and law have none.

    Raises
    ------
    CertificateError : model and law do not list the same, or what they list is malformed.
    """
    listed, of_law = (
        owner.get(MEMBER) if isinstance(owner, dict) else None for owner in (model, gains)
    )
    if canonical(listed) != canonical(of_law):
        raise CertificateError(f"gains.{MEMBER} are not the model's: the law has other states")
    if listed is None:
        return {}
    if not isinstance(listed, list) or not listed:
        raise CertificateError(f"model.{MEMBER}: a list is needed")
    pairs = []
    for k, entry in enumerate(listed):
        where = f"model.{MEMBER}[{k}]"
        if not isinstance(entry, dict):
            raise CertificateError(f"{where}: an object is needed")
        pairs += [text(entry, "state", where), text(entry, "rate", where)]
    if len(set(pairs)) < len(pairs):
        raise CertificateError(f"model.{MEMBER}: each has a state and a rate of its own")
    return dict(zip(pairs[::2], pairs[1::2], strict=True))


def require_integrators(model: Any, gains: Any) -> None:
    """Refuse a law with states of its own that are no integrators beside the model's plant.

    A law without them, of a model that has some, is one of all states of that model.

    Raises
    ------
    CertificateError : the equation of one is not x_c' = v, something else has x_c or v in it, or
        the law has an observer, a blend or references as well.
    """
    integrators = integrators_of(model, gains)
    if not integrators:
        return
    if others := {"observer", "blending", "references"} & {*gains, *model}:
        raise CertificateError(f"gains.{MEMBER}: a law with them has no {min(others)}")
    plant = read_plant(model, "model")
    states, inputs = ({v.name: v for v in group} for group in (plant.states, plant.inputs))
    if not integrators.keys() <= states.keys() or not {*integrators.values()} <= inputs.keys():
        raise CertificateError(f"model.{MEMBER}: states and inputs of the model are needed")
    rows = {list(states).index(name): rate for name, rate in integrators.items()}
    for row, rate in rows.items():
        if plant.f[row] != plant.value_of(inputs[rate]):
            raise CertificateError(f"model.equations[{row}] is not that of an integrator of {rate}")
    symbols = {states[name].symbol for name in integrators}
    symbols |= {inputs[rate].symbol for rate in integrators.values()}
    elsewhere = [node for row, node in enumerate(plant.f) if row not in rows]
    elsewhere += [*plant.outputs, *_masses(plant, rows)]
    if any(symbols & plant.graph.variables(node) for node in elsewhere):
        raise CertificateError(f"model: the plant depends on {MEMBER}, which the law has alone")


def _masses(plant: PlantNodes, rows: dict[int, str]) -> list[int]:
    """Return the entries of the mass matrix; refuses rows and columns that are no identity's."""
    entries = []
    for i, row in enumerate(plant.mass or []):
        for j, entry in enumerate(row):
            if {i, j} & rows.keys() and plant.graph.value(entry) != (1 if i == j else 0):
                raise CertificateError(f"model.mass: an entry beside 1 of {MEMBER}")
            entries.append(entry)
    return entries
