"""Norms from disturbance to output of a given loop, each by one quadratic function.

energy_gain, output_variance, peak_to_peak    H-infinity, H2, and the peaks
guessed_function             functions of one vertex by Riccati and Lyapunov equations
least_gain, channel          what all norms have in common; the path through the vertices
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.analysis.disturbance.channel import disturbance_channel as disturbance_channel
    from takagi.lmi.analysis.disturbance.energy_gain import energy_gain_of as energy_gain_of
    from takagi.lmi.analysis.disturbance.guessed_function import OneVertex as OneVertex
    from takagi.lmi.analysis.disturbance.output_variance import variance_bound as variance_bound
    from takagi.lmi.analysis.disturbance.peak_to_peak import peak_bound as peak_bound

__getattr__, __dir__ = lazy_names(__name__)
