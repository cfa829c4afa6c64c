"""docs/pendulum.md is what takagi says of the pendulum: nothing stale, and the figures are true."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.docs_pages import DOCS, catalogue, text_of

pendulum = catalogue("catalogue.pendulum")


@pytest.fixture(scope="module")
def attained() -> dict[str, tuple[float, float]]:
    """Premise of the sixteen rules -> least and greatest value found."""
    found: dict[str, tuple[float, float]] = catalogue("catalogue.pendulum_bounds").sampled_ranges(
        pendulum._model("cart_pole")
    )
    return found


def test_what_the_page_calls_proved_is_proved() -> None:
    """From both sides of the largest rate: 1 1/s is proved, 1.5 1/s is proved impossible."""
    found = {name: one.verdict.name for name, one in pendulum.certificates().items()}

    assert found == {"two": "PROVED", "too much": "DISPROVED", "sixteen": "PROVED"}
    text = text_of("pendulum.md")
    assert re.findall(r"returns\s+\*\*(\w+)\*\*", text) == ["PROVED", "DISPROVED", "PROVED"]


def test_the_textbooks_gains_place_the_poles() -> None:
    """Wang, Tanaka, Griffin (1996), recalled: both poles of each local model at -2 1/s."""
    model = pendulum._model("cart_pole_2rules")
    for A, B, K in zip(model.A, model.B, np.array(pendulum.TWO), strict=True):
        # Rounded to a tenth of a gain, a double pole moves by the root of it.
        assert np.poly(A - B @ K) == pytest.approx([1, 4, 4], abs=0.02)


def test_vertices_are_those_of_the_textbook() -> None:
    """Tanaka and Wang (2001), recalled: a21 17.294 and 9.360, b2 -0.1765 and -0.00524."""
    text = text_of("pendulum.md").split("## Sixteen rules")[0]

    for number in ("17.2941", "9.36002", "-0.176471", "-0.00523587"):
        assert number in text


def test_bounds_contain_what_is_attained(attained: dict[str, tuple[float, float]]) -> None:
    """And exceed it by less than the thousandth of the range that is promised."""
    model = pendulum._model("cart_pole")
    for name, (low, high) in attained.items():
        premise = {p.name: p for p in model.premises}[name]
        lower, upper = float(premise.lower), float(premise.upper)
        assert lower <= low and high <= upper
        assert max(low - lower, upper - high) <= 1e-3 * (upper - lower)


def test_the_extremes_are_those_of_the_formulas(attained: dict[str, tuple[float, float]]) -> None:
    """sin(a)/a and cos(a) at 1.5 and 0; rate sin(2 angle) at 4 and pi/4."""
    assert attained["gravity"] == pytest.approx((np.sin(1.5) / 1.5, 1), abs=1e-9)
    assert attained["arm"] == pytest.approx((np.cos(1.5), 1), abs=1e-9)
    assert attained["swing"] == pytest.approx((-4, 4), abs=1e-9)


def test_the_figures_of_the_page_are_there() -> None:
    """Well-formed, with words for who cannot see them on the page."""
    shown = re.findall(r"!\[([^\]]+)\]\(figures/([^)]+)\)", text_of("pendulum.md"))

    assert {file for _, file in shown} == set(pendulum.FIGURES.values())
    for words, file in shown:
        assert len(words) > 20
        ElementTree.parse(DOCS / "figures" / file)
