"""Loops of python-control as margins read them."""

from __future__ import annotations

from typing import Any

import control
import numpy as np

from takagi.reports.margins.response import LoopResponse, continuous_response


def response_of(loop: Any) -> LoopResponse:
    """Return the response of a strictly proper loop in continuous time."""
    system = control.ss(loop)
    assert not np.any(system.D)
    return continuous_response(system.A, system.B, system.C)
