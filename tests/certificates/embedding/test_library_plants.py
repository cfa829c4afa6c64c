"""Every plant of the library lies in its model: proved from its equations alone."""

from __future__ import annotations

import json

import numpy as np
import pytest

from takagi.certificates import Verdict, certify
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.document.plant_embedding import plant_data
from takagi.lmi import pdc
from takagi.models.files.library import built_in_kinds
from tests.certificates.embedding.plants import checked, library_model
from tests.certificates.kinds.claims import as_read

PLANTS = [name for name, kind in built_in_kinds().items() if kind == "plant"]


@pytest.mark.parametrize("name", PLANTS)
def test_the_embedding_is_proved(name: str) -> None:
    """Identity, ranges and determinants, with the standard library alone; the data are short."""
    model = library_model(name)

    found = checked(model)

    assert found.verdict is Verdict.PROVED, found.claims[0].text
    assert len(json.dumps(plant_data(model))) < 5000


@pytest.mark.parametrize("name", PLANTS)
def test_the_checker_makes_the_vertices_of_the_model(name: str) -> None:
    """Two ways: sympy's polynomials rounded to floats, and the checker's exact corners."""
    model = library_model(name)

    family = plant_loop(as_read(plant_data(model)))

    assert family.states == model.states
    assert family.corners == model.rules
    assert family.sample_time == model.sample_time
    for letter in "ABCDE":
        stack = getattr(family, letter)
        if stack:
            exact = [
                [[M[i, j] for j in range(M.shape[1])] for i in range(M.shape[0])] for M in stack
            ]
            np.testing.assert_allclose(
                np.array(exact, dtype=np.float64) + 0 * getattr(model, letter),
                getattr(model, letter),
                rtol=1e-14,
                atol=1e-300,
            )


def test_certify_puts_the_plant_in_front_of_its_claims() -> None:
    """The decay is about the blends of the exact vertices, and the plant is shown to be one."""
    model = library_model("flexible_joint")
    gains = pdc(model, decay_rate=0.2).gains

    certificate = certify(model, gains)

    assert certificate.document["model"]["kind"] == "plant"
    assert [c["kind"] for c in certificate.document["claims"]] == ["sector-embedding", "decay"]
    assert certificate.verdict is Verdict.PROVED
    assert "model of 2 rules exactly" in certificate.checked.claims[0].text
    assert "rules with their gains" in certificate.checked.claims[1].text


def test_a_law_with_other_weights_is_not_taken_for_one_with_the_models() -> None:
    """Cart-pole: the same gains, but a premise of the law that is computed otherwise."""
    model = library_model("cart_pole")
    certificate = certify(model, pdc(model, decay_rate=0.5).gains)
    data = as_read(certificate.document["model"])
    law = as_read(certificate.document["gains"])
    from takagi.certificates.checker.loop.model_loop import read_model_loop

    assert read_model_loop(data, law).shared_weights
    law["premises"][1]["expression"] = "cos(angle)"
    assert not read_model_loop(data, law).shared_weights
