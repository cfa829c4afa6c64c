"""A published objective over the LMIs of a polynomial Lyapunov function."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.lmi import (
    LMI,
    Condition,
    Constant,
    Term,
    Unknown,
    optimise,
    polynomial_lyapunov_condition,
)


@pytest.mark.parametrize("polya", range(5))
def test_least_trace_of_yalmips_robust_example(polya: int) -> None:
    """YALMIP, test_robust_4: min max(tr P_1, tr P_2) = 1.8203 for each degree of Polya's theorem.

    sum_ij h_i h_j He(A_i' P_j) <= -I, recomputed 1.8203463.  As both traces count, so does their
    maximum; P needs no scale of its own.
    """
    A = [[[-1.0, 2.0], [0.0, -1.1]], [[-1.0, 1.1], [0.0, -2.0]]]
    posed = polynomial_lyapunov_condition(A, polya=polya)
    P, decrease = posed.unknowns[0], posed.lmis[-1]
    assert decrease.name == "decrease" and decrease.count == polya + 3
    tau = Unknown("tau", 1, 1)
    rows = np.eye(2)[:, None, :]
    traces = LMI(
        name="trace",
        blocks=(1,),
        terms=(
            Term(unknown=tau, left=np.ones((1, 1, 1))),
            *(
                Term(unknown=P, left=-row[None], right=row.T[None], members=np.arange(2))
                for row in rows
            ),
        ),
        count=2,
    )
    condition = Condition(
        name="least trace",
        unknowns=(P, tau),
        lmis=(
            posed.lmis[0],
            replace(decrease, constants=(Constant(value=np.eye(2)[None]),)),
            traces,
        ),
        objective={"tau": np.ones((1, 1, 1))},
        parameters=posed.parameters,
    )

    assert optimise(condition).objective == pytest.approx(1.8203463, abs=5e-6)
