"""Files beside a certificate that have other numbers, or none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, check
from takagi.certificates.checker.files.given_files import compare_model
from tests.certificates.kinds.claims import resealed


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
