"""Numbers of a plant that are not decimals: a decimal next to each, and how far it is at most."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.plant.plant import Plant

DIGITS = 13  # of the number that its ball settles
PRECISION = 60  # decimals worked with


@dataclass(frozen=True, slots=True)
class Ball:
    """A number within ``radius`` of the decimal ``middle``, under the name ``symbol``.

    ``equals`` is the expression without symbols that it is; None for a rest that was solved for.
    """

    symbol: sp.Symbol
    middle: Fraction
    radius: Fraction
    equals: sp.Expr | None = None

    @property
    def side(self) -> Interval:
        return Interval(self.middle - self.radius, self.middle + self.radius)


def decimal_near(value: sp.Expr | Fraction) -> tuple[Fraction, Fraction]:
    """Return the decimal that the nearest float prints, and a radius that settles 13 digits.

    Raises
    ------
    ModelError : no finite real number, or 0.
    """
    import sympy as sp

    if isinstance(value, Fraction):
        nearest = float(value)
    else:
        number = sp.N(value, PRECISION)
        if not (number.is_real and number.is_finite):
            raise ModelError(f"{value} is no finite real number")
        nearest = float(number)
    middle = Fraction(repr(nearest))
    if middle == 0:
        raise ModelError(f"{value} is too small to stand apart from 0")
    power = int(f"{float(middle):e}".partition("e")[2]) - DIGITS
    return middle, Fraction(10) ** power


def balls_of(plant: Plant) -> dict[sp.Symbol, Ball]:
    """Return variable or parameter -> its ball; a rest of x has the name ``x_rest``.

    Raises
    ------
    ModelError : a name that is taken.
    """
    import sympy as sp

    balls = {
        p.symbol: Ball(p.symbol, p.value, p.within, p.equals)
        for p in plant.parameters
        if p.within > 0
    }
    names = {v.name for v in plant.variables} | {p.symbol.name for p in plant.parameters}
    names |= {s.name for s in plant.premises}
    for variable in plant.variables:
        if variable.within == 0:
            continue
        name = f"{variable.name}_rest"
        if name in names:
            raise ModelError(
                f"plant {plant.name!r}: the rest of {variable.name} is called {name}, which is "
                "another name of the plant; rename that one"
            )
        symbol = sp.Symbol(name, real=True)
        balls[variable.symbol] = Ball(symbol, variable.rest, variable.within, variable.equals)
    return balls
