r"""Refuses a gain file that replaces a premise where it is not 0/0, or by something else.

Near a point where a premise is 0/0 the program takes a polynomial, |of| <= within.  Model and law
do not determine it: it is in the certificate's member ``controller``.  So it is asked that

    within    is at most a tenth of the largest |of| on the box
    formula   differs from the premise by at most 1e-6 of its range (of its value where that is
              constant): everywhere on that interval, by an enclosure of the difference, where
              both have no other variable; else at its ends, where the premise itself has a value,
              with the other variables at their least, middle and greatest values

An ``of`` that is not a variable, and a formula with functions of programs alone, such as
``choose``, are compared by the first condition only.

A claim about the polynomial that the law's gains are in the states (``attraction-region``) holds
for no other weights: beside it no premise of gains that differ is replaced.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.interval import ONE, enclose, point
from takagi.certificates.checker.controller.decimals import exact
from takagi.certificates.checker.kernel.refusal import CertificateError, OtherGains, Refused
from takagi.certificates.checker.plant.evaluate import Box, Evaluator
from takagi.certificates.checker.plant.expression import read_expression
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes, read_plant

EXACT = "attraction-region"
SHARE, CLOSE = Fraction(1, 10), Fraction(1, 10**6)


def require_premises(
    model: Any, law: Any, controller: Mapping[str, Any], kinds: Collection[str] = ()
) -> None:
    """Refuse a replacement formula that does not agree with its premise.

    Parameters
    ----------
    kinds : of the certificate's claims.

    Raises
    ------
    OtherGains : ``within`` reaches too far, the formula has another value, or a claim of ``kinds``
        is about the premise alone.
    CertificateError : an entry is malformed.
    """
    replacements = controller.get("removable") or {}
    if not replacements or not isinstance(model, dict) or model.get("kind") != "plant":
        return
    try:
        _require_all(replacements, model, law)
        replaced = sorted({p["name"] for p in law.get("premises", ())} & set(replacements))
        if EXACT in kinds and replaced and any(gain != law["K"][0] for gain in law["K"]):
            raise OtherGains(
                f"controller.removable: {', '.join(replaced)} is replaced near a point, and the "
                f"claim {EXACT} is about the law without replacements"
            )
    except (AttributeError, LookupError, TypeError, ValueError, ArithmeticError) as error:
        if isinstance(error, CertificateError):
            raise
        raise CertificateError(
            "controller.removable: a list of replacements with 'of', 'within' and 'formula' is "
            f"needed for each premise ({type(error).__name__}: {error}); make the certificate "
            "again with 'takagi certify'"
        ) from error


def _require_all(replacements: Mapping[str, Any], model: Any, law: Any) -> None:
    plant = read_plant(model, "model")
    premises = {p["name"]: p for p in law.get("premises", ())}
    for name, entries in replacements.items():
        for entry in entries if name in premises else ():
            _require(plant, premises[name], entry, f"controller.removable.{name}")


def _require(plant: PlantNodes, premise: Any, entry: Any, where: str) -> None:
    graph, evaluator, within = plant.graph, plant.evaluator, exact(entry["within"])
    scope = plant.premise_scope
    of = read_expression(entry["of"], graph, scope, f"{where}.of")
    reach = evaluator.value(of, plant.box)
    if reach is None or within < 0 or within * ONE > SHARE * reach.magnitude():
        raise OtherGains(f"{where}.within: a tenth of the range of {entry['of']!a} at most")
    if graph[of].op != "variable":
        return
    try:
        formula = read_expression(entry["formula"], graph, scope, f"{where}.formula")
    except CertificateError:
        return
    node = read_expression(premise["expression"], graph, scope, f"{where}.expression")
    low, high = exact(premise["lower"]), exact(premise["upper"])
    tolerance = CLOSE * ((high - low) or abs(high))
    difference, name = graph.subtract(node, formula), graph[of].name
    refusal = f"{where}.formula: it is not the premise near {entry['of']} = 0"
    if graph.variables(difference) <= {name}:
        low, high = plant.sides.get(name, (-within, within))
        near = {**plant.box, name: enclose(max(low, -within), min(high, within))}
        signs = plant.form == "sector"
        ranges = Ranges(evaluator, Algebra(graph, plant.tables), near, signs=signs)
        try:
            ranges.prove_within(difference, -tolerance, tolerance, f"{where}.formula")
        except Refused as error:
            raise OtherGains(f"{refusal}, or not shown to be: {error}") from error
        return
    for box in _edges(plant, name, within):
        there, ours = (_value(evaluator, expression, box) for expression in (node, formula))
        if there is None or ours is None:
            continue
        apart = max(there.low - ours.high, ours.low - there.high)
        if apart > tolerance * ONE:
            raise OtherGains(refusal)


def _edges(plant: PlantNodes, name: str, within: Fraction) -> Iterator[Box]:
    """Yield the points at which premise and formula are compared."""
    for share in (Fraction(0), Fraction(1, 2), Fraction(1)):
        box = {v: point(low + share * (high - low)) for v, (low, high) in plant.sides.items()}
        for end in (-within, within):
            low, high = plant.sides.get(name, (end, end))
            if low <= end <= high:
                yield {**box, name: point(end)}


def _value(evaluator: Evaluator, node: int, box: Box) -> Any:
    try:
        return evaluator.value(node, box)
    except Refused:
        return None
