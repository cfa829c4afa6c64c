"""Amplitudes and rates of inputs on an invariant set: exact limits, a simulation, mutants."""

from __future__ import annotations

from itertools import combinations_with_replacement, permutations, product
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.requests import InputLimits
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import pdc
from takagi.models import ModelError, TSModel, sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.claims import law_data, model_data, said_of, verdict_of

Data = dict[str, Any]
MORE = 1 + 1e-12


def steered() -> tuple[Data, Data, Data]:
    """Return x' = x + u, u = -3 x on |x| <= 2: |u| <= 6, u' = 6 x so |u'| <= 12; and a claim."""
    claim = {"name": "steered", "kind": "input-limits", "P": [[1]], "level": 4, "multiplier": 4}
    rates = {"rate_limits": [12], "rate_shares": {"motion": [12]}}
    return model_data([[[1]]], B=[[[1]]]), law_data([[[3]]]), claim | {"input_limits": [6]} | rates


def two_gains() -> tuple[Data, Data, Data]:
    """Return x' = x + u, gains 3 and 5, |h'| <= 1/2, on |x| <= 1, and a claim at its limits.

    u' = (h1 3 + h2 5) (h1 2 + h2 4) x - (h1' 3 + h2' 5) x: at most 20 and 1/2 |5 - 3| = 1.
    """
    model, _, claim = steered()
    two = model | {"A": [[[1]], [[1]]]}
    shares = {"motion": [20], "memberships": [1]}
    evidence = {"level": 1, "input_limits": [5], "rate_limits": [21], "rate_shares": shares}
    return two, law_data([[[3]], [[5]]]), claim | evidence | {"membership_rates": [0.5, 0.5]}


def test_amplitude_and_rate_at_their_exact_limits() -> None:
    model, gains, claim = steered()

    found = said_of(model, gains, claim)
    assert found.verdict is Verdict.PROVED
    assert "|u_k| <= 6" in found.text
    assert "|u_k'| <= 12" in found.text
    for mutant in (
        {"input_limits": [6 / MORE]},
        {"rate_limits": [12 / MORE]},
        {"rate_shares": {"motion": [12 / MORE]}},
        {"level": 4 * MORE},
        {"multiplier": 4 * MORE},
    ):
        assert verdict_of(model, gains, claim | mutant) == "UNDECIDED"


def test_moving_memberships_move_the_input() -> None:
    model, gains, claim = two_gains()

    assert verdict_of(model, gains, claim) == "PROVED"
    for mutant in (
        {"rate_limits": [20.999]},
        {"rate_shares": {"motion": [19.999], "memberships": [1]}},
        {"rate_shares": {"motion": [20], "memberships": [0.999]}},
        {"membership_rates": [0.5001, 0.5001]},
        {"input_limits": [4.999]},
    ):
        assert verdict_of(model, gains, claim | mutant) == "UNDECIDED"
    slow = {"membership_rates": [0.41234567, 0.4], "rate_limits": [21.1234567]}
    text = said_of(model, gains, claim | slow).text
    assert "and |u_k'| <= 21.1235 for memberships with |h_j'| <= 0.412345, 0.4, along" in text
    # Rates sum to zero, so the slower membership holds back the other.
    slow = claim | {"membership_rates": [0.5, 9]}
    assert verdict_of(model, gains, slow) == "PROVED"


def test_sampled_input_moves_from_one_sample_to_the_next() -> None:
    """u(x+) - u(x) of x+ = x + u, u = -x/2: x/4."""
    model = model_data([[[1]]], B=[[[1]]], sample_time=1)
    claim = {"name": "s", "kind": "input-limits", "P": [[1]], "level": 1, "multiplier": 0.75}
    claim |= {"input_limits": [0.5], "rate_limits": [0.25], "rate_shares": {"motion": [0.25]}}
    gains = law_data([[[0.5]]], sample_time=1)

    assert "|u_k(x+) - u_k(x)| <= 0.25, along" in said_of(model, gains, claim).text
    less = {"rate_limits": [0.2499], "rate_shares": {"motion": [0.2499]}}
    assert verdict_of(model, gains, claim | less) == "UNDECIDED"


def test_sampled_memberships_jump() -> None:
    """Gains 1/2 and 3/2 with any h+: u(x+) - u(x) = (K+ (1 - K) - K) x: at most 9/4 in size."""
    model = model_data([[[1]], [[1]]], B=[[[1]]], sample_time=1)
    claim = {"name": "s", "kind": "input-limits", "P": [[1]], "level": 1, "multiplier": 0.75}
    claim |= {"input_limits": [1.5], "rate_limits": [2.25], "rate_shares": {"motion": [2.25]}}
    gains = law_data([[[0.5]], [[1.5]]], sample_time=1)

    assert verdict_of(model, gains, claim) == "PROVED"
    less = {"rate_limits": [2.2499], "rate_shares": {"motion": [2.2499]}}
    assert verdict_of(model, gains, claim | less) == "UNDECIDED"


def test_disturbance_pushes_the_input() -> None:
    """x' = -2 x + w, |w| <= 4 holds |x| <= 2; u' = 6 x - 3 w adds 12 to the rate."""
    model, gains, claim = steered()
    pushed = model | {"E": [[[1]]]}
    claim |= {"multiplier": 2, "disturbance": "disturbances", "disturbance_bounds": [4]}

    assert verdict_of(pushed, gains, claim) == "UNDECIDED"
    assert verdict_of(pushed, gains, claim | {"rate_limits": [24]}) == "PROVED"
    assert verdict_of(pushed, gains, claim | {"rate_limits": [23.999]}) == "UNDECIDED"


def test_each_rule_moves_with_its_own_matrix() -> None:
    """With A_2 = 1/2 the second rule alone is the fastest: 5 (5 - 1/2) = 22.5."""
    model, gains, claim = two_gains()
    apart = model | {"A": [[[1]], [[0.5]]]}
    claim |= {"rate_limits": [23.5]}

    for motion, verdict in ((22.5, Verdict.PROVED), (22.4999, Verdict.UNDECIDED)):
        shares = {"motion": [motion], "memberships": [1]}
        assert verdict_of(apart, gains, claim | {"rate_shares": shares}) == verdict.name


def test_rates_that_are_not_claimed() -> None:
    """Weights of the law's own, too many rules, too many memberships, a rate below zero."""
    model, gains, claim = two_gains()
    premises = [{"name": "z", "lower": 0, "upper": 1}]
    many = law_data([[[3 + j / 100]] for j in range(25)])
    some = law_data([[[3 + j / 100]] for j in range(11)])
    rules = {"A": [[[1]]] * 24 + [[[0.9]]]}
    wide = claim | {"level": 0.01, "membership_rates": [0.5] * 11}

    for other, law, evidence, words in (
        (model, gains | {"premises": premises, "rules": [[0], [1]]}, claim, "weights of its own"),
        (model | rules, many, claim, "more than 24 rules"),
        (model | {"A": [[[1]]] * 10 + [[[0.9]]]}, some, wide, "at most 10 memberships"),
        (model, gains, claim | {"membership_rates": [0.5, -0.5]}, "not negative"),
    ):
        with pytest.raises(CertificateError, match=words):
            said_of(other, law, evidence)


def test_one_gain_for_two_rules_needs_no_membership_rates() -> None:
    """x' = -x or -2 x under u = -3 x of x' = (2 or 1) x + u: u' = 3 x or 6 x, on |x| <= 2."""
    model, gains, claim = steered()
    two = model | {"A": [[[2]], [[1]]]}
    claim |= {"multiplier": 2}

    assert verdict_of(two, gains, claim) == "PROVED"
    for first, second in ((0.999, 1), (1, 0.999)):
        faster = model | {"A": [[[first]], [[second]]]}
        assert verdict_of(faster, gains, claim) == "UNDECIDED"


def test_limits_need_gains_and_evidence() -> None:
    model, gains, claim = steered()

    with pytest.raises(CertificateError, match="no gains"):
        said_of(model, None, claim)
    model, gains, claim = two_gains()
    with pytest.raises(CertificateError, match="membership"):
        said_of(model, gains, {k: v for k, v in claim.items() if k != "membership_rates"})


def mass() -> tuple[TSModel, Any]:
    model = sector_model(load_plant("mass_spring_damper"))
    return model, np.round(pdc(model, decay_rate=0.2).require()[0], 3)


def test_found_limits_are_those_of_the_float_bound() -> None:
    """The proved rate against |K(h) G(h) x| + |K(h)' x| from their rows, in floating point."""
    model, gains = mass()
    phi = 0.7

    attempt = InputLimits(rates=True, membership_rates=phi).attempt(ClaimedLoop.of(model, gains))

    assert attempt.proved
    claim = attempt.claim
    Q = np.linalg.inv(np.array(claim["P"]) / claim["level"])
    closed = model.A[:, None] - model.B[:, None] @ gains[None]
    rows = [
        np.mean([gains[j] @ closed[i, k] for j, i, k in permutations(rules)], axis=0)
        for rules in combinations_with_replacement(range(4), 3)
    ]
    # With one bound for four rates that sum to 0 two are at it, and two at its negative.
    signs = [s for s in product((-1, 1), repeat=4) if sum(s) == 0]
    moved = np.tensordot(signs, gains, axes=1)
    lengths = [max(float((row @ Q @ row.T)[0, 0]) ** 0.5 for row in part) for part in (rows, moved)]
    bound = lengths[0] + phi * lengths[1]
    assert bound <= claim["rate_limits"][0] <= bound * 1.001


def test_asked_limits_shape_the_set() -> None:
    """A set sought for half the inputs is larger than the free one made smaller."""
    model, gains = mass()
    free = InputLimits().attempt(ClaimedLoop.of(model, gains)).claim
    half = [0.5 * free["input_limits"][0]]

    asked = InputLimits(limits=half).attempt(ClaimedLoop.of(model, gains))

    assert asked.proved
    assert asked.claim["input_limits"] == half
    volumes = [np.linalg.det(np.array(c["P"]) / c["level"]) ** -0.5 for c in (asked.claim, free)]
    assert 0.25 * volumes[1] < volumes[0] < volumes[1]


def test_limits_alone_bound_the_set() -> None:
    """Without a box the set is as large as the limits let it be: |3 x| <= 6."""
    model = TSModel([[[1.0]]], [[[1.0]]])

    attempt = InputLimits(limits=[6.0]).attempt(ClaimedLoop.of(model, np.array([[3.0]])))

    assert attempt.proved
    reach = np.sqrt(attempt.claim["level"] / attempt.claim["P"][0][0])
    assert 1.999 < reach <= 2


def test_inputs_keep_their_limits_in_simulation() -> None:
    model, gains = mass()
    claim = InputLimits().attempt(ClaimedLoop.of(model, gains)).claim
    P, level = np.array(claim["P"]), claim["level"]

    draw = np.random.default_rng(3)
    x = np.linalg.solve(np.linalg.cholesky(P).T, draw.normal(size=(2, 2000)))
    x *= np.sqrt(level / np.einsum("ik,ij,jk->k", x, P, x))
    h = draw.dirichlet(np.full(len(gains), 0.2), size=2000)
    u = np.einsum("kr,rmn,nk->km", h, gains, x)
    assert 0.9 * claim["input_limits"][0] < np.abs(u).max() <= claim["input_limits"][0]


def test_misuse_raises() -> None:
    model, gains = mass()
    with pytest.raises(ModelError, match="give gains"):
        InputLimits().attempt(ClaimedLoop.of(model))
    with pytest.raises(ModelError, match="1 positive"):
        InputLimits(limits=[1.0, 2.0]).attempt(ClaimedLoop.of(model, gains))
    with pytest.raises(ModelError, match="membership_rates"):
        InputLimits(rates=True).attempt(ClaimedLoop.of(model, gains))
