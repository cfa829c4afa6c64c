"""The HTML report of a plant's design, one section a file.

page                    put together from its sections, whose words are in templates/
verdict                 what is proved, and what is left out
plant, derivation       the equations as given; from them to the vertices
gains, blend            the law; two actuators that share an effort
certificate             claim by claim
loops, motion           poles and margins; simulations
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.reports.appendix.plant_files import plant_appendix
    from takagi.reports.sections.plant.page import plant_figures, plant_report, plant_report_files

__all__ = ["plant_appendix", "plant_figures", "plant_report", "plant_report_files"]

_HOME = {
    "plant_appendix": "takagi.reports.appendix.plant_files",
    "plant_figures": "takagi.reports.sections.plant.page",
    "plant_report": "takagi.reports.sections.plant.page",
    "plant_report_files": "takagi.reports.sections.plant.page",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
