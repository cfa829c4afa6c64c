"""Exact solution of equalities between unknowns and data: free entries, and exact answers.

exact_solution    a condition with equalities as one in the free numbers alone; a rounded answer
                  that satisfies the equalities; its LMIs in exact arithmetic
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.equalities.exact_solution import exact_solution as exact_solution
    from takagi.lmi.equalities.exact_solution import parametrised as parametrised

__getattr__, __dir__ = lazy_names(__name__)
