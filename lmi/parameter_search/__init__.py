"""The best value of a parameter in a condition.

largest_parameter    the largest or smallest value with a solution
parameter_path       an interior-point path towards that value
parameter_pencil     the largest value of the parameter that given unknowns allow
multiplier_bound     the values that the multipliers of a solver exclude
parameter_sweep      one condition solved at many values, assembled once
least_over_rate      the decay rate at which a bound is least
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.parameter_search.multiplier_bound import excluded_from as excluded_from
    from takagi.lmi.parameter_search.parameter_path import follow_path as follow_path
    from takagi.lmi.parameter_search.parameter_pencil import ParameterPencil as ParameterPencil

__getattr__, __dir__ = lazy_names(__name__)
