"""Amplitudes and rates of inputs on an invariant set: exact limits, and a simulation."""

from __future__ import annotations

from itertools import combinations_with_replacement, permutations, product
from typing import Any

import numpy as np

from takagi.certificates.requests import InputLimits
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import pdc
from takagi.models import TSModel, sector_model
from takagi.models.plant_files.loader import load_plant


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
