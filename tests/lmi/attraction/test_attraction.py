"""Regions of attraction: analytic limits, saturation that is simulated, and what it buys."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import sympy as sp

from takagi.lmi import Answer, attraction_ellipsoid, attraction_pdc
from takagi.models import Floats, ModelError, TSModel, sector_model
from tests.lmi.known_models import torque_pendulum
from tests.symbolic_plants import plant_of

pytestmark = pytest.mark.numeric


def area(answer: Answer) -> float:
    """Return det(P)^(-1/2), the volume over that of the unit ball."""
    assert answer.P is not None
    return float(np.linalg.det(answer.P) ** -0.5)


def boundary(P: Floats, count: int, seed: int = 0) -> Floats:
    x = np.random.default_rng(seed).standard_normal((count, len(P)))
    return np.asarray(x / np.sqrt(np.einsum("ki,ij,kj->k", x, P, x))[:, None])


def require_contractive(
    model: TSModel, gains: Floats, P: Floats, limit: Floats, rates: tuple[float, float]
) -> None:
    """V falls at the rate of the input as it is, clipped or not, at ten thousand points."""
    rng, step = np.random.default_rng(2), model.sample_time
    x = boundary(P, 10_000) * np.sqrt(rng.uniform(0, 1, (10_000, 1)))
    h = rng.dirichlet(0.5 * np.ones(len(model.A)), len(x))
    A, B, gain = (np.tensordot(h, part, 1) for part in (model.A, model.B, gains))
    v = np.einsum("tmn,tn->tm", gain, x)
    moved = np.einsum("tij,tj->ti", A, x) - np.einsum("tij,tj->ti", B, np.clip(v, -limit, limit))
    V = np.einsum("ti,ij,tj->t", x, P, x)
    clipped = (np.abs(v) > limit).any(axis=1)
    alpha = np.where(clipped, rates[1], rates[0])

    if step is None:
        assert np.all(2 * np.einsum("ti,ij,tj->t", x, P, moved) < -2 * alpha * V)
    else:
        after = np.einsum("ti,ij,tj->t", moved, P, moved)
        assert np.all(after < np.exp(-2 * alpha * step) * V)
    assert 0.02 < clipped.mean() < 0.98


@pytest.mark.parametrize("half", [0.5, 0.9, 0.99])
def test_the_cubic_tends_to_its_analytic_region_from_below(half: float) -> None:
    """x' = -x + x^3 settles exactly from |x| < 1 (Drake, region_of_attraction_test.cc: rho = 1).

    With V = x^2 the largest level set in |x| <= a < 1 is a^2; the model is exact there.
    """
    x = sp.Symbol("x")
    model = sector_model(plant_of([-x + x**3], [x], box={x: (-half, half)}), tolerance="1e-6")
    answer = attraction_ellipsoid(model)
    assert answer.P is not None
    level = 1 / answer.P[0, 0]

    assert (1 - 3e-4) * half**2 < level < half**2


def test_the_cubic_has_no_region_beyond_one() -> None:
    """At a = 1 the vertex -1 + a^2 does not decay."""
    answer = attraction_ellipsoid([[[-1.0]], [[0.0]]], state_box=[1.0])

    assert answer.status == "infeasible" and answer.P is None
    assert "no ellipsoid, however small" in answer.diagnosis


def test_a_box_limits_the_volume_exactly() -> None:
    """x' = -x in the box |x_k| <= b_k: the ellipsoid with these semi-axes, by every measure."""
    box = np.array([2.0, 0.5, 30.0])
    for measure in ("volume", "trace", np.eye(3) * box):
        P = attraction_ellipsoid(-np.eye(3), state_box=box, measure=measure).P
        assert P is not None
        np.testing.assert_allclose(P, np.diag(box**-2.0), rtol=3e-3, atol=3e-3 / box.min() ** 2)


def test_a_scalar_plant_with_saturation_from_both_sides() -> None:
    """x' = a x - sat(k x): contractive on |x| < ubar / a; unsaturated on |x| <= ubar / k."""
    model, a, limit, k = TSModel([[[2.0]]], [[[1.0]]]), 2.0, 3.0, 10.0
    plain = attraction_ellipsoid(model, gains=[[k]], input_limit=limit).P
    assert plain is not None
    assert plain[0, 0] ** -0.5 == pytest.approx(limit / k, rel=3e-4)
    P = attraction_ellipsoid(model, gains=[[k]], input_limit=limit, saturation="polytope").P
    assert P is not None
    reach = P[0, 0] ** -0.5
    assert reach < limit / a
    assert reach == pytest.approx(limit / a, rel=1e-3)


def test_v_falls_at_its_rate_everywhere_in_the_ellipsoid() -> None:
    limit = np.array([10.0])
    design = attraction_pdc(
        torque_pendulum(), input_limit=limit, decay_rate=2.0, saturated_decay_rate=0.1
    )
    K, P = design.require()

    require_contractive(torque_pendulum(), K, P, limit, (2.0, 0.1))


def test_saturation_buys_a_larger_region_for_fast_gains() -> None:
    """Decay 2 1/s near 0, torque 10 N m: twice the area once the torque may saturate."""
    model = torque_pendulum()
    areas = [
        area(attraction_pdc(model, input_limit=10.0, saturation=way, decay_rate=2.0).answer)
        for way in (None, "polytope")
    ]

    assert areas[1] > 2 * areas[0]


def test_with_one_rate_for_all_saturation_buys_nothing() -> None:
    """Hu and Lin (2001): the set that a saturated law makes contractive, H x does unsaturated."""
    model = torque_pendulum()
    plain = area(attraction_pdc(model, input_limit=10.0, saturation=None).answer)
    more = attraction_pdc(model, input_limit=10.0).answer
    assert area(more) == pytest.approx(plain, rel=2e-3)


def two_inputs(sample_time: float | None = None) -> tuple[TSModel, Floats]:
    A = np.array([[[1.0, 0.5], [-0.3, 0.6]], [[0.8, -0.4], [0.5, 1.0]]])
    B = np.array([np.eye(2), [[1.2, 0.1], [-0.1, 0.9]]])
    K = np.array([[[6.0, 0.5], [0.0, 5.0]], [[5.0, 0.0], [0.3, 6.0]]])
    if sample_time is not None:
        A, B = np.eye(2) + sample_time * A, sample_time * B
    return TSModel(A, B, sample_time=sample_time), K


@pytest.mark.parametrize("sample_time", [None, 0.05])
def test_two_inputs_in_both_kinds_of_time(sample_time: float | None) -> None:
    model, K = two_inputs(sample_time)
    limit = np.array([1.0, 2.0])
    plain = attraction_ellipsoid(model, gains=K, input_limit=limit, decay_rate=0.1)
    answer = attraction_ellipsoid(
        model,
        gains=K,
        input_limit=limit,
        saturation="polytope",
        decay_rate=0.1,
        saturated_decay_rate=0.05,
    )
    assert answer.P is not None

    assert area(answer) > 2 * area(plain)
    require_contractive(model, K, answer.P, limit, (0.1, 0.05))


def test_limits_on_top_of_each_other_only_shrink_the_ellipsoid() -> None:
    model, K = two_inputs()
    boxed = TSModel(model.A, model.B, states=("a [m]", "b [m]"), box={"a [m]": (-0.05, 0.1)})
    one = attraction_ellipsoid(model, gains=K, input_limit=[1.0, 3.0])
    two = attraction_ellipsoid(model, gains=K, input_limit=[1.0, 1.0])
    three = attraction_ellipsoid(boxed, gains=K, input_limit=[1.0, 1.0], state_box=[1.0, 1.0])
    assert three.P is not None

    assert area(two) < area(one)
    assert np.linalg.inv(three.P)[0, 0] <= 0.05**2


def test_the_points_are_what_counts() -> None:
    """Measured by one direction, the ellipsoid reaches farther there than the largest one does."""
    model, point = torque_pendulum(), np.array([[1.0, 4.0]])
    ways = {
        name: attraction_pdc(model, input_limit=10.0, decay_rate=1.0, measure=measure).P
        for name, measure in (("volume", "volume"), ("point", point))
    }
    reach = {name: float((point @ P @ point.T)[0, 0] ** -0.5) for name, P in ways.items()}

    assert reach["point"] > 1.05 * reach["volume"]


def test_units_do_not_matter() -> None:
    S, T = np.array([2.0**10, 2.0**4]), 2.0**-10
    other = TSModel(torque_pendulum().A * S[:, None] / S, torque_pendulum().B * S[:, None] / T)
    options = {"saturation": "polytope", "decay_rate": 2.0}
    plain = attraction_pdc(torque_pendulum(), input_limit=10.0, **options)  # type: ignore[arg-type]
    scaled = attraction_pdc(other, input_limit=10.0 * T, **options)  # type: ignore[arg-type]

    assert area(scaled.answer) == pytest.approx(area(plain.answer) * S.prod(), rel=1e-3)


@pytest.mark.parametrize("limit", [1e-9, 1e-3, 1e6])
def test_any_size_of_limit_is_answered(limit: float) -> None:
    model = TSModel([[[2.0]]], [[[1.0]]])
    given = attraction_ellipsoid(model, gains=[[1e4]], input_limit=limit).P
    sought = attraction_pdc(model, input_limit=limit).P
    boxed = attraction_ellipsoid([[-1.0]], state_box=limit).P
    assert given is not None and sought is not None and boxed is not None

    assert given[0, 0] ** -0.5 == pytest.approx(limit / 1e4, rel=1e-3)
    assert sought[0, 0] ** -0.5 == pytest.approx(limit / 2, rel=1e-3)
    assert boxed[0, 0] ** -0.5 == pytest.approx(limit, rel=1e-3)


def test_the_rate_of_the_answer_holds_in_the_whole_ellipsoid() -> None:
    model, rates = torque_pendulum(), {"decay_rate": 2.0, "saturated_decay_rate": 0.1}

    assert attraction_pdc(model, input_limit=10.0, **rates).decay_rate == 0.1  # type: ignore[arg-type]
    design = attraction_pdc(model, input_limit=10.0, saturation=None, **rates)  # type: ignore[arg-type]
    assert design.decay_rate == design.answer.decay_rate == 2.0


def test_what_is_misused_is_refused() -> None:
    model, K = two_inputs()
    cases: list[tuple[Callable[[], object], str]] = [
        (lambda: attraction_ellipsoid(-np.eye(2)), "nothing limits the ellipsoid"),
        (lambda: attraction_ellipsoid(model, input_limit=1.0), "give gains"),
        (lambda: attraction_ellipsoid(model, gains=K, saturation="polytope"), "needs input_limit"),
        (lambda: attraction_pdc(model, input_limit=1.0, saturation="sat"), "is not known"),
        (lambda: attraction_pdc(model, input_limit=[1, -1]), r"input_limit\[1\]"),
        (lambda: attraction_pdc(model, input_limit=1.0, overdrive=0.5), "at least 1"),
        (lambda: attraction_pdc(model, input_limit=1.0, measure="size"), "measure 'size'"),
        (lambda: attraction_pdc(model, input_limit=1.0, measure=[[0.0, 0.0]]), "all 0"),
        (
            lambda: attraction_pdc(model, input_limit=1.0, saturated_decay_rate=1.0),
            "saturation slows",
        ),
        (
            lambda: attraction_ellipsoid(model, gains=K, input_limit=1.0, relaxation="common-gain"),
            "gains differ from rule to rule",
        ),
        (
            lambda: attraction_pdc(
                TSModel([[[1.0, 0.0], [0.0, 2.0]]], [[[1.0], [0.0]]]), input_limit=1.0
            ),
            "can be moved by no input",
        ),
    ]
    for call, message in cases:
        with pytest.raises(ModelError, match=message):
            call()


def test_the_models_box_must_hold_the_origin_and_its_inputs() -> None:
    x, u = sp.symbols("x u")
    away = TSModel([[[-0.9]]], states=["x [-]"], box={"x [-]": (0.1, 0.5)})
    with pytest.raises(ModelError, match="needs 0 inside"):
        attraction_ellipsoid(away)
    driven = sector_model(
        plant_of([x + u + u * x**2 / 4], [x], [u], box={x: (-1, 1), u: (-2, 2)}), tolerance="1e-6"
    )
    with pytest.raises(ModelError, match="give an input_limit within"):
        attraction_pdc(driven, input_limit=3.0)
    P = attraction_pdc(driven, input_limit=2.0, saturation=None).P
    assert P is not None and P[0, 0] >= 1


def test_without_inputs_their_box_is_kept() -> None:
    """u = 0 lies in every box of the input: none has to be limited, and none could be."""
    A = np.array([[[0.0, 1.0], [-1.0, -1.0]], [[0.0, 1.0], [-2.0, -1.0]]])
    names = {"states": ["a [-]", "b [-]"], "inputs": ["u [-]"]}
    box = {"a [-]": (-1, 1), "b [-]": (-2, 2), "u [-]": (-2, 2)}
    boxed = TSModel(A, np.array([[[0.0], [1.0]]] * 2), box=box, **names)  # type: ignore[arg-type]

    found, plain = attraction_ellipsoid(boxed), attraction_ellipsoid(A, state_box=[1.0, 2.0])

    assert area(found) == pytest.approx(area(plain), rel=1e-6)
