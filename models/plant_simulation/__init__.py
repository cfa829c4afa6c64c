"""Simulation of a plant: signals from outside, actuator limits, sampled laws.

signals       step, pulse, ramp, sine, noise: values over time, and where they jump
signal_text   a signal as a user writes it, such as "step 0.2 at 1s"
right_side    x' by the plant's own equations, with disturbances that move or rest
experiment    the loop that is simulated: plant, law, limits, signals
runs          the integration, segment by segment between the jumps of signals
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.plant_simulation.experiment import Experiment as Experiment
    from takagi.models.plant_simulation.experiment import SampledProgram as SampledProgram
    from takagi.models.plant_simulation.right_side import right_side as right_side
    from takagi.models.plant_simulation.runs import run as run
    from takagi.models.plant_simulation.signal_text import parse_signal as parse_signal
    from takagi.models.plant_simulation.signals import Noise as Noise
    from takagi.models.plant_simulation.signals import Pulse as Pulse
    from takagi.models.plant_simulation.signals import Ramp as Ramp
    from takagi.models.plant_simulation.signals import Signal as Signal
    from takagi.models.plant_simulation.signals import Signals as Signals
    from takagi.models.plant_simulation.signals import Sine as Sine
    from takagi.models.plant_simulation.signals import Step as Step

__getattr__, __dir__ = lazy_names(__name__)
