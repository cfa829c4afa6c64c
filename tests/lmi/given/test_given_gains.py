"""Given gains: how much decay each relaxation shows, against closed forms and other conditions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.lmi import (
    closed_loop_condition,
    closed_loop_decay,
    closed_loop_ladder,
    decide,
    exact_no,
    max_decay_rate,
    parametrised,
    pdc,
)
from takagi.models import ModelError, TSModel


def placed(b: float, sample_time: float | None = None) -> tuple[TSModel, Any]:
    """Tanaka, Ikeda and Wang (1998), example 1 with a = 2: poles at -2, -2 in both rules.

    A_1 = A_2 and B_2 = b B_1, so K_2 = K_1 / b, and every blend is A_1 - c B_1 K_1.
    """
    A, B, K = (
        np.array([[2.0, -10.0], [1.0, 0.0]]),
        np.array([[1.0], [0.0]]),
        np.array([[6.0, -6.0]]),
    )
    gains = np.array([K, K / b])
    if sample_time is not None:
        A, B = np.eye(2) + sample_time * A, sample_time * B
    return TSModel([A, A], np.array([B, b * B]), sample_time=sample_time), gains


def slowest(c: float) -> float:
    """The slowest pole of s^2 + (6 c - 2) s + 10 - 6 c, the loop A_1 - c B_1 K_1, as a rate."""
    return -float(np.roots([1.0, 6 * c - 2, 10 - 6 * c]).real.max())


def three_rules() -> TSModel:
    """Kim and Lee (2000): three rules that tell the relaxations apart."""
    return TSModel(
        [[[1.59, -7.29], [0.01, 0.0]], [[0.02, -4.64], [0.35, 0.21]], [[-2.0, -4.33], [0.0, 0.05]]],
        [[[1.0], [0.0]], [[8.0], [0.0]], [[4.0], [-1.0]]],
    )


@pytest.mark.parametrize("b", [2.0, 2.5, 3.2])
def test_all_pairs_show_the_slowest_pole_of_the_mean_of_the_pair(b: float) -> None:
    """All pairs see the loop (G_12 + G_21) / 2, c = (b + 1/b) / 2: no decay from b = 3 on.

    The published threshold of Tanaka, Ikeda and Wang (1998), b + 1/b < 10/3, is where it is 0.
    """
    answer = closed_loop_decay(*placed(b))

    assert answer.decay_rate == pytest.approx(slowest((b + 1 / b) / 2), abs=1e-4)
    assert ((answer.decay_rate or 0.0) > 0) is (b < 3)


@pytest.mark.parametrize("name", ["tanaka-wang", "tuan", "kim-lee", "liu-zhang"])
def test_relaxed_conditions_show_the_slowest_pole_of_the_real_blends(name: str) -> None:
    """Real blends reach c = (2 + b + 1/b) / 4 only: their slowest pole, and none shows more."""
    b = 3.2

    answer = closed_loop_decay(*placed(b), relaxation=name)

    assert answer.decay_rate == pytest.approx(slowest((2 + b + 1 / b) / 4), abs=1e-4)


@pytest.mark.parametrize(("b", "status"), [(2.99, "candidate"), (3.01, "infeasible")])
def test_both_sides_of_the_published_threshold_are_decided(b: float, status: str) -> None:
    """Tanaka, Ikeda and Wang (1998): b < 3 by all pairs; the no by exact multipliers."""
    answer = closed_loop_decay(*placed(b), decay_rate=0.0)

    assert answer.status == status
    no = exact_no(closed_loop_condition(*placed(b)))
    assert (no is not None and no.holds) is (status == "infeasible")


def test_tuans_relaxation_ends_where_a_real_blend_loses_its_pole() -> None:
    """b + 1/b < 14/3, b < 4.4415: beyond it the blend (1/2, 1/2) is unstable itself."""
    limit = (14 / 3 + np.sqrt((14 / 3) ** 2 - 4)) / 2

    inside, outside = (
        closed_loop_decay(*placed(b), decay_rate=0.0, relaxation="tuan").status
        for b in (limit - 1e-2, limit + 1e-2)
    )

    assert (inside, outside) == ("candidate", "infeasible")


@pytest.mark.parametrize("sample_time", [None, 0.05])
def test_all_pairs_agree_with_the_decay_of_the_vertices_of_pairs(
    sample_time: float | None,
) -> None:
    """The same question to ``max_decay_rate``: rules, and means of pairs, as vertices."""
    model, gains = placed(2.5, sample_time)
    loop = model.A[:, None] - model.B[:, None] @ gains[None]
    vertices = [loop[0, 0], (loop[0, 1] + loop[1, 0]) / 2, loop[1, 1]]

    theirs = max_decay_rate(vertices, sample_time=sample_time).decay_rate

    assert closed_loop_decay(model, gains).decay_rate == pytest.approx(theirs, rel=1e-4)


def test_the_function_that_is_handed_back_decays_at_every_blend() -> None:
    """P of the answer, along a fine grid of blends: never slower than the rate; nearly attained."""
    model, gains = placed(3.2)
    answer = closed_loop_decay(model, gains, relaxation="tuan")
    P, rate = answer.P, answer.decay_rate
    assert P is not None and rate is not None

    worst = np.inf
    for h in np.linspace(0, 1, 201):
        share = np.array([h, 1 - h])
        A, B = (np.tensordot(share, part, 1) for part in (model.A, model.B))
        G = A - B @ np.tensordot(share, gains, 1)
        R = np.linalg.cholesky(P).T
        inside = R @ G @ np.linalg.inv(R)
        worst = min(worst, -float(np.linalg.eigvalsh(inside + inside.T).max()) / 2)

    assert rate - 1e-3 <= worst <= rate + 1e-3


def test_the_ladder_of_three_rules_has_gains_that_only_the_richest_relaxation_proves() -> None:
    """Kim and Lee's rules with gains by Liu and Zhang: others show growth; the bound is above all.

    The order of the relaxations that contain one another by theorems is kept.
    """
    gains, _ = pdc(three_rules(), relaxation="liu-zhang").require()
    names = ("wang-tanaka-griffin", "tanaka-wang", "tuan", "kim-lee", "liu-zhang")

    ladder = closed_loop_ladder(three_rules(), gains, relaxations=names)

    rate = {result.relaxation: float(result.decay_rate or np.nan) for result in ladder.results}
    assert (
        rate["wang-tanaka-griffin"] < rate["tanaka-wang"] < rate["kim-lee"] < 0 < rate["liu-zhang"]
    )
    assert rate["wang-tanaka-griffin"] < rate["tuan"]
    assert rate["any relaxation"] >= rate["liu-zhang"]
    assert ladder.best is not None and ladder.best.relaxation == "liu-zhang"
    assert "liu-zhang" in str(ladder) and "any relaxation" in str(ladder)


def test_broken_gains_are_not_shown_to_decay() -> None:
    """The sign of one gain turned: the rule alone is unstable, no relaxation shows decay."""
    model, gains = placed(2.0)
    broken = gains * np.array([[[1.0]], [[-1.0]]])

    ladder = closed_loop_ladder(model, broken, decay_rate=0.0)

    assert {result.status for result in ladder.results} == {"infeasible"}
    assert ladder.best is None


def test_one_gain_for_all_rules_needs_no_relaxation() -> None:
    """Theta does not depend on j then: one row, and the decay of the rules as vertices."""
    model, gains = placed(2.0)

    ladder = closed_loop_ladder(model, gains[0])

    first = ladder.results[0]
    vertices = model.A - model.B @ gains[0]
    assert first.relaxation == "common-gain"
    assert first.decay_rate == pytest.approx(max_decay_rate(vertices).decay_rate, rel=1e-4)


def test_rules_that_never_act_together_leave_the_rules_alone() -> None:
    """h_1 h_2 = 0: every rule by itself has its poles at -2, and all pairs show nearly that."""
    model, gains = placed(5.0)

    answer = closed_loop_decay(model, gains, overlap=np.eye(2))

    assert answer.decay_rate == pytest.approx(2.0, abs=1e-2)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"gains": np.zeros((3, 1, 2))}, "gains have shape"),
        ({"relaxation": "auto"}, 'relaxation "auto"'),
        ({"relaxation": "tanaka"}, "is not known"),
        ({"decay_rate": "most"}, "decay_rate"),
        ({"active_rules": 3}, "active_rules"),
    ],
)
def test_misuse_is_named(arguments: dict[str, Any], message: str) -> None:
    """Shapes, names and numbers are checked before anything is posed."""
    model, gains = placed(2.0)

    with pytest.raises(ModelError, match=message):
        closed_loop_decay(model, **{"gains": gains, **arguments})


def test_the_condition_is_data() -> None:
    """Posed without being solved; ``decide`` agrees with the function."""
    condition = closed_loop_condition(*placed(2.0), decay_rate=0.3)

    assert decide(condition).status == "candidate"
    assert parametrised(condition) is not None
