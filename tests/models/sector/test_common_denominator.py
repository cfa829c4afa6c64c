"""Forms that keep a common denominator: mass matrices whose inverses are taken at every rule.

Spong and Block (1995), The Pendubot: a mechatronic system for control research and education, give
the five inertias and the equations that are used here (American Control Conference; recalled).
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import sympy as sp

from takagi.models import Interval, ModelError, Plant, TSModel, Variable, sector_model
from takagi.models.sector.common_denominator import denominator_forms, sum_quotients
from takagi.models.sector.terms import terms_of

Q1, Q2, W1, W2, U, X = sp.symbols("q1 q2 w1 w2 u x", real=True)
INERTIAS = dict(
    zip(
        ("t1", "t2", "t3", "t4", "t5"),
        map(sp.Rational, "0.0761 0.0662 0.0316 0.979 0.383".split()),
        strict=True,
    )
)
GRAVITY = sp.Rational("9.81")


def inertia(q2: sp.Expr) -> sp.Matrix:
    t1, t2, t3, *_ = INERTIAS.values()
    c = t3 * sp.cos(q2)
    return sp.Matrix([[t1 + t2 + 2 * c, t2 + c], [t2 + c, t2]])


def pendubot(angle: str = "0.26") -> Plant:
    _, _, t3, t4, t5 = INERTIAS.values()
    s, lean = t3 * sp.sin(Q2), t5 * GRAVITY * sp.sin(Q1 + Q2)
    rates = (
        W1,
        W2,
        U + s * (2 * W1 + W2) * W2 + t4 * GRAVITY * sp.sin(Q1) + lean,
        lean - s * W1**2,
    )
    mass = sp.diag(1, 1, inertia(Q2))
    box = (Interval.of("-" + angle, angle),) * 2 + (Interval.of(-2, 2),) * 2
    return Plant(
        states=tuple(Variable(x, "-", side) for x, side in zip((Q1, Q2, W1, W2), box, strict=True)),
        inputs=(Variable(U, "-", Interval.of(-10, 10)),),
        equations=rates,
        mass=mass,
        units="unchecked",
        name="pendubot",
    )


@cache
def pendubot_model() -> TSModel:
    return sector_model(pendubot())


def test_the_pendubot_has_six_premises_that_can_be_read() -> None:
    """1/det M, cos q2 in adj M, two of gravity (one of the sum of the angles), two of the rates."""
    model = pendubot_model()
    assert model.derivation is not None and model.derivation.form is not None
    premises = set(model.derivation.form.factored.premises.values())

    assert model.derivation.exactness == "checked symbolically"
    assert len(model.A) == 64
    assert {
        sp.cos(Q2),
        sp.sin(Q1) / Q1,
        sp.sin(Q1 + Q2) / (Q1 + Q2),
        W1 * sp.sin(Q2),
    } <= premises
    # Steiner's det M = t1 t2 - (t3 cos q2)^2 has no zero; as 1/det it is one premise.
    assert any(p.is_Pow and p.exp == -1 for p in premises)


def test_every_rule_has_the_input_matrix_of_some_inverse() -> None:
    """B of each rule is [t2, -(t2 + t3 c)] times 1/d, with c and d from their ranges."""
    _, t2, t3, *_ = (float(v) for v in INERTIAS.values())
    cosines = np.cos([0.26, 0.0])
    ratios = [B[3, 0] / B[2, 0] for B in pendubot_model().B]

    for ratio in ratios:
        assert min(abs(-(t2 + t3 * c) / t2 - ratio) for c in cosines) < 1e-6


def test_the_blend_is_the_plant_at_points() -> None:
    """x' of the blend against M^-1 f in floating point, a way of its own."""
    found = pendubot()
    model = pendubot_model()
    rates = sp.lambdify((Q1, Q2, W1, W2, U), list(found.equations))
    draw = np.random.default_rng(3)
    for x in draw.uniform(-1, 1, (50, 5)) * [0.26, 0.26, 2, 2, 10]:
        names = dict(zip(("q1", "q2", "w1", "w2", "u"), x, strict=True))
        h = model.memberships(model.premise_values(**names))
        blend = (
            np.einsum("i,ijk->jk", h, model.A) @ x[:4] + np.einsum("i,ijk->jk", h, model.B) @ x[4:]
        )
        f = np.array(rates(*x), dtype=np.float64)
        M = np.array(inertia(sp.Float(x[1])), dtype=np.float64)
        wanted = [f[0], f[1], *np.linalg.solve(M, f[2:])]
        assert np.allclose(blend, wanted, rtol=1e-6, atol=1e-6)


def test_a_power_of_a_sum_in_a_denominator_is_left_to_the_other_forms() -> None:
    """1/(1 + x)^2 in one term: its numerator over 1 + x is no polynomial."""
    entries = {("A", 0, 0): terms_of(1 / (1 + X) ** 2), ("B", 0, 0): terms_of(1 / (1 + X))}

    assert not list(denominator_forms(entries))
    assert not list(denominator_forms({("A", 0, 0): terms_of(sp.cos(X))}))


@pytest.mark.parametrize(
    ("row", "found"),
    [
        (sp.sin(Q1 + 2 * Q2), {sp.sin(Q1 + 2 * Q2) / (Q1 + 2 * Q2)}),
        (sp.cos(Q1 + Q2), set()),  # does not vanish with the sum
        (sp.sin(Q1 + 1), set()),  # one state
        (sp.sin(Q1 * Q2), set()),  # no sum
        (sp.sin(Q1 + U), set()),  # u is no state
    ],
)
def test_quotients_of_sums(row: sp.Expr, found: set[sp.Expr]) -> None:
    assert set(sum_quotients([row], (Q1, Q2)).values()) == found


def test_an_input_in_a_premise_needs_a_range() -> None:
    """u^3 = u^2 u: without a range of u the premise u^2 has no bounds, and the message says so."""
    x = Variable(X, "-", Interval.of(-1, 1))

    def cubic(side: Interval | None) -> Plant:
        return Plant(
            states=(x,),
            inputs=(Variable(U, "-", side),),
            equations=(U + U**3 - X,),
            units="unchecked",
        )

    model = sector_model(cubic(Interval.of(-1, 1)))
    assert sorted(float(B[0, 0]) for B in model.B) == [1.0, 2.0]
    with pytest.raises(ModelError, match="u enters nonlinearly .*u\\*\\*3.*give it a range"):
        sector_model(cubic(None))
