"""The HTML report of a turbine design: one self-contained page, readable without JavaScript.

page                      put together from its sections, whose words are in templates/
verdict                   what is proved, and what is left out
model, operation          the plant; where it is run
regions, gains, blending  regional models; the law; how control is blended
synthesis_table           gains found in one step against two
cells                     the certificate cell by cell
loops, responses          poles and margins; steps and gusts
observer                  the wind observer
drawings                  figures that only this page has
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.reports.page.assembly import ReportFiles
    from takagi.reports.sections.turbine.page import report_html

__all__ = ["ReportFiles", "report_html"]

_HOME = {
    "ReportFiles": "takagi.reports.page.assembly",
    "report_html": "takagi.reports.sections.turbine.page",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
