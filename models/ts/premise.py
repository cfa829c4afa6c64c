"""A premise variable of a Takagi-Sugeno model: a name, its proved range, and how it is computed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact

if TYPE_CHECKING:
    from takagi.models.ranges.expression_range import Domain, RangeProof

# A premise computed in floats may leave its exact range by rounding alone: this part of the
# width (or of the size, for narrow ranges) is moved back to the end, more than that is refused.
ROUNDING = 1e-12


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Premise:
    """A premise z in [lower, upper] with weights w_1 = (upper - z)/(upper - lower), w_2 = 1 - w_1.

    Attributes
    ----------
    name : an identifier, unique in its model, e.g. ``"a"``.
    lower, upper : exact ends.  Strings, ints, Fractions and floats are read exactly, a float as
        the shortest decimal that prints it.
    unit : e.g. ``"1/s"``; ``"-"`` for a pure number, ``"SI"`` for coherent SI units that were
        not determined.
    latex : symbol for formulas; empty takes the name.
    evidence : why z cannot leave [lower, upper], e.g. ``"Bernstein hull over 52 wind cells"``.
    evaluate : the value of z at an operating point, called with keyword arguments that the maker
        of the model documents; None when it is not needed at run time.
    proof : what ``replay`` makes the bounds from again; None where only ``evidence`` tells.
    sampled : the bounds rest on samples, so nothing is proved with them.  A premise whose evidence
        says "sampled" is taken so even if it is not declared here: derived premises keep their
        words.
    domain : where the bounds hold, if that is less than the model's box (a band, a union of
        cells); None for the whole box.

    Raises
    ------
    ModelError : no name, ends that are not numbers, or lower > upper.
    """

    name: str
    lower: Fraction
    upper: Fraction
    unit: str
    latex: str
    evidence: str
    evaluate: Callable[..., float] | None
    proof: RangeProof | None
    sampled: bool
    domain: Domain | None

    def __init__(
        self,
        name: str,
        lower: Number,
        upper: Number,
        *,
        unit: str = "-",
        latex: str = "",
        evidence: str = "given by the user",
        evaluate: Callable[..., float] | None = None,
        proof: RangeProof | None = None,
        sampled: bool = False,
        domain: Domain | None = None,
    ) -> None:
        if not name.strip():
            raise ModelError("a premise has an empty name; name it, e.g. 'z1'")
        first, last = _end(name, "lower", lower), _end(name, "upper", upper)
        if first > last:
            raise ModelError(
                f"premise {name}: lower bound {float(first):.9g} exceeds upper bound "
                f"{float(last):.9g}; give the smaller one first"
            )
        doubtful = sampled or "sampled" in evidence
        fields = (name, first, last, unit, latex or name, evidence, evaluate, proof, doubtful)
        for field, value in zip(self.__slots__, (*fields, domain), strict=True):
            object.__setattr__(self, field, value)

    @property
    def corners(self) -> tuple[Fraction, ...]:
        """(lower, upper), or one value when both agree: a constant premise costs no rule."""
        return (self.lower,) if self.lower == self.upper else (self.lower, self.upper)

    @property
    def bounds(self) -> Interval:
        """[lower, upper] as an interval."""
        return Interval(self.lower, self.upper)

    def replay(self) -> Interval:
        """Return the enclosure of the premise, made again, which lies in [lower, upper].

        Raises
        ------
        ModelError : no proof is kept, or it does not prove these bounds.
        """
        if self.proof is None:
            raise ModelError(
                f"premise {self.name} keeps no proof to replay; its bounds are {self.evidence}"
            )
        try:
            return self.proof.replay(self.bounds)
        except ModelError as error:
            raise ModelError(f"premise {self.name}: {error}") from error

    def weights(self, value: ArrayLike, *, clip: bool = False) -> Floats:
        """Return (w_1, w_2) stacked on the first axis, or (1,) for a constant premise.

        Parameters
        ----------
        value : number or array.
        clip : False refuses a value outside [lower, upper]: there the model means nothing.
            True moves it to the nearer end, for run time; the model is then no longer exact.

        Raises
        ------
        ModelError : NaN, or a value outside with clip=False.
        """
        z = np.asarray(value, dtype=np.float64)
        low, high = float(self.lower), float(self.upper)
        slack = math.inf if clip else ROUNDING * max(high - low, abs(low), abs(high))
        outside = ~((z >= low - slack) & (z <= high + slack))
        if np.any(outside):
            raise ModelError(
                f"premise {self.name} = {float(z[outside].flat[0]):.9g} {self.unit} is outside its "
                f"range [{low:.9g}, {high:.9g}], where the model means nothing; stay inside the "
                "model's box, enlarge it, or pass clip=True at run time"
            )
        if low == high:
            return np.ones((1, *z.shape))
        first = (high - np.clip(z, low, high)) / (high - low)
        return np.stack((first, 1.0 - first))


def round_outward(enclosure: Interval, *, digits: int = 8) -> Interval:
    """Return the enclosure with both ends rounded outward to decimals.

    ``digits`` : significant digits of the larger end; a number below 16 keeps every end a decimal
    that a float reproduces.
    """
    size = float(enclosure.magnitude)
    decimals = digits if size == 0 else digits - 1 - math.floor(math.log10(size))
    return enclosure.outward(max(decimals, 0))


def _end(name: str, end: str, value: Number) -> Fraction:
    try:
        return exact(value)
    except ModelError as error:
        raise ModelError(f"premise {name}: {end} bound: {error}") from error
