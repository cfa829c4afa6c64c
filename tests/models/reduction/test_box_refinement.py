"""Cells of a box: they cover it, contain the plant, and one P for all of them shows more."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from itertools import product
from math import prod

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify
from takagi.lmi import pdc
from takagi.models import (
    CellModels,
    Interval,
    ModelError,
    Plant,
    TSModel,
    Variable,
    load_model,
    refine,
)

x, v, u, z1, z2 = sp.symbols("x v u z1 z2", real=True)


def moving(name: str, *equations: sp.Expr, premises: dict[sp.Symbol, sp.Expr]) -> Plant:
    return Plant(
        equations=equations,
        states=(Variable(x, "m", Interval.of(-1, 1)), Variable(v, "m/s")),
        inputs=(Variable(u, "N"),) if any(row.has(u) for row in equations) else (),
        premises=premises,
        name=name,
    )


def stiffening() -> Plant:
    """Return x'' = -(1 + 3 x^2) x - (1 + 3 x^4) x': stiff only where it is damped."""
    row = -(1 + 3 * x**2) * x - (1 + 3 * x**4) * v
    return moving("stiffening", v, row, premises={z1: x**2, z2: x**4})


def weak_in_the_middle() -> Plant:
    """Return x'' = x + 4 x^3 + (1 - 0.9 (1 - x^2)^2) u: weak where little is needed."""
    row = x + 4 * x**3 + (1 - sp.Rational(9, 10) * (1 - x**2) ** 2) * u
    return moving("weak in the middle", v, row, premises={z1: x**2, z2: (1 - x**2) ** 2})


@cache
def cells_of(name: str, count: int) -> CellModels:
    plant = stiffening() if name == "stiffening" else load_model(name)
    assert isinstance(plant, Plant)
    return refine(plant, cells=count)


def test_one_function_for_all_cells_shows_what_the_whole_box_denies() -> None:
    """The box has the corner stiffness 4, damping 1, which the plant never has.

    x'' + d x' + k(t) x with k in [k1, k2] has a quadratic function if and only if sqrt(k2) -
    sqrt(k1) < d (circle criterion): with 1, 4 and d = 1 the whole box is at the limit, and decays
    at no rate.
    """
    cells = cells_of("stiffening", 16)

    assert certify(cells.whole, decay_rate=0.01).verdict is Verdict.DISPROVED
    assert certify(cells.union(), decay_rate=0.25).verdict is Verdict.PROVED
    assert certify(cells.union(), decay_rate=0.51).verdict is Verdict.DISPROVED


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stiffening", "tora", "lorenz"])
def test_cells_cover_the_box_without_overlap(name: str) -> None:
    """Volumes add up exactly, and every cell lies in the box."""
    cells = cells_of(name, 7)
    ends = {symbol.split()[0]: side for symbol, side in cells.whole.box.items()}

    def volume(sides: Mapping[str, Interval]) -> Fraction:
        return prod((side.width for side in sides.values()), start=Fraction(1))

    whole = {name: Interval(*side) for name, side in ends.items()}
    assert len(cells.cells) == 7
    assert sum(volume(cell.sides) for cell in cells.cells) == volume(whole)
    for cell in cells.cells:
        assert all(whole[name].contains(side) for name, side in cell.sides.items())


@given(share=st.tuples(*[st.floats(-1, 1)] * 3), w=st.tuples(*[st.floats(-1, 1)] * 5))
def test_the_model_of_a_point_is_the_plant_there(
    share: tuple[float, ...], w: tuple[float, ...]
) -> None:
    """Equations of TORA by hand (Bupp, Bernstein, Coppola 1998), epsilon = 0.1."""
    cells = cells_of("tora", 8)
    position, angle, rate = share
    state, force = np.array([position, w[0], angle, rate]), w[1]
    point = {"x": position, "theta": angle, "omega": rate}

    model = cells.model_at(**point)
    blend = model.blend(model.premise_values(**point))

    c, s, e = np.cos(angle), np.sin(angle), 0.1
    mass = np.array([[1, e * c], [e * c, 1]])
    forces = np.array([-position + e * rate**2 * s, force])
    acceleration = np.linalg.solve(mass, forces)
    found = blend.A @ state + blend.B[:, 0] * force
    order = [label.split()[0] for label in model.states]
    assert order[0] == "x"
    assert order[2] == "theta"
    assert found[[1, 3]] == pytest.approx(acceleration, abs=1e-7)


def test_weights_of_the_union_are_those_of_one_cell() -> None:
    cells = cells_of("tora", 8)
    point = {"x": 0.2, "theta": -0.6, "omega": 0.9}

    h = cells.memberships(**point)
    model = cells.model_at(**point)

    union = cells.union()
    assert h.shape == (len(union.rules),)
    assert h.sum() == pytest.approx(1)
    assert np.count_nonzero(h) <= len(model.rules)
    own = model.blend(model.premise_values(**point)).A
    assert np.tensordot(h, union.A, axes=1) == pytest.approx(own)
    assert np.all(np.isfinite(np.outer(h, h)[cells.overlap == 0]))
    assert not np.outer(h, h)[cells.overlap == 0].any()


def test_bounds_of_a_cell_are_tighter_and_contain_what_is_attained() -> None:
    cells = cells_of("stiffening", 16)

    for cell in cells.cells:
        lower, upper = float(cell.sides["x"].lower), float(cell.sides["x"].upper)
        for place in np.linspace(lower, upper, 11):
            values = cell.model.premise_values(x=place)
            for premise, value in zip(cell.model.premises, values, strict=True):
                assert float(premise.lower) - 1e-12 <= value <= float(premise.upper) + 1e-12
        assert sum(p.upper - p.lower for p in cell.model.premises) < 1
        assert cell.width < 0.2


@pytest.mark.slow
def test_gains_for_each_cell_decay_faster_with_one_function() -> None:
    """pdc over the union, knowing that rules of two cells never act together."""
    cells = refine(weak_in_the_middle(), cells=4)

    whole = pdc(cells.whole, decay_rate="max", gain_bound=60)
    known = pdc(cells.union(), decay_rate="max", gain_bound=60, overlap=cells.overlap)
    unknown = pdc(cells.union(), decay_rate="max", gain_bound=60)

    rates = [float(d.answer.decay_rate or 0) for d in (whole, unknown, known)]
    assert rates[0] < 0.3 < 1.3 < rates[1] < rates[2]
    assert known.gains is not None
    assert known.P is not None
    for cell, gains in zip(cells.cells, np.split(known.gains, len(cells.cells)), strict=True):
        assert decays(cell.model, gains, known.P, Fraction(14, 10))
        assert not decays(cell.model, -gains, known.P, Fraction(14, 10))


def decays(model: TSModel, gains: np.ndarray, P: np.ndarray, rate: Fraction) -> bool:
    """Return whether He(P (G_ij + G_ji)) + 4 rate P < 0 for every pair, in Fractions, n = 2."""
    exactly = np.vectorize(lambda value: Fraction(float(value)), otypes=[object])
    A, B, K, P = (exactly(part) for part in (model.A, model.B, gains, P))
    for i, j in product(range(len(A)), repeat=2):
        both = P @ (A[i] - B[i] @ K[j] + A[j] - B[j] @ K[i])
        form = both + both.T + 4 * rate * P
        if form[0, 0] >= 0 or form[0, 0] * form[1, 1] <= form[0, 1] * form[1, 0]:
            return False
    return True


def test_a_plant_that_does_not_vary_has_one_cell() -> None:
    plant = moving("linear", v, -x - v, premises={})

    cells = refine(plant, cells=5)

    assert len(cells.cells) == 1
    assert cells.memberships(x=0.5, v=7) == pytest.approx([1])


def test_misuse_is_refused() -> None:
    cells = cells_of("stiffening", 16)

    with pytest.raises(ModelError, match="at least 1"):
        refine(stiffening(), cells=0)
    with pytest.raises(ModelError, match="a Turbine was given"):
        refine(load_model("nrel5mw"))  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="x missing"):
        cells.model_at(v=0)
    with pytest.raises(ModelError, match=r"x = 1\.5 lies in none of the 16 cells"):
        cells.model_at(x=1.5)
    assert cells.index_at(x=1) == 15
