"""What stands in the way and what would help, against thresholds that are known otherwise."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from takagi.lmi import common_lyapunov, explain, hinf_norm, max_decay_rate, pdc
from takagi.lmi.decision.outcome import Share, binding_items, binding_shares, shares_in_words
from takagi.lmi.explaining.explanation import on_smaller_box, with_narrower_premise
from takagi.models import Floats, ModelError, Premise, TSModel
from tests.lmi.known_models import three_rules


def have_common_p(A1: Floats, A2: Floats) -> bool:
    """Shorten and Narendra (2002), two stable 2 x 2 matrices: no negative real eigenvalue."""
    products = np.linalg.eigvals(np.array([A1 @ A2, A1 @ np.linalg.inv(A2)]))
    return not ((products.imag == 0) & (products.real < 0)).any()


def lpj12(low: float = 0.0, high: float = 20.0) -> Floats:
    return np.array([[[-2.0, 4.0], [-1.0 - change, -2.0]] for change in (low, high)])


def lost_authority() -> TSModel:
    """Return xdot = (1 - b / 2) x + a u with a in [-1/2, 1]: no input at a = 0, which is inside."""
    return TSModel(
        [[[1.0]], [[1.0]], [[0.5]], [[0.5]]],
        [[[-0.5]], [[1.0]], [[-0.5]], [[1.0]]],
        premises=[Premise("b", 0, 1), Premise("a", "-0.5", 1, unit="m")],
    )


def test_a_common_p_and_the_largest_box_that_has_one() -> None:
    """The share is bracketed: at it there is a common P by theorem, at a sixty-fourth more not."""
    model = TSModel(lpj12(), premises=[Premise("change", 0, 20, unit="1/s")])
    told = explain(common_lyapunov(model), model)

    assert told.box is not None
    half, more = 10.0 * told.box, 10.0 * (told.box + 1 / 64)
    assert have_common_p(*lpj12(10.0 - half, 10.0 + half))
    assert not have_common_p(*lpj12(10.0 - more, 10.0 + more))
    assert told.premises[0].share == told.box
    assert told.premises[0].upper == pytest.approx(10.0 + half)
    assert [share.label for share in told.binding] == ["vertex 1 of 2", "vertex 2 of 2"]
    assert told.rules == ("rule 1: change = 0 1/s", "rule 2: change = 20 1/s")
    assert f"{told.box:.0%} of it about its middle is enough" in str(told)


def test_shares_say_once_of_what_they_are() -> None:
    shares = [Share("rule 1", "pair", 0.564), Share("rules 1 and 2", "pair", 0.19)]
    answer = common_lyapunov(lpj12())
    assert answer.condition is not None
    told = binding_items(answer.condition, answer.multipliers, "vertex")

    assert shares_in_words(shares) == (
        "rule 1 (56% of the multipliers that show it), rules 1 and 2 (19%)"
    )
    assert told.startswith("the no rests on vertex 1 of 2 (") and told.count("multipliers") == 1
    assert f"  {told}\n" in str(explain(answer, lpj12()))
    assert binding_items(answer.condition, {}) == "the no depends on no single inequality"


def test_the_rate_of_a_common_p_is_the_largest_one() -> None:
    """By bisection what ``max_decay_rate`` finds by its own iteration: here V must grow."""
    told = explain(common_lyapunov(lpj12()), lpj12(), steps=12)
    largest = max_decay_rate(lpj12()).decay_rate

    assert largest is not None and told.decay_rate is not None
    assert largest - 0.02 < told.decay_rate <= largest
    assert "V may grow" in str(told)


def test_a_lower_rate_is_named_where_it_is_enough() -> None:
    told = explain(common_lyapunov([[-1.0]], decay_rate=2.0), [[-1.0]])

    assert told.decay_rate is not None
    assert 1.0 - 2.0 / 64 <= told.decay_rate <= 1.0
    assert told.box is None
    assert "not even its middle" in str(told)


def test_the_premise_that_takes_the_authority_away() -> None:
    """Gains exist for a in 1/4 +- 3/4 theta without 0, where nothing moves x: theta < 1/3."""
    model = lost_authority()
    told = explain(pdc(model), model)

    assert [one.name for one in told.premises] == ["a", "b"]
    share = told.premises[0].share
    assert share is not None and 1 / 3 - 1 / 64 <= share < 1 / 3
    assert told.premises[1].share is None
    assert all(found is False for _, found in told.relaxations)
    assert told.stuck is not None
    assert np.allclose(told.stuck.weights @ model.B.ravel(), 0.0, atol=1e-5)
    assert told.stuck.eigenvalue == pytest.approx(told.stuck.weights @ model.A.ravel(), abs=1e-4)
    assert told.stuck.eigenvalue > 0
    text = str(told)
    assert "premise b: a constant at its middle does not help" in text
    assert "no input moves the mode at" in text
    assert "lower decay rate" not in text


def test_a_blend_whose_mode_decays_by_itself_is_not_in_the_way() -> None:
    """Half of each rule has no input, and decays at 2 1/s; the no is due to the bounded gain."""
    model = TSModel([[[1.0]], [[-5.0]]], [[[1.0]], [[-1.0]]])
    told = explain(pdc(model, gain_bound=0.5), model, gain_bound=0.5)

    assert not told.found
    assert told.stuck is None


def test_the_cheapest_relaxation_that_helps_ends_the_search() -> None:
    """Kim and Lee (2000): gains by theirs, not by all pairs, Tuan's, or a slack."""
    told = explain(pdc(three_rules(0.0)), three_rules(0.0))

    assert dict(told.relaxations) == {"tuan": False, "tanaka-wang": False, "kim-lee": True}
    assert told.stuck is None
    assert "kim-lee has gains" in str(told)


@pytest.mark.slow
def test_the_options_are_those_that_were_given_before() -> None:
    model = TSModel([[[0.0, 1.0], [1.0, 0.0]]], [[[0.0], [1.0]]])
    design = pdc(model, input_limit=[0.5], initial_box=[1.0, 1.0])

    assert not explain(design, model, steps=1, input_limit=[0.5], initial_box=[1.0, 1.0]).found
    forgotten = explain(design, model, steps=1)
    assert forgotten.found and forgotten.asked_again == 1
    assert "nothing to explain" in str(forgotten)


def test_discrete_time() -> None:
    """x+ = 1.1 x, T = 0.1 s: V grows with log(1.1) / 0.1 = 0.953 1/s."""
    told = explain(common_lyapunov([[1.1]], sample_time=0.1), [[1.1]], sample_time=0.1, steps=12)

    assert told.decay_rate == pytest.approx(-np.log(1.1) / 0.1, abs=1e-3)


def test_a_model_need_not_be_one_of_ours() -> None:
    plain = SimpleNamespace(A=three_rules(0.0).A, B=three_rules(0.0).B)
    told = explain(pdc(plain), plain)

    assert told.box is not None and 0.9 < told.box < 1.0
    assert told.rules == ()


def test_an_answer_to_another_question_is_refused() -> None:
    norm = hinf_norm(-np.eye(2), np.ones((2, 1)), np.ones((1, 2)))
    with pytest.raises(ModelError, match="explain knows the answers of pdc and of common_lyapunov"):
        explain(norm, -np.eye(2))
    with pytest.raises(ModelError, match="input_limit has shape"):
        explain(pdc(three_rules(0.0)), three_rules(0.0), input_limit=[1.0, 2.0])


def test_items_without_a_share_are_not_named() -> None:
    A = np.concatenate([lpj12(), [[[-50.0, 0.0], [0.0, -50.0]]]])
    answer = common_lyapunov(A)
    assert answer.condition is not None
    shares = binding_shares(answer.condition, answer.multipliers, "vertex")

    assert {share.label for share in shares} == {"vertex 1 of 3", "vertex 2 of 3"}
    assert sum(share.share for share in shares) == pytest.approx(1.0, abs=0.02)
    assert [share.share for share in shares] == sorted((s.share for s in shares), reverse=True)
    assert binding_shares(answer.condition, {}) == ()


def two_premises(rules: list[tuple[int, int]] | None = None) -> TSModel:
    """Return A = a, B = b of a in [0, 4], b in [-1, 3] /s and with the rules in any order."""
    order = rules or [(0, 0), (0, 1), (1, 0), (1, 1)]
    A = [[[4.0 * c]] for c, _ in order]
    B = [[[-1.0 + 4.0 * c]] for _, c in order]
    premises = [Premise("a", 0, 4), Premise("b", -1, 3, unit="1/s")]
    return TSModel(A, B, premises=premises, rules=rules, states=["x [m]"], sample_time=0.5)


@pytest.mark.parametrize("rules", [None, [(1, 0), (0, 1), (1, 1), (0, 0)]])
def test_the_smaller_model_is_the_same_plant_where_both_hold(
    rules: list[tuple[int, int]] | None,
) -> None:
    model = two_premises(rules)
    smaller = on_smaller_box(model, Fraction(1, 4))

    assert [(one.lower, one.upper) for one in smaller.premises] == [
        (Fraction(3, 2), Fraction(5, 2)),
        (Fraction(1, 2), Fraction(3, 2)),
    ]
    for point in ([1.5, 0.5], [1.9, 1.4], [2.5, 1.5]):
        for before, after in zip(model.blend(point), smaller.blend(point), strict=True):
            assert np.allclose(before, after, rtol=0, atol=1e-14)
    assert (smaller.states, smaller.sample_time) == (("x [m]",), 0.5)


def test_a_premise_without_a_range_costs_no_rule() -> None:
    smaller = with_narrower_premise(two_premises(), 1, Fraction(0))

    assert smaller.rules == ((0, 0), (1, 0))
    assert smaller.A.ravel().tolist() == [0.0, 4.0]
    assert smaller.B.ravel().tolist() == [1.0, 1.0]
    assert with_narrower_premise(smaller, 1, Fraction(1, 2)) is smaller


def test_without_premises_the_vertices_move_to_their_mean() -> None:
    A, B = np.array([[[0.0]], [[4.0]]]), np.ones((2, 1, 1))
    half = Fraction(1, 2)

    assert on_smaller_box(TSModel(A, B), half).A.ravel().tolist() == [1.0, 3.0]
    plain = on_smaller_box(SimpleNamespace(A=A, B=B, C=None), half)
    assert plain.A.ravel().tolist() == [1.0, 3.0]
    assert not hasattr(plain, "C")
    assert on_smaller_box(A, half).ravel().tolist() == [1.0, 3.0]
    assert on_smaller_box(A[0], half).ravel().tolist() == [0.0]
