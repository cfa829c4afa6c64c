"""The LaTeX appendix of a plant: whole, equal to the design, and it compiles on its pages."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import pytest

from takagi.certificates import Claim, Verdict, certify
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.requests import FuzzyDecay, FuzzyL2Gain, ObservedFeedback, ObserverError
from takagi.certificates.requests.request import Request
from takagi.lmi import observer
from takagi.reports.appendix.design_files import plant_appendix
from tests.reports.plant_designs import design_of
from tests.reports.tex_runs import PAPERS, compiled, sound

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
    assert text.count(r"\begin{takagitheorem}") == len(design.checked.claims)


def test_every_kind_of_claim_has_a_theorem() -> None:
    """No claim is left to the checker's words."""
    from takagi.certificates.checker.replay.claim_kinds import PROBLEM_KINDS, READ
    from takagi.reports.kinds_in_words import KINDS_IN_WORDS

    assert set(KINDS_IN_WORDS) == READ
    folder = files("takagi.reports.appendix.templates")
    text = "".join(
        folder.joinpath(f"{name}.tex.jinja").read_text("utf-8") for name in
        ("claims", "turbine_claims")
    )  # fmt: skip
    assert all(f"{{macro {kind.replace('-', '_')}(c)}}" in text for kind in READ - {*PROBLEM_KINDS})


def test_a_kind_without_a_macro_is_stated_by_its_sentence() -> None:
    """A kind that is being added has a theorem in the appendix before it has LaTeX of its own."""
    design = design_of("duffing")
    claims = [dict(claim) for claim in design.document["claims"]]
    claims[1]["kind"] = "toy"
    document = {**design.document, "claims": claims}
    before, result = body(design), design.checked.claims[1]

    text = body(replace(design, certificate=replace(design.certificate, document=document)))

    assert text.count(r"\begin{takagitheorem}") == before.count(r"\begin{takagitheorem}")
    start = result.text.partition(" ")[0]
    assert start in text.partition(f"[{result.name}]")[2][:200]


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
@pytest.mark.parametrize("paper", PAPERS)
@pytest.mark.parametrize(
    "name",
    [
        *("cart_pole", "cart_pole_2rules", "tora", "truck_trailer", "dayawansa_martin"),
        *("dc_servo", "flexible_link"),
    ],
)
def test_the_appendix_compiles(name: str, paper: str, tmp_path: Path, reduced: bool) -> None:
    """Sixteen rules, long coefficients, a mass matrix, discrete time, an analysis, an observer.

    Reduced: long coefficients, discrete time and an analysis, in the quicker designs.
    """
    if reduced and (name in ("cart_pole", "tora") or paper in ("article", "IEEEtran")):
        pytest.skip("reduced: neither the longest matrices nor the wider columns")
    if reduced and paper != "IEEEtran, two columns" and name != "dc_servo":
        pytest.skip("reduced: the narrowest columns, and one design in each layout")
    sound(compiled(tmp_path, plant_appendix(design_of(name)), paper))


@pytest.mark.tex
@pytest.mark.parametrize("paper", ["article, two columns", "IEEEtran"])
def test_claims_with_observers_and_functions_of_the_weights_compile(
    paper: str, tmp_path: Path
) -> None:
    """Kinds that no design states, and that ``certify`` may be asked for."""
    design = design_of("duffing")
    L = observer(design.model, decay_rate=1.0).gains
    assert L is not None
    of_weights = FuzzyDecay(rate_bounds=1.0), FuzzyL2Gain(rate_bounds=1.0)
    claims: list[Request] = [ObserverError(L), ObservedFeedback(L), *of_weights]
    stated = replace(design, certificate=certify(design.model, design.gains, claims=claims))
    files = plant_appendix(stated)

    assert str(files["appendix-body.tex"]).count(r"\begin{takagitheorem}") == 5
    sound(compiled(tmp_path, files, paper))


@pytest.mark.tex
def test_hostile_words_compile(tmp_path: Path) -> None:
    """No name, source or message breaks the document."""
    sound(compiled(tmp_path, plant_appendix(hostile(design_of("ball_and_beam")))))
