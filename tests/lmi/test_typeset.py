"""Conditions as a paper would print them, in LaTeX and on a Markdown page."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import LMI, Condition, Constant, Term, Unknown, latex, markdown, pdc_condition
from takagi.lmi.condition import lmi_latex
from takagi.models import Premise, TSModel


def two_rules(sample_time: float | None = None) -> TSModel:
    """Return a model of two states with two rules over one premise."""
    return TSModel(
        -np.ones((2, 2, 2)),
        np.ones((2, 2, 1)),
        premises=[Premise("z", 0, 1)],
        sample_time=sample_time,
    )


def lines_of(model: TSModel, relaxation: str) -> dict[str, str]:
    """Return name -> formula of each LMI, without its index range."""
    text = latex(pdc_condition(model, relaxation=relaxation))
    rows = (row.split(r" \quad & ") for row in text.splitlines()[1:-1])
    return {
        row[0].removeprefix(r"\text{").rstrip(":}"): row[1].removesuffix(r" \\").split(", ")[0]
        for row in rows
    }


def test_latex_shows_the_condition_that_is_solved() -> None:
    """The formula of all pairs carries He, both products and twice the decay term."""
    text = latex(pdc_condition(two_rules(), relaxation="wang-tanaka-griffin"))

    assert text.startswith("\\begin{align*}\n\\text{minimise}")
    assert r"Q \in \mathbb{S}^{2},\; M_1, M_{2} \in \mathbb{R}^{1 \times 2},\; \nu" in text
    assert r"\mathrm{He}\left(A_{i} Q - B_{i} M_{j} + A_{j} Q - B_{j} M_{i}\right)" in text
    assert r"+ 4\alpha Q \prec 0" in text
    assert r"\text{scale of Q:} \quad & Q \preceq I \\" in text
    assert r"\begin{bmatrix} Q & M_i^\top \\ \ast & \nu I \end{bmatrix} \succeq 0" in text
    assert r"\quad i = 1, 2" in text


@pytest.mark.parametrize(
    ("relaxation", "name", "formula"),
    [
        (
            "tanaka-wang",
            "rule",
            r"\mathrm{He}\left(A_{i} Q - B_{i} M_{i}\right) + 2\alpha Q + Y \prec 0",
        ),
        (
            "tuan",
            "pair",
            r"\mathrm{He}\left(2 \left(A_{i} Q - B_{i} M_{i}\right) + A_{i} Q - B_{i} M_{j}"
            r" + A_{j} Q - B_{j} M_{i}\right) + 8\alpha Q \prec 0",
        ),
        (
            "kim-lee",
            "slack",
            r"\mathrm{He}\left(\sum_{i<j} E_i X_{ij} E_j^\top\right)"
            r" + \sum_i E_i X_{ii} E_i^\top \prec 0",
        ),
        (
            "polya-1",
            "product of memberships",
            r"\mathrm{He}\left(\sum_{i,j} \tfrac{k_i (k_j - \delta_{ij})}{6} "
            r"\left(A_{i} Q - B_{i} M_{j}\right)\right) + 2\alpha Q \prec 0",
        ),
        (
            "product",
            "product of corner weights",
            r"\mathrm{He}\left(\tfrac{1}{|\mathcal{P}_k|} \sum_{(i,j) \in \mathcal{P}_k} "
            r"\left(A_{i} Q - B_{i} M_{j}\right)\right) + 2\alpha Q \prec 0",
        ),
    ],
)
def test_relaxations_read_as_they_are_printed(relaxation: str, name: str, formula: str) -> None:
    """A common factor stands before one bracket; a factor 1 is not written."""
    text = latex(pdc_condition(two_rules(), relaxation=relaxation))

    assert rf"\text{{{name}:}} \quad & {formula}" in text


def test_blocks_kept_below_the_diagonal_share_a_transpose() -> None:
    """Discrete time: one transpose for the whole block, numbers multiplied, no lone minus."""
    found = lines_of(two_rules(sample_time=0.1), "wang-tanaka-griffin")

    assert found["rule"] == (
        r"\begin{bmatrix} -\rho^2 Q & (A_{i} Q - B_{i} M_{i})^\top \\ \ast & -Q \end{bmatrix}"
        r" \prec 0"
    )
    assert found["pair"] == (
        r"\begin{bmatrix} -2\rho^2 Q & (A_{i} Q - B_{i} M_{j} + A_{j} Q - B_{j} M_{i})^\top \\"
        r" \ast & -2Q \end{bmatrix} \prec 0"
    )


def test_objectives_are_traces_where_they_are() -> None:
    """The identity is a trace, a multiple carries its number, anything else is a product."""
    W = Unknown("W", 2, 2, symmetric=True)
    V = Unknown("V", 2, 2, symmetric=True, count=3)
    z = Unknown("z", 1, 1, latex=r"\zeta")
    cases = {
        r"\operatorname{trace} W": {"W": np.eye(2)[None]},
        r"3\operatorname{trace} W + 0.5\zeta": {
            "W": 3 * np.eye(2)[None],
            "z": np.full((1, 1, 1), 0.5),
        },
        r"\langle C_{W}, W \rangle": {"W": np.ones((1, 2, 2))},
        r"\textstyle\sum_k \operatorname{trace} V_k": {"V": np.tile(np.eye(2), (3, 1, 1))},
        r"-\zeta": {"z": -np.ones((1, 1, 1))},
    }
    for formula, objective in cases.items():
        text = latex(Condition(name="cost", unknowns=(W, V, z), lmis=(), objective=objective))
        assert rf"\text{{minimise}} \quad & {formula} \\" in text


def test_transposes_of_single_symbols_need_no_bracket() -> None:
    """C below the diagonal is C^T above it, C^T is C, a product keeps its bracket."""
    P = Unknown("P", 1, 1, symmetric=True)
    one = np.ones((1, 1, 1))
    for text, shown in (
        ("C_{i}", r"C_{i}^\top"),
        (r"C_{i}^\top", "C_{i}"),
        ("-H", r"-H^\top"),
        ("C D", r"(C D)^\top"),
    ):
        lmi = LMI(
            name="mine",
            blocks=(1, 1),
            terms=(Term(unknown=P, left=one, right=one),),
            constants=(Constant(value=one, at=(1, 0), latex=text),),
        )
        assert (
            lmi_latex(lmi) == rf"\begin{{bmatrix}} P & {shown} \\ \ast & 0 \end{{bmatrix}} \succ 0"
        )


def test_markdown_is_one_formula_a_block() -> None:
    """Each LMI under its name in a fence that GitHub hands to the renderer as it is."""
    condition = pdc_condition(two_rules(), relaxation="tuan")
    text = markdown(condition)
    blocks = text.split("```")

    assert text.count("```math\n") == len(condition.lmis) + 2 == len(blocks) // 2
    assert "input effort:\n\n```math\n\\begin{bmatrix}" in text
    for lmi in condition.lmis:
        assert lmi_latex(lmi) in text
    assert not any("$" in block or "\n\n" in block for block in blocks[1::2])


def test_scalars_are_compared_as_numbers() -> None:
    """Less and greater for 1 x 1, a second index behind the first, equal summands counted."""
    tau = Unknown("tau", 1, 1, count=3, latex=r"\tau_{1}")
    one = np.ones((1, 1, 1))
    twice = Term(unknown=tau, left=one, symbol=r"\tau_{1i}")
    limit = LMI(
        name="limit",
        blocks=(1,),
        count=3,
        terms=(twice, twice),
        constants=(Constant(value=-one, latex="-1"),),
        sign=-1,
        strict=False,
    )

    text = latex(Condition(name="limits", unknowns=(tau,), lmis=(limit,)))

    assert r"\tau_{1,1}, \dots, \tau_{1,3} \in \mathbb{R}" in text
    assert r"2\tau_{1i} \le 1" in text
    assert lmi_latex(limit) == r"2\tau_{1i} \le 1"
