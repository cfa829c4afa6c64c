r"""Refuses a gain file that replaces a premise where it is not 0/0, or by something else.

Near a point where a premise is 0/0 the program takes a polynomial, |of| <= within.  Model and law
do not determine it: it is in the certificate's member ``controller``.  So it is asked that

    within    is at most a tenth of the largest |of| on the box
    formula   differs from the premise by at most 1e-6 of its range (of its value where that is
              constant), everywhere with |of| <= within

The second is proved by Taylor's formula in t = ``of``, a variable or a sum of variables.  The
difference is a mean of values T(s t, y), 0 <= s <= 1 (``plant.quotient_form``), and with
T = T_0(y) + T_1(y) t + ... + R_m(t, y) t^m

    |T(t, y)| <= |T_0| + |T_1| within + ... + |R_m| within^m.

Exact algebra shows that T_j is 0, or it has a proved bound; R_m has one.  The two formulas of
``choose(of, a, b)`` are compared on one side of t = 0 each, where |t| is -t and t.

A claim about the polynomial that the law's gains are in the states (``attraction-region``) holds
for no other weights: beside it no premise of gains that differ is replaced.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.interval import ONE, enclose
from takagi.certificates.checker.controller.decimals import exact
from takagi.certificates.checker.kernel.reader import text
from takagi.certificates.checker.kernel.refusal import CertificateError, OtherGains, Refused
from takagi.certificates.checker.plant.derivative import derivative, rebuilt, substituted
from takagi.certificates.checker.plant.expression import read_expression
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.linear_sum import Ends, linear_sum, with_variable
from takagi.certificates.checker.plant.quotient_form import Form, with_signs
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes, read_plant

EXACT = "attraction-region"
SHARE, CLOSE = Fraction(1, 10), Fraction(1, 10**6)
TERMS = 8  # of Taylor's formula, beside its remainder
CHOICE = "choose("


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
    graph, within, scope = plant.graph, exact(entry["within"]), plant.premise_scope
    of = read_expression(entry["of"], graph, scope, f"{where}.of")
    reach = plant.evaluator.value(of, plant.box)
    if reach is None or within < 0 or within * ONE > SHARE * reach.magnitude():
        raise OtherGains(f"{where}.within: a tenth of the range of {entry['of']!a} at most")
    t = linear_sum(graph, of)
    if t is None or not t.factors or t.constant:
        raise OtherGains(f"{where}.of: a sum of multiples of variables is needed")
    node = read_expression(premise["expression"], graph, scope, f"{where}.expression")
    low, high = exact(premise["lower"]), exact(premise["upper"])
    tolerance = CLOSE * ((high - low) or abs(high))
    for sign, written in _sides(entry["formula"], entry["of"], where):
        formula = read_expression(written, graph, scope, f"{where}.formula")
        difference = graph.subtract(node, formula)
        start, end = (Fraction(0) if sign > 0 else -within), (Fraction(0) if sign < 0 else within)
        name, factor = t.factors[0]
        if len(t.factors) > 1:
            name, factor = t.name(1), Fraction(1)
            difference = with_variable(graph, difference, t, graph.variable(name))
        start, end = sorted((start / factor, end / factor))
        least, greatest = plant.sides.get(name, (start, end))
        start, end = max(start, least), min(end, greatest)
        if start > end:
            continue
        if sign:
            difference = _one_sided(graph, difference, name, positive=sign * factor > 0)
        try:
            _prove_close(plant, difference, name, (start, end), tolerance)
        except Refused as error:
            refusal = f"{where}.formula: it is not the premise near {entry['of']} = 0"
            raise OtherGains(f"{refusal}, or not shown to be: {error}") from error


def _sides(formula: Any, of: str, where: str) -> list[tuple[int, str]]:
    """Return the formula for both signs of t, (0, text), or (-1, text), (1, text) of a choice."""
    written = text({"formula": formula}, "formula", where)
    if not written.startswith(CHOICE):
        return [(0, written)]
    arguments, depth = [""], 0
    for sign in written.removeprefix(CHOICE).removesuffix(")"):
        depth += (sign == "(") - (sign == ")")
        if sign == "," and depth == 0:
            arguments.append("")
        else:
            arguments[-1] += sign
    if len(arguments) != 3 or arguments[0].strip() != of:
        raise CertificateError(f"{where}.formula: choose({of}, a, b) is needed")
    return [(-1, arguments[1]), (1, arguments[2])]


def _one_sided(graph: Graph, root: int, name: str, *, positive: bool) -> int:
    """Return the node on one side of x = 0: sign(x) is 1 or -1 there, and |x| is x or -x."""
    variable, unit = graph.variable(name), graph.constant(1 if positive else -1)
    root = with_signs(graph, root)
    sign, size = graph.sign(variable), graph.call("abs", variable)
    on_side = {sign: unit, size: graph.multiply(unit, variable)}
    replaced: dict[int, int] = {}
    for number in graph.below([root]):
        operands = tuple(replaced[operand] for operand in graph[number].operands)
        replaced[number] = on_side.get(number, rebuilt(graph, number, operands))
    return replaced[root]


def _prove_close(
    plant: PlantNodes, difference: int, name: str, side: Ends, tolerance: Fraction
) -> None:
    """Prove |difference| <= tolerance where the variable of this name is in ``side``.

    Raises
    ------
    Refused : it is not shown.
    """
    graph, algebra, evaluator = plant.graph, Algebra(plant.graph, plant.tables), plant.evaluator
    near = {**plant.box, name: enclose(*side)}
    ranges = Ranges(evaluator, algebra, near, signs=plant.form == "sector")
    form: Form | None = ranges.form(difference, "the difference")
    if form is not None and name in form.poles:
        form = form.continued(name)
    if form is None:
        raise Refused(f"the difference has no limit at {name} = 0 that this checker can show")
    within, power = max(-side[0], side[1]), Fraction(1)
    for order in range(TERMS):
        remainder = form.value(ranges.box)
        if remainder is not None and power * remainder.magnitude() <= tolerance * ONE:
            return
        try:
            slope = derivative(graph, form.top, name)
        except Refused:
            break
        at_zero = substituted(graph, form.top, {name: graph.constant(0)})
        if not algebra.vanishes(at_zero):
            term = Form(evaluator, algebra, at_zero, form.poles)
            size = term.value(ranges.box)
            share = None if size is None else power * size.magnitude() / ONE
            if share is None or share > tolerance:
                share = tolerance / 2
                bound = share / power
                ranges.prove_within(term.direct, -bound, bound, f"term {order} at 0")
            tolerance -= share
        slope = graph.multiply(graph.constant(Fraction(1, order + 1)), slope)
        form = Form(evaluator, algebra, slope, form.poles)
        power *= within or 1
    bound = tolerance / power
    ranges.prove_within(form.direct, -bound, bound, "the difference")
