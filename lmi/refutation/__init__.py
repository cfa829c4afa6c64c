"""A rigorous no: exact multipliers and functions that exclude every solution of a condition.

refutation           multipliers of a condition as it was posed, made exact; also of an objective
contradiction        whether multipliers in floats leave no solution
exact_multipliers, multiplier_face      exact ones next to them; faces where they are singular
adjoint, alternative    a condition as one integer matrix; multipliers that rule it out
indefinite           a function that decays but is not positive; the test of a matrix
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.refutation.indefinite import is_definite as is_definite
    from takagi.lmi.refutation.indefinite import is_semidefinite as is_semidefinite

__getattr__, __dir__ = lazy_names(__name__)
