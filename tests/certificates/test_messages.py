"""What a check says beside its verdicts: which files it had, and what they are not about."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import CertificateError, check
from takagi.certificates.checker.kernel import reader
from tests.certificates.pinned.shapes import hashed

GAIN = "checked without a gain file: the verdict is about the gains inside the certificate"
MODEL = "checked without a model file: the verdict is about the plant inside the certificate"
ALONE = "about matrices inside the claim alone: claims[0]"
ALONE += "; no claim is about the loop of the given files"
ABC = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"  # of "abc", FIPS 180-4


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """A certificate with one claim about its own matrices, its gain file and its model file."""
    claim = {"name": "n", "kind": "quadratic-decay", "A": [[[-1]]], "P": [[1]], "decay_rate": 0}
    model: dict[str, Any] = {"kind": "takagi-sugeno", "files_sha256": {"plant.data": ABC}}
    document = {"format": "takagi-certificate", "version": 1, "model": model, "gains": {"K": 1}}
    found = {name: tmp_path / name for name in ("certificate.json", "gains.json", "plant.data")}
    found["gains.json"].write_text(json.dumps({"law": {"K": 1}}))
    found["plant.data"].write_text("abc")
    written = json.dumps({**document, "claims": [claim]})
    found["certificate.json"].write_text(written)
    sealed = hashed(reader.read_json(found["certificate.json"]))
    document["provenance"] = sealed["provenance"]
    found["certificate.json"].write_text(json.dumps({**document, "claims": [claim]}))
    return found


def test_every_choice_of_files_has_its_own_messages(files: dict[str, Path]) -> None:
    certificate, gains, model = files.values()

    assert check(certificate).messages == [GAIN, MODEL]
    assert check(certificate, gains=gains).messages == [MODEL, ALONE]
    assert check(certificate, model=model).messages == [GAIN, ALONE]
    assert check(certificate, gains=gains, model=model).messages == [ALONE]


def test_either_file_is_compared(files: dict[str, Path]) -> None:
    certificate, gains, model = files.values()
    other = gains.with_name("other.json")
    other.write_text(json.dumps({"law": {"K": 2}}))
    with pytest.raises(CertificateError, match="K"):
        check(certificate, gains=other)
    with pytest.raises(CertificateError, match="K"):
        check(certificate, gains=other, model=model)

    model.write_text("abcd")
    with pytest.raises(CertificateError, match="changed"):
        check(certificate, model=model)
    with pytest.raises(CertificateError, match="changed"):
        check(certificate, gains=gains, model=model)


def test_a_file_of_the_largest_size_is_read_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One byte more is refused, and not read as what is left without it."""
    monkeypatch.setattr(reader, "LARGEST_FILE", 10)
    path = tmp_path / "large.json"
    path.write_text('{"a": 1}  ')
    assert reader.read_json(path) == {"a": "1"}

    path.write_text('{"a": 1}   ')
    with pytest.raises(CertificateError, match="larger than 10 bytes"):
        reader.read_json(path)
