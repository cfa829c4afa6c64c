"""Output variance by compensation: COMPleib, Riccati equations, Gramians, the regulator, cvxpy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are, solve_discrete_are

from takagi.lmi import expressed, h2_pdc, h2_pdc_condition, lqr_pdc
from takagi.models import ModelError, TSModel
from tests.lmi.compleib import SYSTEMS
from tests.lmi.known_models import cost_of
from tests.lmi.norms import gramian_norm, sampled_gramian_norm
from tests.lmi.performance.disturbed import blends, gain_of, loop, three_rules, two_rules


@pytest.mark.parametrize("name", SYSTEMS)
def test_one_rule_has_the_optimum_of_compleib(name: str) -> None:
    """COMPleib (Leibfritz, 2004): the regulator's Riccati equation gives trace B1' X B1.

    The number recorded beside the system, the equation solved here, and the loop's own Gramian.
    """
    system = SYSTEMS[name]()
    design = h2_pdc(
        TSModel([system.A], [system.B], E=[system.B1]),
        performance=(system.C1, system.D12),
        tolerance=1e-6,
    )
    K = design.require()[0][0]
    A, B, C, D = system.A, system.B, system.C1, system.D12
    X = solve_continuous_are(A, B, C.T @ C, D.T @ D, s=C.T @ D)
    least = float(np.sqrt(np.trace(system.B1.T @ X @ system.B1)))

    assert least == pytest.approx(system.h2, rel=1e-7)
    assert gain_of(design) == pytest.approx(least, rel=3e-5)
    assert least * (1 - 1e-9) <= gramian_norm(A - B @ K, system.B1, C - D @ K) <= gain_of(design)


def test_one_rule_in_discrete_time_has_the_riccati_optimum() -> None:
    """The sum over samples: trace E' X E + D11' D11 with the discrete Riccati equation's X."""
    model = three_rules(0.1)
    A, B, C, D, E = (part[0] for part in (model.A, model.B, model.C, model.D, model.E))
    D11 = np.array([[0.3, 0.0], [-0.1, 0.2]])
    one = TSModel([A], [B], E=[E], sample_time=0.1)
    X = solve_discrete_are(A, B, C.T @ C, D.T @ D, s=C.T @ D)
    least = float(np.sqrt(np.trace(E.T @ X @ E) + np.trace(D11.T @ D11)))

    design = h2_pdc(one, performance=(C, D, D11))
    K = design.require()[0][0]
    assert gain_of(design) == pytest.approx(least, rel=1e-5)
    assert sampled_gramian_norm(A - B @ K, E, C - D @ K, D11) == pytest.approx(least, rel=1e-4)


@pytest.mark.parametrize(
    ("relaxation", "step"),
    [("common-gain", None), ("wang-tanaka-griffin", 0.1), ("tanaka-wang", None)],
)
def test_it_is_the_regulator_where_the_noise_is_the_start(
    relaxation: str, step: float | None
) -> None:
    """``lqr_pdc``, of several rules too: with z'z = x'Qx + u'Ru and E = L its cost is nu."""
    plain = three_rules(step)
    L = np.array([[1.0, 0.0, 0.0], [0.2, 0.8, 0.0], [0.0, -0.3, 0.5]])
    C, D = np.diag([1.0, 2.0, 0.5]), np.diag([0.7, 1.5])
    model = TSModel(plain.A, plain.B, E=L, sample_time=step)
    performance = (np.vstack([C, np.zeros((2, 3))]), np.vstack([np.zeros((3, 2)), D]))
    regulator = lqr_pdc(model, C.T @ C, D.T @ D, deviations=L, relaxation=relaxation)

    design = h2_pdc(model, performance=performance, relaxation=relaxation)
    assert gain_of(design) ** 2 == pytest.approx(cost_of(regulator), rel=1e-4)


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate:UserWarning")
@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_the_gramian_form_is_that_of_cvxpy_and_less_where_noise_enters_differently(
    sample_time: float | None,
) -> None:
    """The condition as data, read by cvxpy; of one rule both forms are the H2 norm."""
    model = three_rules(sample_time)
    design = h2_pdc(model, form="gramian")
    other = expressed(h2_pdc_condition(model, form="gramian"), margin=0.0)
    other.problem().solve(solver="CLARABEL")
    assert gain_of(design) ** 2 == pytest.approx(float(other.values()["nu"][0, 0, 0]), rel=3e-4)
    assert gain_of(design) < 0.9 * gain_of(h2_pdc(model))

    matrices = (part[:1] for part in (model.A, model.B, model.C, model.D, model.E))
    A, B, C, D, E = matrices
    alone = TSModel(A, B, C=C, D=D, E=E, sample_time=sample_time)
    both = h2_pdc(alone), h2_pdc(alone, form="gramian", tolerance=1e-6)
    assert gain_of(both[1]) == pytest.approx(gain_of(both[0]), rel=2e-4)


def test_the_gramian_form_bounds_every_instant_of_any_schedule() -> None:
    """The covariance from rest, by its own recursion, under random and adversarial memberships."""
    model, D11 = three_rules(0.1), 0.1 * np.eye(2)
    performance = model.C, model.D, D11
    design = h2_pdc(model, performance=performance, form="gramian")
    K, P = design.require()
    bound, rng, largest = np.linalg.inv(P), np.random.default_rng(5), 0.0
    for _ in range(20):
        covariance = np.zeros((3, 3))
        for h in rng.dirichlet(np.full(3, 0.2), size=60):
            A, E, C = loop(model, K, h)
            shown = C @ covariance @ C.T + D11 @ D11.T
            largest = max(largest, float(np.trace(shown)))
            covariance = A @ covariance @ A.T + E @ E.T
            assert np.linalg.eigvalsh(bound - covariance)[0] > 0

    assert 0.1 * gain_of(design) ** 2 < largest <= gain_of(design) ** 2


def test_a_decay_rate_and_a_gain_bound_hold_at_a_price() -> None:
    model = two_rules()
    free = h2_pdc(model)
    fast, bounded = h2_pdc(model, decay_rate=4.0), h2_pdc(model, gain_bound=10.0)
    poles = [np.linalg.eigvals(loop(model, fast.require()[0], h)[0]) for h in blends(2, 8)]

    assert float(np.max(np.concatenate(poles).real)) < -4.0
    assert np.linalg.norm(bounded.require()[0], 2, axis=(1, 2)).max() <= 10.0
    assert np.linalg.norm(free.require()[0], 2, axis=(1, 2)).max() > 10.0
    assert gain_of(fast) > gain_of(free) * 1.01
    assert gain_of(bounded) > gain_of(free) * 1.001


def test_white_noise_that_reaches_the_output_directly_is_refused() -> None:
    """In continuous time its variance is infinite; in discrete time it only adds."""
    performance = ([[1.0, 0.0]], None, [[0.5]])
    with pytest.raises(ModelError, match="infinite variance"):
        h2_pdc(two_rules(), performance=performance)
    with pytest.raises(ModelError, match="infinite variance"):
        h2_pdc_condition(two_rules(), performance=performance)

    assert gain_of(h2_pdc(two_rules(0.1), performance=performance)) > 0.5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"relaxation": "tuann"}, "relaxation 'tuann' is not known"),
        ({"performance": ([[1.0]],)}, r"C1 has shape \(1, 1\)"),
        ({"form": "gram"}, "form is 'gram'"),
        ({"gain_bound": -1.0}, "gain_bound is -1; it must be positive"),
        ({"tolerance": 1e-9}, "tolerance is 1e-09"),
    ],
)
def test_misuse_is_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        h2_pdc(two_rules(), **arguments)
