"""The HTML report of a plant's design, one section a file.

page                    put together from its sections, whose words are in templates/
verdict                 what is proved, and what is left out
plant, derivation       the equations as given; from them to the vertices
gains, blend            the law; two actuators that share an effort
certificate             claim by claim
regulator               beside a linear-quadratic regulator at rest
proved_set              its half-widths, and a picture of every pair of states
loops, motion           poles and margins; simulations
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.loops.largest_commands import largest_commands
    from takagi.reports.sections.plant.page import plant_figures, plant_report, plant_report_files

__all__ = [
    "largest_commands",
    "plant_figures",
    "plant_report",
    "plant_report_files",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
