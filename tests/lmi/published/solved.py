"""Each published problem once more, from its data to the number that docs/published.md prints."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from takagi.lmi import (
    He,
    Unknown,
    attraction_ellipsoid,
    common_lyapunov,
    exact_matrices,
    fuzzy_lyapunov_condition,
    h2_norm,
    hinf_norm,
    max_decay_rate,
    optimise,
    pdc,
    pose,
    trace,
)
from takagi.models import sector_model
from tests.lmi.compleib import LEAST_NORMS
from tests.lmi.known_models import (
    book_pair,
    cart_pole,
    family_gain,
    feasp_triple,
    gain_of,
    masses_and_spring,
    placed,
    rules_and_pair,
    tanaka_wang_rules,
)
from tests.lmi.norms import third_order
from tests.lmi.solver.control import control1
from tests.symbolic_plants import plant_of

ROLMIP_DISCRETE = [[["0.1", "0.9"], ["0", "0.1"]], [["0.5", "0"], ["1", "0.5"]]]
ROLMIP_PRINTED = [
    [["0.56664", "0.0039574"], ["0.0039574", "0.87634"]],
    [["1.0987", "0.062489"], ["0.062489", "0.45827"]],
]


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
    A1, A2 = np.array([[-1.0, 2.0], [0.0, -1.1]]), np.array([[-1.0, 1.1], [0.0, -2.0]])
    P1, P2 = (Unknown(name, 2, 2, symmetric=True) for name in ("P1", "P2"))
    tau, one = Unknown("tau", 1, 1), np.eye(2)
    return optimise(
        pose(
            He(P1 @ A1) << -one,
            He(P2 @ A1) + He(P1 @ A2) << -2 * one,
            He(P2 @ A2) << -one,
            trace(P1) <= tau,
            trace(P2) <= tau,
            minimise=tau,
        )
    ).objective


def level_of_the_cubic() -> float:
    """x' = -x + x^3 on |x| <= 0.99: the largest level of x^2 that is shown to settle."""
    x = sp.Symbol("x")
    answer = attraction_ellipsoid(
        sector_model(plant_of([-x + x**3], [x], box={x: (-0.99, 0.99)}), tolerance="1e-6")
    )
    assert answer.P is not None
    return float(1 / answer.P[0, 0])


def least_of_control1() -> tuple[float, float]:
    """SDPLIB: the objective of a point inside, and a lower bound by the multipliers."""
    outcome = optimise(control1())
    return outcome.objective, outcome.lower_bound


def rate_of(vertices: Any) -> float:
    rate = max_decay_rate(np.array(vertices)).decay_rate
    assert rate is not None
    return rate


NUMBERS: Mapping[str, Callable[[], float | tuple[float, ...]]] = {
    "rolmip-massspring-g0": lambda: gain_of(hinf_norm(masses_and_spring())),
    "rolmip-massspring-g1": lambda: gain_of(family_gain(masses_and_spring())),
    "rolmip-disc-7.1": residuals,
    "yalmip-robust4": least_larger_trace,
    "yalmip-decay": lambda: rate_of([[[-1.0, 2.0], [-3.0, -4.0]]]),
    "matlab-gevp": lambda: 2 * rate_of(feasp_triple()),
    "pc-G4-hinf": lambda: gain_of(hinf_norm(*third_order())),
    "pc-G4-h2": lambda: gain_of(h2_norm(*third_order())),
    "drake-cubic-roa": level_of_the_cubic,
    "pendulum-2rule": lambda: rate_of(rules_and_pair(cart_pole(), placed(cart_pole()))),
    "sdplib-control1": least_of_control1,
    # The designs are held to these norms by ``test_one_rule_has_the_optimum_of_compleib``.
    **{f"compleib-{name}-sf": lambda norms=norms: norms for name, norms in LEAST_NORMS.items()},  # type: ignore[misc]
}

STATUSES: Mapping[str, Callable[[], str]] = {
    "matlab-feasp": lambda: common_lyapunov(feasp_triple()).status,
    "qi-tao-jiang-2.3": lambda: common_lyapunov(book_pair(), sample_time=1.0).status,
    "tw-p58": lambda: pdc(tanaka_wang_rules()).status,
}
