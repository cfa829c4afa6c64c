"""Claims shown on pieces of the weights."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates import Verdict, certify
from takagi.certificates.checker import read_text
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.loop.halvings import pieces
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.coq.coq_export import coq_file
from takagi.certificates.requests import (
    Decay,
    FuzzyDecay,
    GainRounding,
    H2Norm,
    InputLimits,
    InvariantEllipsoid,
    L2Gain,
    ObservedFeedback,
    ObserverError,
    Peak,
    Poles,
    Transient,
)
from takagi.lmi import EigenvalueRegion
from takagi.models import Premise, TSModel
from tests.certificates.kinds.claims import (
    Data,
    law_data,
    model_data,
    resealed,
    verdict_of,
    verdicts,
)
from tests.certificates.test_thresholds import placed_loop

K = [[[0.0]], [[3.0]]]


def opposed(*, s: float = 3.0, step: float | None = None, **others: Any) -> TSModel:
    """Return x' = G(h) x + w, y = x with K above: G(h) = -1 + s h_1 h_2 for s = 3, in [-1, -1/4].

    The mean of the pair is 1/2, so that nothing holds for it.  With ``step`` x+ = x + step x'.
    """
    A, B = np.array([[[-1.0]], [[2 * s - 1]]]), np.array([[[1.0]], [[2.0]]])
    size = step or 1.0
    if step is not None:
        A, B = 1 + step * A, step * B
    given: Data = {"C": [[[1.0]]] * 2, "E": [[[size]]] * 2, "sample_time": step} | others
    names: Data = {"states": ["x [m]"], "inputs": ["u [N]"], "disturbances": ["w [N]"]}
    return TSModel(A, B, **given, **names, outputs=["y [m]"])


def dual() -> TSModel:
    """Return the same where an observer's gains L = K stand beside C in the place of B."""
    return opposed(C=[[[1.0]], [[2.0]]])


@pytest.mark.parametrize(("s", "verdict"), [(3.999, Verdict.PROVED), (4.0, Verdict.DISPROVED)])
def test_one_state_is_decided_at_its_threshold(s: float, verdict: Verdict) -> None:
    """G(h) = -1 + s h_1 h_2 < 0 for all h exactly where s < 4; the pairs say so up to s = 2."""
    gains = [[[0.0]], [[s]]]

    assert certify(opposed(s=s), gains, decay_rate=0).verdict is verdict


ASKED: list[tuple[str, Any, TSModel]] = [
    ("decay", Decay(0.2499), opposed()),
    ("region", Poles(EigenvalueRegion.half_plane(0.2499)), opposed()),
    ("transient", Transient(decay_rate=0.2), opposed()),
    ("gain-rounding", GainRounding(), opposed()),
    ("l2-gain", L2Gain(4.001), opposed()),
    ("h2-norm", H2Norm(1.4143), opposed()),
    ("peak", Peak(4.001), opposed()),
    ("invariant-ellipsoid", InvariantEllipsoid(), opposed(box={"x [m]": (-1, 1)})),
    (
        "invariant-ellipsoid",
        InvariantEllipsoid(disturbance_bounds=[0.2]),
        opposed(box={"x [m]": (-1, 1)}),
    ),
    (
        "input-limits",
        InputLimits(rates=True, membership_rates=[0.5, 0.5]),
        opposed(box={"x [m]": (-1, 1)}),
    ),
    ("observer", ObserverError(K, 0.2499), dual()),
    ("observed-feedback", ObservedFeedback(K, 0.2), dual()),
    ("decay", Decay(0.25), opposed(step=0.1)),
    ("l2-gain", L2Gain(4.001), opposed(step=0.1)),
    ("h2-norm", H2Norm(0.451), opposed(step=0.1)),
    ("invariant-ellipsoid", InvariantEllipsoid(), opposed(step=0.1, box={"x [m]": (-1, 1)})),
    ("input-limits", InputLimits(rates=True), opposed(step=0.1, box={"x [m]": (-1, 1)})),
]


@pytest.mark.parametrize(
    ("kind", "request_", "model"), ASKED, ids=[f"{k}-{i}" for i, (k, _, _) in enumerate(ASKED)]
)
def test_every_kind_is_shown_on_pieces(kind: str, request_: Any, model: TSModel) -> None:
    """A scalar loop, whose bounds are known: decay 1/4, gain 4, variance 2, peak 4."""
    found = certify(model, K, claims=[request_])
    claim = found.document["claims"][0]

    assert (claim["kind"], found.verdict) == (kind, Verdict.PROVED)
    # The pieces are what shows it.
    uncut = {key: value for key, value in claim.items() if key != "halvings"}
    assert verdicts(resealed({**found.document, "claims": [uncut]})) == ["UNDECIDED"]


@pytest.mark.parametrize(
    "request_", [Decay(0.2501), L2Gain(3.999), H2Norm(1.4142), ObserverError(K, 0.2501)]
)
def test_no_pieces_show_what_is_false(request_: Any) -> None:
    """A hair beyond the same bounds."""
    assert certify(dual(), K, claims=[request_]).verdict is not Verdict.PROVED


def test_a_scheduled_function_takes_higher_degrees() -> None:
    """P(h) without bounds on the rates is one P: its coefficients need (h_1 + h_2)^3."""
    found = certify(opposed(), K, claims=[FuzzyDecay()])

    assert found.verdict is Verdict.PROVED
    assert found.document["claims"][0]["polya"] >= 3


def test_where_no_scheduled_function_is_found_one_for_all_may_be() -> None:
    """s = 3.9: P(h) would need a degree of some forty; one P needs two pieces."""
    model, gains = opposed(s=3.9), [[[0.0]], [[3.9]]]
    found = certify(model, gains, claims=[FuzzyDecay()])

    assert found.verdict is Verdict.PROVED
    assert found.document["claims"][0]["kind"] == "decay"
    assert "one P for all weights" in found.tried


def test_ranges_of_premises_are_halved() -> None:
    """Two states, each ``opposed`` by a premise of its own: four rules, two cuts."""
    corners = [(0, 0), (0, 1), (1, 0), (1, 1)]
    a, b, k = (-1.0, 5.0), (1.0, 2.0), (0.0, 3.0)
    model = TSModel(
        [np.diag([a[p], a[q]]) for p, q in corners],
        [np.diag([b[p], b[q]]) for p, q in corners],
        premises=[Premise("z1", 0, 1), Premise("z2", 0, 1)],
        rules=corners,
    )
    gains = [np.diag([k[p], k[q]]) for p, q in corners]

    found = certify(model, gains, decay_rate=0.24)

    assert found.verdict is Verdict.PROVED
    assert {entry[0] for entry in found.document["claims"][0]["halvings"] if entry} == {0, 1}
    no = certify(model, gains, decay_rate=0.26)
    assert no.verdict is Verdict.DISPROVED


def test_a_set_in_the_ranges_of_inputs_is_found() -> None:
    """|u| <= 1.5 for u = -3 h_2 x: the set is |x| <= 1/2."""
    box = {"x [m]": (-1, 1), "u [N]": (-1.5, 1.5)}
    found = certify(opposed(box=box), K, claims=[InvariantEllipsoid()])

    assert found.verdict is Verdict.PROVED
    assert "it reaches 0.5 in x [m]" in found.checked.claims[0].text


def test_every_matrix_of_a_piece_is_a_theorem(tmp_path: Path) -> None:
    """Equal ones stand once: P, G at the rules, where h_1 h_2 = 0, and G where it is 1/4."""
    found = certify(*placed_loop(4.0), decay_rate=0)
    count = found.document["claims"][0]["halvings"].count([])
    text = coq_file(found.save(tmp_path / "certificate.json"))

    assert count == 2
    assert text.matrices == {1: 3}


def tree(rng: random.Random, sizes: list[int], depth: int) -> list[list[int]]:
    if depth == 0 or rng.random() < 0.2:
        return [[]]
    premise = rng.randrange(len(sizes))
    i, j = rng.sample(range(sizes[premise]), 2)
    below = [tree(rng, sizes, depth - 1) for _ in range(2)]
    return [[premise, i, j], *below[0], *below[1]]


def weights(count: int, corners: tuple[tuple[int, ...], ...] | None) -> PolytopicLoop:
    one = Matrix.identity(count)
    E = tuple(Matrix([[row[i]] for row in one.rows]) for i in range(count))
    return PolytopicLoop(A=(one,) * count, E=E, corners=corners, stated_rules=count)


@pytest.mark.parametrize("premises", [0, 2])
def test_the_pieces_cover_all_weights(premises: int) -> None:
    """Every blend lies in a piece."""
    rng, points = random.Random(premises), np.random.default_rng(premises)
    corners = ((0, 0), (0, 1), (1, 0), (1, 1)) if premises else None
    count, sizes = (4, [2, 2]) if premises else (3, [3])
    for _ in range(20):
        claim = {"halvings": tree(rng, sizes, 4)}
        read = read_text(json.dumps(claim), "claim")
        found = [
            np.array([[float(E[i, 0]) for i in range(count)] for E in piece.E])
            for piece in pieces(read, weights(count, corners), "claim")
        ]
        assert len(found) == claim["halvings"].count([])
        for _ in range(40):
            u = points.uniform(size=(2, 1))
            h = (
                np.prod(np.hstack([1 - u, u])[[0, 1], corners], axis=1)
                if corners
                else (points.dirichlet(np.ones(3)))
            )
            assert any(np.linalg.solve(rows.T, h).min() > -1e-9 for rows in found)


def test_no_tree_shows_a_loop_that_grows() -> None:
    """s = 4.1: the middle is unstable, and lies in a piece of every tree."""
    rng, model = random.Random(5), opposed(s=4.1)
    data = model_data(model.A.tolist(), B=model.B.tolist())
    claim: Data = {"name": "x", "kind": "decay", "decay_rate": 0, "P": [[1]]}
    for _ in range(100):
        cut = claim | {"halvings": tree(rng, [2], 6)}
        assert verdict_of(data, law_data([[[0]], [[4.1]]]), cut) == "UNDECIDED"
