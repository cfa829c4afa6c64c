"""Polynomial Lyapunov functions by sums of squares, posed as LMIs.

monomials             exponents, and the motion of monomials along x' = A x
polynomial            polynomials of the state with exact coefficients
gram                  Gram matrices: the L with m' L m = 0, and identities as equalities
homogeneous_lyapunov  common forms of degree 2, 4, 6, ... of a polytope of matrices
attraction_level      the largest level of a polynomial function inside the region of attraction
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.sums_of_squares.attraction_level import AttractionLevel as AttractionLevel
    from takagi.lmi.sums_of_squares.attraction_level import attraction_level as attraction_level
    from takagi.lmi.sums_of_squares.attraction_level import (
        attraction_level_condition as attraction_level_condition,
    )
    from takagi.lmi.sums_of_squares.homogeneous_lyapunov import (
        HomogeneousLyapunov as HomogeneousLyapunov,
    )
    from takagi.lmi.sums_of_squares.homogeneous_lyapunov import (
        homogeneous_lyapunov as homogeneous_lyapunov,
    )
    from takagi.lmi.sums_of_squares.homogeneous_lyapunov import (
        homogeneous_lyapunov_condition as homogeneous_lyapunov_condition,
    )
    from takagi.lmi.sums_of_squares.polynomial import StatePolynomial as StatePolynomial

__getattr__, __dir__ = lazy_names(__name__)
