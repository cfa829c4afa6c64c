"""The LaTeX appendix of a plant: whole, equal to the design, and it compiles on its pages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from takagi.certificates import Claim, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.design.plant.result import PlantDesign
from takagi.reports.appendix.design_files import plant_appendix
from tests.reports.plant_designs import design_of
from tests.reports.tex_runs import compiled, sound

HOSTILE = r"50 % of a_1 & b^2 {x} \input{y} #3 $z$ ~ <|> K\"uhn Kühn"


def body(design: PlantDesign) -> str:
    text = plant_appendix(design)["appendix-body.tex"]
    assert isinstance(text, str)
    return text


def hostile(design: PlantDesign) -> PlantDesign:
    """The same with LaTeX's own characters in all words, and nothing proved."""
    plant = replace(
        design.plant,
        name=HOSTILE,
        description=HOSTILE,
        source=HOSTILE,
        parameters=tuple(replace(p, source=HOSTILE) for p in design.plant.parameters),
    )
    claims = [Claim(HOSTILE, Verdict.UNDECIDED, HOSTILE)]
    certificate = replace(design.certificate, checked=concluded(claims, [HOSTILE]))
    return replace(design, plant=plant, certificate=certificate, notes=(HOSTILE,))


@pytest.mark.slow
def test_gains_and_claims_are_in_the_body_as_emitted() -> None:
    """Every gain, in its row; every claim in the checker's words."""
    design = design_of("duffing")
    assert design.gains is not None
    text = body(design)

    for K in design.gains:
        cells = [rf"\ensuremath{{{x:.12g}}}" for x in K.ravel()]
        assert " & ".join(cells) + r" \\" in text
    assert text.count(r"\textbf{PROVED} -- ") == len(design.checked.claims)


@pytest.mark.slow
def test_an_open_certificate_is_not_called_proved() -> None:
    """The word does not occur."""
    text = body(hostile(design_of("duffing")))

    assert "PROVED" not in text and "not proved as a whole" in text


@pytest.mark.slow
def test_the_same_design_gives_the_same_bytes() -> None:
    """There is no date in any file, figures included."""
    design = design_of("dayawansa_martin")

    assert plant_appendix(design) == plant_appendix(design)


@pytest.mark.tex
@pytest.mark.parametrize(
    "name", ["cart_pole", "cart_pole_2rules", "tora", "truck_trailer", "dayawansa_martin"]
)
def test_the_appendix_compiles(name: str, tmp_path: Path, reduced: bool) -> None:
    """Sixteen rules, long coefficients, a mass matrix, discrete time, an analysis.

    Reduced: long coefficients, discrete time and an analysis, in the quicker designs.
    """
    if reduced and name in ("cart_pole", "tora"):
        pytest.skip("reduced: their pages differ from the others' by the size of their matrices")
    sound(compiled(tmp_path, plant_appendix(design_of(name))), "hv")


@pytest.mark.tex
def test_hostile_words_compile(tmp_path: Path) -> None:
    """No name, source or message breaks the document."""
    sound(compiled(tmp_path, plant_appendix(hostile(design_of("ball_and_beam")))), "hv")
