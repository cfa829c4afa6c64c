"""The exact inputs of a claim about a published law: law, schedules, overlaps."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

from takagi.certificates.checker.kernel.reader import (
    integer,
    matrix,
    member,
    number,
    numbers,
    text,
)
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.effort_sharing.inputs import increasing_in_floats
from takagi.certificates.checker.turbine.members import Members, plain

NAME, STATES = "paper", 3
SHAPES = ("smooth", "linear")
KINDS = ("k_speed", "k_pitch", "k_integral")
POSITIVE = (
    "speed_setpoint",
    "minimum_rotor_speed",
    "optimal_tip_speed_ratio",
    "largest_tip_speed_ratio",
    "cut_in",
    "cut_out",
    "rated_torque",
)
MOST_WINDS = 2000
REGION = plain("wind rotor_speed pitch rules k_speed k_pitch k_integral")
MEMBERS: Members = {
    **plain(
        "name states speed_setpoint minimum_rotor_speed optimal_tip_speed_ratio "
        "largest_tip_speed_ratio cut_in cut_out rated_torque pitch_min pitch_max"
    ),
    "coupling": plain(
        "variant speed_ramp_start speed_overlap speed_ramp_shape torque_overlap minimum_torque "
        "top_torque"
    ),
    "partial": {**REGION, "premises": plain("a d")},
    "full": {**REGION, "premises": plain("a b d")},
}


@dataclass(frozen=True, eq=False)
class Region:
    """A region's trim table, premise bounds and gains; gains must not depend on the premise d.

    ``gains[kind][corner]``: kind 0 speed, 1 pitch, 2 integral; corner over a, or over (a, b).
    """

    wind: list[Fraction]
    speed: list[Fraction]
    pitch: list[Fraction]
    bounds: list[tuple[Fraction, Fraction]]
    gains: list[dict[tuple[int, ...], Fraction]]

    @classmethod
    def read(cls, owner: Any, where: str, premises: int) -> Region:
        """Return a region; refuses gains that differ between the corners of d."""
        wind = numbers(owner, "wind", where)
        increasing_in_floats(wind, f"{where}.wind")
        if not 1 < len(wind) <= MOST_WINDS or wind[0] <= 0:
            raise CertificateError(f"{where}.wind: 2 to {MOST_WINDS} winds above 0 are needed")
        speed = numbers(owner, "rotor_speed", where, len(wind))
        pitch = numbers(owner, "pitch", where, len(wind))
        names = "ab"[:premises]
        stated = member(owner, "premises", where)
        bounds = [numbers(stated, name, f"{where}.premises", 2) for name in names]
        # The program of a gain file gives a premise without a range, in its floats, the weight 0.
        for ends in bounds:
            increasing_in_floats(ends, f"{where}.premises")
        # A law without d would add up the gains of both its corners.
        numbers(stated, "d", f"{where}.premises", 2)
        rules = matrix(owner, "rules", where)
        if [tuple(rule) for rule in rules] != list(product((0, 1), repeat=premises + 1)):
            raise CertificateError(f"{where}.rules: all corners in order are needed")
        gains: list[dict[tuple[int, ...], Fraction]] = [{}, {}, {}]
        for kind, table in zip(KINDS, gains, strict=True):
            row = numbers(owner, kind, where, len(rules))
            for rule, gain in zip(rules, row, strict=True):
                corner = tuple(int(entry) for entry in rule[:premises])
                if table.setdefault(corner, gain) != gain:
                    raise CertificateError(f"{where}.{kind}: differs between the corners of d")
        if max(gains[2].values()) >= 0:
            raise CertificateError(f"{where}.k_integral: must be negative")
        return cls(wind, speed, pitch, [(b[0], b[1]) for b in bounds], gains)


@dataclass(frozen=True)
class Overlaps:
    """The ramp in speed and the rounding in torque of a claim."""

    start: Fraction
    width: Fraction
    torque: Fraction

    @classmethod
    def read(cls, owner: Any, where: str, rated_torque: Fraction) -> Overlaps:
        found = cls(
            number(owner, "speed_ramp_start", where),
            number(owner, "speed_overlap", where),
            number(owner, "torque_overlap", where),
        )
        if found.width <= 0 or not 0 < found.torque < 2 * rated_torque:
            raise CertificateError(f"{where}: overlaps must be positive, and torque stays so")
        return found


@dataclass(frozen=True, kw_only=True)
class PublishedLaw:
    """The law's numbers."""

    setpoint: Fraction
    minimum_speed: Fraction
    optimal_ratio: Fraction
    largest_ratio: Fraction
    cut_in: Fraction
    cut_out: Fraction
    rated_torque: Fraction
    top_torque: Fraction
    pitch_min: Fraction
    pitch_max: Fraction
    smooth: bool
    overlaps: Overlaps
    partial: Region
    full: Region

    @classmethod
    def read(cls, gains: Any) -> PublishedLaw:
        """Return the law; refuses other laws, other filters, and numbers of the wrong sign."""
        if text(gains, "name", "gains") != NAME:
            raise CertificateError(f"gains.name: {NAME!r} is needed")
        positive = {key: number(gains, key, "gains") for key in POSITIVE}
        ordered = positive["cut_in"] < positive["cut_out"]
        if min(positive.values()) <= 0 or not ordered:
            raise CertificateError("gains: speeds, ratios, winds and torque must be positive")
        filter_, where = member(gains, "coupling", "gains"), "gains.coupling"
        if text(filter_, "variant", where) != "saturated":
            raise CertificateError(f"{where}.variant: only 'saturated' is covered")
        shape = text(filter_, "speed_ramp_shape", where)
        if shape not in SHAPES:
            raise CertificateError(f"{where}.speed_ramp_shape: one of {', '.join(SHAPES)}")
        if integer(gains, "states", "gains") != STATES:
            raise CertificateError(f"gains.states: {STATES} are needed")
        partial = Region.read(member(gains, "partial", "gains"), "gains.partial", 1)
        if any(partial.gains[1].values()):
            raise CertificateError("gains.partial.k_pitch: must be 0")
        return cls(
            setpoint=positive["speed_setpoint"],
            minimum_speed=positive["minimum_rotor_speed"],
            optimal_ratio=positive["optimal_tip_speed_ratio"],
            largest_ratio=positive["largest_tip_speed_ratio"],
            cut_in=positive["cut_in"],
            cut_out=positive["cut_out"],
            rated_torque=positive["rated_torque"],
            top_torque=number(filter_, "top_torque", where),
            pitch_min=number(gains, "pitch_min", "gains"),
            pitch_max=number(gains, "pitch_max", "gains"),
            smooth=shape == "smooth",
            overlaps=Overlaps.read(filter_, where, positive["rated_torque"]),
            partial=partial,
            full=Region.read(member(gains, "full", "gains"), "gains.full", 2),
        )
