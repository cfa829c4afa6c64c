"""The page of several designs: words for every difference, links, nothing that is loaded."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.document.certificate_file import certificate_document, dumps
from takagi.cli.main import main
from tests.reports.html_page import HtmlPage

Data = dict[str, Any]
P = [[1, 0], [0, 1]]


def design(folder: Path, rate: float, *, level: float = 0, name: str = "motor") -> Path:
    """Write a design of x1' = -x1, x2' = -2 x2: its claims, and a report if it has a set."""
    claims: list[Data] = [{"name": "line", "kind": "decay", "P": P, "decay_rate": rate}]
    if level:
        of_set = {"name": "set", "kind": "invariant-ellipsoid", "P": P, "multiplier": 0.5}
        claims.append({**of_set, "level": level})
    document = certificate_document(
        model={
            "kind": "takagi-sugeno",
            "name": name,
            "sample_time": None,
            "state_names": [f"{name} angle [rad]", "rate [rad/s]"],
            "A": [[[-1.0, 0.0], [0.0, -2.0]]],
        },
        gains=None,
        claims=claims,
        provenance={"configuration": {}},
    )
    folder.mkdir()
    (folder / "certificate.json").write_text(dumps(document), encoding="utf-8")
    if level:
        (folder / "report.html").write_text("<html></html>", encoding="utf-8")
    return folder


def page_of(*folders: Path, out: Path, status: int) -> HtmlPage:
    """Compare the designs; return the page, which loads nothing and is well-formed."""
    places = [str(folder) for folder in folders]
    assert main(["compare", *places, "--html", str(out)]) == status
    page = HtmlPage(out.read_text(encoding="utf-8"))
    assert page.wrong == [] and page.open == []
    assert not {"script", "link", "img", "iframe", "object"} & {tag for tag, _ in page.tags}
    return page


def test_each_design_has_a_column_and_each_change_a_word(tmp_path: Path) -> None:
    """5 % of 0.8 is 0.04: 0.77 is worse and allowed, 0.7 is more than allowed, 0.9 is better."""
    folders = [
        design(tmp_path / name, rate)
        for name, rate in (("base", 0.8), ("b", 0.77), ("c", 0.7), ("d", 0.9), ("e", 0.8))
    ]

    page = page_of(*folders, out=tmp_path / "page.html", status=1)

    start = next(k for k, cell in enumerate(page.cells) if cell.startswith("decay rate"))
    row = [page.cells[start + k] for k in range(6)]
    assert row[1:] == ["0.8", "0.77", "0.7", "0.9", "0.8"]
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    for words in (
        '<td class="open">0.77<span>slower, 3.75 % worse<',
        '<td class="bad">0.7<span>slower, 12.5 % worse (over 5 %)<',
        '<td class="good">0.9<span>faster, 12.5 % better<',
        "<td>0.8<span>the same<",
    ):
        assert words in text
    assert text.count('<span class="badge PROVED">') == 5
    assert text.count("<strong>worse") == 1 and text.count("<strong>not worse") == 3


def test_a_claim_is_lost_in_one_design_and_the_reports_are_linked(tmp_path: Path) -> None:
    """The page lies in a folder of its own; only designs with a report have a link."""
    folders = [design(tmp_path / "with a space", 0.8, level=1), design(tmp_path / "b", 0.8)]
    third = design(tmp_path / "c", 0.8, level=0.5)

    page = page_of(*folders, third, out=tmp_path / "pages" / "all.html", status=1)

    links = [a["href"] for a in page.all("a") if not str(a["href"]).startswith("#")]
    assert links == ["../with%20a%20space/report.html", "../c/report.html"]
    text = (tmp_path / "pages" / "all.html").read_text(encoding="utf-8")
    assert "1 claim lost" in text and "lost<span>not proved here" in text
    # Three figures of the set are lost in one design, and decay rate is the same in all.
    assert text.count("lost<span>not proved here") == 3 and "the others, 1, are the same" in text
    assert "smaller set, 50 % worse (over 5 %)" in text


def damaged(folder: Path, **members: object) -> Path:
    """Change members of a certificate."""
    file = folder / "certificate.json"
    document = json.loads(file.read_text(encoding="utf-8")) | members
    file.write_text(json.dumps(document), encoding="utf-8")
    return folder


@pytest.mark.parametrize("which", ["plant", "version", "empty", "missing"])
def test_what_cannot_be_compared_is_refused_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], which: str
) -> None:
    """Status 2, what to do, and no page."""
    base, other = design(tmp_path / "base", 0.8), tmp_path / "other"
    cure = "takagi design MODEL --out DIR"
    if which == "plant":
        design(other, 0.8, name="pump")
        cure = "give two certificates of one"
    elif which == "version":
        damaged(design(other, 0.8), version=2)
        cure = "version"
    elif which == "empty":
        other.mkdir()
    page = tmp_path / "page.html"

    assert main(["compare", str(base), str(other), "--html", str(page)]) == 2

    lines = capsys.readouterr().err.strip().splitlines()
    assert lines[-1].startswith("Error: ") and cure in lines[-1]
    assert [line for line in lines if line.startswith("Error: ")] == lines[-1:]
    assert not page.exists()
