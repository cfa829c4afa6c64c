"""The members of a claim that state a quadratic function scheduled by the weights."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.requests.loop.decimals import rounded_up, short
from takagi.certificates.requests.loop.loop import ClaimedLoop

if TYPE_CHECKING:
    from takagi.lmi.polynomials.simplex_polynomials import PolynomialLyapunov


def scheduled_function(
    loop: ClaimedLoop,
    function: PolynomialLyapunov | None,
    rate_bounds: ArrayLike | Mapping[str, float],
    *,
    digits: int,
    polya: int,
) -> dict[str, Any]:
    """Return degrees, raised degree and coefficients of P(h), and in continuous time the rates.

    Parameters
    ----------
    function : P(h); None states P = I, which the checker answers with UNDECIDED.
    rate_bounds : of the premises or the memberships, as for ``FuzzyDecay``.
    digits : to which the coefficients are rounded.
    polya : how far the checker is to raise the degrees.
    """
    from takagi.lmi.varying.parameter_space import membership_rates, space_of

    space = space_of(loop.model, len(loop.model.A))
    if function is None:
        degrees = [0] * len(space.sizes)
        rows = [([[0] * size for size in space.sizes], np.eye(loop.A.shape[1]))]
    else:
        degrees = list(function.basis.degrees)
        starts = np.cumsum([0, *space.sizes])
        rows = [
            ([a[s:e].tolist() for s, e in zip(starts[:-1], starts[1:], strict=True)], P)
            for a, P in zip(function.basis.exponents, function.members, strict=True)
        ]
    stated: dict[str, Any] = {
        "degrees": degrees,
        "polya": polya,
        "P": [{"powers": a, "matrix": short(P, digits).tolist()} for a, P in rows],
    }
    if loop.sample_time is None:
        # A bound must be a number in a JSON file: a premise without one has None, not infinity.
        stated["rates"] = [
            [rounded_up(float(bound)) for bound in row] if np.isfinite(row).all() else None
            for row in membership_rates(space, rate_bounds)
        ]
    return stated
