"""How fast the actuators move on a certified set: the candidate of a claim ``actuator-rates``.

The bounds themselves are those of the checker
(``certificates/checker/turbine/effort_sharing/actuator_rates.py``),
rounded up; computed here, in floating point, are B and the largest |v_s''| that the torque's rate
limit allows. Nothing is proved here.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.reader import number, read_text
from takagi.certificates.checker.turbine.effort_sharing.actuator_rates import (
    CellRates,
    cell_rates,
    largest_bends,
    torque_step,
)
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.models.intervals.interval import exact

# Factor on B, which is found in floating point.
RESERVE = 1 + 1e-6
DIGITS = 7


def actuator_rates_claim(
    model: Mapping[str, Any],
    gains: Mapping[str, Any],
    loop: Mapping[str, Any],
    *,
    wind_rate: tuple[Mapping[str, Any], int] | None = None,
) -> dict[str, Any]:
    """Return the claim as plain data.

    A cell's ``torque_rate`` is the least bound that holds. If the torque uses the schedule wind's
    rate, it is the turbine's limit, with the largest |v_s''| that this limit allows, if any.

    Parameters
    ----------
    model, gains : as the certificate states them.
    loop : its claim of kind ``coherent-loop``, the first of the file.
    wind_rate : its claim of kind ``wind-rate`` and that claim's number; the claim refers to it if
        all of its winds keep the stated |v_s''|.
    """
    parts = {"model": dict(model), "gains": dict(gains), "loop": dict(loop)}
    if wind_rate is not None:
        parts["rate"] = dict(wind_rate[0])
    data = read_text(json.dumps(parts), "candidate")
    subject = Subject.read(data["loop"], data["model"], data["gains"], "loop")
    bounds = cell_rates(subject, data["loop"], "loop")
    P = np.linalg.inv(np.array(loop["P"], dtype=np.float64))
    signal = [_signal_rate(bound, P) for bound in bounds]
    rests = [b.torque_rate(B, Fraction(0)) for b, B in zip(bounds, signal, strict=True)]
    limit = number(data["model"], "torque_rate_limit", "model")
    rates = [number(cell, "wind_rate", "loop") for cell in data["loop"]["cells"]]
    claim: dict[str, Any] = {
        "name": "actuator rates of the effort-sharing loop",
        "kind": "actuator-rates",
        "loop": 0,
        "torque_step": float(_up(torque_step(subject.law, rates))),
        "cells": [
            {
                "pitch_rate": float(_pitch(bound, data["model"])),
                "signal_rate": float(B),
                **_torque(bound, rest, limit),
            }
            for bound, B, rest in zip(bounds, signal, rests, strict=True)
        ],
    }
    if wind_rate is not None:
        bends = largest_bends(
            data["rate"], subject.law, number(data["gains"], "wind_filter", "gains"), "rate"
        )
        stated = [exact(cell["schedule_bend"]) for cell in claim["cells"]]
        triples = zip(bounds, bends, stated, strict=True)
        if all(bend <= most for bound, bend, most in triples if bound.fed):
            claim["wind_rate"] = wind_rate[1]
    return claim


def _signal_rate(bound: CellRates, inverse: Any) -> Fraction:
    """Return max sqrt(h P^-1 h') over the corners, rounded up."""
    rows = np.array([[float(entry) for entry in h] for h in bound.corners])
    largest = float(np.sqrt(np.einsum("ci,ij,cj->c", rows, inverse, rows).max()))
    return _up(Fraction(largest * RESERVE))


def _pitch(bound: CellRates, model: Any) -> Fraction:
    """Return the bound of the pitch rate, in short decimals where it is below the limit."""
    limit = number(model, "pitch_rate_limit", "model")
    return min(limit, _up(bound.pitch))


def _torque(bound: CellRates, rest: Fraction, limit: Fraction) -> dict[str, float]:
    """Return the torque's rate, and |v_s''| [m/s^3]: 0 without a feed-forward or without margin."""
    if not bound.fed or rest >= limit:
        return {"torque_rate": float(_up(rest)), "schedule_bend": 0.0}
    bend = math.floor((limit - rest) / bound.fed * 10**DIGITS) / 10**DIGITS
    return {"torque_rate": float(limit), "schedule_bend": bend}


def _up(value: Fraction) -> Fraction:
    return Fraction(math.ceil(value * 10**DIGITS), 10**DIGITS)
