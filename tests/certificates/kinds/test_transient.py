"""Overshoot and settling time: exact limits, and a simulation."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.certificates import Verdict
from takagi.certificates.requests import Transient
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import TSModel
from tests.certificates.kinds.claims import Data, model_data, verdict_of


def plane() -> tuple[Data, Data]:
    """Return x' = -x in the plane, and a claim with the exact overshoot 2 of P = diag(1, 4)."""
    claim = {"name": "plane", "kind": "transient", "P": [[1, 0], [0, 4]], "decay_rate": 0.999}
    sizes = {"scales": [1, 1], "lower": 1, "overshoot": 2}
    return model_data([[[-1, 0], [0, -1]]]), claim | sizes | {
        "settled_share": 0.02,
        "settling_time": 4.6099,
    }


def test_overshoot_at_its_exact_limit() -> None:
    """kappa^2 is the condition number of P."""
    model, claim = plane()

    assert verdict_of(model, None, claim) == "PROVED"
    for mutant in ({"overshoot": 1.999999}, {"lower": 1.000001}, {"lower": 0.999999}):
        assert verdict_of(model, None, claim | mutant) == "UNDECIDED"


def test_settling_time_from_both_sides() -> None:
    """2 e^(-0.999 t) = 0.02 at t = ln(100) / 0.999 = 4.609779965..."""
    model, claim = plane()

    after = claim | {"settling_time": 4.60977997}
    before = claim | {"settling_time": 4.60977996}
    assert verdict_of(model, None, after) == "PROVED"
    assert verdict_of(model, None, before) == "UNDECIDED"


@pytest.mark.parametrize("discrete", [False, True])
def test_found_bound_holds_in_simulation(discrete: bool) -> None:
    """Blends that jump; the state over its bound stays below one, and has settled in time."""
    A = np.array([[[0.0, 1.0], [-2.0, -1.0]], [[0.0, 1.0], [-3.0, -2.0]]])
    step = 0.05 if discrete else 0.01
    A = np.eye(2) + step * A if discrete else A
    attempt = Transient().attempt(
        ClaimedLoop.of(TSModel(A, sample_time=step if discrete else None))
    )
    assert attempt.proved
    claim = attempt.claim

    draw = np.random.default_rng(4)
    steps = int(np.ceil(claim["settling_time"] / step))
    for _ in range(20):
        x = draw.normal(size=2)
        start = np.linalg.norm(x)
        for k in range(1, steps + 1):
            moved = np.einsum("i,ijk,k->j", draw.dirichlet([0.3, 0.3]), A, x)
            x = moved if discrete else x + step * moved
            bound = claim["overshoot"] * np.exp(-claim["decay_rate"] * k * step)
            assert np.linalg.norm(x) <= bound * start * 1.02
        assert np.linalg.norm(x) <= claim["settled_share"] * start * 1.02


def test_loop_without_decay_is_not_claimed() -> None:
    for step in (None, 0.3):
        attempt = Transient().attempt(ClaimedLoop.of(TSModel([[[1.0]]], sample_time=step)))
        assert attempt.checked.verdict is Verdict.UNDECIDED
