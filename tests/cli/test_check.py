"""`takagi check`: what it prints, writes and returns for each verdict.

The checker is replaced by one whose answer is known; what the real one proves is tested where it
lives.
"""

from __future__ import annotations

import json
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

# The command imports these parts of the checker by name: they have to be there before the whole is
# replaced, when this file is run alone as well.
import takagi.reports.code.c.comparison  # noqa: F401
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.kernel.refusal import CertificateError, OtherGains
from takagi.certificates.checker.kernel.result import Checked, Claim, Verdict
from takagi.cli.main import main
from takagi.models.files.library import data_folder

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def checker(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """A checker that answers with its `.answer`, or raises it, and keeps what it was asked."""
    module: Any = ModuleType("takagi.certificates.checker")

    def check(path: Path, *, gains: Path | None = None, model: Path | None = None) -> Any:
        module.asked = (path, gains, model)
        if isinstance(module.answer, Exception):
            raise module.answer
        return module.answer

    module.check, module.CertificateError = check, CertificateError
    monkeypatch.setitem(sys.modules, "takagi.certificates.checker", module)
    return module  # type: ignore[no-any-return]


def answer(verdict: Verdict) -> Checked:
    return Checked(verdict, [Claim("decay", verdict, "at 0.1 1/s")], ["3 inequalities"])


@pytest.mark.parametrize(
    ("verdict", "status"), [(Verdict.PROVED, 0), (Verdict.DISPROVED, 1), (Verdict.UNDECIDED, 1)]
)
def test_the_status_is_the_verdict(
    checker: Any, capsys: Capture, verdict: Verdict, status: int
) -> None:
    """Only PROVED is 0; the verdict, the claim's name in quotes and the messages are printed."""
    checker.answer = answer(verdict)

    assert main(["check", "c.json"]) == status

    assert capsys.readouterr().out.splitlines() == [
        f"c.json: {verdict.name}",
        f'  {verdict.name}  "decay": at 0.1 1/s',
        "3 inequalities",
    ]


def test_gains_and_model_are_handed_to_the_checker(checker: Any) -> None:
    """What is compared is the checker's business."""
    checker.answer = answer(Verdict.PROVED)

    main(["check", "c.json", "--gains", "g.json", "--model", "m.toml"])

    assert checker.asked == (Path("c.json"), Path("g.json"), Path("m.toml"))


def test_a_built_in_name_stands_for_its_file(
    checker: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checker.answer = answer(Verdict.PROVED)
    monkeypatch.chdir(tmp_path)

    main(["check", "c.json", "--model", "cart_pole"])
    assert checker.asked[2] == data_folder() / "cart_pole.toml"

    main(["check", "c.json", "--model", "cart_poles"])
    assert checker.asked[2] == Path("cart_poles")

    (tmp_path / "cart_pole").write_text("mine", encoding="utf-8")
    main(["check", "c.json", "--model", "cart_pole"])
    assert checker.asked[2] == Path("cart_pole")


def test_json_is_the_whole_answer(checker: Any, capsys: Capture) -> None:
    """Machines read standard output; there is nothing else on it."""
    checker.answer = answer(Verdict.UNDECIDED)
    claim = {"name": "decay", "verdict": "UNDECIDED", "text": "at 0.1 1/s", "assumes": []}

    assert main(["check", "c.json", "--json"]) == 1

    assert json.loads(capsys.readouterr().out) == {
        "certificate": "c.json",
        "verdict": "UNDECIDED",
        "claims": [claim | {"figures": []}],
        "assumes": [],
        "messages": ["3 inequalities"],
    }


def test_reports_are_written_where_asked(checker: Any, tmp_path: Path) -> None:
    """Each report in its own file, its folder made on the way."""
    checker.answer = answer(Verdict.PROVED)
    files = [tmp_path / "ci" / name for name in ("c.xml", "c.sarif", "c.md")]

    options = [f"{option}={file}" for option, file in zip(_REPORTS, files, strict=True)]
    assert main(["check", "c.json", *options]) == 0

    assert all("decay" in file.read_text(encoding="utf-8") for file in files)


@pytest.mark.parametrize(
    ("verdict", "whole"), [(Verdict.PROVED, "FAILED"), (Verdict.UNDECIDED, "UNDECIDED")]
)
def test_what_is_missed_beside_the_claims_hides_none(
    checker: Any, monkeypatch: pytest.MonkeyPatch, capsys: Capture, tmp_path: Path,
    verdict: Verdict, whole: str,
) -> None:  # fmt: skip
    """A margin that is missed stands behind the claims: printed, in JSON, and in every report."""
    checker.answer = answer(verdict)
    margins: Any = ModuleType("takagi.reports.simulation.measured_loop")
    margins.filed_margins = lambda *_: (("at 9 m/s it is 1.1",), ("least gain 1.1",))
    monkeypatch.setitem(sys.modules, margins.__name__, margins)
    asked = ["check", "c.json", "--gains", "g.json", "--model", "m.toml", "--margins", "gain 2"]
    files = {option: tmp_path / option.strip("-") for option in _REPORTS}
    missed = "the loop that runs has the margins asked"

    assert main([*asked, *(f"{option}={file}" for option, file in files.items())]) == 1
    assert main([*asked, "--json"]) == 1

    text, _, data = capsys.readouterr().out.partition("{")
    assert text.startswith(f"c.json: {whole}\n")
    assert '"decay": at 0.1 1/s' in text and f'"{missed}": g.json: at 9 m/s' in text
    assert "3 inequalities\nleast gain 1.1\n" in text
    found = json.loads("{" + data)
    assert [one["name"] for one in found["claims"]] == ["decay", missed]
    assert found["verdict"] == whole
    cases = ElementTree.parse(files["--junit"]).iter("testcase")
    assert [case.get("name") for case in cases] == ["decay", missed]
    summary = files["--summary"].read_text("utf-8")
    assert f"| {verdict.name} | decay |" in summary and f"| FAILED | {missed} |" in summary
    (run,) = json.loads(files["--sarif"].read_text("utf-8"))["runs"]
    assert run["results"][-1]["partialFingerprints"]["claim/v1"] == missed


def test_a_refused_file_is_misuse_and_stands_in_the_reports(
    checker: Any, capsys: Capture, tmp_path: Path
) -> None:
    """One message, status 2, and no green report left from an earlier run."""
    checker.answer = CertificateError("c.json, line 3: a number is not decimal")
    report = tmp_path / "c.xml"

    assert main(["check", "c.json", "--junit", str(report)]) == 2

    assert capsys.readouterr().err == "Error: c.json, line 3: a number is not decimal\n"
    assert "REFUSED" in report.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("error", "case", "status"),
    [
        (CertificateError("c.json: not JSON"), "the file is a certificate", 2),
        (
            CertificateError("provenance: 'sha256' is missing"),
            "the file is a certificate",
            2,
        ),
        (OtherGains("g.json: the law is not"), "the gain file is the certificate's", 1),
        (CertificateError("g.json: not JSON"), "the gain file can be read", 2),
        (OtherModel("m.toml: not the certificate's"), "the model file is the certificate's", 1),
        (CertificateError("m.toml: cannot be read"), "the model file can be read", 2),
    ],
)
def test_the_reports_blame_the_file_that_is_refused(
    checker: Any, tmp_path: Path, error: Exception, case: str, status: int
) -> None:
    checker.answer = error
    files = {option: tmp_path / option.strip("-") for option in _REPORTS}
    given = ["check", "c.json", "--gains", "g.json", "--model", "m.toml"]

    assert main([*given, *(f"{option}={file}" for option, file in files.items())]) == status

    (told,) = ElementTree.parse(files["--junit"]).iter("testcase")
    assert told.get("name") == case
    (run,) = json.loads(files["--sarif"].read_text("utf-8"))["runs"]
    names = [result["partialFingerprints"]["claim/v1"] for result in run["results"]]
    assert names == [case]
    assert f"| REFUSED | {case} |" in files["--summary"].read_text("utf-8")


def test_a_report_that_cannot_be_written_is_misuse(
    checker: Any, capsys: Capture, tmp_path: Path
) -> None:
    """A check whose report is lost must not look like one that passed."""
    checker.answer = answer(Verdict.PROVED)

    assert main(["check", "c.json", "--junit", str(tmp_path)]) == 2

    assert "this is a folder, and a file was expected" in capsys.readouterr().err


@pytest.mark.parametrize(
    "options", [["--junit", "DIR"], ["--gains", "g.json", "--c-source", "DIR/none.c"]]
)
def test_what_cannot_be_used_is_refused_before_the_check(
    checker: Any, capsys: Capture, tmp_path: Path, options: list[str]
) -> None:
    """A check may take a minute: a place or a file that is wrong is told first."""
    checker.answer, checker.asked = answer(Verdict.PROVED), None
    given = [text.replace("DIR", str(tmp_path)) for text in options]

    assert main(["check", "c.json", *given]) == 2

    assert checker.asked is None
    assert str(tmp_path) in capsys.readouterr().err


_REPORTS = ("--junit", "--sarif", "--summary")
