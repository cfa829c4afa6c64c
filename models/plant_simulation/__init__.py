"""A plant in time: disturbances and noise as signals, limits of actuators, laws in samples.

signals       step, pulse, ramp, sine, noise: values over time, and where they jump
signal_text   a signal as a user writes it, such as "step 0.2 at 1s"
right_side    x' of the plant itself, its disturbances moving or at rest
experiment    what is run: plant, law, limits, signals
runs          the experiment in time, segment by segment between jumps
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.plant_simulation.experiment import (
        Experiment,
        ExperimentRun,
        SampledProgram,
    )
    from takagi.models.plant_simulation.right_side import right_side
    from takagi.models.plant_simulation.runs import run
    from takagi.models.plant_simulation.signal_text import parse_signal
    from takagi.models.plant_simulation.signals import (
        Noise,
        Pulse,
        Ramp,
        Signal,
        Signals,
        Sine,
        Step,
    )

__all__ = [
    "Experiment",
    "ExperimentRun",
    "Noise",
    "Pulse",
    "Ramp",
    "SampledProgram",
    "Signal",
    "Signals",
    "Sine",
    "Step",
    "parse_signal",
    "right_side",
    "run",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
