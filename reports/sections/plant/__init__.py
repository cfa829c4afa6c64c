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
    from takagi.reports.sections.plant.page import plant_figures, plant_report, plant_report_files

__all__ = ["plant_figures", "plant_report", "plant_report_files"]


def __getattr__(name: str) -> object:
    if name in __all__:
        return getattr(import_module("takagi.reports.sections.plant.page"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
