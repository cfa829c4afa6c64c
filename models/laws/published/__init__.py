"""The published multi-region laws (``paper`` and ``paper-two-integrators`` on the command line).

law               the law, read literally, and its nearest working reading
coupling_filter, reference_filter    torque and pitch control blended; a low-pass on the speed
regional_schedule     one region's scheduled gains
equilibrium, equilibrium_point    its equilibrium; that point as a value
one_integrator, two_integrators   the balances that give the point
linearisation     the law and its loop, linearised there
loop_cells        the nonlinear loop as an interval family, one a wind cell, for searching
vector_field, loop_tables         its right-hand side on ranges with slopes; what that is made of
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.laws.published.coupling_filter import Variant as Variant
    from takagi.models.laws.published.law import PublishedLawName as PublishedLawName
    from takagi.models.laws.published.loop_cells import PublishedCell as PublishedCell
    from takagi.models.laws.published.loop_cells import disturbance_bound as disturbance_bound
    from takagi.models.laws.published.loop_cells import enclosed_cell as enclosed_cell
    from takagi.models.laws.published.loop_cells import wind_breaks as wind_breaks
    from takagi.models.laws.published.loop_tables import LoopFigures as LoopFigures
    from takagi.models.laws.published.loop_tables import loop_figures as loop_figures
    from takagi.models.laws.published.regional_schedule import RegionalSchedule as RegionalSchedule

__getattr__, __dir__ = lazy_names(__name__)
