"""Rigorous ranges of expressions on boxes, with evidence that can be replayed.

expression_range      an expression: Bernstein form or ball arithmetic, branch and bound
bernstein_form        polynomials and rational functions, exact
tape, ball_form       expressions compiled to ball operations; derivative and Taylor forms of them
box_side, ball_operations, table_balls    boxes as balls; splines as operations on balls
symbolic_derivatives, linear_combination  derivatives; a new variable t for a sum x + 2 y
cell, domain          a box with dependent variables; boxes, bands around a curve, unions of cells
cell_enclosures, cell_search    one cell in a search; the search over cells
branch_and_bound      the range of any interval enclosure over boxes
evidence, replayed_leaves    trees of boxes that prove a range, and their replay
sampled               bounds from samples, which prove nothing

Every bound from this package holds for all points of the domain.  The only exception is
``sampled``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.intervals.interval import Interval as Interval
    from takagi.models.intervals.interval import exact as exact
    from takagi.models.ranges.cell import Cell as Cell
    from takagi.models.ranges.domain import Domain as Domain
    from takagi.models.ranges.evidence import Evidence as Evidence
    from takagi.models.ranges.evidence import replay as replay
    from takagi.models.ranges.expression_range import expression_value as expression_value
    from takagi.models.ranges.large_powers import (
        with_exponentials_as_symbols as with_exponentials_as_symbols,
    )
    from takagi.models.ranges.sampled import sampled_bounds as sampled_bounds

__getattr__, __dir__ = lazy_names(__name__)
