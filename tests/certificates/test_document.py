"""The certificate as a file: what is written is read and hashed, part by part, and its verdict."""

from __future__ import annotations

import json
from copy import deepcopy
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import Claim
from takagi.certificates.checker import CertificateError, Verdict, check, check_document, read_text
from takagi.certificates.checker.files.given_files import compare_model
from takagi.certificates.checker.kernel.reader import digest
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.checker.replay.claim_kinds import PLANT_KINDS, TURBINE_KINDS, replay
from takagi.certificates.checker.replay.containment import LAST_READER, NO_LONGER_READ
from takagi.certificates.document.certificate_file import certificate_document, dumps
from tests.certificates.kinds.claims import law_data, model_data, resealed

TEXTS = ["},{", '"},{"', "a\\", '\\"},{', "plain"]


@pytest.mark.parametrize("text", TEXTS)
def test_line_breaks_do_not_enter_texts(text: str) -> None:
    """Rows are written one a line; a text that looks like a seam between rows stays whole."""
    document = {"rows": [{"a": 1}, {"a": text}, {text: 2}]}

    assert json.loads(dumps(document)) == document
    assert dumps(document).count("\n") == 3


def test_hashes_are_those_of_the_file(short: dict[str, Any]) -> None:
    read = read_text(dumps(short), "file")

    for part, found in short["provenance"]["sha256"].items():
        assert digest(read[part]) == found
    assert check_document(json.loads(dumps(short))).verdict is check_document(short).verdict


def test_what_is_no_number_cannot_be_written() -> None:
    """NaN has no place in a certificate."""
    document = certificate_document(model={"a": 1}, gains=None, claims=[], provenance={"b": 1})

    assert document["provenance"]["b"] == 1
    with pytest.raises(ValueError, match="JSON"):
        dumps(document | {"claims": [float("nan")]})


PROVED, DISPROVED, UNDECIDED = Verdict.PROVED, Verdict.DISPROVED, Verdict.UNDECIDED


PAIRS = list(product(Verdict, repeat=2))


@pytest.mark.parametrize("verdicts", PAIRS, ids=lambda pair: "-".join(v.name for v in pair))
def test_two_claims(verdicts: tuple[Verdict, Verdict]) -> None:
    """PROVED when both are, DISPROVED when one is, UNDECIDED otherwise; messages are kept."""
    checked = concluded([Claim("a", verdict, "text") for verdict in verdicts], ["note"])

    expected = DISPROVED if DISPROVED in verdicts else UNDECIDED
    if verdicts == (PROVED, PROVED):
        expected = PROVED
    assert checked.verdict is expected
    assert [claim.verdict for claim in checked.claims] == list(verdicts)
    assert checked.messages == ["note"]


def test_no_claim_is_not_proved() -> None:
    assert concluded([], []).verdict is UNDECIDED


@pytest.mark.parametrize("kind", [*PLANT_KINDS, *TURBINE_KINDS])
def test_a_claim_that_reads_the_file_needs_one(kind: str) -> None:
    with pytest.raises(CertificateError, match="is not one that this checker replays"):
        replay({"kind": kind, "name": "a"}, None, None, [], "claim 1")


@pytest.fixture(scope="module")
def sealed() -> dict[str, Any]:
    claim = {"name": "decay", "kind": "decay", "P": [[1]], "decay_rate": 1}
    model, gains = model_data([[[-1]]], B=[[[1]]]), law_data([[[1]]])
    return certificate_document(model=model, gains=gains, claims=[claim], provenance={})


def test_the_certificate_is_proved(sealed: dict[str, Any]) -> None:
    assert check_document(sealed).verdict is Verdict.PROVED


CHANGES: dict[str, tuple[tuple[Any, ...], Any]] = {
    "model": (("model", "A", 0, 0, 0), -1.5),
    "gains": (("gains", "K", 0, 0, 0), 2),
    "claims": (("claims", 0, "decay_rate"), 0.5),
}


@pytest.mark.parametrize("part", CHANGES)
def test_a_changed_part_is_refused_even_where_it_is_true(
    part: str, sealed: dict[str, Any], tmp_path: Any
) -> None:
    """Each change leaves a true claim: the hash of that part alone refuses it."""
    changed, (path, value) = deepcopy(sealed), CHANGES[part]
    place: Any = changed
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    file = tmp_path / "certificate.json"
    file.write_text(json.dumps(changed), encoding="utf-8")

    with pytest.raises(CertificateError, match=f"the {part} changed after"):
        check_document(changed)
    with pytest.raises(CertificateError, match=f"the {part} changed after"):
        check(file)
    again = certificate_document(**{p: changed[p] for p in CHANGES}, provenance={})
    assert check_document(again).verdict is Verdict.PROVED


@pytest.mark.parametrize("part", CHANGES)
def test_a_hash_that_is_missing_is_refused(part: str, sealed: dict[str, Any]) -> None:
    changed = deepcopy(sealed)
    del changed["provenance"]["sha256"][part]

    with pytest.raises(CertificateError, match=f"'{part}' is missing"):
        check_document(changed)


@pytest.mark.parametrize("hashes", [None, 7, "controller", []])
def test_hashes_that_are_no_table_are_refused(hashes: object, sealed: dict[str, Any]) -> None:
    changed = deepcopy(sealed)
    changed["provenance"]["sha256"] = hashes

    with pytest.raises(CertificateError):
        check_document(changed)


REMOVED = sorted(NO_LONGER_READ)
SENTENCE = (
    "claims of kind '{}' are no longer read; check this file with takagi at commit "
    f"{LAST_READER}, the last that reads them, or make the certificate again"
)


def document(*kinds: str) -> dict[str, Any]:
    claim = {"name": "by hand", "P": [[1]], "decay_rate": 0.5}
    claims = [{"kind": kind, **claim} for kind in kinds]
    return certificate_document(
        model=model_data([[[-1]]]), gains=None, claims=claims, provenance={}
    )


def test_the_document_is_proved_with_a_kind_that_is_read() -> None:
    """So the files below are refused for their kinds, not for how they are made."""
    assert check_document(document("decay")).verdict.name == "PROVED"


@pytest.mark.parametrize("kind", REMOVED)
def test_a_file_with_the_kind_is_refused(kind: str, tmp_path: Path) -> None:
    """Also beside a claim that is proved; the sentence names the last commit that reads it."""
    path = tmp_path / "certificate.json"
    for kinds in ((kind,), ("decay", kind)):
        path.write_text(json.dumps(document(*kinds)), encoding="utf-8")
        with pytest.raises(CertificateError) as refused:
            check(path)
        assert SENTENCE.format(kind) in str(refused.value)
        assert str(refused.value).startswith(f"claims[{len(kinds) - 1}].kind: ")


def test_the_gain_file_must_hold_the_same_numbers(short: Any, tmp_path: Path) -> None:
    """Checked with gains, the certificate is about these: one decimal apart is refused by name."""
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"
    certificate.write_text(json.dumps(resealed(short)))
    gains.write_text(json.dumps({"law": short["gains"]}))
    assert "gain file" not in " ".join(check(certificate, gains=gains).messages)

    short["gains"]["overlap"] += 1e-9
    gains.write_text(json.dumps({"law": short["gains"]}))
    with pytest.raises(CertificateError, match="overlap"):
        check(certificate, gains=gains)


def test_matrices_are_those_of_no_file(tmp_path: Path) -> None:
    """Whatever hash a certificate of matrices holds: no claim says that the file has them."""
    known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    data = {"model": {"kind": "takagi-sugeno", "files_sha256": {"plant.data": known}}}
    model = tmp_path / "plant.data"
    model.write_text("abc")

    with pytest.raises(CertificateError, match="no claim ties to a model file"):
        compare_model(data, model)
