"""`takagi check --cross`: both deciders' verdicts beside each other, and what is left open."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates import Certificate, CertificateError, certify, check
from takagi.certificates.cross_check import comparison
from takagi.certificates.cross_check.comparison import (
    FlintDecider,
    VerdictComparison,
    VerdictRow,
    cross_checked,
    cross_checked_document,
)
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.cli.main import main
from takagi.lmi import pdc
from takagi.models import sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.claims import Data, resealed
from tests.certificates.weights.cells import cubic


@pytest.fixture(scope="module")
def lorenz() -> Data:
    """All that is claimed of a library plant with gains of four digits."""
    model = sector_model(load_plant("lorenz"))
    gains = np.round(pdc(model, decay_rate=0.2).require()[0], 4)
    return dict(certify(model, gains, claims="all").document)


def saved(folder: Path, document: object) -> str:
    path = folder / "certificate.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return str(path)


def verdicts_of(document: Data) -> list[tuple[str, str]]:
    return [(row.first, row.second) for row in cross_checked_document(document).rows]


def test_a_refusal_by_one_run_alone_is_a_difference(
    lorenz: Data, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuses(self: object, required: object) -> bool:
        raise CertificateError("not by FLINT")

    monkeypatch.setattr(comparison.FlintDecider, "__call__", refuses)
    compared = cross_checked_document(lorenz)

    assert [(row.first, row.second) for row in compared.rows] == [("PROVED", "REFUSED")]
    assert not compared.agrees


def test_agreement_as_text_and_as_json(lorenz: Data, tmp_path: Path, capsys: Any) -> None:
    path = saved(tmp_path, lorenz)

    assert main(["check", path, "--cross"]) == 0
    assert "6 of 6 claims decided twice: they agree" in capsys.readouterr().out
    assert main(["check", path, "--cross", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)["cross"]
    assert (data["agree"], data["replayed"], data["not_replayed"]) == (True, 6, [])
    assert [claim["name"] for claim in data["claims"]] == [c["name"] for c in lorenz["claims"]]


@pytest.mark.parametrize("blind", ["is_definite", "keeps_bounds"])
def test_a_difference_is_shown_and_fails(
    blind: str, lorenz: Data, tmp_path: Path, monkeypatch: Any, capsys: Any
) -> None:
    """A decider to which no matrix is definite, or that no range keeps, ends the verb with 1."""
    path = saved(tmp_path, lorenz)
    monkeypatch.setattr(comparison, blind, lambda *_, **__: False)

    compared = cross_checked(path)
    assert not compared.agrees and not compared.data["agree"]
    assert any(row.reason for row in compared.rows if row.second == "UNDECIDED")
    assert main(["check", path, "--cross"]) == 1
    assert "THEY DIFFER" in capsys.readouterr().out
    assert main(["check", path, "--cross", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["cross"]["agree"] is False


def test_a_claim_is_undecided_by_both(lorenz: Data) -> None:
    changed = deepcopy(lorenz)
    changed["claims"][1]["decay_rate"] = 50
    assert verdicts_of(resealed(changed))[:2] == [("PROVED", "PROVED"), ("UNDECIDED", "UNDECIDED")]


def test_a_refused_file_is_one_row(lorenz: Data, tmp_path: Path) -> None:
    """Changed after it was hashed, or without claims: the row is no claim."""
    for part, value in (("model", {}), ("claims", []), ("claims", "decay"), ("claims", None)):
        changed = {**lorenz, part: value}
        for document in (changed, resealed(changed)):
            (row,) = cross_checked(saved(tmp_path, document)).rows
            assert (row.first, row.second, row.is_claim) == ("REFUSED", "REFUSED", False)
            assert row.reason


def test_a_range_of_a_table_is_left_open_and_named(tmp_path: Path, capsys: Any) -> None:
    """The status is the checker's; text and JSON name the claim."""
    certificate = certify(cubic("tables"), [[1.0]])
    assert isinstance(certificate, Certificate)
    path = str(certificate.save(tmp_path / "c.json"))
    name = "cubic is its Takagi-Sugeno model"

    assert main(["check", path, "--cross"]) == 0
    summed = capsys.readouterr().out.splitlines()[-1]
    assert summed.startswith("1 of 2 claims decided twice: they agree") and f'"{name}"' in summed
    assert main(["check", path, "--cross", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)["cross"]
    assert (data["agree"], data["replayed"], data["not_replayed"]) == (True, 1, [name])
    assert [claim["second"] for claim in data["claims"]] == [comparison.NOT_REPLAYED, "PROVED"]


@pytest.mark.parametrize("name", ["cubic", "duffing", "flexible_joint"])
def test_an_honest_secant_certificate_is_decided_twice(name: str) -> None:
    model = cubic("secants") if name == "cubic" else secant_model(load_plant(name))
    compared = cross_checked_document(certify(model, [[3.0] * model.A.shape[1]]).document)

    assert compared.left_open == ()
    assert [row.second for row in compared.rows] == [row.first for row in compared.rows]
    assert compared.rows[0].second == "PROVED"


@pytest.mark.parametrize("change", ["entry", "bound", "equation", "kink"])
def test_false_secants_are_undecided(change: str) -> None:
    wrong = deepcopy(dict(certify(cubic("secants"), [[1.0]]).document))
    if change == "entry":
        wrong["model"]["embedding"]["A"] = [["3*s1 - 1.001"]]
    elif change == "bound":
        wrong["model"]["embedding"]["premises"][0]["lower"] = -0.99
        wrong["gains"]["premises"][0]["lower"] = -0.99
    elif change == "equation":
        wrong["model"]["equations"] = ["-x - x^3 + u + w + x^2/1000"]
    else:
        wrong["model"]["equations"] = ["-x - x^3 + u + w + abs(x) - abs(x)"]
    assert verdicts_of(resealed(wrong))[0] == ("UNDECIDED", "UNDECIDED")


def test_a_name_of_the_file_is_quoted() -> None:
    row = VerdictRow('any"\n', "PROVED", "PROVED", 1)
    assert row.shown == '"any\\"\\n"'
    assert row.shown in VerdictComparison([row]).text


@pytest.mark.parametrize(
    ("first", "second", "agree"),
    [
        ("PROVED", "PROVED", True),
        ("PROVED", "NOT REPLAYED", True),
        ("PROVED", "UNDECIDED", False),
        ("UNDECIDED", "PROVED", False),
        ("DISPROVED", "UNDECIDED", False),
        ("DISPROVED", "PROVED", False),
    ],
)
def test_what_counts_as_agreement(first: str, second: str, agree: bool) -> None:
    assert VerdictComparison([VerdictRow("any", first, second, 1)]).agrees is agree


def test_turbine_is_decided_twice(short: Data) -> None:
    """The matrices of the effort-sharing loop; and they can fail."""
    (row,) = cross_checked_document(short).rows
    assert (row.first, row.second) == ("PROVED", "PROVED")
    assert row.matrices > 300

    short["claims"][0]["cells"][2]["decay_rate"] = 1.0
    assert verdicts_of(resealed(short)) == [("UNDECIDED", "UNDECIDED")]


DOCS = Path(__file__).resolve().parents[3] / "docs"
PAGE = " ".join((DOCS / "cross-check.md").read_text(encoding="utf-8").split())
STORED = DOCS / "figures" / "nrel5mw-certificate.json"


@pytest.mark.slow
def test_the_page_counts_what_is_decided_and_exported(tmp_path: Path) -> None:
    """Matrices and numbers of the second decision; matrices of the Coq file, and its size."""
    deciders: dict[int, FlintDecider] = {}
    checked = check(STORED, decider_of=lambda k: deciders.setdefault(k, FlintDecider()))
    out = tmp_path / "nrel5mw.v"
    assert main(["export", str(STORED), "--coq", str(out)]) == 0

    assert checked.verdict.name == "PROVED" and len(checked.claims) == 4
    claims = json.loads(STORED.read_text(encoding="utf-8"))["claims"]
    cells, running = (len(claims[place]["cells"]) for place in (0, 3))
    matrices, numbers = (
        sum(getattr(decider, name) for decider in deciders.values())
        for name in ("matrices", "numbers")
    )
    of = f"{cells} wind cells and {running} of the running loop"
    assert f"its four claims with {of}) has {matrices} matrices and {numbers} numbers" in PAGE
    of = f"4 claims, all {cells} wind cells, and {running} of the running loop"
    assert f"{of} | {matrices} | {out.stat().st_size / 1e6:.1f} MB |" in PAGE
    assert not any(decider.left_open for decider in deciders.values())
