"""D-stability: eigenvalues in LMI regions, against the eigenvalues themselves, and exactly."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from takagi.lmi import (
    Answer,
    EigenvalueRegion,
    common_lyapunov,
    d_stability,
    d_stability_condition,
    exact_matrices,
    exact_no,
)
from takagi.lmi.refutation.exact_algebra import is_definite
from takagi.models import Floats, ModelError


def companion() -> Floats:
    """Of (s + 2)(s + 3)(s + 5)."""
    return np.array([[0.0, 1, 0], [0, 0, 1], [-30, -31, -10]])


def holds_exactly(answer: Answer) -> bool:
    assert answer.condition is not None
    return all(
        is_definite(F)
        for lmi in answer.condition.lmis
        if lmi.strict
        for F in exact_matrices(answer.condition, lmi, answer.values)
    )


@pytest.mark.parametrize(
    ("inside", "outside"),
    [
        (EigenvalueRegion.half_plane(1.99), EigenvalueRegion.half_plane(2.01)),
        (EigenvalueRegion.disc(5.01), EigenvalueRegion.disc(4.99)),
        (EigenvalueRegion.sector(1e-3), EigenvalueRegion.sector(1e-3, apex=-2.01)),
        (EigenvalueRegion.vertical_strip(1.9, 5.1), EigenvalueRegion.vertical_strip(1.9, 4.9)),
    ],
    ids=lambda region: str(region),
)
def test_the_companion_matrix_from_both_sides(
    inside: EigenvalueRegion, outside: EigenvalueRegion
) -> None:
    """(s+2)(s+3)(s+5): decay below 2, disc above 5, any sector; the yes holds in rationals."""
    yes, no = d_stability(companion(), inside), d_stability(companion(), outside)

    assert yes.found and holds_exactly(yes)
    assert no.status == "infeasible" and no.P is None


def test_a_disc_below_the_farthest_eigenvalue_is_not_accepted_at_a_tolerance() -> None:
    """At radius 4.983 a P exists that misses by 1e-10 only: float tolerances have accepted it.

    The P of radius 5.001 put into the LMI of 4.983 does not hold in rationals, and w' F w > 0 for
    w = (1, -1) (x) (1, -5, 25), of the eigenvector, is a proof that no other P does.
    """
    yes = d_stability(companion(), EigenvalueRegion.disc(5.001))
    tight = d_stability_condition(companion(), EigenvalueRegion.disc(Fraction(4983, 1000)))
    (F,) = exact_matrices(tight, tight.lmis[2], {"P": yes.P[None]})  # type: ignore[index]
    w = np.kron([1, -1], [1, -5, 25])

    assert d_stability(companion(), EigenvalueRegion.disc(4.983)).status == "infeasible"
    for touched in (EigenvalueRegion.half_plane(2), EigenvalueRegion.disc(5)):
        assert exact_no(d_stability_condition(companion(), touched)) is not None
    assert exact_no(tight) is not None
    assert not is_definite(F)
    assert w @ F @ w < 0  # sign F, so the LMI itself is positive along w


@given(st.integers(0, 10_000), st.integers(0, 5))
def test_one_matrix_has_a_p_exactly_when_its_eigenvalues_are_inside(seed: int, which: int) -> None:
    """Chilali and Gahinet (1996), theorem 2.2, with eigenvalues a percent off the boundary."""
    A = np.random.default_rng(seed).standard_normal((3, 3)) - np.eye(3)
    z = np.linalg.eigvals(A)
    region = (
        EigenvalueRegion.half_plane(0.3),
        EigenvalueRegion.disc(2),
        EigenvalueRegion.sector(0.8),
        EigenvalueRegion.disc(2, centre=-1) & EigenvalueRegion.half_plane(0.2),
        EigenvalueRegion.horizontal_strip(0.5) & EigenvalueRegion.half_plane(0),
        # A parabola.
        EigenvalueRegion.lmi([[0, 0], [0, -1]], [[0.5, 0.5], [-0.5, 0]]),
    )[which]
    assume(np.abs(region.excess(z)).min() > 2e-2)

    assert d_stability(A, region).found == bool(np.all(region.excess(z) < 0))


def test_every_frozen_blend_has_its_eigenvalues_inside() -> None:
    """One P for all vertices puts all blends in the region, and V decays as its rate says."""
    rng = np.random.default_rng(3)
    A = np.array([[-2.0, 1.5], [-1.5, -2.0]]) + 0.4 * rng.standard_normal((4, 2, 2))
    region = (
        EigenvalueRegion.half_plane(0.8) & EigenvalueRegion.sector(1.0) & EigenvalueRegion.disc(5)
    )
    answer = d_stability(A, region)
    h = rng.dirichlet(np.ones(4), 500)

    assert answer.found and answer.decay_rate is not None and answer.decay_rate > 0.8
    assert region.excess(np.linalg.eigvals(np.tensordot(h, A, 1))).max() < 0


def test_vertices_inside_need_not_have_a_common_p() -> None:
    """Each of two stable matrices alone is fine; switching between them is unstable."""
    A = np.array([[[-0.1, 1.0], [-4.0, -0.1]], [[-0.1, 4.0], [-1.0, -0.1]]])
    answer = d_stability(A, EigenvalueRegion.half_plane(0.01))

    assert answer.status == "infeasible"
    assert "no common P, though each vertex" in answer.diagnosis


def test_a_disc_about_zero_is_discrete_decay() -> None:
    """disc(rho) asks A_i' P A_i < rho^2 P: the discrete decay rate -log(rho) / T."""
    rng = np.random.default_rng(5)
    A = 0.45 * rng.standard_normal((3, 3, 3))
    radii = np.linspace(0.3, 1.5, 25)
    by_disc = [d_stability(A, EigenvalueRegion.disc(rho), sample_time=0.1).found for rho in radii]
    by_rate = [
        common_lyapunov(A, sample_time=0.1, decay_rate=-np.log(rho) / 0.1).found for rho in radii
    ]

    assert by_disc == by_rate
    assert any(by_disc) and not all(by_disc)
    first = d_stability(A, EigenvalueRegion.disc(1.5), sample_time=0.1)
    assert first.decay_rate is not None and first.decay_rate >= -np.log(1.5) / 0.1


def test_what_is_no_region_is_refused() -> None:
    with pytest.raises(ModelError, match="an EigenvalueRegion is needed"):
        d_stability(companion(), 2.0)  # type: ignore[arg-type]


def test_a_loop_at_rest_in_one_step_is_as_fast_as_can_be() -> None:
    """x+ = 0: the rate is inf, without a warning of a logarithm."""
    answer = d_stability(np.zeros((1, 2, 2)), EigenvalueRegion.disc(0.5), sample_time=1.0)

    assert answer.decay_rate == np.inf


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
def test_a_region_that_is_none_is_refused(make: Callable[[], EigenvalueRegion], what: str) -> None:
    with pytest.raises(ModelError, match=what):
        make()
