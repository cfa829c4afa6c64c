"""The ladder of relaxations: order, theorems between them, sizes, and what none exceeds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.lmi import EigenvalueRegion, RelaxationResult, lqr_pdc, pdc, pdc_condition
from takagi.lmi.sums.relaxations import contains
from takagi.models import ModelError, Premise, TSModel
from tests.lmi.known_models import blended_rates, pendulum, three_rules

NAMES = (
    "common-gain",
    "wang-tanaka-griffin",
    "tanaka-wang",
    "tuan",
    "kim-lee",
    "liu-zhang",
    "polya-1",
    "polya-2",
)


def random_model(seed: int, *, premises: bool = False) -> TSModel:
    rng = np.random.default_rng(seed)
    r = 4 if premises else 3
    A = rng.standard_normal((2, 2)) + 0.8 * rng.standard_normal((r, 2, 2))
    B = rng.standard_normal((2, 1)) + 0.7 * rng.standard_normal((r, 2, 1))
    named = [Premise("z1", 0, 1), Premise("z2", 0, 1)] if premises else []
    return TSModel(A, B, premises=named)


def result_named(results: tuple[RelaxationResult, ...], name: str) -> RelaxationResult:
    return next(result for result in results if result.relaxation == name)


@pytest.mark.parametrize(
    ("relaxation", "limit"),
    [
        ("common-gain", -15.9656),
        ("wang-tanaka-griffin", -2.1432),
        ("tanaka-wang", -2.1432),
        ("tuan", -0.66993),
        ("polya-1", -0.66993),
        ("kim-lee", 1.25935),
        ("polya-2", 1.29992),
        ("liu-zhang", 2.72520),
        ("polya-4", 2.72785),
        ("polya-8", 3.93341),
        ("polya-16", 4.87284),
        ("polya-24", 5.36761),
    ],
)
def test_three_rules_close_to_each_limit(relaxation: str, limit: float) -> None:
    """Kim and Lee (2000): the brackets of b, recomputed; below b = 0 and above polya-8 our own."""
    below = pdc(three_rules(limit - 2e-3), relaxation=relaxation)
    assert below.found
    assert blended_rates(three_rules(limit - 2e-3), below).min() > 0
    assert pdc(three_rules(limit + 2e-3), relaxation=relaxation).status == "infeasible"


def test_auto_stops_at_the_first_gains_and_says_what_was_before() -> None:
    """At b = 2 Liu and Zhang's is the cheapest with gains; none of the poorer has any."""
    design = pdc(three_rules(2.0), relaxation="auto")

    assert design.relaxation == "liu-zhang" == design.ladder[-1].relaxation
    for result in design.ladder[:-1]:
        assert result.status in ("infeasible", "bound") and not result.found
    np.testing.assert_array_equal(
        design.require()[0], pdc(three_rules(2.0), relaxation="liu-zhang").require()[0]
    )


def test_auto_costs_one_cheap_solve_where_it_is_easy() -> None:
    """Two calls of the solver, as for one gain alone: to decide, and to lessen the effort."""
    design = pdc(pendulum(), relaxation="auto")

    assert [result.relaxation for result in design.ladder] == ["common-gain"]
    assert len(design.answer.tries) == 2


def test_a_no_of_auto_is_a_no_of_every_relaxation() -> None:
    """At b = 8 blends of the rules have no common V; nothing further is tried, and that is said."""
    design = pdc(three_rules(8.0), relaxation="auto")

    assert design.status == "infeasible" and design.gains is None and design.P is None
    assert design.answer.diagnosis.startswith("no gains by any relaxation: the no rests on ")
    assert "richer" not in design.answer.diagnosis
    assert result_named(design.ladder, "any relaxation").status == "infeasible"
    assert result_named(design.ladder, "polya-8").status == "not tried"
    assert pdc(three_rules(8.0), relaxation="polya-16").status == "infeasible"


def test_a_no_that_is_open_names_what_was_tried() -> None:
    """At b = 6 no result has gains, though the blends do not rule them out."""
    design = pdc(three_rules(6.0), relaxation="auto")

    assert design.status == "infeasible" and design.relaxation == "auto"
    assert "polya-8; of the last" in design.answer.diagnosis
    assert result_named(design.ladder, "any relaxation").status == "bound"


@pytest.mark.slow
@settings(max_examples=12)
@given(st.integers(0, 10_000), st.booleans())
def test_auto_is_never_worse_than_a_rung(seed: int, premises: bool) -> None:
    model = random_model(seed, premises=premises)
    names = (*NAMES, "product", "product-1") if premises else NAMES
    found = [pdc(model, relaxation=name).found for name in names]
    auto = pdc(model, relaxation="auto")

    assert auto.found >= any(found)
    for result in auto.ladder:
        if result.relaxation == "any relaxation" and result.status == "infeasible":
            assert not any(found)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::takagi.lmi.ZeroGainsWarning")
@settings(max_examples=12)
@given(st.integers(0, 10_000), st.booleans())
def test_what_contains_another_never_loses_its_gains(seed: int, premises: bool) -> None:
    """The table of theorems, against solves; it claims nothing between Tuan's and Kim-Lee's."""
    model = random_model(seed, premises=premises)
    names = (*NAMES, "product", "product-1", "product-liu-zhang") if premises else NAMES
    found = {name: pdc(model, relaxation=name).found for name in names}

    for rich in names:
        for poor in names:
            assert not (contains(rich, poor) and found[poor]) or found[rich], (rich, poor)


def test_the_bound_is_met_where_one_rule_decides() -> None:
    """With one rule all is known: common-gain alone, and auto asks for nothing more."""
    model = TSModel([[[1.0]]], [[[2.0]]])
    design = pdc(model, relaxation="auto", decay_rate="max", gain_bound=5.0)

    assert [result.relaxation for result in design.ladder] == ["common-gain"]
    assert design.decay_rate == pytest.approx(9.0, rel=2e-4)


@pytest.mark.parametrize("step", [None, 0.1])
def test_sizes_are_those_of_the_posed_condition(step: float | None) -> None:
    model = TSModel(
        [np.diag([1.2, 1.5])] * 4,
        [[[b], [b]] for b in (-1.0, 1.0, -2.0, 2.0)],
        premises=[Premise("z1", 0, 1), Premise("z2", 0, 1)],
        sample_time=step,
    )
    region = EigenvalueRegion.disc(3.0) & EigenvalueRegion.sector(1.2, apex=1.0)
    plain = ("Q positive definite", "scale of Q", "input effort")
    ladder = pdc(model, relaxation="auto", region=region).ladder
    assert len(ladder) == 15
    for result in ladder:
        if result.relaxation == "any relaxation":
            continue
        condition = pdc_condition(model, relaxation=result.relaxation, region=region)
        lmis = [lmi for lmi in condition.lmis if lmi.name not in plain]
        unknowns = [unknown for unknown in condition.unknowns if unknown.name not in ("Q", "nu")]
        assert result.lmis == sum(lmi.count for lmi in lmis)
        assert result.width == max(lmi.size for lmi in lmis)
        assert result.variables == sum(unknown.length for unknown in unknowns)


def test_a_rung_too_large_is_left_out_before_it_is_posed() -> None:
    """Twelve rules: polya-8 would be hundreds of thousands of LMIs; the ladder says so."""
    model = TSModel([np.eye(1)] * 12, [[[-1.0]], [[1.0]]] * 6)
    result = result_named(pdc(model, relaxation="auto").ladder, "polya-8")

    assert result.status == "not tried"
    assert result.note.startswith("too large: 352 716 LMIs")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"decay_rate": "max"}, "nothing bounds the gains"),
        ({"decay_rate": "max", "input_limit": [1.0]}, "nothing bounds the gains"),
        ({"decay_rate": "most"}, "decay_rate is 'most'"),
        ({"relaxation": "tuna"}, "'tuna' is not known"),
    ],
)
def test_misuse_is_refused(options: dict[str, object], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        pdc(pendulum(), **options)  # type: ignore[arg-type]


def test_auto_where_nothing_is_tried_but_one_after_another_is_refused() -> None:
    with pytest.raises(ModelError, match='"auto".*pdc and observer'):
        lqr_pdc(pendulum(), np.eye(2), np.eye(1), relaxation="auto")
