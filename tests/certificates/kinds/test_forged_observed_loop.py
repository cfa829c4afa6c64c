"""Claims about loops through an observer that are false, of another law, or malformed."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.document.certificate_file import certificate_document
from takagi.certificates.document.plant_embedding import slope_claim
from tests.certificates.kinds.claims import model_data, verdict_of
from tests.certificates.kinds.observed_documents import (
    Data,
    cubic,
    hidden,
    line,
    of_cubic,
    outcome,
)


@pytest.mark.parametrize("end", ["lower", "upper"])
def test_slopes_that_are_not_the_plants_prove_nothing(end: str) -> None:
    model, *others = of_cubic()
    forged = deepcopy(model)
    (premise,) = forged["slopes"]["premises"]
    width = float(premise["upper"]) - float(premise["lower"])
    premise[end] = float(premise[end]) + (0.1 if end == "lower" else -0.1) * width

    verdict, text = outcome(forged, *others)

    assert verdict == "UNDECIDED"
    assert "not proved to be the plant's" in text


def test_slopes_have_to_be_claimed() -> None:
    model, gains, first, _, claim = of_cubic()
    document = certificate_document(model=model, gains=gains, claims=[first, claim], provenance={})
    with pytest.raises(CertificateError, match="no claim about the slopes"):
        check_document(document)


def test_a_premise_that_is_not_measured_cannot_give_the_plants_weights() -> None:
    model, gains = hidden()
    forged = deepcopy(gains)
    forged["observer"] |= {"weights": "measured"}
    first = {"name": "model", "kind": "sector-embedding"}
    claim = {"name": "h", "kind": "observed-loop", "decay_rate": 0, "level": 1e-6}

    verdict, text = outcome(model, forged, first, claim | {"P": np.eye(4).tolist()})

    assert verdict == "UNDECIDED"
    assert "not measured" in text


def test_a_claim_about_another_law_is_refused() -> None:
    """decay of u = -K x says nothing of u = -K xhat."""
    model, gains, _ = line()
    claim = {"name": "d", "kind": "decay", "P": [[1]], "decay_rate": 1}
    document = certificate_document(model=model, gains=gains, claims=[claim], provenance={})
    with pytest.raises(CertificateError, match="another law"):
        check_document(document)


@pytest.mark.parametrize(
    "observer",
    [
        {"weights": "guessed", "measured": ["y"], "L": [[[4]]]},
        {"weights": "measured", "measured": ["w"], "L": [[[4]]]},
        {"weights": "measured", "measured": [], "L": [[[4]]]},
        {"weights": "measured", "measured": ["y", "y"], "L": [[[4, 4]]]},
        {"weights": "measured", "measured": ["y"], "L": [[[4], [4]]]},
        {"weights": "measured", "measured": ["y"], "L": [[[4]], [[4]]]},
        {"weights": "estimated", "measured": ["y"], "L": [[[4]]]},
        {"weights": "estimated", "measured": ["y"], "L": [[[4]], [[4]]]},
        {"weights": "measured", "measured": [["y"]], "L": [[[4]]]},
        {"weights": "measured", "measured": "y", "L": [[[4]]]},
    ],
)
def test_an_observer_that_does_not_fit_is_refused(observer: Data) -> None:
    model, gains, claim = line()
    document = certificate_document(
        model=model, gains=gains | {"observer": observer}, claims=[claim], provenance={}
    )
    with pytest.raises(CertificateError):
        check_document(document)


def test_outputs_are_needed() -> None:
    """A name of an output without its C: nothing says what L acts on."""
    model, gains, claim = line()
    stable = {**model, "A": [[[-1]]]}
    del stable["C"]
    document = certificate_document(
        model=stable, gains=gains, claims=[claim | {"P": [[1, 0], [0, 9]]}], provenance={}
    )
    with pytest.raises(CertificateError, match="no output"):
        check_document(document)


def test_one_gain_of_an_observer_at_its_estimate() -> None:
    """The weights at the estimate are not those of the error, so that L cannot go by them."""
    model, gains, *claims = of_cubic()
    two = deepcopy(gains)
    two["observer"]["L"] *= 2
    assert verdict_of(model, gains, *claims) == "PROVED"
    assert verdict_of(model, two, *claims) == "REFUSED"


@pytest.mark.parametrize("slopes", [None, [], 5, "A"])
def test_slopes_are_an_object_of_the_model(slopes: Any) -> None:
    model, gains, *claims = of_cubic()
    changed = deepcopy(model) | {"slopes": slopes}
    assert verdict_of(changed, gains, *claims) == "REFUSED"
    measured = deepcopy(gains)
    measured["observer"]["weights"] = "measured"
    assert verdict_of(changed, measured, *claims[:2]) == "REFUSED"


def test_slopes_have_those_of_the_outputs() -> None:
    model, gains, *claims = of_cubic()
    changed = deepcopy(model)
    del changed["slopes"]["C"]
    assert verdict_of(changed, gains, *claims) == "REFUSED"


def test_slopes_are_a_plants() -> None:
    """Matrices with the slopes of some plant beside them are not that plant's."""
    model, gains, _, slopes, claim = of_cubic()
    plain = {**model_data([[[1]], [[0]]], B=[[[1]]], C=[[[1]]]), "output_names": ["y"]}
    plain |= {"state_names": gains["state_names"], "input_names": gains["input_names"]}
    law = {k: v for k, v in gains.items() if k not in ("premises", "rules", "trim")}
    for whole in (plain, {**model, **plain}):
        for claims in ([claim], [slopes, claim]):
            found = verdict_of({**whole, "slopes": model["slopes"]}, law, *claims)
            assert found == "REFUSED"


def test_gains_are_those_of_the_rules() -> None:
    """Without gains, or with weights of their own, the loop is another."""
    model, gains, *claims = of_cubic()
    own = deepcopy(gains)
    own["premises"][0]["expression"] = "2*x"
    own["K"][0] = [[3.1]]
    assert verdict_of(model, own, *claims) != "PROVED"
    assert verdict_of(model, None, *claims) != "PROVED"


def test_a_state_and_an_input_of_one_name() -> None:
    """Their range in the box would be one, and nobody knows of which."""
    model, gains, claim = line()
    assert verdict_of(model, gains, claim) == "PROVED"
    named = {"input_names": ["x1 [-]"]}
    assert verdict_of(model | named, gains | named, claim) == "REFUSED"


@pytest.mark.parametrize("box", [[-1, 1], [-1, 3], [-3, 1]])
def test_the_nearer_end_of_a_range_counts(box: list[int]) -> None:
    """The range of a state, and that of an input: u = -3 (x - e), within 5.75 of ``line``."""
    model, gains, claim = line()
    for level, verdict in ((1, "PROVED"), (1.001, "UNDECIDED")):
        changed = model | {"box": {"x1 [-]": box}}
        assert verdict_of(changed, gains, claim | {"level": level}) == verdict
    for end, verdict in ((5.75, "PROVED"), (5.74, "UNDECIDED")):
        wide = [end * side if abs(side) == 1 else 9 * side for side in box]
        changed = model | {"box": {"x1 [-]": [-1, 1], "u [-]": wide}}
        assert verdict_of(changed, gains, claim) == verdict


def test_the_estimate_keeps_the_ranges_too() -> None:
    """P = diag(1, 100): x = xhat + e reaches sqrt(1.01 c), xhat sqrt(c)."""
    wide = deepcopy(cubic()[0])
    wide["inputs"][0]["range"] = [-4, 4]
    for P, level, verdict in (
        ([[1, 0], [0, 100]], 0.99, "PROVED"),
        ([[1, 0], [0, 100]], 0.9902, "UNDECIDED"),
        # x = xhat + e reaches less than xhat where both are opposed.
        ([[1.2, 1], [1, 100]], 1.19, "PROVED"),
        ([[1.2, 1], [1, 100]], 1.1901, "UNDECIDED"),
    ):
        found = verdict_of(*of_cubic(wide, P=P, level=level))
        assert found == verdict, (P, level)


def test_a_disturbance_at_rest_lies_in_its_range() -> None:
    """Its range has 0 inside or is refused; at rest it leaves no range, however small."""
    model, gains, claim = line()
    pushed = model | {"E": [[[1]]], "disturbance_names": ["w [-]"]}
    for box, verdict in (([-0.5, 0.5], "PROVED"), ([-0.5, 0], "PROVED")):
        changed = pushed | {"box": {"x1 [-]": [-1, 1], "w [-]": box}}
        assert verdict_of(changed, gains, claim) == verdict
    for box in ([0.1, 0.5], [-0.5, -0.1]):
        changed = pushed | {"box": {"x1 [-]": [-1, 1], "w [-]": box}}
        assert verdict_of(changed, gains, claim) != "PROVED"


@pytest.mark.parametrize("changed", [{"level": 0}, {"level": -1}, {"decay_rate": -0.001}])
def test_numbers_without_a_meaning_are_refused(changed: Data) -> None:
    assert verdict_of(*line(**changed)) == "REFUSED"


def test_products_of_gains_and_slopes_have_their_order() -> None:
    """Two states, one output: L R is 2 by 2, R L a number."""
    model, gains = hidden()
    # V of both parts at v^2 = 1/2, each alone, the error's 300 times as large.
    one, other = np.array([[0, 1], [-1, -1.5]]), np.array([[-3, 1], [-3, -1.5]])
    shape = np.zeros((4, 4))
    for k, (A, size) in enumerate(((one, 1), (other, 300))):
        part = slice(2 * k, 2 * k + 2)
        shape[part, part] = solve_continuous_lyapunov(A.T, -size * np.eye(2))
    claim = {"name": "h", "kind": "observed-loop", "decay_rate": 0, "level": 0.01}
    claims = [
        {"name": "model", "kind": "sector-embedding"},
        slope_claim("hidden"),
        claim | {"P": np.round(shape, 6).tolist()},
    ]
    assert verdict_of(model, gains, *claims) == "PROVED"
    text = outcome(model, gains, *claims)[1]
    assert "where the estimate starts at the measured states and else at rest" in text
