"""The data that a claim about the running loop states of the machine and of each cell.

Observer, filters and rate limits are those of the gain file.  The claim repeats observer and
filters, so that it can be read without the file; the checker compares them.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.controller.decimals import short
from takagi.certificates.checker.kernel.reader import Number, member, number, numbers, positive
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.rotor import nominal_inertia

Span = tuple[Fraction, Fraction]
# The members of the gain file that the claim states, and the numbers in them.
STATED = {
    "observer": ("l1", "l2", "wind_limits"),
    "measurement": ("speed_filter", "torsion_filter"),
}


@dataclass(frozen=True)
class Sides:
    """The box of one cell: bounds of the deviations from the rest, all positive.

    Attributes
    ----------
    speed, measured : of the rotor's speed and of the filtered one [rad/s].
    pitch : b0 times the pitch [rad/s^2].
    signal : of omega_m - omega*(v_s) - x [rad/s];  effort : of U [rad/s^2].
    schedule, estimate : of v_s and of the observer's wind [m/s].
    integral : of x [rad/s].
    measured_rate : of the filtered speed's rate [rad/s^2].
    """

    speed: Fraction
    measured: Fraction
    pitch: Fraction
    signal: Fraction
    effort: Fraction
    schedule: Fraction
    estimate: Fraction
    integral: Fraction
    measured_rate: Fraction

    @classmethod
    def read(cls, cell: Any, where: str) -> Sides:
        """Return the box; refuses a side that is not positive."""
        stated, place = member(cell, "sides", where), f"{where}.sides"
        values = [number(stated, name, place) for name in cls.__dataclass_fields__]
        if min(values) <= 0:
            raise CertificateError(f"{place}: every side must be positive")
        return cls(*values)


@dataclass(frozen=True)
class Machine:
    """Observer, filters, limits of rates, and the ranges of the plants.

    Attributes
    ----------
    l1, l2 : the observer's gains [1/s, m/s^2 per rad/s];  wind_limits : of its estimate [m/s].
    corner : of the low-pass on the measured speed [1/s].
    stop : frequency [rad/s] and share passed [-] of the band-stop before it, or None.
    wind_filter : tau_f [s].
    torque_rate : the gain file's limit of the torque's rate [N m/s].
    observer_inertia : nominal inertia over the inertia in the gain file's observer.
    inertia : true over nominal, from the least to the greatest.
    wake_length : wind over the wake's rate [m], from the least to the greatest.
    """

    l1: Fraction
    l2: Fraction
    wind_limits: Span
    corner: Fraction
    stop: Span | None
    wind_filter: Fraction
    torque_rate: Fraction
    observer_inertia: Fraction
    inertia: Span
    wake_length: Span

    @classmethod
    def read(cls, claim: Any, model: Any, gains: Any, where: str) -> Machine:
        """Return it.

        Refused are numbers that are not positive, limits and ranges in the wrong order, a band-stop
        that passes more than everything, and a law without a wind filter.
        """
        seen, place = member(claim, "observer", where), f"{where}.observer"
        l1, l2 = (positive(seen, name, place) for name in ("l1", "l2"))
        limits = _range(seen, "wind_limits", place)
        if limits[0] == limits[1]:
            raise CertificateError(f"{place}.wind_limits: two limits that differ are needed")
        filters, place = member(claim, "measurement", where), f"{where}.measurement"
        corner, stop = positive(filters, "speed_filter", place), None
        if "torsion_filter" in filters:
            stopped, place = filters["torsion_filter"], f"{place}.torsion_filter"
            stop = positive(stopped, "frequency", place), number(stopped, "passed", place)
            if not 0 <= stop[1] <= 1:
                raise CertificateError(f"{place}.passed: a share from 0 to 1 is needed")
        # J over the decimal of J in the gain file, which the observer divides by.
        inertia = nominal_inertia(model)
        given, place = member(claim, "uncertainty", where), f"{where}.uncertainty"
        return cls(
            l1=l1,
            l2=l2,
            wind_limits=limits,
            corner=corner,
            stop=stop,
            wind_filter=positive(gains, "wind_filter", "gains"),
            torque_rate=positive(model, "torque_rate_limit", "model"),
            observer_inertia=inertia / Fraction(short(inertia)),
            inertia=_range(given, "inertia", place),
            wake_length=_range(given, "wake_length", place),
        )


def other_than_the_controller(claim: Any, data: Any, where: str) -> str:
    """Return where the claim's observer or filters differ from the certificate's ``controller``.

    That member is the gain file's content, with which ``takagi check --gains`` compares the file.
    A certificate without this member has no other observer; then that of the claim is taken.
    """
    controller = data.get("controller") if isinstance(data, dict) else None
    if controller is None:
        return ""
    for part, names in STATED.items():
        stated = member(claim, part, where)
        own = controller.get(part) if isinstance(controller, dict) else None
        for name in names:
            there, here = (
                _plain(one.get(name)) if isinstance(one, dict) else None for one in (own, stated)
            )
            if here != there:
                return f"{part}.{name} is not the controller's"
        # The claim states every filter, so a further one of the file makes another loop.
        if part == "measurement" and _members(own) != _members(stated):
            return f"{part} is not the controller's"
    return ""


def _members(stated: Any) -> set[str]:
    return set(stated) if isinstance(stated, dict) else set()


def _plain(value: Any) -> Any:
    """Return numbers as such, so that 1 and 1.0 are equal; ``true`` is not 1, as in Python."""
    if isinstance(value, bool):
        return bool, value
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return Fraction(value) if isinstance(value, Number) else value


def _range(owner: Any, key: str, where: str) -> Span:
    low, high = numbers(owner, key, where, 2)
    if not 0 < low <= high:
        raise CertificateError(f"{where}.{key}: 0 < low <= high is needed")
    return low, high
