"""The LaTeX appendix says what was solved and proved, and nothing breaks its LaTeX."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Claim, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.reports.appendix.tex import Tex, decimal, escape, scientific, unit, with_decimals
from takagi.reports.appendix.turbine import appendix_files
from tests.reports.published_designs import with_published_law
from tests.undrawn import few_margins

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

HOSTILE = r"50 % of a_1 & b^2 {x} \input{y} #3 $z$ ~ <|>"


@pytest.fixture(scope="module")
def design(turbine_design: TurbineDesign) -> TurbineDesign:
    return turbine_design


@pytest.fixture(scope="module")
def files(design: TurbineDesign) -> dict[str, bytes | str]:
    """Its appendix, figures as one word: drawing them takes long, ``test_appendix_tex`` does it."""
    with pytest.MonkeyPatch.context() as patch:
        undrawn(patch)
        return appendix_files(design)


@pytest.fixture(scope="module")
def body(files: dict[str, bytes | str]) -> str:
    return str(files["appendix-body.tex"])


@pytest.fixture(scope="module")
def paper_files(design: TurbineDesign) -> dict[str, bytes | str]:
    with pytest.MonkeyPatch.context() as patch:
        undrawn(patch)
        claim = {"name": HOSTILE, "kind": "other", "P": [[2.5, -0.125], [-0.125, 1]], "winds": "12"}
        left_open = concluded([Claim("paper loop", Verdict.UNDECIDED, HOSTILE)], [HOSTILE])
        parts: dict[str, Any] = {"document": {"claims": [claim]}, "checked": left_open}
        return appendix_files(with_published_law(design, **parts))


def undrawn(patch: pytest.MonkeyPatch) -> None:
    """Let a figure be one word, without responses, and with margins at one wind."""
    patch.setattr("takagi.reports.figures.style.figure_to_pdf", lambda _: b"%PDF")
    few_margins(patch)


def plain(cell: str) -> str:
    return (
        re.sub(r"\\ensuremath\{([^{}]*)\}", r"\1", cell).replace(r"\rlap{$^\dagger$}", "").strip()
    )


def table(body: str, label: str) -> list[list[str]]:
    rows = []
    start = body.index(rf"\label{{{label}}}")
    while True:
        end = body.index(r"\end{table", start)
        text = body[body.index(r"\midrule", start) : body.index(r"\bottomrule", start)]
        rows += [line.removesuffix(r" \\") for line in text.splitlines() if "&" in line]
        start = body.find(r"\begin{table", end)
        if start < 0 or "(continued)" not in body[start : body.index(r"\toprule", start)]:
            return [[plain(cell) for cell in row.split("&")] for row in rows]


def test_the_lyapunov_matrix_is_the_certificates(design: TurbineDesign, body: str) -> None:
    emitted = design.document["claims"][0]["P"]

    opening = r"P = \begin{bmatrix}"
    shown = body[body.index(opening, body.index(r"\label{tk:P}")) :]
    rows = shown[len(opening) : shown.index(r"\end{bmatrix}")].split(r"\\")

    assert [[float(plain(x)) for x in row.split("&")] for row in rows] == emitted


def test_every_cell_of_the_certificate_is_in_the_tables(design: TurbineDesign, body: str) -> None:
    cells: list[dict[str, Any]] = design.document["claims"][0]["cells"]
    ranges = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
    sizes = (
        *("integral_rate", "residual", "wind_gain", "effectiveness_slope", "reference_slope"),
        "lag_disturbance",
        *("multiplier", "wind_error", "wind_rate", "decay_rate"),
    )

    found = [[float(x) for x in row[2:]] for row in table(body, "tk:ranges")]
    claimed = [[float(x) for x in row[2:]] for row in table(body, "tk:cells")]

    assert found == [[cell[name][end] for name in ranges for end in (0, 1)] for cell in cells]
    assert claimed == [[cell[name] for name in sizes] for cell in cells]


def test_the_gain_table_is_the_laws(design: TurbineDesign, body: str) -> None:
    law = design.effort_sharing_law
    assert law is not None

    rows = table(body, "tk:gains")

    assert len(rows) == len(law.schedule.wind)
    gamma = np.array([float(row[9]) for row in rows])
    nu = np.array([float(row[10]) for row in rows[:-1]])
    assert np.abs(gamma - law.gains.proportional).max() <= 0.5e-5 + 1e-12
    assert np.abs(nu - law.gains.integral_rate).max() <= 0.5e-6 + 1e-12


def test_the_inequalities_are_those_of_the_solved_conditions(
    design: TurbineDesign, paper_files: dict[str, bytes | str]
) -> None:
    """Every inequality of both regions' conditions stands there as ``lmi.typeset`` writes it."""
    from takagi.lmi.condition.typeset import lmi_latex

    body = str(paper_files["appendix-body.tex"])
    for region in (design.regional.partial, design.regional.full):
        assert all(lmi_latex(lmi) in body for lmi in region.condition.lmis)


def test_the_vertices_are_the_models(design: TurbineDesign, body: str) -> None:
    for model in (design.partial_load, design.full_load):
        for i in (0, len(model.rules) - 1):
            start = body.index(rf"A_{{{i + 1}}} = \begin{{bmatrix}} {decimal(model.A[i, 0, 0])}")
            assert body.index(rf"E_{{{i + 1}}} =", start) > start


@pytest.mark.slow
@pytest.mark.parametrize("law", ["coherent", "paper"])
def test_the_body_is_closed_in_itself(
    files: dict[str, bytes | str], paper_files: dict[str, bytes | str], law: str
) -> None:
    found = files if law == "coherent" else paper_files
    body = str(found["appendix-body.tex"])

    bare = re.sub(r"\\[\\{}]", "", body)
    assert bare.count("{") == bare.count("}")
    assert Counter(re.findall(r"\\begin\{(\w+\*?)\}", body)) == Counter(
        re.findall(r"\\end\{(\w+\*?)\}", body)
    )
    assert set(re.findall(r"\\(?:eq)?ref\{([^}]*)\}", body)) <= set(
        re.findall(r"\\label\{([^}]*)\}", body)
    )
    cited = {key for keys in re.findall(r"\\cite\{([^}]*)\}", body) for key in keys.split(",")}
    assert cited <= set(re.findall(r"@\w+\{([^,]*),", str(found["appendix.bib"])))
    pictures = set(re.findall(r"\\takagifigures/([\w.-]+)", body))
    assert pictures == {name.removeprefix("figures/") for name in found if name.endswith(".pdf")}
    assert r"\VAR" not in body and r"\BLOCK" not in body


def test_every_proved_claim_is_a_theorem(
    design: TurbineDesign, body: str, files: dict[str, bytes | str]
) -> None:
    assert r"\textbf{PROVED}" in body and "What is not proved" in body
    assert body.count(r"\begin{takagitheorem}") == len(design.checked.claims)
    assert r"\begin{takagiopen}" not in body
    assert "figures/cells.pdf" in files


def test_what_is_not_proved_is_not_called_proved(
    design: TurbineDesign, monkeypatch: pytest.MonkeyPatch
) -> None:
    claims = [Claim(one.name, Verdict.UNDECIDED, "a reason") for one in design.checked.claims]
    undrawn(monkeypatch)

    found = appendix_files(replace(design, checked=concluded(claims, [])))
    body = str(found["appendix-body.tex"])

    assert "not proved as a whole" in body
    assert "PROVED" not in body and r"\begin{takagitheorem}" not in body
    assert "exceeds rated speed" not in body
    assert "figures/cells.pdf" not in found


def test_the_published_law_has_an_appendix_without_the_theorem(
    paper_files: dict[str, bytes | str],
) -> None:
    body = str(paper_files["appendix-body.tex"])

    assert r"\begin{takagitheorem}" not in body and "effort-sharing" not in body
    assert "One integrator serves both channels" in body
    assert escape(HOSTILE) in body and HOSTILE not in body


@pytest.mark.slow
@given(st.text())
def test_escaped_words_hold_no_command_of_their_own(words: str) -> None:
    """Whatever the words, LaTeX reads no character of theirs as its own, and they are ASCII."""
    text = escape(words)

    allowed = r"\\(?:textbackslash|textasciicircum|textasciitilde|textless|textgreater|textbar"
    allowed += r"|textperiodcentered|aa|AA|ss)\{\}|\\textsuperscript\{2\}|\$\^\\circ\$"
    allowed += r"|\$-\$|\$\\times\$|\$\\mathdollar\$|\\[{}&%#_]|\\[\"'`][a-zA-Z]"
    rest = re.sub(allowed, "", text)
    assert not set(rest) & set("\\{}&%$#_^~<>|\n")
    assert text.isascii()
    assert escape(text) is text


def test_numbers_keep_their_meaning() -> None:
    assert decimal(0.1 + 0.2) == r"\ensuremath{0.30000000000000004}"
    assert decimal(1e-7) == r"\ensuremath{0.0000001}"
    assert with_decimals(-0.0001, 2) == r"\ensuremath{0.00}"
    assert with_decimals(float("nan"), 2) == "--"
    assert scientific(43784725.444, 8) == r"\ensuremath{4.3784725 \times 10^{7}}"
    assert scientific(9.99999e7, 3) == r"\ensuremath{1.00 \times 10^{8}}"
    assert unit("N m s^2/rad^2") == r"\ensuremath{\mathrm{N\,m\,s^{2}/rad^{2}}}"
    assert isinstance(unit("-"), Tex)


@pytest.mark.slow
def test_the_verb_reads_a_folder_and_designs_nothing(
    design: TurbineDesign,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The appendix of a folder has the bytes of its design's; the files are listed; status 0."""
    from takagi.cli.main import main
    from takagi.models.loading import read_model
    from takagi.reports import design_folder
    from takagi.reports.output import write_folder

    undrawn(monkeypatch)
    monkeypatch.setattr(design_folder, "report_files", lambda *_, **__: {})
    written = design_folder.design_files(design, source=read_model("nrel5mw"))
    folder = write_folder(tmp_path / "design", written)
    read = design_folder.read_design(folder)
    assert (read.document, read.checked) == (design.document, design.checked)

    out = tmp_path / "appendix"
    assert main(["appendix", str(folder), "--out", str(out), "--json"]) == 0

    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "PROVED"
    names = sorted(str(path) for path in out.rglob("*") if path.is_file())
    assert sorted(answer["files"]) == names
    for name, content in appendix_files(design).items():
        expected = content.encode() if isinstance(content, str) else content
        assert (out / name).read_bytes() == expected, name
