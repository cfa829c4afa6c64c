"""What the second checker leaves open is named, and hides no disagreement."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path

import pytest

from takagi.certificates import Certificate, certify
from takagi.certificates.audit.two_checkers import cross_checked_document
from takagi.certificates.checker import check_document
from takagi.certificates.checker.replay.claim_kinds import (
    KINDS,
    OWN_READING,
    RESTING,
    WHOLE_FILE,
)
from takagi.certificates.cross_check import opinion
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.cli.verbs.check import run as check_verb
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.test_damage import resealed
from tests.certificates.weights.cells import cubic

PAGE = Path(__file__).resolve().parents[3] / "docs" / "cross-check.md"


def saved(folder: Path, document: object) -> Path:
    path = folder / "certificate.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def test_the_page_lists_the_kinds_without_a_reading() -> None:
    own = {kind for kind in OWN_READING if opinion.obligations({}, kind, None, {}, None) is None}

    assert set(KINDS) == set(opinion.LOOPS)
    assert set(RESTING) == set(opinion.RESTING)
    assert own == {"paper-loop"}
    assert set(WHOLE_FILE) == {opinion.WITH_OBSERVER}
    row = "| `paper-loop` | does not read Schulte's law"
    assert row in PAGE.read_text()


@pytest.mark.parametrize("name", ["cubic", "duffing", "flexible_joint"])
def test_an_honest_secant_certificate_is_replayed_twice(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = cubic("secants") if name == "cubic" else secant_model(load_plant(name))
    certificate = certify(model, [[3.0] * model.A.shape[1]])
    found = cross_checked_document(certificate.document)

    assert found.agrees
    assert found.left_open == ()
    assert [row.second for row in found.rows] == [row.first for row in found.rows]
    assert found.rows[0].second == "PROVED"
    if certificate.verdict.name == "PROVED":
        assert check_verb([str(certificate.save(tmp_path / "c.json")), "--cross"]) == 0
        assert "2 of 2 claims replayed twice: they agree\n" in capsys.readouterr().out


def test_false_secants_are_seen_by_both() -> None:
    """An entry, a bound and the equation: each wrong by itself."""
    whole = certify(cubic("secants"), [[1.0]]).document
    for change in ("entry", "bound", "equation", "kink"):
        wrong = deepcopy(dict(whole))
        if change == "entry":
            wrong["model"]["embedding"]["A"] = [["3*s1 - 1.001"]]
        elif change == "bound":
            wrong["model"]["embedding"]["premises"][0]["lower"] = -0.99
            wrong["gains"]["premises"][0]["lower"] = -0.99
        elif change == "equation":
            wrong["model"]["equations"] = ["-x - x^3 + u + w + x^2/1000"]
        else:
            wrong["model"]["equations"] = ["-x - x^3 + u + w + abs(x) - abs(x)"]
        found = cross_checked_document(resealed(wrong))
        assert [found.rows[0].first, found.rows[0].second] == ["UNDECIDED", "UNDECIDED"], change


def test_what_is_left_open_is_named_everywhere(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ranges of a table are the first checker's: the status is its own, and the claim is named."""
    certificate = certify(cubic("tables"), [[1.0]])
    assert isinstance(certificate, Certificate)
    path = str(certificate.save(tmp_path / "c.json"))

    assert check_verb([path, "--cross"]) == 0
    told = capsys.readouterr().out.splitlines()[-1]
    assert check_verb([path, "--cross", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)["cross"]

    name = "cubic is its Takagi-Sugeno model"
    summed = "1 of 2 claims replayed twice: they agree; left to the first checker"
    assert told == f'{summed}: "{name}"'
    assert data["agree"] is True
    assert (data["replayed"], data["not_replayed"]) == (1, [name])
    assert [claim["second"] for claim in data["claims"]] == ["NOT REPLAYED", "PROVED"]


def test_a_refusal_is_not_hidden_behind_what_is_left_open() -> None:
    """A table that only the first checker reads: what the second says of each claim is told."""
    wrong = deepcopy(dict(certify(cubic("tables"), [[1.0]]).document))
    wrong["model"]["tables"]["stiffness"] = {}
    (row,) = cross_checked_document(resealed(wrong)).rows

    assert row.first == "REFUSED"
    assert "second checker says: sector-embedding NOT REPLAYED, decay PROVED" in row.reason


def test_an_equation_that_is_another_is_no_abstention() -> None:
    """Where both sides differ at a point, the second checker says so."""
    wrong = deepcopy(dict(certify(cubic(), [[1.0]]).document))
    wrong["model"]["equations"] = ["-x - x^3 + u + w + sin(x)/1000"]
    rows = cross_checked_document(resealed(wrong)).rows

    assert (rows[0].first, rows[0].second) == ("UNDECIDED", "UNDECIDED")
    assert check_document(resealed(wrong)).verdict.name == "UNDECIDED"
