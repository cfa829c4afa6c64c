"""Model, gains and claims are each sealed by a hash of their own."""

from __future__ import annotations

import json
from copy import deepcopy
from typing import Any

import pytest

from takagi.certificates import check
from takagi.certificates.checker import CertificateError, Verdict, check_document
from takagi.certificates.document.certificate_file import certificate_document
from tests.certificates.kinds.claims import law_data, model_data


@pytest.fixture(scope="module")
def sealed() -> dict[str, Any]:
    """A proved certificate of x' = -x + u under u = -x; no change here exceeds its margin."""
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
