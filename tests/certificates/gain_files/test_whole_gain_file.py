"""`check --gains` compares the whole file: every field that an implementer reads, by content."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import TurbineDesign
from takagi.certificates.checker import CertificateError, check, read_text
from takagi.certificates.checker.files.gain_file import compare_gains, expected_file
from takagi.certificates.checker.kernel.refusal import OtherGains
from takagi.certificates.controller.content import (
    bound,
    bound_to_file,
    differences_in_words,
    gain_file_of,
)
from takagi.certificates.document.certificate_file import (
    certificate_document,
    effort_sharing_law_data,
    turbine_data,
)
from takagi.cli.main import main
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.turbine.loader import nrel5mw
from takagi.reports.gains_file.envelope import dump_gains, gain_file
from tests.certificates.kinds.claims import resealed
from tests.plant_files import written

Capture = pytest.CaptureFixture[str]
Change = Callable[[dict[str, Any]], object]


@pytest.fixture(scope="module")
def turbine() -> tuple[dict[str, Any], dict[str, Any]]:
    """A law with gains of no meaning: the certificate without claims, and its file."""
    found = nrel5mw()
    schedule = effort_schedule(found)
    gains = EffortGains([0.5] * len(schedule.wind), [0.2] * (len(schedule.wind) - 1))  # type: ignore[arg-type]
    law = EffortSharingLaw.of(found, schedule, gains)
    document = certificate_document(
        model=turbine_data(found, ()), gains=effort_sharing_law_data(law), claims=[], provenance={}
    )
    own = {
        "name": "NREL 5-MW, effort-sharing law",
        "turbine": "NREL 5-MW",
        "states": list(law.state_names),
        "trim": {"wind": [3.0, 25.0], "rotor_speed": [0.7, 1.2], "pitch": [0.0, 0.4]},
        "observer": {"l1": 2.5, "l2": 40.0, "decay_rate": 0.05, "wind_limits": [1.5, 37.5]},
        "certificate": {"verdict": "PROVED", "claims": [], "overspeed": 0.1},
    }
    bounded = bound(document, own)
    return bounded, gain_file_of(bounded)


def read(path: Path) -> Any:
    return json.loads(path.read_text("utf-8"))


def kept(folder: Path, content: Any, name: str = "gains.json") -> Path:
    return written(folder, content if isinstance(content, str) else json.dumps(content), name)


def told(document: dict[str, Any], content: Any, folder: Path) -> str:
    return compare_gains(read_text(json.dumps(document), "certificate"), kept(folder, content))


TURBINE_CHANGES: dict[str, Change] = {
    "limits.pitch[1]": lambda f: f["limits"]["pitch"].__setitem__(1, 1.4),
    "limits.torque_rate": lambda f: f["limits"].update(torque_rate=2e4),
    "observer.l1": lambda f: f["observer"].update(l1=2.6),
    "observer.wind_limits[0]": lambda f: f["observer"]["wind_limits"].__setitem__(0, 2.0),
    "observer.equations[1]": lambda f: f["observer"]["equations"].__setitem__(1, "vhat' = 0"),
    "trim.pitch[1]": lambda f: f["trim"]["pitch"].__setitem__(1, 0.41),
    "ramp.overlap": lambda f: f["ramp"].update(overlap=0.02),
    "ramp.formula[0]": lambda f: f["ramp"]["formula"].__setitem__(0, "psi(s) = s"),
    "units.law.wind": lambda f: f["units"].update({"law.wind": "km/h"}),
    "execution.integral": lambda f: f["execution"].update(integral="x after = x"),
    "schedule.outside": lambda f: f["schedule"].update(outside="extrapolated"),
    "rotor.inertia": lambda f: f["rotor"].update(inertia=4e7),
    "rotor.torque_coefficient.coefficients[3][4]": lambda f: f["rotor"]["torque_coefficient"][
        "coefficients"
    ][3].__setitem__(4, 0.05),
    "programs[1].steps": lambda f: f["programs"][1]["steps"].pop(),
    "programs[1].send[0].formula": lambda f: f["programs"][1]["send"][0].update(formula="0"),
    "language.limit(x, a, b)": lambda f: f["language"].update({"limit(x, a, b)": "x"}),
    "law.pitch_max": lambda f: f["law"].update(pitch_max=1.4),
    "certificate.overspeed": lambda f: f["certificate"].update(overspeed=0.01),
    "version": lambda f: f.update(version=2),
    "states[0]": lambda f: f["states"].__setitem__(0, "speed integral [rpm]"),
    "remark": lambda f: f.update(remark="start at full torque"),
}


def test_a_design_s_own_gains_are_certified_as_they_are(
    turbine_design: TurbineDesign, tmp_path: Path
) -> None:
    """With its filters of the measured speed; a filter that is none is refused."""
    content, path = gain_file(turbine_design), tmp_path / "gains.json"
    document = {k: v for k, v in turbine_design.document.items() if k != "controller"}
    path.write_text(dump_gains(content), encoding="utf-8")

    assert json.loads(path.read_text("utf-8"))["name"] == "NREL 5-MW, effort-sharing law"
    found = bound_to_file(document, path)
    stop: dict[str, Any] = {"frequency": 9.3, "passed": 0.2}
    own: dict[str, Any] = {"speed_filter": 30.0, "torsion_filter": stop}
    assert dict(found)["controller"]["measurement"] == own
    assert differences_in_words(found, path) == ""
    for bad in ({"speed_filter": 0}, {"speed_filter": "8"}, {"corner": 8}, [8], "8 rad/s"):
        path.write_text(dump_gains(content | {"measurement": bad}), encoding="utf-8")
        with pytest.raises(CertificateError, match="a corner above 0 is needed"):
            bound_to_file(document, path)
    wrong: list[dict[str, Any]] = [
        {"frequency": 0},
        {"passed": 1.1},
        {"passed": True},
        {"depth": 1},
    ]
    for changed in wrong:
        measurement = own | {"torsion_filter": stop | changed}
        path.write_text(dump_gains(content | {"measurement": measurement}), encoding="utf-8")
        with pytest.raises(CertificateError, match="a frequency above 0 in rad/s and a share"):
            bound_to_file(document, path)


@pytest.mark.parametrize("place", TURBINE_CHANGES)
def test_a_changed_field_of_a_turbine_is_named(
    place: str, turbine: tuple[dict[str, Any], dict[str, Any]], tmp_path: Path
) -> None:
    """Whatever is changed, the refusal says which field it was."""
    document, content = turbine[0], copy.deepcopy(turbine[1])
    assert told(document, content, tmp_path) == ""
    TURBINE_CHANGES[place](content)

    with pytest.raises(OtherGains) as refused:
        told(document, content, tmp_path)
    assert f"; {place} is " in str(refused.value) and "in the certificate" in str(refused.value)


PLANT_CHANGES: dict[str, Change] = {
    "states[0].rest": lambda f: f["states"][0].update(rest=1.1),
    "states[0].range[0]": lambda f: f["states"][0]["range"].__setitem__(0, 0.4),
    "states[0].unit": lambda f: f["states"][0].update(unit="ft"),
    "states[0].description": lambda f: f["states"][0].update(description="level, in feet"),
    "inputs[0].range[1]": lambda f: f["inputs"][0]["range"].__setitem__(1, 50),
    "inputs[0].rest": lambda f: f["inputs"][0].update(rest=0),
    "inputs[0].range": lambda f: f["inputs"][0].update(range=None),
    "formulas.command": lambda f: f["formulas"].update(
        command="u = u* + sum over rules i of h_i K_i (x - x*)"
    ),
    "programs[0].send[0].formula": lambda f: f["programs"][0]["send"][0].update(formula="q_rest"),
    "units.K, q per h": lambda f: f["units"].update({"K, q per h": "kg/s"}),
    "law.premises[0].upper": lambda f: f["law"]["premises"][0].update(upper=9),
    "notes": lambda f: f["notes"].append("use twice the gain"),
    "certificate.sha256.claims": lambda f: f["certificate"]["sha256"].update(claims="0" * 64),
    "certificate.verdict": lambda f: f["certificate"].update(verdict="UNDECIDED"),
}


@pytest.mark.parametrize("place", PLANT_CHANGES)
def test_a_changed_field_of_a_plant_has_status_one(
    place: str, tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """`takagi check` refuses the pair with the field's name, and proves the honest one."""
    content = read(tank / "gains.json")
    PLANT_CHANGES[place](content)
    changed = kept(tmp_path, content)
    report = tmp_path / "junit.xml"

    status = main(["check", str(tank / "c.json"), "--gains", str(changed), "--junit", str(report)])

    said = capsys.readouterr().err
    assert status == 1 and f"; {place} is " in said and "Traceback" not in said
    assert place in report.read_text("utf-8")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        # A sign late in a formula: not two equal beginnings.
        (lambda f: f["formulas"].update(
            memberships=f["formulas"]["memberships"].replace("corner 1;", "corner 0;")
        ), r"memberships is \.\.\..*corner 0; a premise.* there, \.\.\..*corner 1; a p"),
        (lambda f: f["inputs"][0].update(rest=str(f["inputs"][0]["rest"])),
         r'inputs\[0\].rest is "([0-9.]+)" there, \1 in'),
    ],
)  # fmt: skip
def test_the_place_where_texts_differ_is_shown(
    change: Change, words: str, tank: Path, tmp_path: Path
) -> None:
    content = read(tank / "gains.json")
    change(content)

    with pytest.raises(OtherGains, match=words):
        check(tank / "c.json", gains=kept(tmp_path, content))


def shuffled(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: shuffled(value[key]) for key in reversed(value)}
    return [shuffled(part) for part in value] if isinstance(value, list) else value


def rewritten(text: str) -> Iterator[tuple[str, str]]:
    content = json.loads(text)
    yield "order of keys", json.dumps(shuffled(content))
    yield "white space", json.dumps(content, indent=7)
    yield "CRLF", text.replace("\n", "\r\n")
    longer = json.loads(text, parse_int=lambda s: float(s), parse_float=lambda s: float(s))
    yield "1.0 for 1", json.dumps(longer)
    yield (
        "1e0 for 1",
        text.replace("null, ", "null ,")
        .replace(": 5.0]", ": 0.5e1]")
        .replace("[0.5, 1.5]", "[5e-1, 15.0E-1]"),
    )


def test_other_bytes_of_the_same_content_change_nothing(tank: Path, tmp_path: Path) -> None:
    """Order of keys, white space, line ends, the form of numbers, the file's name."""
    text = (tank / "gains.json").read_text("utf-8")
    for k, (what, other) in enumerate(rewritten(text)):
        assert other != text, what
        path = tmp_path / f"renamed-{k}.json"
        path.write_bytes(other.encode())
        assert check(tank / "c.json", gains=path).verdict.name == "PROVED", what


def test_a_byte_order_mark_and_another_unit_are_refused(tank: Path, tmp_path: Path) -> None:
    """As docs/cli.md says; of a model's file they change nothing."""
    text = (tank / "gains.json").read_text("utf-8")
    path, model = tmp_path / "g.json", tmp_path / "tank.toml"
    path.write_text(text, encoding="utf-8-sig")
    with pytest.raises(CertificateError, match="not JSON"):
        check(tank / "c.json", gains=path)
    path.write_text(text.replace('"unit": "m"', '"unit": "cm"'), encoding="utf-8")
    with pytest.raises(OtherGains, match=r"unit is cm there, m in the certificate"):
        check(tank / "c.json", gains=path)

    stated = (tank / "tank.toml").read_text("utf-8")
    other = stated.replace('value = 0.1, unit = "1/s"', 'value = 6, unit = "1/min"')
    assert other != stated
    model.write_text(other, encoding="utf-8-sig")
    assert check(tank / "c.json", model=model).verdict.name == "PROVED"


def test_a_member_that_is_not_there_is_told(tank: Path, tmp_path: Path) -> None:
    """Status 1, unless it is allowed; a reader learns what was not compared."""
    content = read(tank / "gains.json")
    for left in ({"law": content["law"]}, {k: v for k, v in content.items() if k != "programs"}):
        path = kept(tmp_path, left)

        with pytest.raises(OtherGains, match="it does not say .*: of these nothing is compared"):
            check(tank / "c.json", gains=path)
        found = check(tank / "c.json", gains=path, allow_old_gain_files=True)

        assert found.verdict.name == "PROVED"
        (told,) = [word for word in found.messages if "it does not say" in word]
        assert told.endswith(": of these nothing is compared")
        named = told.split("it does not say ")[1].split(":")[0].split(", ")
        assert named == sorted(content.keys() - left.keys())


def test_an_older_certificate_says_what_it_does_not_cover(tank: Path, tmp_path: Path) -> None:
    """Without ``controller`` the law alone is compared, and the rest is named."""
    old = read(tank / "c.json")
    del old["controller"], old["provenance"]["sha256"]["controller"]
    path = kept(tmp_path, old)

    with pytest.raises(OtherGains, match="only its law is compared"):
        check(path, gains=tank / "gains.json")
    found = check(path, gains=tank / "gains.json", allow_old_gain_files=True)

    (words,) = [word for word in found.messages if "only its law is compared" in word]
    assert "inputs" in words and "programs" in words and "formulas" in words


def test_a_damaged_controller_is_refused(tank: Path, tmp_path: Path) -> None:
    """Its hash is looked at first; with the hash made again, no file follows from it."""
    document = read(tank / "c.json")
    wrong: list[Any] = [{"states": 5}, [], {"states": [], "inputs": [{}]}, {"removable": 3}]
    for controller in wrong:
        damaged = document | {"controller": controller}
        path = kept(tmp_path, damaged)
        with pytest.raises(CertificateError, match="hash differs"):
            check(path, gains=tank / "gains.json")
        kept(tmp_path, bound(document, controller))
        with pytest.raises(CertificateError) as refused:
            check(path, gains=tank / "gains.json")
        assert "no gain file follows" in str(refused.value) or isinstance(refused.value, OtherGains)


def test_words_that_both_files_have_wrong_are_refused(tank: Path, tmp_path: Path) -> None:
    """The sign in ``command``, a range, a step of the program: the checker knows them itself."""
    document = read(tank / "c.json")
    content = read(tank / "gains.json")
    forged = {
        "formulas": {**content["formulas"], "command": "u = u* + ..."},
        "inputs": [{**content["inputs"][0], "range": [0, 50]}],
        "programs": [{**content["programs"][0], "steps": []}],
        "language": {},
    }
    for key, value in forged.items():
        own = {**document["controller"], key: value}
        certificate = kept(tmp_path, bound(document, own), "c.json")
        with pytest.raises(OtherGains, match=key):
            check(certificate, gains=kept(tmp_path, {**content, key: value}))


def certified(tank: Path, gains: Path, out: Path, *more: str) -> int:
    return main(
        ["certify", str(tank / "tank.toml"), "--gains", str(gains), "--out", str(out), *more]
    )


def test_a_certificate_for_a_given_file_is_bound_to_it(
    tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """The pair is PROVED; what the file says of an older certificate does no harm."""
    out = tmp_path / "c.json"

    given = ("--choice=fewest-rules", "--solve-rest")
    assert certified(tank, tank / "gains.json", out, *given) == 0
    assert "will refuse" not in capsys.readouterr().out
    assert main(["check", str(out), "--gains", str(tank / "gains.json")]) == 0


def test_fields_that_are_not_the_plant_s_are_told_and_written_anew(
    tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """A range of an input that is another: told, refused by check, right in --gains-out."""
    content = read(tank / "gains.json")
    content["inputs"][0]["range"] = [0, 50]
    content["formulas"]["command"] = "u = u* + ..."
    gains, out, new = kept(tmp_path, content), tmp_path / "c.json", tmp_path / "new.json"

    assert certified(tank, gains, out) == 0
    said = capsys.readouterr().out
    assert "inputs[0].range[1] is 50 there, 5.0 for this model" in said
    assert "--gains-out FILE" in said
    assert main(["check", str(out), "--gains", str(gains)]) == 1

    assert certified(tank, gains, out, "--gains-out", str(new)) == 0
    assert main(["check", str(out), "--gains", str(new)]) == 0
    made = json.loads(new.read_text("utf-8"))
    assert made["inputs"][0]["range"] == [0, 5] and made["law"] == content["law"]


def earlier(content: dict[str, Any]) -> dict[str, Any]:
    kept = ("format", "name", "plant", "units", "law", "states", "inputs", "formulas", "notes")
    return {"version": 1, **{key: content[key] for key in kept}}


def test_a_file_of_an_earlier_version_is_certified_and_bound(
    tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Old files are read; a change afterwards is noticed; the check says what it rests on."""
    content = earlier(read(tank / "gains.json"))
    gains, out = kept(tmp_path, content), tmp_path / "c.json"

    assert certified(tank, gains, out) == 0
    asked = ["check", str(out), "--gains", str(gains)]
    assert "will refuse it beside this certificate: of an earlier" in capsys.readouterr().out
    assert main(asked) == 1
    assert "or accept this with --allow-old-gain-files" in capsys.readouterr().err
    assert main([*asked, "--allow-old-gain-files"]) == 0
    assert "certificate's copy of it, not with model and law" in capsys.readouterr().out
    content["notes"].append("changed")
    kept(tmp_path, content)
    assert main([*asked, "--allow-old-gain-files"]) == 1
    assert "notes is " in capsys.readouterr().err


@pytest.mark.parametrize("version", [1, 2, 3])
def test_a_program_cannot_hide_behind_an_earlier_version(
    version: int, tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Contents with ``version`` are compared with themselves alone: that proves no program."""
    document = read(tank / "c.json")
    content = read(tank / "gains.json")
    content["programs"][0]["steps"] = []
    own = {key: value for key, value in content.items() if key not in ("format", "law")}
    document["controller"] = {**own, "version": version}
    gains = kept(tmp_path, {**content, "version": version})
    document = resealed(document, "controller")
    out = kept(tmp_path, document, "c.json")

    assert main(["check", str(out), "--gains", str(gains)]) == 2
    assert "an earlier gain file, 1 or 2, which has no programs" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f["states"][0].update(rest=1.1), "states[0].rest is 1.1 there"),
        (lambda f: f["formulas"].update(command="u = u* + ..."), "formulas.command is"),
    ],
)
def test_an_earlier_file_that_says_something_else_is_not_certified(
    change: Change, words: str, tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    content = earlier(read(tank / "gains.json"))
    change(content)
    gains, out = kept(tmp_path, content), tmp_path / "c.json"

    assert certified(tank, gains, out) == 2
    assert words in capsys.readouterr().err and not out.exists()


def test_gains_out_needs_a_place_of_its_own(tank: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "c.json"

    assert certified(tank, tank / "gains.json", out, "--gains-out", str(out)) == 2
    assert "the same file" in capsys.readouterr().err


def test_a_law_of_another_kind_of_model_has_no_file(tank: Path) -> None:
    """The program follows from the law's name: a plant's claims would stand beside another's."""
    document = read(tank / "c.json")
    document["gains"]["name"] = "coherent"
    with pytest.raises(CertificateError, match="'coherent' is no law of this kind of model"):
        expected_file(read_text(json.dumps(document), "certificate"))
