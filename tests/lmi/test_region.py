"""LMI regions as values: what they contain, how they combine, what is refused."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.lmi import EigenvalueRegion
from takagi.models import ModelError

FORMULAS: dict[str, tuple[EigenvalueRegion, Callable[[float, float], float]]] = {
    "half-plane": (EigenvalueRegion.half_plane(1.5), lambda x, y: x + 1.5),
    "vertical strip": (EigenvalueRegion.vertical_strip(1, 4), lambda x, y: max(x + 1, -4 - x)),
    "horizontal strip": (EigenvalueRegion.horizontal_strip(2), lambda x, y: abs(y) - 2),
    "disc": (EigenvalueRegion.disc(3, centre=-2), lambda x, y: np.hypot(x + 2, y) - 3),
    "sector": (EigenvalueRegion.sector(0.6, apex=-1), lambda x, y: abs(y) - np.tan(0.6) * (-1 - x)),
    "ellipse": (
        EigenvalueRegion.lmi([[-1, 4 / 3], [4 / 3, -1]], [[0, 2 / 3], [-1 / 3, 0]]),
        lambda x, y: ((x + 4) / 3) ** 2 + y**2 - 1,
    ),
    "parabola": (
        EigenvalueRegion.lmi([[1, 0], [0, -2]], [[0.5, 0.5], [-0.5, 0]]),
        lambda x, y: y**2 - 2 * (-1 - x),
    ),
}


@pytest.mark.parametrize("name", FORMULAS)
@given(x=st.floats(-8, 8), y=st.floats(-8, 8))
def test_a_region_contains_what_its_formula_says(name: str, x: float, y: float) -> None:
    """Chilali and Gahinet (1996), section II: each set against its own inequality."""
    region, formula = FORMULAS[name]
    if abs(formula(x, y)) > 1e-9:
        assert region.contains(complex(x, y)) == (formula(x, y) < 0)


def test_an_intersection_has_every_part_once_in_any_order() -> None:
    a, b, c = EigenvalueRegion.half_plane(1), EigenvalueRegion.disc(4), EigenvalueRegion.sector(0.5)

    assert a & b == b & a
    assert hash(a & b) == hash(b & a)
    assert (a & b) & c == a & (c & b)
    assert a & a == a
    assert a != b
    assert (a & b).contains(-2) and not (a & b).contains(-5) and not (a & b).contains(-0.5)


def test_a_region_is_written_as_a_set() -> None:
    region = (
        EigenvalueRegion.half_plane(0.5)
        & EigenvalueRegion.disc(10)
        & EigenvalueRegion.disc(12, centre=1)
    )

    assert str(region) == "Re z < -0.5 and |z - 1| < 12 and |z| < 10"
    assert region.labels == ("half-plane", "disc 1", "disc 2")
    assert region.latex.startswith(r"\{z \in \mathbb{C} : \operatorname{Re} z < -0.5,\;")


def test_fractions_stay_exact() -> None:
    L, M = EigenvalueRegion.disc(Fraction(1, 3)).parts[0].matrices

    assert L[0, 0] == Fraction(-1, 3) and isinstance(M[0, 1], Fraction)


def test_matrices_of_ones_own_are_a_region() -> None:
    """|z|^2 < 4 written by hand is the disc."""
    own = EigenvalueRegion.lmi([[-2, 0], [0, -2]], [[0, 1], [0, 0]], name="mine")

    assert own == EigenvalueRegion.disc(2)
    assert str(own) == "mine"


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda: EigenvalueRegion.disc(0), "radius of a region is 0; it must be positive"),
        (lambda: EigenvalueRegion.disc(float("nan")), "a finite real number is needed"),
        (lambda: EigenvalueRegion.half_plane("fast"), "decay_rate .* 'fast'"),  # type: ignore[arg-type]
        (lambda: EigenvalueRegion.sector(1.6), "below pi/2"),
        (lambda: EigenvalueRegion.vertical_strip(3, 2), "slowest < fastest"),
        (lambda: EigenvalueRegion.lmi([[1, 2], [3, 4]], np.eye(2)), "not symmetric"),
        (lambda: EigenvalueRegion.lmi([[1]], np.eye(2)), "both must be"),
        (lambda: EigenvalueRegion.lmi([1.0], [1.0]), "square"),
        (lambda: EigenvalueRegion(()), "at least one part"),
    ],
)
def test_what_is_no_region_is_refused(make: Callable[[], EigenvalueRegion], what: str) -> None:
    with pytest.raises(ModelError, match=what):
        make()
