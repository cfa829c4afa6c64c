"""Margins of the running loop at a wind, with numbers that a test chooses."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import control
import numpy as np

from takagi.reports.margins.margins import DiskMargin, loop_margins
from takagi.reports.margins.response import LoopResponse, continuous_response
from takagi.reports.margins.running_over_wind import RunningMargins


def response_of(loop: Any) -> LoopResponse:
    system = control.ss(loop)
    assert not np.any(system.D)
    return continuous_response(system.A, system.B, system.C)


def margin_row(wind: float, loop: str, gain: float, alpha: float, **changed: Any) -> RunningMargins:
    """A wind whose ``loop``, torque or pitch, may grow by ``gain``; alpha of both together."""
    found = replace(
        loop_margins(response_of(control.tf(1, [1, 1, 0]))),
        gain_increase=gain,
        gain_decrease=0.0,
        phase=math.radians(60),
        delay=0.5,
    )
    whole = RunningMargins(
        wind=wind,
        inertia=1.0,
        wake="dynamic",
        torque=found if loop == "torque" else None,
        pitch=found if loop == "pitch" else None,
        both=DiskMargin(alpha, 1.0),
        decay_rate=0.1,
        modes_met=(),
        kinks=(),
    )
    return replace(whole, **changed)
