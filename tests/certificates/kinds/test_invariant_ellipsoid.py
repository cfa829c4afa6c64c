"""Sets that no solution leaves, and the box they lie in: exact limits, simulation, mutants."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.words.ellipsoid_size import (
    reaches,
    square_root_above,
    square_root_below,
    volume_below,
)
from takagi.certificates.document.model_data import ts_model_data
from takagi.certificates.requests import InvariantEllipsoid
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import TSModel
from tests.certificates.kinds.claims import Data, model_data, said_of, verdict_of

LESS = 1 - 1e-12
MORE = 1 + 1e-12


def line(**others: Any) -> tuple[Data, Data]:
    """Return x' = -2 x + w on |x| <= 1/2, where |w| <= 1 keeps it, and a claim at this limit."""
    model = model_data([[[-2]]], E=[[[1]]], box={"x1 [-]": [-0.5, 0.5]}, **others)
    claim = {"name": "line", "kind": "invariant-ellipsoid", "P": [[4]], "level": 1}
    disturbed = {"disturbance": "disturbances", "disturbance_bounds": [1], "multiplier": 2}
    return model, claim | disturbed


def wind_pushed() -> TSModel:
    """Return two rules with two disturbances on a box."""
    return TSModel(
        [[[0.0, 1.0], [-2.0, -1.0]], [[0.0, 1.0], [-3.0, -2.0]]],
        C=[[1.0, 0.0]],
        E=[[[0.0, 0.3], [1.0, 0.0]], [[0.1, 0.3], [1.0, 0.0]]],
        states=["p [m]", "v [m/s]"],
        disturbances=["a [m/s^2]", "b [m/s]"],
        box={"p [m]": (-1, 2), "v [m/s]": (-2, 2), "a [m/s^2]": (-1, 1), "b [m/s]": (-1, 1)},
    )


def test_disturbance_that_the_set_just_withstands() -> None:
    """|x| <= 1/2 is what |w| <= 1 holds x' = -2 x + w to: proved at the limit itself."""
    model, claim = line()

    found = said_of(model, None, claim)
    assert found.verdict is Verdict.PROVED
    assert "lies in the model's box" in found.text
    assert verdict_of(model, None, claim | {"disturbance_bounds": [MORE]}) == "UNDECIDED"
    assert verdict_of(model, None, claim | {"level": LESS}) == "UNDECIDED"
    assert verdict_of(model, None, claim | {"level": MORE}) == "UNDECIDED"


def test_more_work_than_a_reader_waits_for_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    model, claim = line()
    monkeypatch.setattr("takagi.certificates.checker.loop.polytopic_loop.MOST_WORK", 16)

    assert verdict_of(model, None, claim) == "PROVED"
    with pytest.raises(CertificateError, match="too many"):
        two = claim | {"disturbance_bounds": [0.5, 0.5]}
        said_of(model | {"E": [[[1, 1]]]}, None, two)


def test_found_sets_are_kept_in_simulation() -> None:
    """From the rim, blends and disturbances that switch: V never rises above the level."""
    model = wind_pushed()
    attempt = InvariantEllipsoid(disturbance_bounds="box").attempt(ClaimedLoop.of(model))
    assert attempt.proved
    P, level = np.array(attempt.claim["P"]), attempt.claim["level"]
    bounds = np.array(attempt.claim["disturbance_bounds"])

    draw = np.random.default_rng(2)
    rim = np.linalg.solve(np.linalg.cholesky(P).T, draw.normal(size=(2, 300)))
    rim *= np.sqrt(level / np.einsum("ik,ij,jk->k", rim, P, rim))
    h = draw.dirichlet([0.3, 0.3], size=300)
    w = draw.choice([-1.0, 1.0], size=(300, 2)) * bounds
    rate = np.einsum("ki,iab,bk->ka", h, model.A, rim) + np.einsum("ki,iaq,kq->ka", h, model.E, w)
    assert np.all(np.einsum("ka,ab,bk->k", rate, P, rim) <= 1e-9)
    assert np.all(np.abs(rim[0]) <= 1)


def test_disturbance_that_is_too_much_is_backed_off_and_said() -> None:
    model = wind_pushed()
    hard = TSModel(
        model.A,
        E=10 * model.E,
        states=model.states,
        disturbances=model.disturbances,
        box=model.box,
    )

    attempt = InvariantEllipsoid(disturbance_bounds="box").attempt(ClaimedLoop.of(hard))

    assert attempt.proved
    assert max(attempt.claim["disturbance_bounds"]) < 1
    asked = InvariantEllipsoid(disturbance_bounds=[1.0, 1.0]).attempt(ClaimedLoop.of(hard))
    assert asked.checked.verdict is Verdict.UNDECIDED


def test_largest_set_touches_the_box() -> None:
    """The volume of the largest ellipsoid in a square, of x' = -x: its circle, pi b^2."""
    model = TSModel(
        [-np.eye(2)], states=["x [-]", "y [-]"], box={"x [-]": (-3, 3), "y [-]": (-3, 4)}
    )

    attempt = InvariantEllipsoid(decay_rate=0.0).attempt(ClaimedLoop.of(model))

    assert attempt.proved
    P, level = np.array(attempt.claim["P"]), attempt.claim["level"]
    assert np.pi * level / np.sqrt(np.linalg.det(P)) == pytest.approx(9 * np.pi, rel=1e-3)


@given(st.fractions(max_denominator=10**6).filter(lambda end: end > 0), st.booleans())
def test_emitted_box_lies_inside_the_models(end: Fraction, negative: bool) -> None:
    """1/3 is not a decimal: the file's box must not reach beyond what the model was derived on."""
    side = (-2 * end, -end) if negative else (end, 2 * end)
    model = TSModel([[[-1.0]]], box={"z [-]": side})

    low, high = (Fraction(repr(e)) for e in ts_model_data(model)["box"]["z [-]"])

    assert side[0] <= low < high <= side[1]
    assert low - side[0] <= end * Fraction(1, 10**14)


entries = st.lists(st.integers(-9, 9), min_size=9, max_size=9)


@given(entries, st.integers(1, 50))
def test_size_is_rounded_to_the_safe_side(values: list[int], level: int) -> None:
    """Reach and volume by numpy's inverse and determinant, and on their safe sides of them."""
    root = np.reshape(values, (3, 3))
    whole = root @ root.T + np.eye(3, dtype=int)
    P = Matrix([[int(v) for v in row] for row in whole], 7)
    inverse = np.linalg.inv(whole / 7)
    ball = 4 / 3 * np.pi

    reach = np.sqrt(level * np.diag(inverse))
    assert np.array([float(r) for r in reaches(P, Fraction(level))]) == pytest.approx(
        reach, rel=1e-9
    )
    volume = ball * np.sqrt(level**3 / np.linalg.det(whole / 7))
    assert float(volume_below(P, Fraction(level))) == pytest.approx(volume, rel=1e-9)


@given(st.fractions(min_value=0, max_denominator=10**9))
def test_roots_lie_on_their_sides(value: Fraction) -> None:
    below, above = square_root_below(value), square_root_above(value)

    assert below**2 <= value < above**2
    assert above - below <= above * Fraction(1, 2**50) or value < Fraction(1, 10**9)
