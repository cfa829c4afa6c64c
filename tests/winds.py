"""Winds that tests alone need."""

from __future__ import annotations

import numpy as np

from takagi.models.simulation.wind import WindSeries


def constant_wind(speed: float, duration: float) -> WindSeries:
    return WindSeries(
        np.array([0.0, duration]), np.array([speed, speed]), f"constant {speed:g} m/s"
    )
