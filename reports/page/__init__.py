"""The elements of every HTML page.

assembly                 a page put together from sections; templates/ has what all share
labels                   labels of variables, in name and unit
text                     numbers as text, tables, figures with captions, sections
rounded_bounds           proved bounds, rounded to the side on which they stay true
mathml                   formulas as MathML
readable_latex           a derivation's formulas made readable
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.page.assembly import ReportFiles as ReportFiles
    from takagi.reports.page.assembly import render as render
    from takagi.reports.page.readable_latex import readable as readable
    from takagi.reports.page.text import Section as Section
    from takagi.reports.page.text import at_least as at_least
    from takagi.reports.page.text import at_most as at_most
    from takagi.reports.page.text import decimal as decimal
    from takagi.reports.page.text import powers as powers
    from takagi.reports.page.text import significant as significant
    from takagi.reports.page.text import with_decimals as with_decimals

__getattr__, __dir__ = lazy_names(__name__)
