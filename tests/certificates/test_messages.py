"""What a check says beside its verdicts: the files it had, and what each claim rests on."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from takagi.certificates import CertificateError, certify, check
from takagi.certificates.checker import check_document
from takagi.certificates.checker.files.given_files import EARLIER
from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.replay.claim_kinds import TURBINE_KINDS, class_of
from takagi.certificates.claims.turbine.loop_claims import loop_claims
from takagi.certificates.document.certificate_file import dumps
from takagi.cli.main import main
from takagi.models import sector_model
from takagi.models.plant_files.loader import load_plant
from takagi.reports import ci_formats
from tests.certificates.kinds.claims import resealed

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
    monkeypatch.setattr(reader, "LARGEST_FILE", 10)
    path = tmp_path / "large.json"
    path.write_text('{"a": 1}  ')
    assert reader.read_json(path) == {"a": "1"}

    path.write_text('{"a": 1}   ')
    with pytest.raises(CertificateError, match="larger than 10 bytes"):
        reader.read_json(path)


# What such a line has to name, whatever else it names.
NEEDED = (
    "start with V <= 1",
    "torque without delay, and commands without a limit of their rates",
    "first-order pitch drive",
    "rigid shaft",
    "wake without states",
    "continuous time",
    "exact speed",
    "wind estimate from outside",
    "start of the wind filter at its estimate",
)


@pytest.fixture(scope="module")
def resting(short_document: dict[str, Any]) -> dict[str, Any]:
    document = deepcopy(short_document)
    claims, _ = loop_claims(document["model"], document["gains"], document["claims"][0])
    return dict(resealed(document | {"claims": claims}))


@pytest.fixture(scope="module")
def written(resting: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("assumed") / "certificate.json"
    path.write_text(json.dumps(resting), encoding="utf-8")
    return path


def test_every_reader_prints_what_each_claim_assumes(
    written: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Terminal, JSON, JUnit, Markdown and SARIF of one file; JSON has lists."""
    checked = check(written)
    lines = [f"assumes: {'; '.join(claim.assumes)}" for claim in checked.claims]
    reports = {name: tmp_path / name for name in ("junit", "sarif", "summary")}
    options = [word for name, path in reports.items() for word in (f"--{name}", str(path))]

    assert main(["check", str(written), *options]) == 0
    printed = [line.strip() for line in capsys.readouterr().out.splitlines()]
    assert [line for line in printed if line.startswith("assumes")] == lines
    assert main(["check", str(written), "--json"]) == 0
    claims = json.loads(capsys.readouterr().out)["claims"]
    assert [tuple(claim["assumes"]) for claim in claims] == [c.assumes for c in checked.claims]
    out = ElementTree.fromstring(reports["junit"].read_text(encoding="utf-8")).find(".//system-out")
    assert out is not None and out.text is not None
    summary = reports["summary"].read_text(encoding="utf-8")
    (run,) = json.loads(reports["sarif"].read_text(encoding="utf-8"))["runs"]
    assumed_there = run["tool"]["driver"]["properties"]["assumes"]
    for claim, line in zip(checked.claims, lines, strict=True):
        assert line in out.text and line.replace("<", "&lt;") in summary
        assert assumed_there[claim.name] == list(claim.assumes)
    for phrase in NEEDED:
        assert sum(phrase in one for one in checked.assumes) == 1, phrase


def test_each_claim_carries_its_own(resting: dict[str, Any]) -> None:
    """The filter's start is the wind rate's alone; a claim that is not proved assumes the same."""
    loop, rate, actuators = check_document(resting).claims

    assert loop.assumes == actuators.assumes
    assert set(rate.assumes) - set(loop.assumes) == {"start of the wind filter at its estimate"}
    assert "from any start with V <= 1 and the filter at its estimate" in rate.text
    assert all(class_of(kind).assumes for kind in TURBINE_KINDS)
    wrong = deepcopy(resting)
    wrong["claims"][0]["cells"][0]["decay_rate"] = 3.0
    undecided = check_document(resealed(wrong)).claims
    assert [claim.verdict.name for claim in undecided] == ["UNDECIDED"] * 3
    assert [claim.assumes for claim in undecided] == [c.assumes for c in (loop, rate, actuators)]


def test_a_claim_about_no_turbine_assumes_nothing_here() -> None:
    """Claims of plants say what they rest on in their own words."""
    assert ci_formats.junit(ci_formats.refusal("no"), source="c.json").count("assumes") == 0


CONSTANT, MOVING = ("paper-loop", "running-loop", "set-points"), ("coherent-loop", "wind-rate")


@pytest.mark.parametrize("kind", TURBINE_KINDS)
def test_every_claim_about_a_turbine_names_what_its_model_leaves_out(kind: str) -> None:
    """The running loop alone has a wake with a state and filters of the measured speed."""
    words = " ".join(class_of(kind).assumes)
    for phrase in ("rigid shaft, tower and blades", "first-order pitch drive", "continuous time"):
        assert phrase in words
    assert ("wake without states" in words) is (kind != "running-loop")
    assert ("exact speed" in words) is (kind != "running-loop")
    assert ("constant wind" in words) is (kind in CONSTANT)
    assert ("estimate from outside" in words) is (kind in (*MOVING, "bumpless"))
