"""Eigenvalues in a region: matrices whose eigenvalues are known, from both sides of its edge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.certificates import Verdict, certify
from takagi.certificates.requests import Poles
from takagi.lmi import EigenvalueRegion
from takagi.models import TSModel
from tests.certificates.kinds.claims import Data, model_data, said_of, verdict_of

HAIR = 1e-9
# -1 +- 1j; normal, so that P = I shows whatever any P shows.
SPIRAL = [[-1, 1], [-1, -1]]


def part(region: EigenvalueRegion) -> list[Data]:
    return [
        {"L": np.asarray(L, dtype=float).tolist(), "M": np.asarray(M, dtype=float).tolist()}
        for L, M in (one.matrices for one in region.parts)
    ]


def parabola(width: float) -> EigenvalueRegion:
    return EigenvalueRegion.lmi([[0.0, 0.0], [0.0, -width]], [[0.5, 0.5], [-0.5, 0.0]])


def claim(region: EigenvalueRegion, **others: Any) -> Data:
    return {
        "name": "poles",
        "kind": "region",
        "P": [[1, 0], [0, 1]],
        "parts": part(region),
        **others,
    }


@pytest.mark.parametrize(
    ("inside", "outside", "words"),
    [
        (EigenvalueRegion.half_plane(1 - HAIR), EigenvalueRegion.half_plane(1), "Re z < -1"),
        (
            EigenvalueRegion.horizontal_strip(1 + HAIR),
            EigenvalueRegion.horizontal_strip(1),
            "|Im z| < 1",
        ),
        (
            EigenvalueRegion.disc(1 + HAIR, centre=-1),
            EigenvalueRegion.disc(1, centre=-1),
            "|z + 1| < 1",
        ),
        (EigenvalueRegion.disc(1.41421357), EigenvalueRegion.disc(1.41421356), "|z| < 1.41421"),
        (
            EigenvalueRegion.sector(np.pi / 4 + HAIR),
            EigenvalueRegion.sector(np.pi / 4 - HAIR),
            "|Im z| < -1",
        ),
        (
            EigenvalueRegion.vertical_strip(0, 1 + HAIR),
            EigenvalueRegion.vertical_strip(0, 1),
            "Re z > -1",
        ),
        (parabola(1 + HAIR), parabola(1 - HAIR), "L + z M"),
    ],
    ids=str,
)
def test_eigenvalues_on_the_edge_are_not_inside(
    inside: EigenvalueRegion, outside: EigenvalueRegion, words: str
) -> None:
    """-1 +- 1j lies on the edge of each region, to a billionth."""
    model = model_data([SPIRAL])

    found = said_of(model, None, claim(inside))
    assert found.verdict is Verdict.PROVED
    assert words[:-1] in found.text
    assert verdict_of(model, None, claim(outside)) == "UNDECIDED"


def test_a_design_is_proved_in_its_region() -> None:
    """A loop of two rules; the region that is asked for is proved, a narrower one is not."""
    A = [[[0, 1], [-4, -3]], [[0, 1], [-3, -3]]]
    model = TSModel(A, name="pair")
    wide = EigenvalueRegion.half_plane(0.5) & EigenvalueRegion.sector(1.2)

    proved = certify(model, claims=[Poles(wide)])
    assert proved.verdict is Verdict.PROVED
    open_ = certify(model, claims=[Poles(EigenvalueRegion.half_plane(1.6))])
    assert open_.verdict is Verdict.UNDECIDED
    assert open_.tried[0]


def test_a_sampled_loop_lies_inside_a_circle() -> None:
    """In discrete time the region is of the matrix itself: 0.5 lies in |z| < 0.51."""
    model = TSModel([np.diag([0.5, -0.2])], sample_time=1.0)

    assert certify(model, claims=[Poles(EigenvalueRegion.disc(0.51))]).verdict is Verdict.PROVED
    assert certify(model, claims=[Poles(EigenvalueRegion.disc(0.5))]).verdict is Verdict.UNDECIDED
