"""The trim of a law, u = u* - K (x - x*), compared with the equilibrium of its plant."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.interval import ONE, enclose
from takagi.certificates.checker.kernel.reader import member, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.plant.reading import PlantNodes, Variable

# A law's trim is written in decimals, an equilibrium may be irrational: they may differ by SLACK of
# the value, and by at most SHARE of the variable's range.
SLACK, SHARE = Fraction(1, 10**12), Fraction(1, 10**9)


def compared_trim(plant: PlantNodes, gains: Any, where: str = "gains") -> Fraction:
    """Return a bound of the distance from the law's trim to the plant's equilibrium; 0 if equal.

    Without a law (None) it is 0.

    An equilibrium value such as 5/18 or sin(1/2) is not a decimal.  A difference up to ``allowed``
    is no error, and the claim's sentence states it.

    Raises
    ------
    CertificateError : the law has no trim, or another one.
    """
    if gains is None:
        return Fraction(0)
    trim, evaluator = member(gains, "trim", where), plant.evaluator
    balls = {name: enclose(*ball.side) for name, ball in plant.balls.items()}
    largest = Fraction(0)
    for key, variables in (("state", plant.states), ("input", plant.inputs)):
        if not variables:
            continue
        trim_values = numbers(trim, key, f"{where}.trim", len(variables))
        for variable, stated in zip(variables, trim_values, strict=True):
            exact = plant.graph.value(variable.rest)
            if exact == stated:
                continue
            bracket = evaluator.value(variable.rest, balls)
            if bracket is None:
                raise CertificateError(f"the rest of {variable.name} has no value")
            low, high = (Fraction(end, ONE) for end in bracket)
            off = max(abs(stated - low), abs(stated - high))
            if off > allowed(variable, stated):
                raise CertificateError(f"{where}.trim: {_apart(variable.name, low, stated)}")
            largest = max(largest, off)
    return largest


def allowed(variable: Variable, stated: Fraction) -> Fraction:
    """Return how far a stated rest may be from the plant's: the same share in every unit.

    A rest of 0 has to be stated as 0.
    """
    of_value = SLACK * abs(stated)
    if variable.side is None:
        return of_value
    return min(of_value, SHARE * (variable.side[1] - variable.side[0]))


def _apart(name: str, rest: Fraction, stated: Fraction) -> str:
    # Imported here: the check ends here without a verdict.
    from takagi.certificates.checker.words.rounded import at_least

    both_values = f"{at_least(rest, 12)} in the plant, at {at_least(stated, 12)} in the law"
    return f"{name} rests at {both_values}"
