"""Two regional models of the NREL 5-MW turbine, made once, and its loop with the paper's law."""

from __future__ import annotations

from functools import cache

import numpy as np

from takagi.models import Floats, TSModel, full_load_model, nrel5mw, partial_load_model
from takagi.models.laws.protocol import Measurement
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.turbine.data import rotor_torque


@cache
def regional_models() -> tuple[TSModel, TSModel]:
    """Return partial and full load with coarse (still rigorous) bounds: faster to make."""
    models = partial_load_model, full_load_model
    partial, full = (model(nrel5mw(), tolerance="0.1") for model in models)
    return partial, full


def loop_rate(law: PublishedLaw, wind: float, z: Floats, *, clip: bool = False) -> Floats:
    seen = Measurement(float(z[0]), float(z[1]), wind)
    command = law.command(z[2:], seen)
    turbine = nrel5mw()
    torque = float(rotor_torque(turbine, z[0], z[1], wind, clip=clip))
    speeding = (torque - turbine.gear_ratio * command.torque) / turbine.inertia
    drive = (command.pitch - z[1]) / turbine.pitch_time_constant
    return np.array([speeding, drive, *law.state_rate(z[2:], seen)])
