"""The HTML report of a turbine design: one self-contained page, readable without JavaScript.

page                      the page, assembled from its sections; their text is in templates/
verdict                   what is proved, and what is not covered
model, operation          the plant; its steady operating points
regions, gains, blending  regional models; the law; blending of torque and pitch
synthesis_table           a comparison of one-step and two-step gains
cells                     the certificate cell by cell
loops, responses          poles and margins; responses to steps and gusts
running                   margins of the loop with observer, filters and sampling
observer                  the wind observer
drawings                  figures that only this page has
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.sections.turbine.cells import cells_section as cells_section
    from takagi.reports.sections.turbine.gains import gains_section as gains_section
    from takagi.reports.sections.turbine.loops import poles_section as poles_section
    from takagi.reports.sections.turbine.verdict import verdict_section as verdict_section

__getattr__, __dir__ = lazy_names(__name__)
