"""Matrix expressions that are written with operators and are affine in the unknowns.

constant_data    reading of a known matrix, or of one for each vertex; its symbol
piece            one summand: left X right, or a known matrix
expression       sums of pieces in blocks, with @, *, +, -, .T, >>, <<, >=, <=, ==
matrices         He, block, trace, and known matrices with a name
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.expressions.expression import Equation as Equation
    from takagi.lmi.expressions.expression import Expression as Expression
    from takagi.lmi.expressions.expression import Inequality as Inequality
    from takagi.lmi.expressions.expression import Operators as Operators
    from takagi.lmi.expressions.matrices import He as He
    from takagi.lmi.expressions.matrices import block as block
    from takagi.lmi.expressions.matrices import matrix as matrix
    from takagi.lmi.expressions.matrices import trace as trace

__getattr__, __dir__ = lazy_names(__name__)
