"""Conditions as a paper would print them, in LaTeX and on a Markdown page."""

from __future__ import annotations

import numpy as np

from takagi.lmi import latex, markdown, pdc_condition
from takagi.lmi.condition.typeset import lmi_latex
from takagi.models import Premise, TSModel


def two_rules(sample_time: float | None = None) -> TSModel:
    """Return a model of two states with two rules over one premise."""
    return TSModel(
        -np.ones((2, 2, 2)),
        np.ones((2, 2, 1)),
        premises=[Premise("z", 0, 1)],
        sample_time=sample_time,
    )


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
