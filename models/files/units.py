"""Units as text -> dimensions and an exact factor to SI; the units that a turbine file may use.

The list is closed on purpose.  A reader of all units there are (pint 0.25 was tried) takes ``Nm``
for "number metre" and ``rads`` for centigray, and so gives a typing error a wrong meaning instead
of a message.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import lru_cache
from math import isfinite, lcm, pi

from takagi.models.errors import ModelError, did_you_mean

LEAST_DECIMALS, PI_DIGITS = 12, 10  # least decimals, and digits, of a figure converted with pi
ROOT_DIGITS = 15  # of a figure converted by a factor with a root, such as bar^0.5
# Enough for 12 decimals of figures up to 1e30.
PI = Fraction("3.14159265358979323846264338327950288419716939937510")
MAX_POWER = 12
BASE = ("kg", "m", "s", "A", "K", "mol", "cd")


@dataclass(frozen=True, slots=True)
class Dimension:
    """Exponents of kg, m, s, A, K, mol, cd."""

    exponents: tuple[Fraction, ...]

    def times(self, other: Dimension) -> Dimension:
        """Return the dimension of a product."""
        pairs = zip(self.exponents, other.exponents, strict=True)
        return Dimension(tuple(a + b for a, b in pairs))

    def power(self, exponent: Fraction) -> Dimension:
        """Return the dimension of a power."""
        return Dimension(tuple(exponent * a for a in self.exponents))

    def __str__(self) -> str:
        """Return e.g. ``"kg m/s^2"``; ``"-"`` for a pure number."""
        return _written(zip(BASE, self.exponents, strict=True))


PURE = Dimension((Fraction(0),) * len(BASE))


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as written: value in SI = value * factor * pi^pi_power, in ``si``.

    ``rounded`` : the factor is a root that is no fraction, to 50 digits.
    """

    text: str
    si: str
    dimension: Dimension
    factor: Fraction
    pi_power: int
    rounded: bool = False

    @property
    def is_si(self) -> bool:
        """Whether a figure in this unit needs no conversion."""
        return self.factor == 1 and self.pi_power == 0

    def to_si(self, value: Fraction) -> Fraction:
        """Return the value in SI: exact, or to 12 decimals with pi, to 15 digits with a root."""
        converted = value * self.factor
        if self.rounded and self.pi_power == 0:
            return Fraction(
                f"{Decimal(converted.numerator) / converted.denominator:.{ROOT_DIGITS - 1}e}"
            )
        if self.pi_power == 0:
            return converted
        converted *= PI**self.pi_power
        decimals = LEAST_DECIMALS
        while 0 < abs(converted) * 10**decimals < 10 ** (PI_DIGITS - 1):
            decimals += 1
        return round(converted, decimals)


def _base(**exponents: int) -> Dimension:
    return Dimension(tuple(Fraction(exponents.get(name, 0)) for name in BASE))


# Coherent units, each with its own name in SI; rad is a pure number that keeps its name.
_COHERENT = {
    "kg": _base(kg=1),
    "m": _base(m=1),
    "s": _base(s=1),
    "A": _base(A=1),
    "K": _base(K=1),
    "mol": _base(mol=1),
    "cd": _base(cd=1),
    "rad": PURE,
    "N": _base(kg=1, m=1, s=-2),
    "Pa": _base(kg=1, m=-1, s=-2),
    "J": _base(kg=1, m=2, s=-2),
    "W": _base(kg=1, m=2, s=-3),
    "C": _base(A=1, s=1),
    "V": _base(kg=1, m=2, s=-3, A=-1),
    "Ohm": _base(kg=1, m=2, s=-3, A=-2),
    "S": _base(kg=-1, m=-2, s=3, A=2),
    "F": _base(kg=-1, m=-2, s=4, A=2),
    "Wb": _base(kg=1, m=2, s=-2, A=-1),
    "H": _base(kg=1, m=2, s=-2, A=-2),
    "T": _base(kg=1, s=-2, A=-1),
}
# Name -> factor, power of pi, and what it stands for in coherent units.
_DERIVED_UNITS: dict[str, tuple[Fraction, int, dict[str, int]]] = {
    "g": (Fraction(1, 1000), 0, {"kg": 1}),
    "t": (Fraction(1000), 0, {"kg": 1}),
    "L": (Fraction(1, 1000), 0, {"m": 3}),
    "bar": (Fraction(10**5), 0, {"Pa": 1}),
    "min": (Fraction(60), 0, {"s": 1}),
    "h": (Fraction(3600), 0, {"s": 1}),
    "deg": (Fraction(1, 180), 1, {"rad": 1}),
    "rpm": (Fraction(1, 30), 1, {"rad": 1, "s": -1}),
    "%": (Fraction(1, 100), 0, {}),
}
_PREFIXES = {
    "G": Fraction(10**9),
    "M": Fraction(10**6),
    "k": Fraction(10**3),
    "c": Fraction(1, 100),
    "m": Fraction(1, 10**3),
    "u": Fraction(1, 10**6),
    "n": Fraction(1, 10**9),
}
_PREFIXED = frozenset(_COHERENT) - {"kg", "cd"} | {"g", "L", "bar"}
_ADVICE = {
    "Hz": "it may mean 1/s or 2 pi rad/s: write '1/s' or 'rad/s'",
    "Nm": "write 'N m'",
    "degC": "temperatures are in K, counted from 0 K",
    "°C": "temperatures are in K, counted from 0 K",
    "°": "write 'deg'",
    "sec": "write 's'",
    "1": "a pure number has the unit '-'",
    "": "a pure number has the unit '-'",
}
_TYPED = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(.*?)\s*")
_FRACTION = re.compile(r"\((-?\d{1,2})/(\d{1,2})\)", re.ASCII)
_FACTOR = re.compile(r"([A-Za-z%]+)(?:(?:\^|\*\*)(-?\d{1,3}(?:[.:]\d{1,3})?))?", re.ASCII)


@lru_cache(maxsize=512)
def parse_unit(text: str) -> Unit:
    """Return the unit that a text such as ``"kN m"``, ``"rad/s^2"`` or ``"W/(m^2 K)"`` means.

    Names are separated by spaces or ``*``; behind ``/`` stands one name, or several in brackets.
    Powers may be decimals or fractions: ``"cm^2.5/s"``, ``"s/m^(1/3)"``.

    Raises
    ------
    ModelError : a unit that is not known, or a text of another form.
    """
    cleaned = text.strip()
    if cleaned == "-":
        return Unit(text, "-", PURE, Fraction(1), 0)
    # A colon for the fraction of a power, so that "/" divides units alone.
    fraction = _FRACTION.sub(r"\1:\2", cleaned).partition("/")
    above, slash, below = (side.strip() for side in fraction)
    if cleaned in ("", "1") or len(cleaned) > 60 or ":" in cleaned:
        raise _refused(text, cleaned)
    tops = [] if above == "1" and slash else _factors(text, above)
    if below.startswith("(") and below.endswith(")"):
        below = below[1:-1]
    elif len(below.split()) > 1 or "*" in below.replace("**", "") or "/" in below:
        raise ModelError(f"unit {text!r}: what is divided by? put it in brackets, e.g. 'W/(m^2 K)'")
    bottoms = _factors(text, below) if slash else []
    return _combined(text, [*tops, *((name, -power) for name, power in bottoms)])


def _factors(text: str, side: str) -> list[tuple[str, Fraction]]:
    factors = []
    for word in re.sub(r"(?<!\*)\*(?!\*)", " ", side).split() or [""]:
        match = _FACTOR.fullmatch(word)
        if match is None:
            raise _refused(text, word)
        top, _, bottom = (match.group(2) or "1").partition(":")
        if bottom and not int(bottom):
            raise _refused(text, word)
        power = Fraction(top) / int(bottom or 1)
        if not 0 < abs(power) <= MAX_POWER:
            raise ModelError(f"unit {text!r}: the power {power} is 0 or above {MAX_POWER}")
        factors.append((match.group(1), power))
    return factors


def _combined(text: str, factors: Iterable[tuple[str, Fraction]]) -> Unit:
    dimension, scaled, pi_power = PURE, Fraction(1), Fraction(0)
    names: dict[str, Fraction] = {}
    listed = list(factors)
    # One root of all factors together: m^0.5/cm^0.5 is 10.
    root = lcm(*(power.denominator for _, power in listed))
    for name, power in listed:
        scale, turns, base_units = _meaning(text, name)
        scaled *= scale ** int(power * root)
        pi_power += turns * power
        for base, times in base_units.items():
            names[base] = names.get(base, Fraction(0)) + times * power
            dimension = dimension.times(_COHERENT[base].power(times * power))
    if pi_power.denominator > 1:
        raise ModelError(f"unit {text!r}: a root of deg or rpm has no unit; write it with rad")
    factor, exact = _root(scaled, root)
    plain = factor == 1 and pi_power == 0
    written = text.strip() if plain else _written(names.items())
    return Unit(text, written, dimension, factor, int(pi_power), not exact)


def _root(value: Fraction, degree: int) -> tuple[Fraction, bool]:
    """Return the root of a positive number, and whether it is exact."""
    if degree == 1:
        return value, True
    with localcontext(prec=50):
        approximate = (Decimal(value.numerator) / value.denominator) ** (Decimal(1) / degree)
    rational = Fraction(approximate).limit_denominator(10**20)
    return (rational, True) if rational**degree == value else (Fraction(approximate), False)


def _meaning(text: str, name: str) -> tuple[Fraction, int, dict[str, int]]:
    if name in _COHERENT:
        return Fraction(1), 0, {name: 1}
    if name in _DERIVED_UNITS:
        return _DERIVED_UNITS[name]
    if name[:1] in _PREFIXES and name[1:] in _PREFIXED:
        scale, turns, base_units = _meaning(text, name[1:])
        return scale * _PREFIXES[name[0]], turns, base_units
    raise _refused(text, name)


def _refused(text: str, word: str) -> ModelError:
    names = [*_COHERENT, *_DERIVED_UNITS]
    advice = _ADVICE.get(word)
    if advice is None:
        prefixes = ", ".join(_PREFIXES)
        power = re.fullmatch(r"([A-Za-z]+)(\d)", word, re.ASCII)
        suggestion = (
            f" (did you mean '{power[1]}^{power[2]}'?)" if power else did_you_mean(word, names)
        )
        advice = f"known are {', '.join(names)}, with {prefixes} before them, and '-'{suggestion}"
    word_text = "" if word == text.strip() else f": {word!r}"
    return ModelError(f"unit {text!r}{word_text} is not known; {advice}")


def _written(factors: Iterable[tuple[str, Fraction]]) -> str:
    """Return ``"kg m/s^2"``, or ``"J/(kg K)"``, of names with exponents."""
    pairs = [(name, power) for name, power in factors if power]
    above = [_factor(name, power) for name, power in pairs if power > 0]
    below = [_factor(name, -power) for name, power in pairs if power < 0]
    if not below:
        return " ".join(above) or "-"
    bottom = below[0] if len(below) == 1 else f"({' '.join(below)})"
    return f"{' '.join(above) or '1'}/{bottom}"


def _factor(name: str, power: Fraction) -> str:
    if power.denominator == 1:
        return name if power == 1 else f"{name}^{power}"
    ends = 1000 % power.denominator == 0
    return f"{name}^{float(power):g}" if ends else f"{name}^({power})"


_TURBINE_UNITS = (
    "-", "m", "s", "ms", "kg", "t", "kg m^2", "kg/m^3", "m/s", "rad", "deg", "rad/s", "deg/s",
    "rpm", "Hz", "N", "kN", "N m", "kN m", "N m/s", "kN m/s", "N/m", "m/N", "N s/m", "N m/rad",
    "N m s/rad", "N m s^2/rad^2", "W", "kW", "MW", "W/rad", "MW/rad",
)  # fmt: skip


def _si_and_factor(text: str) -> tuple[str, float]:
    if text == "Hz":  # of a frequency, which the field says
        return "rad/s", 2 * pi
    unit = parse_unit(text)
    return unit.si, unit.factor.numerator * pi**unit.pi_power / unit.factor.denominator


UNITS = {text: _si_and_factor(text) for text in _TURBINE_UNITS}
"""Unit as written in a turbine file -> (SI unit, factor)."""


def accepted_units(si_unit: str) -> list[str]:
    """Return the spellings that convert to an SI unit."""
    return [unit for unit, (target, _) in UNITS.items() if target == si_unit]


def typed_figure(text: str) -> tuple[float, str]:
    """Return number and unit of a text such as ``34.5kNm``, where ``kN m`` may lack its space.

    Without a unit the second is empty.

    Raises
    ------
    ModelError : the text does not begin with a number.
    """
    match = _TYPED.fullmatch(text)
    if match is None or not isfinite(float(match.group(1))):
        raise ModelError(f"{text!r} is not a number; write it like 0.05 or 1e-3")
    spellings = {spelled.replace(" ", ""): spelled for spelled in UNITS}
    unit = spellings.get(match.group(2).replace(" ", ""), match.group(2))
    return float(match.group(1)), unit


def to_si(value: float, unit: str, si_unit: str) -> float:
    """Return the value in the SI unit.

    Raises
    ------
    ModelError : the unit is not known, or measures something else.
    """
    accepted = ", ".join(repr(name) for name in accepted_units(si_unit))
    if unit not in UNITS:
        raise ModelError(
            f"unit {unit!r} is not known{did_you_mean(unit, UNITS)}; this field accepts {accepted}"
        )
    target, factor = UNITS[unit]
    if target != si_unit:
        raise ModelError(f"unit {unit!r} does not fit; this field accepts {accepted}")
    return value * factor


def behind(unit: str) -> str:
    """Return a unit as it follows a number; nothing for a pure number."""
    return "" if unit in ("", "-") else f" {unit}"
