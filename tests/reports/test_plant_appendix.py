"""The LaTeX appendix of a plant: whole, equal to the design, and it compiles on its pages."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from importlib.resources import files
from pathlib import Path
from xml.etree import ElementTree

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Claim, Verdict, certify
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.requests import FuzzyDecay, FuzzyL2Gain, ObservedFeedback, ObserverError
from takagi.certificates.requests.request import Request
from takagi.lmi import observer
from takagi.models import ModelError
from takagi.models.files.library import built_in_kinds
from takagi.reports.appendix.plant import plant_appendix
from takagi.reports.page.mathml import mathml, readable, shortens
from takagi.reports.sections.plant.gains import equations_latex
from tests.models.library_plants import model_of, plant_of
from tests.reports.plant_designs import design_of
from tests.reports.tex_runs import PAPERS, compiled, sound
from tests.undrawn import blank_figures

HOSTILE = r"50 % of a_1 & b^2 {x} \input{y} #3 $z$ ~ <|> K\"uhn Kühn"


def body(design: PlantDesign) -> str:
    with blank_figures():
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
    design = design_of("duffing")
    assert design.gains is not None
    text = body(design)

    for K in design.gains:
        cells = [rf"\ensuremath{{{x:.12g}}}" for x in K.ravel()]
        assert " & ".join(cells) + r" \\" in text
    assert text.count(r"\begin{takagitheorem}") == len(design.checked.claims)


def test_every_kind_of_claim_has_a_theorem() -> None:
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
    text = body(hostile(design_of("duffing")))

    assert "PROVED" not in text and "not proved as a whole" in text


@pytest.mark.slow
def test_the_same_design_gives_the_same_bytes() -> None:
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
    """Sixteen rules, long coefficients, a mass matrix, discrete time, an analysis, an observer."""
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
    sound(compiled(tmp_path, plant_appendix(hostile(design_of("ball_and_beam")))))


PLANTS = sorted(name for name, kind in built_in_kinds().items() if kind == "plant")
SYMBOLS = sp.symbols("x angle z1 omega delta_x rate", real=True)


def words(markup: str) -> list[str]:
    """The texts of a formula's numbers, names and signs, in order; well-formed or an error."""
    root = ElementTree.fromstring(markup)
    shown = root.find("semantics")
    assert shown is not None
    body = [part for part in shown if part.tag != "annotation"]
    return [
        element.text.strip()
        for part in body
        for element in part.iter()
        if element.tag in ("mn", "mi", "mo", "mtext") and element.text and element.text.strip()
    ]


@pytest.mark.parametrize("name", PLANTS)
def test_every_step_of_the_library_can_be_set(name: str) -> None:
    derivation = model_of(name).derivation
    assert derivation is not None
    lines = [step.latex for step in derivation.steps] + equations_latex(plant_of(name))

    for line in map(readable, lines):
        # Distances between rows are not shown.
        numbers = re.findall(r"\d+(?:\.\d+)?", re.sub(r"\[4pt\]|\\mathrm\{[^}]*\}", "", line))
        assert [w for w in words(mathml(line)) if w[0].isdigit()] == numbers


def test_a_formula_is_set_piece_by_piece() -> None:
    found = words(
        mathml(r"\dot{x} = \frac{1}{2} \left(a_{i}^{2} - \sin{\left(\theta \right)}\right)")
    )

    assert found == [
        "x", "˙", "=", "1", "2", "(", "a", "i", "2", "−", "sin", "(", "θ", ")", ")",
    ]  # fmt: skip


def test_a_matrix_has_its_cells_and_an_array_its_lines_where_tex_draws_them() -> None:
    root = ElementTree.fromstring(mathml(r"\begin{pmatrix}1 & 2 & 3\\[4pt]4 & 5 & 6\end{pmatrix}"))
    assert [len(row.findall("mtd")) for row in root.iter("mtr")] == [3, 3]

    text = mathml(r"\begin{array}{c|cc}i & a & b \\ \hline 1 & 2 & 3\end{array}")
    table = next(ElementTree.fromstring(text).iter("mtable"))
    assert (table.get("columnlines"), table.get("rowlines")) == ("solid none", "solid")


@pytest.mark.parametrize(
    "formula",
    [
        r"\unheard x", r"\href{http://x.y}{x}", r"\begin{tikzpicture}x\end{tikzpicture}", r"{x",
        r"x}", r"\left(x",
        r"\frac{1}", r"x \right)", r"\begin{pmatrix}1 & 2", "_", "x^",
    ],
)  # fmt: skip
def test_what_is_not_read_is_refused(formula: str) -> None:
    with pytest.raises(ModelError, match="cannot be set as MathML"):
        mathml(formula)


def test_letters_that_mean_something_in_html_are_escaped() -> None:
    assert words(mathml(r"a < b \text{<script>}")) == ["a", "<", "b", "<script>"]


def test_names_are_words_and_commands_stay() -> None:
    """``angle`` is one name, not five letters; products of names keep a space."""
    assert readable(r"\frac{49 gravity inertia}{5} + rate \sin{\left(2 angle \right)}") == (
        r"\dfrac{49\, \mathit{gravity}\, \mathit{inertia}}{5} + \mathit{rate}\, "
        r"\sin{\left(2\, \mathit{angle} \right)}"
    )
    assert readable(r"\begin{pmatrix}angle\\rate\end{pmatrix}") == (
        r"\begin{pmatrix}\mathit{angle}\\\mathit{rate}\end{pmatrix}"
    )
    assert readable(r"a \le b") == r"a \le b"


@pytest.mark.parametrize("name", ["aleph", "eth", "hbar", "mho", "varpi", "wp"])
def test_names_that_sympy_takes_for_signs_are_words(name: str) -> None:
    """The rate ``wp`` of a pendulum is no Weierstrass p, for which MathML has no letter here."""
    assert words(mathml(readable(str(sp.latex(sp.Symbol(name)))))) == [name]


@given(
    above=st.integers(min_value=1, max_value=10**40),
    below=st.integers(min_value=10**9, max_value=10**40),
)
def test_a_long_coefficient_is_shortened_to_six_digits(above: int, below: int) -> None:
    """The decimal that is shown is the fraction to 5e-6 of itself."""
    line = rf"\frac{{{above} x}}{{{below}}}"
    shown = re.fullmatch(r"([\d.]+)(?: \\cdot 10\^\{(-?\d+)\})? x", readable(line))

    assert shortens(line) and shown
    value = Fraction(shown[1]) * Fraction(10) ** int(shown[2] or 0)
    assert abs(value / Fraction(above, below) - 1) <= Fraction(5, 10**6)


@pytest.mark.parametrize(
    "line", [r"\frac{3 x}{17}", r"\frac{x + y}{12345678901234}", r"\frac{x}{y}", "12345678901234 x"]
)
def test_what_cannot_be_shortened_safely_stays(line: str) -> None:
    assert not shortens(line)


def expressions() -> st.SearchStrategy[sp.Expr]:
    """Expressions such as plants have, with names of several letters and long coefficients."""
    number = st.fractions(min_value=-100, max_value=100, max_denominator=10**12).map(
        lambda q: sp.Rational(q.numerator, q.denominator)
    )
    leaf = st.one_of(st.sampled_from(SYMBOLS), number)
    return st.recursive(
        leaf,
        lambda inner: st.one_of(
            st.tuples(inner, inner).map(lambda pair: pair[0] + pair[1]),
            st.tuples(inner, inner).map(lambda pair: pair[0] * pair[1]),
            inner.map(sp.sin),
            inner.map(sp.tanh),
            inner.map(lambda e: sp.sqrt(e**2 + 1)),
            inner.map(abs),
            st.tuples(inner, inner).map(lambda pair: pair[0] / (pair[1] ** 2 + 1)),
        ),
        max_leaves=8,
    )


@given(expressions())
def test_whatever_sympy_prints_for_such_expressions_is_set(expression: sp.Expr) -> None:
    line = readable(str(sp.latex(expression)))
    found = words(mathml(line))

    for name in ("angle", "rate"):
        assert found.count(name) == line.count(rf"\mathit{{{name}}}")
