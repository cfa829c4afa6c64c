"""A linear matrix inequality as data, and the functions that read it.

term, unknown         sums of L X R with constants, in blocks; some of its items; what is sought
statements            a condition from statements that were written with operators
evaluate              values put into it, in floats or in exact numbers; their decay rate
express, typeset      the same terms in cvxpy, in LaTeX or Markdown
region, uncertainty   regions for eigenvalues; norm-bounded uncertainty, as values
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.condition.evaluate import fractions as fractions
    from takagi.lmi.condition.evaluate import lmi_value as lmi_value
    from takagi.lmi.condition.evaluate import margin as margin
    from takagi.lmi.condition.evaluate import smallest_eigenvalues as smallest_eigenvalues
    from takagi.lmi.condition.term import Array as Array
    from takagi.lmi.condition.typeset import lmi_latex as lmi_latex
    from takagi.lmi.condition.uncertainty import Uncertainty as Uncertainty

__getattr__, __dir__ = lazy_names(__name__)
