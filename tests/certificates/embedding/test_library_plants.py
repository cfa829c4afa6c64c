"""Every plant of the library lies in its model: proved from its equations alone."""

from __future__ import annotations

import json
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.certificates import Verdict, certify
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.document.plant_embedding import plant_data
from takagi.lmi import pdc
from takagi.models import Interval
from takagi.models.files.library import built_in_kinds
from takagi.models.ranges.expression_range import expression_range, expression_value
from takagi.models.ts.premise import round_outward
from tests.certificates.embedding.plants import checked, said_of
from tests.certificates.kinds.claims import Data, as_read
from tests.models.library_plants import library_model

PLANTS = [name for name, kind in built_in_kinds().items() if kind == "plant"]


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n == "split_range" else ()) for n in PLANTS]
)
def test_the_embedding_is_proved(name: str) -> None:
    """Identity, ranges and determinants, with the standard library alone; the data are short."""
    model = library_model(name)

    found = checked(model)

    assert found.verdict is Verdict.PROVED, found.claims[0].text
    assert len(json.dumps(plant_data(model))) < 5000


@pytest.mark.parametrize("name", PLANTS)
def test_the_checker_makes_the_vertices_of_the_model(name: str) -> None:
    """Two ways: sympy's polynomials rounded to floats, and the checker's exact corners."""
    model = library_model(name)

    family = plant_loop(as_read(plant_data(model)))

    assert family.states == model.states
    assert family.corners == model.rules
    assert family.sample_time == model.sample_time
    for letter in "ABCDE":
        stack = getattr(family, letter)
        if stack:
            exact = [
                [[M[i, j] for j in range(M.shape[1])] for i in range(M.shape[0])] for M in stack
            ]
            np.testing.assert_allclose(
                np.array(exact, dtype=np.float64) + 0 * getattr(model, letter),
                getattr(model, letter),
                rtol=1e-14,
                atol=1e-300,
            )


def test_certify_puts_the_plant_in_front_of_its_claims() -> None:
    """The decay is about the blends of the exact vertices, and the plant is shown to be one."""
    model = library_model("flexible_joint")
    gains = pdc(model, decay_rate=0.2).gains

    certificate = certify(model, gains)

    assert certificate.document["model"]["kind"] == "plant"
    assert [c["kind"] for c in certificate.document["claims"]] == ["sector-embedding", "decay"]
    assert certificate.verdict is Verdict.PROVED
    assert "model of 2 rules exactly" in certificate.checked.claims[0].text
    assert "rules with their gains" in certificate.checked.claims[1].text


def test_a_law_with_other_weights_is_not_taken_for_one_with_the_models() -> None:
    """Cart-pole: the same gains, but a premise of the law that is computed otherwise."""
    model = library_model("cart_pole")
    certificate = certify(model, pdc(model, decay_rate=0.5).gains)
    data = as_read(certificate.document["model"])
    law = as_read(certificate.document["gains"])
    from takagi.certificates.checker.replay.loop_reading import read_model_loop

    assert read_model_loop(data, law).shared_weights
    law["premises"][1]["expression"] = "cos(angle)"
    assert not read_model_loop(data, law).shared_weights


x, y, u, w, p = sp.symbols("x y u w p", real=True)
P = sp.Rational(7, 3)
# A term of an equation, the state that it is given to, and the premise that is left.
TERMS: list[tuple[sp.Expr, int, sp.Expr]] = [
    (sp.sin(x), 0, sp.sin(x) / x),
    (x * sp.cos(y), 0, sp.cos(y)),
    (y**3, 1, y**2),
    (x**2 * y, 0, x * y),
    (sp.exp(x) - 1, 0, (sp.exp(x) - 1) / x),
    (sp.tanh(2 * y), 1, sp.tanh(2 * y) / y),
    (y / (3 + sp.cos(x)), 1, 1 / (3 + sp.cos(x))),
    (x * sp.sqrt(4 + y), 0, sp.sqrt(4 + y)),
    (sp.sin(x) * sp.sin(2 * x), 0, 2 * sp.sin(x) ** 2 * sp.cos(x) / x),
    (sp.atan(x) * y, 1, sp.atan(x)),
    (y * sp.Abs(x), 1, sp.Abs(x)),
    (x * sp.log(3 + x), 0, sp.log(3 + x)),
    (1 - sp.cos(y), 1, (1 - sp.cos(y)) / y),
    (x / (p + x**2), 0, 1 / (P + x**2)),
    (p * x * sp.cos(x) ** 2, 0, P * (1 + sp.cos(2 * x)) / 2),
]
BOXES = [
    {x: Interval.of("-0.8", "1.3"), y: Interval.of(-1, 1)},
    {x: Interval.of(-1, "0.1"), y: Interval.of("-1.5", "0.7")},
]
TOLERANCE = Fraction(1, 100)


@cache
def bounds_of(term: int, box: int) -> Interval:
    return round_outward(expression_range(TERMS[term][2], BOXES[box], tolerance=TOLERANCE).outer)


numbers = st.fractions(-3, 3, max_denominator=7).filter(lambda c: c != 0)
rows = st.lists(st.tuples(numbers, st.integers(0, len(TERMS) - 1)), min_size=1, max_size=4)
plants = st.tuples(rows, rows, st.integers(0, len(BOXES) - 1), st.booleans(), st.booleans())


def text_of(expression: sp.Expr) -> str:
    return str(expression).replace("Abs", "abs")


def data_of(drawn: Any) -> Data:
    """Return a plant of two states, with a mass matrix or without, and its embedding."""
    first, second, box, has_mass, is_discrete = drawn
    used = sorted({term for _, term in (*first, *second)})
    entries = [["0", "0"], ["0", "0"]]
    equations = []
    for i, row in enumerate((first, second)):
        equations.append("+".join(f"({c})*({text_of(TERMS[k][0])})" for c, k in row))
        for c, k in row:
            entries[i][TERMS[k][1]] += f" + ({c})*z{k}"
    premises = [premise(f"z{k}", TERMS[k][2], bounds_of(k, box)) for k in used]
    if has_mass:
        # diag(2 + cos(x), 1/3) of determinant (2 + cos(x))/3.
        entries = [[f"m*({e})" for e in entries[0]], [f"3*({e})" for e in entries[1]]]
        premises.append(premise("m", 1 / (2 + sp.cos(x)), Interval(Fraction(1, 3), Fraction(1, 2))))
    sides = {s.name: [str(side.lower), str(side.upper)] for s, side in BOXES[box].items()}
    return {
        "kind": "plant",
        "sample_time": 0.5 if is_discrete else None,
        "parameters": {"p": "7/3"},
        "states": [{"name": n, "unit": "-", "rest": 0, "range": sides[n]} for n in ("x", "y")],
        "equations": equations,
        "mass": [["2 + cos(x)", "0"], ["0", "1/3"]] if has_mass else None,
        "outputs": [{"expression": "x + 5"}],
        "embedding": {"premises": premises, "A": entries, "C": [["1", "0"]]},
    }


def premise(name: str, expression: sp.Expr, bounds: Interval) -> Data:
    ends = {"lower": str(bounds.lower), "upper": str(bounds.upper)}
    return {"name": name, "expression": text_of(expression), **ends}


@settings(max_examples=20)
@given(drawn=plants, shares=st.tuples(st.floats(0.01, 0.99), st.floats(0.01, 0.99)))
def test_random_plants_are_proved_and_equal_their_vertices(
    drawn: Any, shares: tuple[float, float]
) -> None:
    """The checker's proof; and in floats, f at a point is the blend of the checker's vertices."""
    data = data_of(drawn)

    found = said_of(data)
    assert found.verdict is Verdict.PROVED, found.text

    family = plant_loop(as_read(data))
    first, second, box, has_mass, _ = drawn
    sides = BOXES[box].values()
    state = [float(s.lower) + t * float(s.width) for s, t in zip(sides, shares, strict=True)]
    at = dict(zip((x, y), state, strict=True))
    used = sorted({term for _, term in (*first, *second)})
    members = [TERMS[k][2] for k in used] + ([1 / (2 + sp.cos(x))] if has_mass else [])
    h: NDArray[Any] = np.ones(1)
    for expression, given_ in zip(members, data["embedding"]["premises"], strict=True):
        value = expression_value(expression, at)
        low, high = (float(Fraction(given_[end])) for end in ("lower", "upper"))
        h = np.kron(h, [(high - value) / (high - low), (value - low) / (high - low)])
    A = np.array([[[float(M[i, j]) for j in range(2)] for i in range(2)] for M in family.A])
    blend = np.tensordot(h if len(A) > 1 else [1.0], A, axes=1) @ np.array(state)
    f = [sum(float(c) * value_at(k, at) for c, k in row) for row in (first, second)]
    if has_mass:
        f = [f[0] / (2 + np.cos(state[0])), 3 * f[1]]

    np.testing.assert_allclose(blend, f, rtol=1e-9, atol=1e-9)


def value_at(term: int, at: dict[sp.Symbol, float]) -> float:
    return float(TERMS[term][0].subs({**at, p: 7.0 / 3.0}))


@settings(max_examples=20)
@given(drawn=plants, row=st.integers(0, 1), factor=st.sampled_from(["1.0000001", "-1", "0"]))
def test_another_equation_is_not_proved(drawn: Any, row: int, factor: str) -> None:
    """One row of f times a factor, with all else as it was."""
    data = data_of(drawn)
    value = sum(c * TERMS[k][0] for c, k in drawn[row])
    assume(sp.expand(value) != 0)  # terms that cancel
    data["equations"][row] = f"{factor}*({data['equations'][row]})"

    assert said_of(data).verdict is Verdict.UNDECIDED
