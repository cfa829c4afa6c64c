"""The three reports of a check, read back by readers that are not ours."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from takagi.certificates import Checked, Claim, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.checker.words.figure import Figure
from takagi.reports.ci_formats import junit, markdown, refusal, sarif, with_failures


def mixed() -> Checked:
    """One claim of each verdict, with what XML and Markdown must escape."""
    claims = [
        Claim("decay", Verdict.PROVED, "V' <= -2 a V & more"),
        Claim("pitch", Verdict.DISPROVED, "|rate| > limit\x00"),
        Claim("box", Verdict.UNDECIDED, 'cell "3"'),
    ]
    return concluded(claims, ["checked <all>"])


def test_junit_fails_what_is_not_proved() -> None:
    """Three cases, two failures, typed by the verdict; the text survives XML."""
    suite = ElementTree.fromstring(junit(mixed(), source="out/certificate.json"))[0]

    cases = suite.findall("testcase")
    failures = {case.get("name"): case.find("failure") for case in cases}

    assert (suite.get("tests"), suite.get("failures")) == ("3", "2")
    assert failures["decay"] is None
    assert failures["pitch"] is not None and failures["pitch"].get("type") == "DISPROVED"
    assert failures["box"] is not None and failures["box"].text == 'cell "3"'
    assert suite.findtext("system-out") == "checked <all>"


def test_sarif_has_one_result_for_what_is_not_proved() -> None:
    """PROVED is a rule without a result, DISPROVED an error, UNDECIDED a warning."""
    run = json.loads(sarif(mixed(), source="my out/certificate.json"))["runs"][0]

    results = run["results"]
    rules = run["tool"]["driver"]["rules"]

    assert [(r["kind"], r["level"]) for r in results] == [("fail", "error"), ("fail", "warning")]
    assert [rules[r["ruleIndex"]]["id"] for r in results] == [r["ruleId"] for r in results]
    assert [rule["id"] for rule in rules] == ["decay", "pitch", "box"]
    location = results[0]["locations"][0]["physicalLocation"]["artifactLocation"]
    assert location["uri"] == "my%20out/certificate.json"


def test_sarif_marks_the_plant_and_names_kinds(tmp_path: Path) -> None:
    """A rule is a kind, never a plant's name; the line is that of the section it follows from."""
    plant = tmp_path / "motor.toml"
    plant.write_text('kind = "plant"\n\n[states]\n[inputs]\n[equations]\n', encoding="utf-8")
    claims = [Claim(f"{name} of motor", Verdict.UNDECIDED, "") for name in ("limits", "decay")]
    missed = with_failures(concluded(claims, []), [("the loop has the margins", "at 9 m/s")])
    text = sarif(missed, source="c", kinds=["input-limits", "decay"], plant=plant)

    run = json.loads(text)["runs"][0]
    driver, places = run["tool"]["driver"], [r["locations"][0] for r in run["results"]]
    ids = [rule["id"] for rule in driver["rules"]]
    assert ids == ["input-limits", "decay", "the-loop-has-the-margins"] and driver["version"]
    assert [p["physicalLocation"]["region"]["startLine"] for p in places] == [4, 5, 5]
    assert places[0]["physicalLocation"]["artifactLocation"]["uri"].endswith("motor.toml")


def test_markdown_is_a_table_of_the_claims() -> None:
    """A bar in the text must not open a new cell."""
    lines = markdown(mixed(), source="certificate.json").splitlines()

    assert lines[0] == "## certificate.json: DISPROVED"
    assert "| DISPROVED | pitch | \\|rate\\| > limit" in lines[5]
    assert lines[-1] == "- checked &lt;all>"


def test_numbers_of_a_claim_stand_beside_it() -> None:
    """As properties of its test case, and in a column; other claims have none."""
    checked = mixed()
    rate = Figure("decay rate", "1/s", Fraction("3.389"))
    first, *others = checked.claims
    checked = replace(checked, claims=[replace(first, figures=(rate,)), *others])
    case = ElementTree.fromstring(junit(checked, source="c.json"))[0][0]
    shown = case.find("properties/property")
    assert shown is not None and shown.attrib == {"name": "decay rate [1/s]", "value": "3.38"}
    lines = markdown(checked, source="c.json").splitlines()
    assert lines[4].endswith("| decay rate [1/s] 3.38 |") and lines[5].endswith("|  |")


def test_a_refused_file_is_a_failure_in_each_format() -> None:
    """Continuous integration must show a refusal as red, never as an empty, green report."""
    refused = refusal("line 3: not JSON")

    assert 'failures="1"' in junit(refused, source="c.json")
    assert json.loads(sarif(refused, source="c.json"))["runs"][0]["results"][0]["level"] == "error"
    assert "REFUSED" in markdown(refused, source="c.json")


def test_claims_of_one_name_are_told_apart() -> None:
    """Two sets in one certificate have one name: readers would show the last one alone."""
    claims = [Claim("set", verdict, "") for verdict in (Verdict.PROVED, Verdict.UNDECIDED)]
    checked = concluded([*claims, Claim("set (2)", Verdict.PROVED, "")], [])

    names = ["set", "set (2)", "set (2) (2)"]
    cases = ElementTree.fromstring(junit(checked, source="c"))[0].findall("testcase")
    run = json.loads(sarif(checked, source="c"))["runs"][0]
    assert [case.get("name") for case in cases] == names
    assert [result["partialFingerprints"]["claim/v1"] for result in run["results"]] == ["set (2)"]
    assert "| UNDECIDED | set (2) |" in markdown(checked, source="c")
