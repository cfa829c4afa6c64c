"""Published loops under parallel distributed compensation, designed and given."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import common_lyapunov, max_decay_rate, pdc, rigorous_no
from tests.lmi.known_models import (
    cart_pole,
    placed,
    rules_and_pair,
    tanaka_wang_rules,
    three_rules,
)


@pytest.mark.parametrize(("a", "b"), [(-3.0, 1.0), (2.5, 25.0), (10.0, 2000.0)])
def test_two_rules_have_gains_for_every_a_and_b(a: float, b: float) -> None:
    """Tanaka and Wang (2001), page 58: with free gains not a problem that tells methods apart."""
    model = tanaka_wang_rules(a, b)
    K, P = pdc(model).require()

    for inside in rules_and_pair(model, K):
        assert np.linalg.eigvalsh(P @ inside + inside.T @ P)[-1] < 0


@pytest.mark.parametrize("a", [-5.0, 0.0, 2.5, 10.0])
def test_given_gains_have_a_common_function_exactly_below_three(a: float) -> None:
    """Tanaka, Ikeda and Wang (1998): poles at -2, -2 in each rule; b + 1/b < 10/3, so b < 3."""
    below, above = tanaka_wang_rules(a, 3 - 1e-3), tanaka_wang_rules(a, 3 + 1e-3)
    inside = rules_and_pair(tanaka_wang_rules(a, 3.0), placed(tanaka_wang_rules(a, 3.0)))[2]

    assert abs(np.linalg.det(inside)) < 1e-9
    assert common_lyapunov(rules_and_pair(below, placed(below))).found
    assert common_lyapunov(rules_and_pair(above, placed(above))).status == "infeasible"


def test_cart_pole_gains_are_those_published() -> None:
    """Wang, Tanaka and Griffin (1996): F1 = [-120.67 -22.67], F2 = [-2551.6 -764.0]."""
    K = placed(cart_pole())

    np.testing.assert_allclose(K[0], [[-120.6667, -22.6667]], atol=5e-5)
    np.testing.assert_allclose(K[1], [[-2551.6, -764.0]], rtol=1e-4)


def test_cart_pole_gains_have_a_common_function_and_this_decay_rate() -> None:
    """Wang, Tanaka and Griffin (1996): a common P exists; the largest rate is 1.08720 1/s."""
    inside = rules_and_pair(cart_pole(), placed(cart_pole()))
    largest = max_decay_rate(inside)

    assert common_lyapunov(inside).found
    assert largest.decay_rate == pytest.approx(1.08720, abs=1e-5)
    assert common_lyapunov(inside, decay_rate=1.0872 - 1e-3).found
    assert common_lyapunov(inside, decay_rate=1.0872 + 1e-3).status == "infeasible"


def test_cart_pole_designed_with_gains_no_larger_decays_no_slower() -> None:
    model = cart_pole()
    bound = float(np.linalg.norm(placed(model), 2, axis=(1, 2)).max())
    design = pdc(model, decay_rate="max", gain_bound=bound)

    assert np.linalg.norm(design.require()[0], 2, axis=(1, 2)).max() <= bound
    shown = max_decay_rate(rules_and_pair(model, design.require()[0])).decay_rate
    assert shown is not None and shown >= design.decay_rate > 1.0872


@pytest.mark.parametrize("b", [2.854, 2.8676, 2.9])
def test_liu_and_zhangs_relaxation_has_an_exact_no_beyond_its_limit(b: float) -> None:
    """Kim and Lee (2000), whose limit by Liu and Zhang's relaxation is 2.7252: none is unknown."""
    design = pdc(three_rules(b), relaxation="liu-zhang")
    no = rigorous_no(design)

    assert design.status == "infeasible"
    assert no is not None and no.holds
