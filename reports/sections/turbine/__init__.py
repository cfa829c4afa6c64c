"""The HTML report of a turbine design: one self-contained page, readable without JavaScript.

page                      put together from its sections, whose words are in templates/
verdict                   what is proved, and what is left out
model, operation          the plant; where it is run
regions, gains, blending  regional models; the law; how control is blended
synthesis_table           gains found in one step against two
cells                     the certificate cell by cell
loops, responses          poles and margins; steps and gusts
running                   margins of the loop that runs
observer                  the wind observer
drawings                  figures that only this page has
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.page.assembly import ReportFiles
    from takagi.reports.sections.turbine.gains import gains_section
    from takagi.reports.sections.turbine.page import report_html

__all__ = [
    "ReportFiles",
    "gains_section",
    "report_html",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
