"""A rigorous no for whatever is posed as a condition: relaxations, limits, costs, discrete time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from takagi.lmi import (
    LMI,
    Answer,
    Condition,
    Constant,
    Term,
    Unknown,
    common_lyapunov,
    common_lyapunov_condition,
    decide,
    exact_matrices,
    exact_no,
    h2_norm,
    h2_pdc,
    hinf_norm,
    hinf_pdc,
    lqr_pdc,
    lqr_pdc_condition,
    objective_below,
    observer,
    pdc,
    pdc_condition,
    peak_pdc,
    rigorous_no,
)
from takagi.lmi.gains.requirements.limits import Limits, limits_of
from takagi.lmi.refutation.exact_algebra import is_definite, is_semidefinite
from takagi.models import Floats, ModelError, TSModel
from tests.lmi.known_models import family_gain, three_rules


def saddle() -> TSModel:
    return TSModel([[[0.0, 1.0], [1.0, 0.0]]], [[[0.0], [1.0]]])


@dataclass
class Plain:
    """Arrays without a sample time of their own."""

    A: Floats
    B: Floats


def exactly_solvable(condition: Condition) -> bool:
    values = dict(decide(condition, rows={"nu": 1e4}).values)
    return all(
        (is_definite if lmi.strict else is_semidefinite)(F)
        for lmi in condition.lmis
        for F in exact_matrices(condition, lmi, values)
    )


@pytest.mark.parametrize(
    ("relaxation", "b"),
    # Brackets of the largest b, computed with cvxpy: 1.25931, 2.72516, 1.29987 at their lower ends.
    [("kim-lee", 1.2593), ("liu-zhang", 2.7252), ("polya-2", 1.2999)],
)
def test_rich_relaxations_on_both_sides_of_their_largest_b(relaxation: str, b: float) -> None:
    """Exact gains 1e-3 below, exact multipliers 1e-3 above: b is known to three digits."""
    below = pdc_condition(three_rules(b - 1e-3), relaxation=relaxation)
    above = pdc_condition(three_rules(b + 1e-3), relaxation=relaxation)

    assert exactly_solvable(below)
    assert exact_no(below) is None
    assert exact_no(above) is not None


limits = partial(limits_of, 2, 1)


@pytest.mark.parametrize(
    ("strict", "loose", "decay_rate"),
    [
        (limits(input_limit=0.5, initial_box=1.0), limits(input_limit=3.0, initial_box=1.0), 0.0),
        (limits(state_box=1.0, initial_box=0.99), limits(state_box=1.0, initial_box=0.3), 0.0),
        # The gain has to move an eigenvalue from 1 to below 0, and both below -3.
        (limits(gain_bound=0.5), limits(gain_bound=5.0), 0.0),
        (limits(gain_bound=5.0), limits(gain_bound=50.0), 3.0),
    ],
)
def test_limits_that_leave_no_gains(strict: Limits, loose: Limits, decay_rate: float) -> None:
    """These conditions have constants, so multipliers must make their sum negative as well."""
    none = pdc_condition(saddle(), limits=strict, decay_rate=decay_rate)
    some = pdc_condition(saddle(), limits=loose, decay_rate=decay_rate)

    assert exact_no(none) is not None
    assert exact_no(some) is None
    assert decide(some, rows={"nu": 1e4}).status == "candidate"


def test_only_huge_gains_are_gains_all_the_same() -> None:
    """Without authority but for 1e-6: bounds on the effort are no reason, and there is no proof."""
    model = TSModel([[[1.0]]], [[[1e-6]]])
    condition = pdc_condition(model)
    outcome = decide(condition, rows={"nu": 1e4})

    assert outcome.status != "infeasible"
    assert exact_no(condition, outcome.multipliers) is None


def test_discrete_time() -> None:
    """x+ = 1.25 x + u / 10^6 w.r.t. another rule of opposite sign: no gains by all pairs."""
    opposite = Plain(np.full((2, 1, 1), 1.25), np.array([[[1.0]], [[-1.0]]]))
    alike = Plain(np.full((2, 1, 1), 1.25), np.array([[[1.0]], [[0.5]]]))

    assert exact_no(pdc_condition(opposite, sample_time=0.1)) is not None
    assert exact_no(pdc_condition(alike, sample_time=0.1)) is None


def test_a_cost_for_rules_that_no_gains_stabilise() -> None:
    """The unknown W only ever helps: its multipliers are zero, and with them those beside it."""
    condition = lqr_pdc_condition(three_rules(0.0), np.eye(2), np.eye(1))
    alternative = exact_no(condition)

    assert alternative is not None
    assert not alternative.multipliers["bound of the cost"][0, :2].any()


def test_nothing_is_bounded_without_an_objective() -> None:
    with pytest.raises(ModelError, match="common quadratic.*has no objective"):
        objective_below(common_lyapunov_condition([[-1.0]]), 1.0)


def test_a_mode_that_no_input_moves_fast_enough() -> None:
    """The answer carries no multipliers; exact ones are found anew."""
    design = pdc(TSModel([[[-1.0, 1.0], [0.0, -0.5]]], [[[1.0], [0.0]]]), decay_rate=0.6)

    assert not design.answer.multipliers
    assert rigorous_no(design) is not None


def test_an_observer_for_an_output_that_shows_too_little() -> None:
    design = observer(TSModel(np.ones((2, 1, 1)), C=[[[1.0]], [[-1.0]]]))

    assert rigorous_no(design) is not None


def test_no_proof_is_made_of_a_yes() -> None:
    yes = common_lyapunov([[-1.0]])

    assert rigorous_no(yes) is None
    assert rigorous_no(pdc(saddle())) is None
    assert rigorous_no(Answer(status="infeasible", P=None, margin=-1.0)) is None


def test_multipliers_that_are_not_numbers_do_no_harm() -> None:
    condition = common_lyapunov_condition([[1.0]])
    nonsense = {"vertex": np.full((1, 1, 1), np.nan)}

    assert exact_no(condition, nonsense) is not None
    with pytest.raises(ModelError, match="there is no LMI 'vertexes'"):
        exact_no(condition, {"vertexes": np.ones((1, 1, 1))})


def test_an_unsettled_answer_may_still_be_a_no() -> None:
    """At b + 1/b = 10/3 the matrix is singular: floating point says neither yes nor no."""
    stable, singular = [[-4.0, -4.0], [1.0, 0.0]], [[-5.0, 0.0], [1.0, 0.0]]
    answer = common_lyapunov(np.array([stable, singular]))

    assert rigorous_no(replace(answer, status="unknown")) is not None


def scalar(factor: object, value: object) -> Condition:
    g = Unknown("g", 1, 1)
    return Condition(
        name="a number",
        unknowns=(g,),
        lmis=(
            LMI(
                name="sum",
                blocks=(1,),
                terms=(Term(unknown=g, left=np.array([[[factor]]])),),
                constants=(Constant(value=np.array([[[value]]])),),
            ),
            LMI(
                name="sign",
                blocks=(1,),
                terms=(Term(unknown=g, left=np.ones((1, 1, 1))),),
                strict=False,
            ),
        ),
    )


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_is_refused(bad: float) -> None:
    with pytest.raises(ModelError, match="finite"):
        exact_no(scalar(-1.0, bad))
    with pytest.raises(ModelError, match="finite"):
        exact_no(scalar(bad, 0.0))


def test_a_constant_of_wide_integers_is_not_rounded_to_a_contradiction() -> None:
    """2^53 + 1 - 2^53 is 1 > 0, and 0 where it is rounded."""
    whole = 2**53
    plain = LMI(
        name="difference",
        blocks=(1,),
        terms=(),
        constants=(
            Constant(value=np.array([[[whole + 1]]])),
            Constant(value=np.array([[[-whole]]])),
        ),
    )
    assert exact_no(Condition(name="one", unknowns=(), lmis=(plain,))) is None
    zero = Constant(value=np.zeros((1, 1, 1)))
    touched = LMI(name="zero", blocks=(1,), terms=(), constants=(zero,))
    assert exact_no(Condition(name="zero", unknowns=(), lmis=(touched,))) is not None


def test_nothing_is_contradicted_by_nothing() -> None:
    assert exact_no(Condition(name="nothing", unknowns=(), lmis=())) is None


# A drive in rpm and kN, far from units of order one: x1' = x2, x2' = -4 x1 - 0.8 x2 in SI.
SIZES = np.diag([1e-3, 9.55])
A = SIZES @ np.array([[0.0, 1.0], [-4.0, -0.8]]) @ np.linalg.inv(SIZES)
E = SIZES @ np.array([[0.0], [1.0]]) * 1e3
C = np.array([[1.0, 0.0]]) @ np.linalg.inv(SIZES) * 1e-6
MODEL = TSModel([A], [E / 50], C=[C], E=[E])
# The output, and the input in a weight at which the two cost about the same.
PERFORMANCE = (np.vstack([C, np.zeros((1, 2))]), np.array([[0.0], [1e-5]]))


@pytest.mark.parametrize(
    "ask",
    [
        lambda: hinf_norm(MODEL),
        lambda: h2_norm(MODEL),
        lambda: family_gain(MODEL),
        lambda: hinf_pdc(MODEL, performance=PERFORMANCE),
        lambda: h2_pdc(MODEL, performance=PERFORMANCE),
        lambda: peak_pdc(MODEL, performance=PERFORMANCE, decay_rate=0.5),
    ],
    ids=["hinf_norm", "h2_norm", "robust", "hinf_pdc", "h2_pdc", "peak_pdc"],
)
def test_a_gain_is_bounded_in_the_units_in_which_it_is_given(ask: Callable[[], Any]) -> None:
    answer = ask()
    gain = float(answer.gain)

    assert decide(objective_below(answer, 1.01 * gain)).status == "candidate"
    assert decide(objective_below(answer, 0.98 * gain)).status == "infeasible"


def test_the_h_infinity_norm_is_bounded_from_below_by_exact_multipliers() -> None:
    """0.999 of the peak of the frequency response: proved, in the drive's own units."""
    w = np.linspace(1.5, 2.5, 20_001)
    peak = max(abs((C @ np.linalg.solve(1j * v * np.eye(2) - A, E))[0, 0]) for v in w)

    no = exact_no(objective_below(hinf_norm(MODEL), 0.999 * peak))

    assert no is not None and no.holds
    assert f"gain below {0.999 * peak:.6g}" in str(no)


def test_the_least_cost_is_riccatis_in_the_units_of_the_weights() -> None:
    """A'P + PA - PBB'P/R + Q = 0: trace P from both sides, of the design and not of its LMIs."""
    B, Q, R = E / 50, np.diag([1e6, 1.0]), np.array([[1e-3]])
    least = float(np.trace(solve_continuous_are(A, B, Q, R)))
    design = lqr_pdc(MODEL, Q, R)

    assert design.cost == pytest.approx(least, rel=1e-3)
    assert decide(objective_below(design, 1.01 * least)).status == "candidate"
    no = exact_no(objective_below(design, 0.98 * least))
    assert no is not None and no.holds


def test_a_direct_path_is_not_undercut() -> None:
    """``peak_pdc`` adds the norm of D11: below it nothing can be asked."""
    model = TSModel([A], [E / 50], C=[C], E=[E])
    direct = (*PERFORMANCE, np.array([[0.5], [0.0]]))
    design = peak_pdc(model, performance=direct, decay_rate=0.5)

    with pytest.raises(ModelError, match="above 0.5, which a direct path adds"):
        objective_below(design, 0.4)


def test_what_minimised_nothing_is_refused() -> None:
    """A design at a decay rate has gains of least effort, which is no quantity of its own."""
    with pytest.raises(ModelError, match="minimised no gain and no cost"):
        objective_below(pdc(MODEL), 1.0)
    with pytest.raises(ModelError, match="the gain is -1; it must be positive"):
        objective_below(hinf_norm(MODEL), -1.0)
