"""What leaves the house for a plant in general: report, figures with their data, LaTeX appendix.

page            the report put together from its sections;  *_section: one each
readable        a derivation's formulas made readable;  mathml: formulas as MathML
claims          which kinds are proved
plant_loop      the loop as numbers: plant, model, gains, proved function;  local_loops, motion
*_drawing       figures;  plates: all figures of a design with captions and data
latex           the appendix
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.reports.plant.latex import plant_appendix
    from takagi.reports.plant.page import plant_figures, plant_report, plant_report_files

__all__ = ["plant_appendix", "plant_figures", "plant_report", "plant_report_files"]

_HOME = {
    "plant_appendix": "latex",
    "plant_figures": "page",
    "plant_report": "page",
    "plant_report_files": "page",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.reports.plant.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
