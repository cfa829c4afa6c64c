"""The HTML report of a plant's design, one section a file.

page                    the page, assembled from its sections; their text is in templates/
verdict                 what is proved, and what is not covered
plant, derivation       the equations as given; the steps from them to the vertices
gains, blend            the law; two actuators that share an effort
certificate             the claims one by one
regulator               a comparison with a linear-quadratic regulator at rest
proved_set              half-widths of the proved set, and a picture for every pair of states
loops, motion           poles and margins; simulations
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.loops.plant_loop import largest_commands as largest_commands
    from takagi.reports.sections.plant.page import plant_figures as plant_figures
    from takagi.reports.sections.plant.page import plant_report as plant_report
    from takagi.reports.sections.plant.page import plant_report_files as plant_report_files

__getattr__, __dir__ = lazy_names(__name__)
