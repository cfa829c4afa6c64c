"""The HTML report of a turbine design: one self-contained page, readable without JavaScript.

page          the page put together from its sections
text          numbers, tables and figures as values that the templates print
local_loops   the law linearised at its trims, whichever law it is
drawings      figures that only this page has
*_section     one section of the page each; its words are in templates/
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.reports.html.page import ReportFiles, report_html

__all__ = ["ReportFiles", "report_html"]

_HOME = {"ReportFiles": "page", "report_html": "page"}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.reports.html.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
