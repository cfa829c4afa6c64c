"""What a check says beside its verdicts: which files it had, and what they are not about."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from takagi.certificates import CertificateError, certify, check
from takagi.certificates.checker.files.given_files import EARLIER
from takagi.certificates.checker.kernel import reader
from takagi.certificates.document.certificate_file import dumps
from takagi.models import sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.conftest import resealed

GAIN = "checked without a gain file: the verdict is about the gains inside the certificate"
MODEL = "checked without a model file: the verdict is about the plant inside the certificate"
PLANT = """format = 1
kind = "plant"
units = "unchecked"
name = "decay"
description = "one rule"
[states]
x = { range = [-1, 1], description = "x" }
[inputs]
u = { description = "u" }
[equations]
x = "-x + u"
"""


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """A certificate that the model is the plant, its gain file and its model file."""
    found = {name: tmp_path / name for name in ("certificate.json", "gains.json", "decay.toml")}
    found["decay.toml"].write_text(PLANT)
    model = sector_model(load_plant(found["decay.toml"]))
    document = dict(certify(model, [[1.0]]).document)
    embedding = next(c for c in document["claims"] if c["kind"] == "sector-embedding")
    document["claims"] = [embedding]
    found["gains.json"].write_text(json.dumps({"law": document["gains"]}))
    found["certificate.json"].write_text(dumps(resealed(document)))
    return found


def test_every_choice_of_files_has_its_own_messages(files: dict[str, Path]) -> None:
    certificate, gains, model = files.values()

    assert check(certificate).messages == [GAIN, MODEL]
    assert check(certificate, gains=gains).messages == [MODEL]
    earlier = f"{model}: {EARLIER}"
    assert check(certificate, model=model).messages == [GAIN, earlier]
    assert check(certificate, gains=gains, model=model).messages == [earlier]


def test_either_file_is_compared(files: dict[str, Path]) -> None:
    certificate, gains, model = files.values()
    other = gains.with_name("other.json")
    law = json.loads(gains.read_text())["law"]
    other.write_text(json.dumps({"law": law | {"K": [[[2]]]}}))
    with pytest.raises(CertificateError, match="K"):
        check(certificate, gains=other)
    with pytest.raises(CertificateError, match="K"):
        check(certificate, gains=other, model=model)

    model.write_text(PLANT.replace("-x", "-2*x"))
    with pytest.raises(CertificateError, match="equation"):
        check(certificate, model=model)
    with pytest.raises(CertificateError, match="equation"):
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
