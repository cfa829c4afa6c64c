"""Gains by parallel distributed compensation: relaxations, limits, a reasoned no."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import (
    Design,
    EigenvalueRegion,
    ZeroGainsWarning,
    common_lyapunov,
    h2_pdc,
    hinf_pdc,
    lqr_pdc,
    max_decay_rate,
    observer,
    pdc,
    rigorous_no,
)
from takagi.lmi.condition.evaluate import smallest_eigenvalues
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import (
    blended_rates,
    cart_pole,
    pendulum,
    placed,
    rules_and_pair,
    tanaka_wang_rules,
    three_rules,
)

ALL = ("common-gain", "wang-tanaka-griffin", "tanaka-wang", "tuan", "kim-lee", "liu-zhang")


@pytest.mark.parametrize("relaxation", [*ALL, "polya-0", "polya-3"])
def test_two_rules_have_gains_by_every_relaxation(relaxation: str) -> None:
    """Tanaka and Wang (2001), page 58: feasible, even with one gain; decay holds for all blends."""
    model = tanaka_wang_rules()
    design = pdc(model, decay_rate=0.5, relaxation=relaxation)

    assert design.gains is not None and design.gains.shape == (2, 1, 2)
    assert blended_rates(model, design).min() >= 0.5
    if relaxation == "common-gain":
        np.testing.assert_array_equal(design.gains[0], design.gains[1])


def test_limits_hold_on_the_ellipsoid() -> None:
    """|K_i x| <= 300 on x' P x <= 1, which holds the initial box and lies in the state box."""
    box = np.array([0.3, 0.5])
    design = pdc(
        pendulum(), decay_rate=0.5, input_limit=[300.0], initial_box=box, state_box=[1.0, np.inf]
    )
    K, P = design.require()
    Q = np.linalg.inv(P)

    assert np.sqrt(np.diagonal(K @ Q @ K.transpose(0, 2, 1), axis1=1, axis2=2)).max() <= 300
    assert np.sqrt(Q[0, 0]) <= 1
    for corner in (box, box * [1, -1]):
        assert corner @ P @ corner <= 1
    assert blended_rates(pendulum(), design).min() >= 0.5


def test_a_limit_too_tight_is_a_no_that_names_it() -> None:
    design = pdc(pendulum(), decay_rate=0.5, input_limit=[30.0], initial_box=[0.3, 0.5])

    assert design.status == "infeasible"
    assert "initial state" in design.answer.diagnosis or "limit of input" in design.answer.diagnosis
    with pytest.raises(ModelError, match="no gains were found"):
        design.require()


def test_gains_keep_their_bound_in_the_models_units() -> None:
    """The bound is on the gains as they are handed out, not on scaled ones."""
    free = pdc(pendulum(), decay_rate=0.5)
    bound = pdc(pendulum(), decay_rate=0.5, gain_bound=150.0)

    assert np.linalg.norm(free.require()[0], 2, axis=(1, 2)).max() > 150
    assert np.linalg.norm(bound.require()[0], 2, axis=(1, 2)).max() <= 150


def test_units_of_states_and_inputs_do_not_matter() -> None:
    plain = pdc(pendulum(), decay_rate=1.0)
    S, T = np.array([2.0**10, 2.0**-3]), 2.0**12
    other = TSModel(pendulum().A * S / S[:, None], pendulum().B * T / S[:, None])
    K, _ = pdc(other, decay_rate=1.0).require()

    np.testing.assert_allclose(K * T / S, plain.require()[0], rtol=1e-3)


def test_one_rule_with_two_inputs() -> None:
    """A single linear system with two inputs is a TS model with one rule."""
    model = TSModel([[[1.0, 2.0], [0.0, 3.0]]], [[[1.0, 0.0], [0.0, 1.0]]])
    for relaxation in (*ALL, "polya-1"):
        K, _ = pdc(model, relaxation=relaxation, decay_rate=1.0).require()
        assert np.linalg.eigvals(model.A[0] - model.B[0] @ K[0]).real.max() < -1


def test_a_gain_that_is_rounding_is_zero() -> None:
    """Two plants side by side share no state: each input's gain on the other's is exactly zero."""
    model = TSModel([np.diag([1.0, -2.0, 3.0])], np.eye(3)[:, [0, 2]], C=np.eye(3), E=np.eye(3))
    output = (np.eye(5)[:, :3], np.eye(5)[:, 3:])
    found = (
        pdc(model, decay_rate=0.5),
        lqr_pdc(model, np.eye(3), np.eye(2)),
        hinf_pdc(model, performance=output, tolerance=0.1),
        h2_pdc(model, performance=output),
    )

    for one in found:
        assert np.count_nonzero(one.require()[0]) == 2
    assert np.count_nonzero(observer(model, decay_rate=0.5).require()[0]) == 3


def random_rules(seed: int, step: float | None) -> TSModel:
    rng = np.random.default_rng(seed)
    A = 0.7 * rng.standard_normal((3, 3)) + 0.2 * rng.standard_normal((2, 3, 3))
    B = rng.standard_normal((3, 2)) + 0.2 * rng.standard_normal((2, 3, 2))
    return TSModel(A, B, sample_time=step)


@pytest.mark.parametrize(("a", "b", "bound"), [(1.0, 2.0, 5.0), (-3.0, 0.5, 1.0), (0.0, 1.0, 0.1)])
def test_a_scalar_reaches_what_its_largest_gain_gives(a: float, b: float, bound: float) -> None:
    """x' = a x + b u with |K| <= g: the largest rate is b g - a."""
    design = pdc(TSModel([[[a]]], [[[b]]]), decay_rate="max", gain_bound=bound)

    assert design.decay_rate == pytest.approx(b * bound - a, rel=2e-4)
    assert design.decay_rate < b * bound - a <= design.answer.bound * (1 + 1e-6)


def test_an_input_limit_bounds_the_gain_where_the_box_begins() -> None:
    """x' = x + 2 u, |u| <= 6 from |x| <= 3: the gain is 2 at most, the rate 3."""
    design = pdc(
        TSModel([[[1.0]]], [[[2.0]]]), decay_rate="max", input_limit=[6.0], initial_box=[3.0]
    )

    assert design.decay_rate == pytest.approx(3.0, rel=1e-3)
    assert design.decay_rate < 3.0


@pytest.mark.parametrize("relaxation", ["common-gain", "wang-tanaka-griffin", "liu-zhang"])
def test_the_largest_rate_has_gains_below_and_none_above(relaxation: str) -> None:
    found = pdc(pendulum(), decay_rate="max", gain_bound=300.0, relaxation=relaxation)
    alpha = found.decay_rate

    for share, exists in ((0.999, True), (1.001, False)):
        design = pdc(pendulum(), decay_rate=share * alpha, gain_bound=300.0, relaxation=relaxation)
        assert design.found is exists
    assert alpha < found.answer.bound < alpha * 1.001


@pytest.mark.slow
@settings(max_examples=10)
@given(st.integers(0, 10_000), st.sampled_from([None, 0.2]))
def test_gains_of_the_largest_rate_keep_bound_and_rate(seed: int, step: float | None) -> None:
    model = random_rules(seed, step)
    design = pdc(model, decay_rate="max", gain_bound=3.0)
    if not design.found:
        return
    K, P = design.require()
    h = np.random.default_rng(0).dirichlet(np.ones(2), 50)
    A, B, gain = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    L = np.linalg.cholesky(P)
    moved = np.linalg.solve(L, (A - B @ gain).transpose(0, 2, 1) @ L)
    if step is None:
        rates = -np.linalg.eigvalsh(moved + moved.transpose(0, 2, 1))[:, -1] / 2
    else:
        rates = -np.log(np.linalg.norm(moved, 2, axis=(1, 2))) / step

    assert np.linalg.norm(K, 2, axis=(1, 2)).max() <= 3.0
    assert rates.min() >= design.decay_rate - 1e-9


def test_gains_too_small_to_stabilise_are_a_no() -> None:
    """At |K| <= 50 the pendulum falls: no gains at decay rate 0, so no largest rate."""
    design = pdc(pendulum(), decay_rate="max", gain_bound=50.0)

    assert design.status == "infeasible" and design.gains is None
    assert "raise gain_bound" in design.answer.diagnosis


@pytest.mark.parametrize("step", [None, 0.2])
@pytest.mark.parametrize("relaxation", ["wang-tanaka-griffin", "kim-lee", "polya-2"])
def test_the_rate_shown_is_where_an_inequality_becomes_singular(
    step: float | None, relaxation: str
) -> None:
    design = pdc(random_rules(1, step), relaxation=relaxation)
    answer = design.answer
    assert answer.condition is not None and answer.decay_rate is not None
    least = []
    for share in (0.999, 1.0, 1.001):
        alpha = share * answer.decay_rate
        number = {"alpha": alpha} if step is None else {"contraction": np.exp(-2 * alpha * step)}
        condition = answer.condition.with_parameters(**number)
        eigenvalues = [
            smallest_eigenvalues(condition, lmi, answer.values).min()
            for lmi in condition.lmis
            if any(term.parameter is not None for term in lmi.terms)
        ]
        least.append(min(eigenvalues))

    assert least[0] > 1e-8 and least[2] < -1e-8
    assert abs(least[1]) < 1e-3 * min(least[0], -least[2])


def frozen_eigenvalues(model: TSModel, design: Design) -> NDArray[np.complex128]:
    K, _ = design.require()
    h = np.linspace(0, 1, 201)
    h = np.stack([h, 1 - h], axis=1)
    A, B, gain = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    return np.asarray(np.linalg.eigvals(A - B @ gain), dtype=np.complex128).ravel()


@pytest.mark.parametrize(
    ("region", "relaxation"),
    [
        (EigenvalueRegion.half_plane(3.0), "common-gain"),
        (EigenvalueRegion.disc(2.0, centre=-5.0), "wang-tanaka-griffin"),
        (EigenvalueRegion.vertical_strip(1.0, 5.0), "tanaka-wang"),
        (EigenvalueRegion.half_plane(3.0) & EigenvalueRegion.disc(9.0), "tuan"),
        (EigenvalueRegion.half_plane(3.0) & EigenvalueRegion.sector(0.3), "kim-lee"),
        (EigenvalueRegion.disc(4.0), "liu-zhang"),
        (EigenvalueRegion.half_plane(3.0) & EigenvalueRegion.disc(9.0), "polya-1"),
    ],
    ids=str,
)
def test_eigenvalues_of_all_blends_lie_in_the_region(
    region: EigenvalueRegion, relaxation: str
) -> None:
    """Chilali and Gahinet (1996); without the region some lie outside."""
    model = pendulum()
    free, held = (pdc(model, relaxation=relaxation, region=asked) for asked in (None, region))

    assert all(region.contains(z) for z in frozen_eigenvalues(model, held))
    assert not all(region.contains(z) for z in frozen_eigenvalues(model, free))


def test_a_disc_places_the_poles_of_a_sampled_loop() -> None:
    """Discrete time: |z - 0.6| < 0.3 for the eigenvalues of every blend."""
    design = pdc(pendulum(0.05), region=EigenvalueRegion.disc(0.3, centre=0.6))

    assert np.abs(frozen_eigenvalues(pendulum(0.05), design) - 0.6).max() < 0.3


@pytest.mark.parametrize(
    ("region", "reachable"),
    [
        (EigenvalueRegion.half_plane(1.9), True),
        (EigenvalueRegion.half_plane(2.1), False),
        (EigenvalueRegion.disc(2.1), True),
        (EigenvalueRegion.disc(1.9), False),
        (EigenvalueRegion.vertical_strip(1, 1.9) & EigenvalueRegion.disc(3), False),
    ],
    ids=str,
)
def test_a_mode_out_of_reach_decides(region: EigenvalueRegion, reachable: bool) -> None:
    """A mode at -2 that no input moves: only regions that hold it can be reached."""
    model = TSModel([[[-2.0, 0.0], [0.0, 1.0]]], [[[0.0], [1.0]]])

    assert pdc(model, region=region).found == reachable


def test_a_half_plane_is_a_decay_rate() -> None:
    """Re z < -alpha as a region and alpha as the rate are feasible for the same gains."""
    rates = pdc(pendulum(), decay_rate="max", gain_bound=300.0).decay_rate

    for share, exists in ((0.99, True), (1.01, False)):
        region = EigenvalueRegion.half_plane(share * rates)
        assert pdc(pendulum(), gain_bound=300.0, region=region).found is exists


@pytest.mark.parametrize(("options", "said"), [({"region": 3.0}, "an EigenvalueRegion is needed")])
def test_misuse_is_refused(options: dict[str, object], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        pdc(pendulum(), **options)  # type: ignore[arg-type]


def test_a_part_of_a_region_without_the_loop() -> None:
    """L < 0 alone, M = 0: every loop keeps it, and the gains are as without it."""
    assert pdc(pendulum(), region=EigenvalueRegion.lmi([[-1.0]], [[0.0]])).found
    assert not pdc(pendulum(), region=EigenvalueRegion.lmi([[1.0]], [[0.0]])).found


def test_gains_that_do_nothing_are_warned_of() -> None:
    """A plant that is stable by itself has gains of zero where no rate is asked for; K is gains."""
    stable = TSModel([[[-1.0, 0.2], [0.0, -2.0]], [[-1.5, 0.0], [0.3, -1.0]]], [[[0.0], [1.0]]] * 2)
    with pytest.warns(ZeroGainsWarning, match="the plant alone meets"):
        design = pdc(stable)
    assert design.K is design.gains is not None
    # Filters make warnings errors: of gains that do something there is none.
    assert pdc(pendulum()).found


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
