"""The best value of a parameter in a condition.

largest_parameter    the largest or smallest value with a solution; values that multipliers exclude
parameter_path       an interior-point path towards it; the value that given unknowns allow
parameter_sweep      one condition solved at many values, assembled once
least_over_rate      the decay rate at which a bound is least
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.parameter_search.largest_parameter import excluded_from as excluded_from
    from takagi.lmi.parameter_search.parameter_path import ParameterPencil as ParameterPencil
    from takagi.lmi.parameter_search.parameter_path import follow_path as follow_path

__getattr__, __dir__ = lazy_names(__name__)
