"""From fewer rules back to all of them: gains for the reduced model, proved on the vertices."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.certificates import Verdict, certify
from takagi.lmi import NormBounded, pdc
from takagi.models import (
    Plant,
    Premise,
    ReducedModel,
    TSModel,
    load_model,
    reduce_rules,
    sector_model,
)

RATE = 0.05  # 1/s


def plant(name: str) -> Plant:
    """Return a built-in plant."""
    found = load_model(name)
    assert isinstance(found, Plant)
    return found


@pytest.fixture(scope="module")
def tora() -> TSModel:
    return sector_model(plant("tora"))


def designed(reduced: ReducedModel, rate: float, *, robust: bool) -> np.ndarray:
    blocks = [NormBounded(*block) for block in reduced.error.blocks()]
    design = pdc(reduced.model, decay_rate=rate, uncertainty=blocks if robust else None)
    assert design.gains is not None
    return reduced.expanded(design.gains)


def test_gains_for_four_rules_and_their_error_are_proved_for_all_sixteen(tora: TSModel) -> None:
    """Every pair of the original's vertices decays, in exact arithmetic about emitted decimals."""
    reduced = reduce_rules(tora, "0.01")

    gains = designed(reduced, RATE, robust=True)

    assert (len(tora.rules), len(reduced.model.rules)) == (16, 4)
    assert gains.shape == (16, 1, 4)
    assert certify(tora, gains=gains, decay_rate=RATE).verdict is Verdict.PROVED


def weak_input(share: float) -> TSModel:
    """Return x' = x + (1 +- share) u: a premise in the input alone."""
    B = np.array([[[1 - share]], [[1 + share]]])
    return TSModel(np.ones((2, 1, 1)), B, premises=[Premise("z", 0, 1)])


def test_a_design_that_leaves_the_error_out_is_caught() -> None:
    """With u = -k x the mean needs k > 1; the vertex with 1 - share needs k > 1 / (1 - share).

    Gains of least effort for the mean do not reach that, and those with the error do.
    """
    model = weak_input(0.75)
    reduced = reduce_rules(model, 1)

    careless = designed(reduced, RATE, robust=False)
    careful = designed(reduced, RATE, robust=True)

    assert len(reduced.model.rules) == 1
    assert certify(reduced.model, gains=careless[:1], decay_rate=RATE).verdict is Verdict.PROVED
    assert certify(model, gains=careless, decay_rate=RATE).verdict is Verdict.DISPROVED
    assert certify(model, gains=careful, decay_rate=RATE).verdict is Verdict.PROVED


def test_expanded_gains_are_the_same_law() -> None:
    """sum_i h_i K_i with h of the original equals sum_j g_j K_j with g of the reduced model."""
    model = sector_model(plant("cart_pole"))
    names = [premise.name for premise in model.premises]
    reduced = reduce_rules(model, "0.1", together=[names])
    K = np.random.default_rng(3).normal(size=(len(reduced.model.rules), 1, 2))
    z = model.premise_values(angle=0.7, rate=2.0)

    whole = np.tensordot(model.memberships(z), reduced.expanded(K), axes=1)
    few = np.tensordot(reduced.memberships(z), K, axes=1)

    assert len(reduced.model.rules) == 3
    assert whole == pytest.approx(few, abs=1e-12)
