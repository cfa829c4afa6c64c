"""Norms from disturbance to output of a given loop, each by one quadratic function.

energy_gain, bounded_real    energy gain (H-infinity); that of one vertex by its Riccati equation
output_variance, gramian     variance (H2); that of one vertex by its Lyapunov equation
peak_to_peak, peak_condition, reachable_set    peak-to-peak gain; its LMIs; that of one vertex
least_gain, channel          what all norms have in common; the path through the vertices
guessed_function             a guess of the function that shows a norm
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.analysis.disturbance.channel import disturbance_channel as disturbance_channel
    from takagi.lmi.analysis.disturbance.energy_gain import energy_gain_of as energy_gain_of
    from takagi.lmi.analysis.disturbance.output_variance import variance_bound as variance_bound
    from takagi.lmi.analysis.disturbance.peak_to_peak import peak_bound as peak_bound
    from takagi.lmi.analysis.disturbance.reachable_set import OneVertex as OneVertex

__getattr__, __dir__ = lazy_names(__name__)
