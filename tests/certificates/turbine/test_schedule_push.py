"""``schedule-rate``: the state of V = 1 at which the nonlinear loop raises V most, by search.

The certificate is the first line of ``recorded/schedule-rate.jsonl``.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.schedule_field import SCHEDULE, WIND, Field, Floats

LAG, ESTIMATE, ETA = 3, 6, 7
STEP = 1e-6


@pytest.fixture(scope="module")
def field() -> Field:
    document: Any = json.loads(next(recorded("schedule-rate"))[1])
    return Field(document)


def slope(field: Field, xi: Floats, v_s: Floats, faster: float) -> Any:
    """Return V' at each state, with what is uncertain and the sign of v' where they raise V most.

    V' is linear in 1 over the inertia, in h, in 1 over the wake's length, and in v'.
    """
    y, family = field.states(xi, v_s), field.claim["uncertainty"]
    sent, P = field.commands(y)[1], field.P(v_s)
    towards = np.einsum("kij,jk->ik", P, xi)
    behind = y[1] - y[ETA]
    h = field.late(y[WIND]) * (towards[0] * behind < 0)
    length = np.where(towards[ETA] * behind > 0, *family["wake_length"])
    wind_rate = faster * field.claim["cells"][0]["wind_rate"] * np.sign(towards[LAG])
    bent = (field.P(v_s + STEP) - P) / STEP
    steep = (field.trim_pitch(v_s + STEP) - field.trim_pitch(v_s)) / STEP
    found = []
    for inertia in family["inertia"]:
        own = field.rates(y, sent, inertia, h, length, wind_rate)
        rates, moved = own[:SCHEDULE], own[SCHEDULE]
        rates[[1, ETA]] -= steep * moved
        rates[[LAG, ESTIMATE]] -= moved
        turned = np.einsum("ik,kij,jk->k", xi, bent, xi)
        found.append(2 * np.sum(towards * rates, axis=0) + moved * turned)
    return np.maximum(*found)


def most(field: Field, faster: float, seed: int) -> float:
    """Return the largest V' [1/s] that is found: random steps on V = 1, kept where V' grows."""
    rng, count = np.random.default_rng(seed), 150
    v_s = rng.uniform(field.places[0] + STEP, field.places[-1] - 2 * STEP, count)
    roots = np.array([np.linalg.inv(np.linalg.cholesky(P)).T for P in field.P(v_s)])

    def on_set(u: Floats) -> Floats:
        return np.asarray(np.einsum("kij,jk->ik", roots, u / np.linalg.norm(u, axis=0)))

    u, size = rng.normal(size=(SCHEDULE, count)), np.full(count, 0.5)
    best = slope(field, on_set(u), v_s, faster)
    for _ in range(350):
        u /= np.linalg.norm(u, axis=0)
        tried = u + size * rng.normal(size=u.shape) * (rng.random(u.shape) < 0.5)
        found = slope(field, on_set(tried), v_s, faster)
        better = found > best
        u, best = np.where(better, tried, u), np.where(better, found, best)
        size = np.where(better, np.minimum(1.5 * size, 1.0), np.maximum(0.93 * size, 1e-4))
    return float(np.max(best))


def test_v_falls_everywhere_on_the_set(field: Field) -> None:
    assert -0.06 < most(field, 1.0, seed=0) < 0


def test_it_does_not_at_a_rate_that_is_half_as_fast_again(field: Field) -> None:
    """Break on purpose; so these functions allow less than 1.5 times the proved rate."""
    assert most(field, 1.5, seed=1) > 0
