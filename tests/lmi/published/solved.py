"""Each published problem once more, from its data to the number that docs/published.md prints."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import control
import numpy as np
import sympy as sp

from takagi.lmi import (
    LMI,
    Condition,
    Constant,
    Term,
    Unknown,
    attraction_ellipsoid,
    common_lyapunov,
    exact_matrices,
    fuzzy_lyapunov_condition,
    h2_norm,
    h2_pdc,
    hinf_norm,
    hinf_pdc,
    max_decay_rate,
    optimise,
    pdc,
)
from takagi.models import TSModel, sector_model
from tests.lmi.compleib import SYSTEMS
from tests.lmi.known_models import family_gain, masses_and_spring
from tests.lmi.norms import third_order
from tests.lmi.solver.control import control1
from tests.symbolic_plants import plant_of

GEVP: list[Any] = [[[-1, 2], [1, -3]], [[-0.8, 1.5], [1.3, -2.7]], [[-1.4, 0.9], [0.7, -2.0]]]
B58 = [[[1.0], [0.0]], [[25.0], [0.0]]]
BOOK_PAIR: list[Any] = [[[-0.6, 0.3], [0.1, -0.5]], [[-0.5, 0.2], [0.3, -0.5]]]
ROLMIP_DISCRETE = [[["0.1", "0.9"], ["0", "0.1"]], [["0.5", "0"], ["1", "0.5"]]]
ROLMIP_PRINTED = [
    [["0.56664", "0.0039574"], ["0.0039574", "0.87634"]],
    [["1.0987", "0.062489"], ["0.062489", "0.45827"]],
]


def two_rules() -> TSModel:
    """Tanaka and Wang (2001), page 58."""
    return TSModel([[[2.0, -10.0], [1.0, 0.0]], [[2.5, -10.0], [1.0, 0.0]]], B58)


def residuals() -> tuple[float, ...]:
    """ROLMIP manual, section 7.1: of h_1^2, h_1 h_2 and h_2^2, for the printed P."""
    exact = np.vectorize(Fraction, otypes=[object])
    condition = fuzzy_lyapunov_condition(exact(ROLMIP_DISCRETE), rate_bounds=0, sample_time=1.0)
    F = exact_matrices(condition, condition.lmis[-1], {"P": exact(ROLMIP_PRINTED)})
    found = np.linalg.eigvalsh(F.astype(np.float64))[:, 0]
    # A plain coefficient of h_1 h_2 is twice Bernstein's.
    return float(found[0]), float(2 * found[1]), float(found[2])


def least_larger_trace() -> float:
    """YALMIP, test_robust_4: min max(tr P_1, tr P_2) with sum_ij h_i h_j He(P_j A_i) <= -I."""
    A = np.array([[[-1.0, 2.0], [0.0, -1.1]], [[-1.0, 1.1], [0.0, -2.0]]])
    P, tau = Unknown("P", 2, 2, symmetric=True, count=2), Unknown("tau", 1, 1)
    one, rows = np.eye(2)[None], np.eye(2)[:, None, :]
    # h_1^2, h_1 h_2 (both orders, halved), h_2^2.
    decrease = Term(
        unknown=P,
        left=np.array([1, 0.5, 0.5, 1])[:, None, None] * one,
        right=A[[0, 0, 1, 1]],
        plus_transpose=True,
        items=np.array([0, 1, 1, 2]),
        members=np.array([0, 1, 0, 1]),
    )
    traces = [
        Term(unknown=P, left=-row[None], right=row.T[None], members=np.arange(2)) for row in rows
    ]
    lmis = (
        LMI(
            name="decrease",
            blocks=(2,),
            count=3,
            terms=(decrease,),
            constants=(Constant(value=one),),
            sign=-1,
        ),
        LMI(
            name="trace",
            blocks=(1,),
            count=2,
            terms=(Term(unknown=tau, left=np.ones((1, 1, 1))), *traces),
        ),
    )
    condition = Condition(
        name="least larger trace",
        unknowns=(P, tau),
        lmis=lmis,
        objective={"tau": np.ones((1, 1, 1))},
    )
    return float(optimise(condition).objective)


def level_of_the_cubic() -> float:
    """x' = -x + x^3 on |x| <= 0.99: the largest level of x^2 that is shown to settle."""
    x = sp.Symbol("x")
    answer = attraction_ellipsoid(
        sector_model(plant_of([-x + x**3], [x], box={x: (-0.99, 0.99)}), tolerance="1e-6")
    )
    assert answer.P is not None
    return float(1 / answer.P[0, 0])


def cart_pole_rate() -> float:
    """Wang, Tanaka and Griffin (1996): poles at -2, -2 in each rule; the common decay rate."""
    a, beta, half, gravity = 0.1, np.cos(np.deg2rad(88)), 0.5, 9.8
    first, second = 4 * half / 3 - a * 2 * half, 4 * half / 3 - a * 2 * half * beta**2
    A = np.array([[[0, 1], [gravity / first, 0]], [[0, 1], [2 * gravity / (np.pi * second), 0]]])
    B = np.array([[[0], [-a / first]], [[0], [-a * beta / second]]])
    K = [np.atleast_2d(control.acker(A[i], B[i], [-2, -2])) for i in range(2)]
    G = [[A[i] - B[i] @ K[j] for j in range(2)] for i in range(2)]
    return rate_of([G[0][0], G[1][1], (G[0][1] + G[1][0]) / 2])


def least_of_control1() -> tuple[float, float]:
    """SDPLIB: the objective of a point inside, and a lower bound by the multipliers."""
    outcome = optimise(control1())
    return outcome.objective, outcome.lower_bound


def rate_of(vertices: Any) -> float:
    """Return the largest common decay rate."""
    rate = max_decay_rate(np.array(vertices)).decay_rate
    assert rate is not None
    return rate


def gain_of(answer: Any) -> float:
    """Return a gain, of an answer or of a design."""
    found = getattr(answer, "answer", answer).gain
    assert found is not None
    return float(found)


def least_norms(name: str) -> tuple[float, float]:
    """COMPleib: the least H-infinity and H2 norm by u = -K x."""
    system = SYSTEMS[name]()
    model = TSModel([system.A], [system.B], E=[system.B1])
    performance = (system.C1, system.D12)
    return (
        gain_of(hinf_pdc(model, performance=performance, tolerance=1e-6)),
        gain_of(h2_pdc(model, performance=performance, tolerance=1e-6)),
    )


NUMBERS: Mapping[str, Callable[[], float | tuple[float, ...]]] = {
    "rolmip-massspring-g0": lambda: gain_of(hinf_norm(masses_and_spring())),
    "rolmip-massspring-g1": lambda: gain_of(family_gain(masses_and_spring())),
    "rolmip-disc-7.1": residuals,
    "yalmip-robust4": least_larger_trace,
    "yalmip-decay": lambda: rate_of([[[-1.0, 2.0], [-3.0, -4.0]]]),
    "matlab-gevp": lambda: 2 * rate_of(GEVP),
    "pc-G4-hinf": lambda: gain_of(hinf_norm(*third_order())),
    "pc-G4-h2": lambda: gain_of(h2_norm(*third_order())),
    "drake-cubic-roa": level_of_the_cubic,
    "pendulum-2rule": cart_pole_rate,
    "sdplib-control1": least_of_control1,
    **{f"compleib-{name}-sf": lambda name=name: least_norms(name) for name in SYSTEMS},  # type: ignore[misc]
}

STATUSES: Mapping[str, Callable[[], str]] = {
    "matlab-feasp": lambda: common_lyapunov(GEVP).status,
    "qi-tao-jiang-2.3": lambda: common_lyapunov(BOOK_PAIR, sample_time=1.0).status,
    "tw-p58": lambda: pdc(two_rules()).status,
}
