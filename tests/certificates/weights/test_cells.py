"""Every kind of claim against every kind of weights: what docs/blends.md says."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray

from takagi.certificates import Verdict, certify
from takagi.certificates.checker.replay.claim_kinds import READ
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.requests import FuzzyDecay, H2Norm, L2Gain, ObservedFeedback, ObserverError
from takagi.certificates.requests.request import Request
from takagi.models import Interval, ModelError, Output, Plant, TSModel, Variable, sector_model
from takagi.models.blending.substitution import blended_model
from takagi.models.laws.pdc import PdcLaw
from tests.certificates.kinds.claims import resealed
from tests.certificates.weights.cells import (
    EVIDENCE,
    cell_document,
    claim_of,
    cubic,
    plant_document,
    sampled,
    verdicts,
)
from tests.docs_pages import catalogue
from tests.models.blending.plants import ROOM, plant_of
from tests.symbolic_plants import plant_of as symbolic_plant

table = catalogue("catalogue.kinds")


def cells() -> Iterator[tuple[str, str, str]]:
    """Yield (kind, weights, what the page says); a blend needs a plant of its own."""
    for kind, row in table.CELLS.items():
        for form, said in zip(table.COLUMNS, row, strict=False):
            if said != "theorem (8)":
                yield kind, form, said


def test_every_kind_has_a_row() -> None:
    """A new kind of claim has to say what it means for each kind of weights."""
    named = {kind.partition(",")[0] for kind in table.CELLS}

    assert named == READ
    assert set(EVIDENCE) <= set(table.CELLS)


@pytest.mark.parametrize(("kind", "form", "said"), list(cells()))
def test_the_checker_says_what_the_page_says(kind: str, form: str, said: str) -> None:
    """The claim is written by hand, so that it is the checker which refuses."""
    found = verdicts(cell_document(kind, form))

    if said.startswith("refused"):
        assert found[0] == "REFUSED"
        return
    wanted = {"disproof": "DISPROVED"}.get(said, "PROVED")
    wanted = "UNDECIDED" if said.startswith("open") else wanted
    assert found[-1] == wanted


Floats = NDArray[np.float64]
x, v, u, w = sp.symbols("x v u w", real=True)


@pytest.mark.parametrize(
    ("gains", "request_", "words"),
    [
        # Held at x = 0.9, V = (x - xhat)^2 tends to (2 x^3 / (1 + 3 x^2 + L))^2 = 0.108, not to 0.
        (None, ObserverError([[1.0]]), "they cannot be evaluated; claim it of a sector model"),
        # V = x^2 + 100 e^2 rises at (x, e) = (0.9, 0.3), where every corner says V' < -V.
        ([[1.0]], ObservedFeedback([[1.0]]), "an observer needs the weights"),
        # Of x' = -10 x - x^3, V = (2 - x^2) x^2 has V' = 0 at x = 1; every slope says V' < -3.98 V.
        (None, FuzzyDecay(rate_bounds=22.0), r"P\(h\) needs the weights"),
        # w = 2 brings x to 1, and y = x^2 x to w / 2: more than the 0.3 that every corner shows.
        (None, L2Gain(output=([[[1.0]], [[0.0]]],)), "an output with a matrix for each rule"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_needs_the_weights_is_refused_of_averages_of_slopes(
    gains: Any, request_: Request, words: str
) -> None:
    """Each would be false.  That such a claim is refused is in ``cells``."""
    with pytest.raises(ModelError, match=words):
        certify(cubic("secants"), gains, claims=[request_])


def test_an_observer_of_a_plant_with_one_A_needs_no_weights() -> None:
    """x' = -x + u + (1 + w^2) w: only what the disturbance does is a blend, and it is left out."""
    plant = Plant(
        equations=(-x + u + w + w**3,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        inputs=(Variable(u, "-"),),
        disturbances=(Variable(w, "-", Interval.of(-1, 1)),),
        outputs=(Output("y", x, "-"),),
    )
    # The premise depends on w, which is not measured; that the slopes are averages is no matter.
    claim = {"kind": "observer", "P": [[1]], "decay_rate": 1, "L": [[[1]]]}
    assert verdicts(plant_document(secant_model(plant), claim)) == ["PROVED", "UNDECIDED"]


def test_a_function_that_no_weight_moves_is_decay() -> None:
    claim = {"kind": "fuzzy-decay", "decay_rate": 0.9, "degrees": [0], "polya": 0}
    claim |= {"rates": [[22, 22]], "P": [{"powers": [[0, 0]], "matrix": [[1]]}]}

    assert verdicts(plant_document(cubic("secants"), claim)) == ["PROVED", "PROVED"]


@pytest.mark.parametrize("degrees", [[1, 0], [0, 1]])
@pytest.mark.parametrize("form", ["sector", "secants"])
def test_a_function_of_one_of_two_weights(degrees: list[int], form: str) -> None:
    """x' = -x - x^3 beside v' = -v - v^3: of averages, one that moves P is enough to refuse."""
    sides = tuple(Variable(s, "-", Interval.of(-1, 1)) for s in (x, v))
    plant = Plant(equations=(-x - x**3, -v - v**3), states=sides, name="two")
    model = secant_model(plant) if form == "secants" else sector_model(plant)
    moving = degrees.index(1)
    P = [
        {"powers": [row, [0, 0]] if moving == 0 else [[0, 0], row], "matrix": [[1, 0], [0, 1]]}
        for row in ([1, 0], [0, 1])
    ]
    rates = [[1, 1] if degree else None for degree in degrees]
    claim = {"kind": "fuzzy-decay", "decay_rate": 0.5, "degrees": degrees, "polya": 0}

    found = verdicts(plant_document(model, claim | {"rates": rates, "P": P}))
    assert found[:2] == ["PROVED", "PROVED"] if form == "sector" else found[0] == "REFUSED"


@pytest.mark.parametrize("by_rule", ["", "C", "D", "F"])
def test_an_output_of_averages_has_one_matrix_of_each(by_rule: str) -> None:
    """y = x + u + w of the cubic plant, u = 0: C, D or F with one for each rule is refused."""
    output = {key: [[[1]]] * (2 if key == by_rule else 1) for key in "CDF"}
    claim = claim_of("l2-gain", gain=3, output=output)

    found = verdicts(plant_document(cubic("secants"), claim))
    assert found[0] == ("REFUSED" if by_rule else "PROVED")
    assert by_rule or found[1] == "PROVED"


def circular() -> tuple[TSModel, Floats]:
    """Return x' = x + (5 - u^2) u and gains for u = 0 and for |u| = 2."""
    z = sp.Symbol("z", real=True)
    plant = symbolic_plant(
        [x + (5 - u**2) * u],
        [x],
        [u],
        box={x: (-10, 10), u: (-2, 2)},
        premises={z: u**2},
        name="weak",
    )
    model = sector_model(plant)
    weak_at_rest = float(model.B[0, 0, 0]) > 3
    gains = np.array([[[0.3]], [[1.2]]] if weak_at_rest else [[[1.2]], [[0.3]]])
    return model, gains


def test_a_law_cannot_schedule_by_its_own_command() -> None:
    """Blends with the same u^2 in plant and law decay; the law as it is run does not."""
    model, gains = circular()
    law = PdcLaw(model, gains, np.zeros(1), np.zeros(1))

    command = float(law.command([6.5])[0])

    assert abs(command) <= 2
    assert 6.5 + (5 - command**2) * command > 4
    claim = {"kind": "decay", "P": [[1]], "decay_rate": 0.1}
    assert verdicts(plant_document(model, claim, gains)) == ["PROVED", "UNDECIDED"]
    assert verdicts(plant_document(model, claim, [[1.2]])) == ["PROVED", "PROVED"]


def test_premises_that_are_the_noise_are_left_open() -> None:
    """x' = -(2 + w^2) x + w: the weights of the plant are the noise of the same instant."""
    plant = Plant(
        equations=(-(2 + w**2) * x + w,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        disturbances=(Variable(w, "-", Interval.of(-1, 1)),),
        outputs=(Output("y", x, "-"),),
    )
    claim = {"kind": "h2-norm", "disturbance": "disturbances", "P": [[1]], "norm": 3}
    for model in (sector_model(plant), secant_model(plant)):
        assert verdicts(plant_document(model, claim))[-1] == "UNDECIDED"


def test_a_blend_beside_a_table_is_proved_and_beside_secants_refused(tmp_path: Path) -> None:
    """The room of the blend's tests with its loss from a table; then with another form stated."""
    (tmp_path / "loss.csv").write_text("-1, 0.5\n-0.5, 0.45\n0, 0.4\n0.5, 0.45\n1, 0.5\n")
    table = '[tables]\nloss = { file = "loss.csv", arguments = [{ name = "x", unit = "-" }] }\n'
    plant = plant_of(
        tmp_path, ROOM.replace("a*x", "loss(x)*x").replace("[equations]", table + "[equations]")
    )
    model = blended_model(plant)
    whole = certify(model, [[4.0, 6.0]])
    kinds = [claim["kind"] for claim in whole.document["claims"]]
    place = kinds.index("effort-blend")

    for kind in ("effort-blend", "bumpless"):
        assert whole.checked.claims[kinds.index(kind)].verdict is Verdict.PROVED
    stated = deepcopy(dict(whole.document))
    stated["model"]["embedding"]["form"] = "secant"
    stated["claims"] = [
        {"name": "s", "kind": "secant-embedding"},
        stated["claims"][place],
    ]
    assert verdicts(resealed(stated))[0] == "REFUSED"
    stated["claims"][1] = whole.document["claims"][kinds.index("bumpless")]
    assert verdicts(resealed(stated))[0] == "REFUSED"


@pytest.mark.parametrize("kind", sorted(READ))
def test_bounds_from_samples_prove_nothing(kind: str) -> None:
    """A peak of height 1 where samples see 0.1 at most: at x = 0.37 the plant is unstable."""
    model = sampled()
    claim = claim_of(kind)
    document = plant_document(model, claim, [[1.0]])
    narrow = document["model"]["embedding"]["premises"][0] | {"lower": 0, "upper": 0.1}
    document["model"]["embedding"]["premises"][0] = narrow
    document["gains"]["premises"][0] = narrow

    assert verdicts(resealed(document))[0] in ("UNDECIDED", "REFUSED")


def test_white_noise_through_a_secant_embedding() -> None:
    """x' = -x - x^3 + noise: E V' = -2 x^2 - 2 x^4 + 1, so the mean of x^2 is at most 1/2."""
    assert certify(cubic("secants"), claims=[H2Norm(0.7072)]).verdict is Verdict.PROVED
