"""Symbolic sector nonlinearity: from equations of motion to an exact Takagi-Sugeno model.

model             sector_model and rule_count; arguments: from their arguments to a problem
terms, factored_form    ways to write f(x, u, w) as A(x) x + B(x) u + E(x) w, and to choose premises
common_denominator    forms that keep the determinant of a mass matrix in one premise
choice            fewest rules or the smallest hull (hull_width);  linear_span: exact elimination
factorisation     one factored form without a search;  given_quotients: premises that are given
premise_bounds    premises with proved ranges; with given or sampled ones
rule_counting     the number of rules, and the premises that could be left out at little cost
assembly          derivation and model from entries in premise symbols
exactness         whether the factored form is the plant: symbolically, or at points
multilinear       entries at all corners, each rounded once
rule_steps        rules and vertices in LaTeX; a band or a union of cells in LaTeX
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.ranges.expression_range import expression_range as expression_range
    from takagi.models.ranges.expression_range import expression_value as expression_value
    from takagi.models.sector.common_denominator import denominator_forms as denominator_forms
    from takagi.models.sector.common_denominator import sum_quotients as sum_quotients
    from takagi.models.sector.terms import terms_of as terms_of

__getattr__, __dir__ = lazy_names(__name__)
