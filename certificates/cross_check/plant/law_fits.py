"""Whether a law fits the plant: its gains go with what it knows, its integrals are states.

A rule is a corner of premises.  A law cannot compute the weights of premises with a hidden signal.
If all rules with the same corners of the other premises have one gain, these weights cancel in the
sum of weights times gains.
"""

from __future__ import annotations

from itertools import product
from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.exact import Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import Refusal, entry, line, stack
from takagi.certificates.cross_check.plant.algebra import Algebra, identical
from takagi.certificates.cross_check.plant.expression import (
    Tree,
    minus,
    names_in,
    parsed,
    plus,
    put,
    value_of,
)
from takagi.certificates.cross_check.plant.plant import TreePlant, Variable


def goes_with_known(plant: TreePlant, hidden: set[str], gains: Any) -> bool:
    """Return whether rules that differ only in premises with a hidden symbol have equal gains.

    Raises
    ------
    Refusal : another number of gains than of rules.
    """
    K = stack(gains, "K")
    if len(K) == 1:
        return True
    seen = [not hidden & set(names_in(p.tree)) for p in plant.premises]
    corners = list(product(*(range(1 + (p.lower < p.upper)) for p in plant.premises)))
    if len(K) != len(corners):
        raise Refusal(f"K: {len(corners)} gains are needed")
    first: dict[tuple[int, ...], Any] = {}
    for corner, gain in zip(corners, K, strict=True):
        key = tuple(c for c, known in zip(corner, seen, strict=True) if known)
        if first.setdefault(key, gain) != gain:
            return False
    return True


def followed(model: Any, plant: TreePlant, gains: Any) -> Obligations:
    """Yield that the integrals which a law computes are states of the model."""
    if entry(gains, "references") != model.get("references"):
        raise Refusal("the law has other references than the model")
    yield from integrals(plant, references_of(model, plant))


def references_of(model: Any, plant: TreePlant) -> list[tuple[Variable, int, Tree]]:
    """Return signal, index of the integral state, and following expression of each reference."""
    named = entry(model, "references")
    if not named or not isinstance(named, list):
        raise Refusal("references: a list is needed")
    by_name = {v.name: v for v in plant.pushes}
    places = {v.name: k for k, v in enumerate(plant.states)}
    meaning: dict[str, Tree] = {v.name: plus(v.rest, ("name", v.symbol)) for v in plant.variables}
    for name, value in model.get("parameters", {}).items():
        meaning[name] = parsed(value)
    found = []
    for one in named:
        name, integral = line(one, "reference"), line(one, "integral")
        if name not in by_name or integral not in places:
            raise Refusal("references: a signal and a state are needed")
        if by_name[name].side is None or by_name[name].unknown:
            raise Refusal("references: a known signal with a range is needed")
        tree = parsed(entry(one, "follow"))
        if set(names_in(tree)) - set(meaning) - {"pi"}:
            raise Refusal("references: a name that is not known")
        found.append((by_name[name], places[integral], put(tree, meaning)))
    if len({v.name for v, _, _ in found}) < len(found) or len({k for _, k, _ in found}) < len(
        found
    ):
        raise Refusal("references: each has its own signal and integral")
    return found


def integrals(plant: TreePlant, follow: list[tuple[Variable, int, Tree]]) -> Obligations:
    """Yield that each xi' is h - r, and that no other equation has xi or r."""
    # Else the rows of f are not the rates of the integrals.
    plain = plant.step is None and plant.mass is None
    yield Fact("integrals are in continuous time, without a mass matrix", plain)
    box = {v.symbol: v.side for v in plant.variables}
    rows = {row for _, row, _ in follow}
    inner = {plant.states[row].symbol for row in rows}
    allowed = {v.symbol for v in plant.states} - inner
    differences = [
        plus(plant.f[row], plus(minus(h), plus(v.rest, ("name", v.symbol)))) for v, row, h in follow
    ]
    algebra = Algebra(differences)
    for (v, row, h), tree in zip(follow, differences, strict=True):
        yield Fact("what follows is known to the law", set(names_in(h)) <= allowed)
        yield Fact("an integral of h - r", identical(algebra, tree, box, "an integral"))
        column = plant.pushes.index(v)
        pushed = [value_of(line_[column]) for line_ in plant.entries["E"]]
        wanted = [fmpq(-1 if k == row else 0) for k in range(len(pushed))]
        yield Fact("a reference is in one equation", pushed == wanted)
    alone = all(not inner & set(names_in(f)) for k, f in enumerate(plant.f) if k not in rows)
    yield Fact("integrals are in no equation of the plant", alone)
