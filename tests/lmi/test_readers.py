"""The readers of an LMI agree: cone data, floating point, rationals, cvxpy, LaTeX."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.lmi import (
    LMI,
    Condition,
    Constant,
    Term,
    Unknown,
    common_lyapunov_condition,
    exact_matrices,
    expressed,
    latex,
    markdown,
    pdc_condition,
)
from takagi.lmi.condition.evaluate import fractions, lmi_value, smallest_eigenvalues
from takagi.lmi.condition.term import Labels
from takagi.lmi.condition.typeset import lmi_latex
from takagi.lmi.cone.cone_program import assemble, unpack
from takagi.models import Floats, ModelError, Premise, TSModel


def short_numbers(rng: np.random.Generator, *shape: int) -> Floats:
    """Return multiples of 1/8, whose products and sums floats hold exactly."""
    return rng.integers(-16, 17, shape) / 8


def random_condition(seed: int) -> Condition:
    rng = np.random.default_rng(seed)
    n, m, count = (int(k) for k in rng.integers(1, 4, 3))
    X = Unknown("X", n, n, symmetric=True, count=2)
    Y = Unknown("Y", m, n, count=3)
    z = Unknown("z", 1, 1)
    entries = int(rng.integers(1, 6))
    first = LMI(
        name="blocks",
        blocks=(n, m),
        count=count,
        terms=(
            Term(
                unknown=X,
                left=short_numbers(rng, entries, n, n),
                right=short_numbers(rng, 1, n, n),
                plus_transpose=True,
                items=rng.integers(0, count, entries),
                members=rng.integers(0, 2, entries),
                parameter="p",
            ),
            Term(
                unknown=Y,
                left=short_numbers(rng, 1, m, m),
                right=short_numbers(rng, count, n, n),
                at=(1, 0),
                members=rng.integers(0, 3, count),
            ),
            Term(unknown=z, left=np.eye(m)[None], at=(1, 1)),
        ),
        constants=(
            Constant(value=short_numbers(rng, count, n, m), at=(0, 1)),
            Constant(value=np.eye(n)[None]),
        ),
    )
    L = short_numbers(rng, 1, n, n)
    second = LMI(
        name="single",
        blocks=(n,),
        terms=(Term(unknown=X, left=L, right=L.transpose(0, 2, 1)),),
        sign=-1,
    )
    return Condition(
        name="random", unknowns=(X, Y, z), lmis=(first, second), parameters={"p": 0.75}
    )


def random_values(condition: Condition, seed: int) -> dict[str, Floats]:
    rng = np.random.default_rng(seed)
    values = {}
    for unknown in condition.unknowns:
        value = short_numbers(rng, unknown.count, unknown.rows, unknown.cols)
        values[unknown.name] = value + value.transpose(0, 2, 1) if unknown.symmetric else value
    return values


@given(st.integers(0, 10_000))
def test_cone_data_say_what_the_terms_say(seed: int) -> None:
    condition = random_condition(seed)
    values = random_values(condition, seed + 1)
    data = assemble(condition)
    x = np.concatenate([u.numbers(values[u.name]) for u in condition.unknowns])
    slack = data.constant + data.matrix() @ x

    for lmi, cone in zip(condition.lmis, data.cones, strict=True):
        expected = lmi.sign * lmi_value(lmi, values, condition.parameters)
        np.testing.assert_allclose(unpack(slack[cone.rows], cone.size), expected, atol=1e-12)
    for name, value in data.values(x).items():
        np.testing.assert_array_equal(value, values[name])


@given(st.integers(0, 10_000))
def test_rationals_and_floats_agree_where_floats_are_exact(seed: int) -> None:
    """With short binary numbers floating point makes no error, so both must be equal."""
    condition = random_condition(seed)
    values = random_values(condition, seed + 1)

    for lmi in condition.lmis:
        exact = exact_matrices(condition, lmi, values)
        assert all(type(entry) is Fraction for entry in exact.flat)
        approximate = lmi.sign * lmi_value(lmi, values, condition.parameters)
        np.testing.assert_array_equal(exact.astype(np.float64), approximate)


@pytest.mark.parametrize("seed", range(4))
def test_cvxpy_says_the_same(seed: int) -> None:
    condition = random_condition(seed)
    values = random_values(condition, seed + 1)
    other = expressed(condition)
    for name, members in other.variables.items():
        for member, value in zip(members, values[name], strict=True):
            member.value = value

    for lmi in condition.lmis:
        expected = lmi.sign * lmi_value(lmi, values, condition.parameters)
        found = np.stack([np.atleast_2d(F.value) for F in other.expressions[lmi.name]])
        np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("relaxation", ["tuan", "kim-lee", "liu-zhang", "polya-2", "tanaka-wang"])
def test_cvxpy_finds_the_same_margin(relaxation: str) -> None:
    from takagi.lmi import decide

    A = np.array([[[2.0, -10.0], [1.0, 0.0]], [[2.5, -10.0], [1.0, 0.0]]])
    B = np.array([[[1.0], [0.0]], [[25.0], [0.0]]])
    condition = pdc_condition(TSModel(A, B), decay_rate=0.1, relaxation=relaxation)
    ours = decide(condition, rows={"nu": 1e4})
    other = expressed(condition)
    problem = other.problem(other.variables["nu"][0] <= 1e4)
    problem.solve(solver="CLARABEL")

    assert ours.status == "candidate"
    assert float(other.margin.value) == pytest.approx(ours.margin, rel=1e-3)


def test_cvxpy_takes_further_constraints() -> None:
    condition = common_lyapunov_condition(np.array([[-1.0, 2.0], [-3.0, -4.0]]))
    other = expressed(condition)
    P = other.variables["P"][0]
    problem = other.problem(P[0, 0] == 2 * P[1, 1])
    problem.solve(solver="CLARABEL")
    value = other.values()["P"]

    assert value[0, 0, 0] == pytest.approx(2 * value[0, 1, 1], abs=1e-6)
    assert smallest_eigenvalues(condition, condition.lmis[2], {"P": value}).min() > 1e-3


def test_fractions_pass_through_builders() -> None:
    """Posed of decimals as Fractions, a condition is evaluated as decimals: -1/10 is -1/10."""
    tenth = Fraction(1, 10)
    A = np.array([[-tenth, Fraction(0)], [Fraction(1), -tenth]], dtype=object)
    condition = common_lyapunov_condition(A)
    found = exact_matrices(condition, condition.lmis[2], {"P": fractions(np.eye(2)[None])})

    assert found[0, 0, 0] == Fraction(1, 5)
    assert found[0, 0, 1] == -1


def test_labels_are_made_when_they_are_read() -> None:
    asked: list[int] = []

    def name(item: int) -> str:
        asked.append(item)
        return f"pair {item}"

    labels = Labels(1000, name)
    P = Unknown("P", 1, 1, symmetric=True)
    one = np.ones((1, 1, 1))
    lmi = LMI(
        name="many",
        blocks=(1,),
        count=1000,
        terms=(Term(unknown=P, left=one, right=one),),
        labels=labels,
    )

    assert not asked
    assert lmi.label(7) == "pair 7" and lmi.label(-1) == "pair 999"
    assert labels[2:4] == ("pair 2", "pair 3")
    assert asked == [7, 999, 2, 3]
    with pytest.raises(IndexError):
        lmi.label(1000)
    with pytest.raises(ModelError, match="1000 labels for 999 items"):
        replace(lmi, count=999)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"left": np.ones((1, 2, 3))}, "do not fit the unknown's 2 x 2"),
        ({"at": (0, 1)}, r"block \(0, 1\) of an LMI with 1 block rows"),
        ({"left": np.ones((3, 2, 2))}, "left has 3 entries; 1 or 2 are needed"),
        ({"members": np.array([0, 1])}, r"members must lie in 0 ... 0"),
        ({"right": None}, "needs a 1 x 1 unknown"),
    ],
)
def test_a_misfit_term_is_named(change: dict[str, object], message: str) -> None:
    X = Unknown("X", 2, 2, symmetric=True)
    parts: dict[str, object] = {"left": np.ones((1, 2, 2)), "right": np.ones((1, 2, 2)), **change}
    with pytest.raises(ModelError, match=f"LMI mine, term 1 .X.: .*{message}|{message}"):
        LMI(name="mine", blocks=(2,), count=2, terms=(Term(unknown=X, **parts),))  # type: ignore[arg-type]


def test_an_unknown_that_is_not_declared_is_named() -> None:
    condition = common_lyapunov_condition(-np.eye(2))
    S = Unknown("S", 2, 2, symmetric=True)
    one = np.eye(2)[None]
    mine = LMI(name="mine", blocks=(2,), terms=(Term(unknown=S, left=one, right=one),))

    with pytest.raises(ModelError, match="unknown S is not among P"):
        condition.with_lmis(mine)
    assert len(condition.with_lmis(mine, unknowns=(S,)).lmis) == 4


def two_rules(sample_time: float | None = None) -> TSModel:
    return TSModel(
        -np.ones((2, 2, 2)),
        np.ones((2, 2, 1)),
        premises=[Premise("z", 0, 1)],
        sample_time=sample_time,
    )


def test_latex_shows_the_condition_that_is_solved() -> None:
    text = latex(pdc_condition(two_rules(), relaxation="wang-tanaka-griffin"))

    assert text.startswith("\\begin{align*}\n\\text{minimise}")
    assert r"Q \in \mathbb{S}^{2},\; M_1, M_{2} \in \mathbb{R}^{1 \times 2},\; \nu" in text
    assert r"\mathrm{He}\left(A_{i} Q - B_{i} M_{j} + A_{j} Q - B_{j} M_{i}\right)" in text
    assert r"+ 4\alpha Q \prec 0" in text
    assert r"\text{scale of Q:} \quad & Q \preceq I \\" in text
    assert r"\begin{bmatrix} Q & M_i^\top \\ \ast & \nu I \end{bmatrix} \succeq 0" in text
    assert r"\quad i = 1, 2" in text


def test_markdown_is_one_formula_a_block() -> None:
    condition = pdc_condition(two_rules(), relaxation="tuan")
    text = markdown(condition)
    blocks = text.split("```")

    assert text.count("```math\n") == len(condition.lmis) + 2 == len(blocks) // 2
    assert "input effort:\n\n```math\n\\begin{bmatrix}" in text
    for lmi in condition.lmis:
        assert lmi_latex(lmi) in text
    assert not any("$" in block or "\n\n" in block for block in blocks[1::2])
