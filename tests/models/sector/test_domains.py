"""Models on bands and unions of cells: tighter bounds, and no claim about the box around them."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.document.model_data import ts_model_data
from takagi.certificates.document.plant_embedding import is_embedded
from takagi.lmi.gains.attraction.condition import state_box_of
from takagi.models import (
    Cell,
    Domain,
    Interval,
    ModelError,
    Plant,
    TSModel,
    Variable,
    rule_count,
    sector_model,
)

X, V, U, W = sp.symbols("x v u w", real=True)
TENTH = sp.Rational(1, 10)
HALF_WIDTH = 0.1


def plant() -> Plant:
    """Return x' = x (x - v^2) sin v, v' = (1 - x) v^2 + u, resting at x = v = 1."""
    return Plant(
        states=(
            Variable(X, "m", Interval.of(-2, 6), Fraction(1)),
            Variable(V, "m/s", Interval.of(-1, 2), Fraction(1)),
        ),
        inputs=(Variable(U),),
        equations=(X * (X - V**2) * sp.sin(V), (1 - X) * V**2 + U),
        name="near a parabola",
    )


def band() -> Domain:
    """Return |x - v^2| <= 1/10, v in [-1, 2]."""
    return Domain.band({V: Interval.of(-1, 2)}, {X: (V**2 - TENTH, V**2 + TENTH)})


@lru_cache
def on_the_band() -> TSModel:
    return sector_model(plant(), domain=band())


@lru_cache
def on_the_box() -> TSModel:
    return sector_model(plant())


def test_a_band_gives_tighter_bounds_than_the_box_around_it() -> None:
    whole = {p.name: p for p in on_the_box().premises}
    narrow = {p.name: p for p in on_the_band().premises}

    assert whole.keys() == narrow.keys()
    shares = {n: float(narrow[n].bounds.width / whole[n].bounds.width) for n in whole}
    assert min(shares.values()) < 0.25
    assert max(shares.values()) == pytest.approx(1, abs=1e-3)


@given(st.floats(0, 1), st.floats(-1, 1))
def test_the_model_equals_the_plant_on_the_band(share: float, across: float) -> None:
    v = -1 + 3 * share
    x = v**2 + HALF_WIDTH * across
    model = on_the_band()
    z = model.premise_values(delta_x=x - 1, delta_v=v - 1)
    h = model.memberships(z)
    moved = model.blend(z).A @ [x - 1, v - 1]

    assert np.all(h >= 0) and h.sum() == pytest.approx(1, abs=1e-12)
    wanted = [x * (x - v**2) * np.sin(v), (1 - x) * v**2]
    np.testing.assert_allclose(moved, wanted, rtol=1e-9, atol=1e-9)


def test_off_the_band_the_model_says_nothing() -> None:
    with pytest.raises(ModelError, match="outside its range"):
        on_the_band().memberships(on_the_band().premise_values(delta_x=5.0, delta_v=0.0))


def test_a_band_is_not_its_box() -> None:
    model = on_the_band()

    assert on_the_box().domain is None
    assert model.domain is not None and len(model.domain.cells) == 1
    low, high = model.box["delta_x [m]"]
    assert low <= Fraction("-1.1") and high >= Fraction("3.1") and high - low < Fraction("4.3")
    assert all("not on the whole box" in premise.evidence for premise in model.premises)
    texts = [getattr(m.derivation, "latex", "") for m in (model, on_the_box())]
    assert "Domain" in texts[0] and "Domain" not in texts[1]
    with pytest.raises(ModelError, match="no box inside it is known"):
        state_box_of(model, None, 2, None)
    assert state_box_of(on_the_box(), None, 2, None) is not None


def test_a_certificate_of_a_band_says_nothing_of_plant_or_box() -> None:
    """The vertices stand in the file; neither the box around the band nor the plant does."""
    data = ts_model_data(on_the_band())

    assert data["box"] == {} and ts_model_data(on_the_box())["box"]
    assert not is_embedded(on_the_band())
    assert is_embedded(on_the_box())


def test_the_proofs_of_a_band_replay_on_the_band_only() -> None:
    for premise in on_the_band().premises:
        assert premise.bounds.contains(premise.replay())
    on_box = {premise.name: premise for premise in on_the_box().premises}
    narrower = [p for p in on_the_band().premises if p.bounds.width < on_box[p.name].bounds.width]
    assert narrower
    for premise in narrower:
        proof = on_box[premise.name].proof
        assert proof is not None
        with pytest.raises(ModelError, match="are not proved"):
            proof.replay(premise.bounds)


def test_a_union_of_cells_leaves_out_what_lies_between() -> None:
    """x in [-2, -1] or [1, 2] instead of [-2, 2]: x^2 is at least 1."""
    states = (
        Variable(X, "-", Interval.of(-2, 2), Fraction(1)),
        Variable(V, "-", Interval.of(-1, 1)),
    )
    cubic = Plant(
        states=states,
        inputs=(Variable(U),),
        equations=(V, V * X**2 + U),
        premises={W: X**2},
        name="c",
    )
    union = Domain.union([{X: Interval.of(-2, -1)}, {X: Interval.of(1, 2)}])
    model = sector_model(cubic, domain=union)
    (premise,) = model.premises

    assert premise.bounds == Interval.of(1, 4)
    assert sector_model(cubic).premises[0].bounds == Interval.of(0, 4)
    assert model.domain is not None and len(model.domain.cells) == 2
    assert premise.replay() == Interval.of(1, 4)


def test_one_rectangle_is_a_box() -> None:
    model = sector_model(plant(), domain=Domain.of_box({X: Interval.of(1, 2)}))

    assert model.domain is None
    assert Interval(*model.box["delta_x [m]"]) == Interval.of(0, 1)
    assert Interval(*model.box["delta_v [m/s]"]) == Interval.of(-2, 1)


def test_the_mass_matrix_need_not_be_regular_off_the_band() -> None:
    """det M = x - v^2 + 1/2 vanishes in the box, and is in [0.4, 0.6] on the band."""
    described = plant()
    with_mass = Plant(
        states=described.states,
        inputs=described.inputs,
        equations=described.equations,
        mass=sp.diag(X - V**2 + sp.Rational(1, 2), 1),
        name="m",
    )
    assert len(sector_model(with_mass, domain=band()).rules) >= 2
    with pytest.raises(ModelError, match="may be singular"):
        sector_model(with_mass)


def test_the_choice_of_a_form_looks_at_the_band() -> None:
    count = rule_count(plant(), domain=band())

    assert count.rules == len(on_the_band().rules)


def test_domains_of_other_symbols_are_refused() -> None:
    """A symbol that only looks like a variable would silently leave the box as it is."""
    with pytest.raises(ModelError, match=r"the domain has x; .*declared otherwise"):
        sector_model(plant(), domain=Domain.of_box({sp.Symbol("x"): Interval.of(1, 2)}))
    with pytest.raises(ModelError, match="the domain has w; the variables are x, v, u"):
        sector_model(plant(), domain=Domain.of_box({W: Interval.of(1, 2)}))


def test_a_coordinate_must_not_have_the_name_of_a_deviation() -> None:
    """delta_v is v - 1 in the model; a coordinate of that name would take its place."""
    other = sp.Symbol("delta_v", real=True)
    curve = Domain((Cell({other: Interval.of(0, 1), V: Interval.of(0, 1)}, {X: other**2}),))
    with pytest.raises(ModelError, match="coordinate of the domain is called delta_v"):
        sector_model(plant(), domain=curve)
