"""What a claim ``turbine-crossing`` states of the wind and of the parameters.

The ranges of the parameters are a box, which a tree of halves cuts into pieces: ``cuts`` lists its
nodes, each before its halves, the half with the lower values first.  A node is the name of the
parameter that is halved, or the empty text for a piece.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

from takagi.certificates.checker.kernel.reader import listed, member, numbers, positive
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.running_loop.inputs import Span

MOST_PIECES = 256
# The parameters in the order of the box's corners.
PARAMETERS = (
    "inertia",
    "speed_damping",
    "pitch_effectiveness",
    "wake_of_pitch",
    "wake_of_wind",
    "wake_length",
)
# These may be zero: the wake then follows at once.
LEAST_ZERO = ("wake_of_pitch", "wake_of_wind")
Box = dict[str, Span]


@dataclass(frozen=True)
class Turbulence:
    """The wind's model: y'' + damping y' + stiffness y = noise.

    Attributes
    ----------
    deviation : of the rotor-effective wind [m/s];  rate : the rms of its rate [m/s^2].
    rotor_time : t_r of the averaging by the rotor [s].
    """

    deviation: Fraction
    rate: Fraction
    rotor_time: Fraction

    @classmethod
    def read(cls, claim: Any, where: str) -> Turbulence:
        """Return it; refuses a number that is not positive."""
        stated, place = member(claim, "turbulence", where), f"{where}.turbulence"
        return cls(*(positive(stated, name, place) for name in cls.__dataclass_fields__))

    @property
    def stiffness(self) -> Fraction:
        """1/(t_r t_L) = (rate / deviation)^2 [1/s^2]."""
        return (self.rate / self.deviation) ** 2

    @property
    def damping(self) -> Fraction:
        """1/t_r + 1/t_L [1/s]."""
        return 1 / self.rotor_time + self.rotor_time * self.stiffness

    @property
    def intensity(self) -> Fraction:
        """The square of the noise's size, 2 damping rate^2 [m^2/s^5]."""
        return 2 * self.damping * self.rate**2


def parameter_box(claim: Any, where: str) -> Box:
    """Return the ranges of the parameters; refuses one that is empty or reaches below zero."""
    stated, place = member(claim, "uncertainty", where), f"{where}.uncertainty"
    found: Box = {}
    for name in PARAMETERS:
        low, high = numbers(stated, name, place, 2)
        least_ok = low >= 0 if name in LEAST_ZERO else low > 0
        if not (least_ok and low <= high):
            raise CertificateError(f"{place}.{name}: 0 < low <= high is needed")
        found[name] = low, high
    return found


def cut_boxes(claim: Any, box: Box, where: str) -> list[Box]:
    """Return the pieces in the tree's order; a claim without ``cuts`` has one.

    Raises
    ------
    CertificateError : the nodes are no tree, or one halves a parameter that has one value.
    """
    if "cuts" not in claim:
        return [box]
    place = f"{where}.cuts"
    open_boxes, found = [box], []
    for name in listed(claim, "cuts", where, 1, 2 * MOST_PIECES - 1):
        if not open_boxes:
            raise CertificateError(f"{place}: more nodes than the tree has")
        here = open_boxes.pop()
        if name == "":
            found.append(here)
            continue
        if not isinstance(name, str) or name not in box or here[name][0] == here[name][1]:
            raise CertificateError(f"{place}: names of parameters that have a range are needed")
        # The next node is the lower half.
        open_boxes += reversed(halves(here, name))
    if open_boxes:
        raise CertificateError(f"{place}: fewer nodes than the tree has")
    return found


def halves(box: Mapping[str, Span], name: str) -> tuple[Box, Box]:
    """Return the box with the lower and with the upper half of one parameter's range."""
    low, high = box[name]
    middle = (low + high) / 2
    return {**box, name: (low, middle)}, {**box, name: (middle, high)}


def corners(box: Mapping[str, Span]) -> Iterator[dict[str, Fraction]]:
    """Yield the corners of a box; a parameter with one value has no two ends."""
    ends = [sorted(set(box[name])) for name in PARAMETERS]
    for values in product(*ends):
        yield dict(zip(PARAMETERS, values, strict=True))
