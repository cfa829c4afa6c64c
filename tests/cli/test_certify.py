"""`takagi certify`: a certificate for gains that exist, or for new ones."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from contextlib import nullcontext
from math import inf, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from takagi.certificates.checker import Verdict, check
from takagi.certificates.design.turbine.settings import LAWS
from takagi.certificates.document.certificate_file import (
    dumps,
)
from takagi.cli.main import main
from takagi.cli.options.plant_options import plant_settings
from takagi.cli.options.turbine_options import IN_FILES, law_in_files, typed_name
from takagi.cli.options.turbine_settings import design_settings
from takagi.models import ModelError
from takagi.models.plant_files.loader import PlantFile
from takagi.models.turbine.loader import nrel5mw
from takagi.reports.gains_file.envelope import dump_gains, gain_file
from tests.certificates.kinds.claims import resealed
from tests.cli.cubic import CUBIC, NOISY_ROD, ROD
from tests.plant_files import written
from tests.turbine_designs import recorded_cells_for_sought, recorded_rows, running_loop
from tests.undrawn import undrawn

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def gains(finished: TurbineDesign, tmp_path: Path) -> Path:
    path = tmp_path / "gains.json"
    path.write_text(json.dumps({"law": finished.document["gains"]}))
    return path


def changed(gains: Path, **entries: Any) -> Path:
    law = {**json.loads(gains.read_text())["law"], **entries}
    gains.write_text(json.dumps({"law": law}))
    return gains


@pytest.mark.slow
def test_a_whole_gain_file_has_the_loop_with_its_observer_proved_again(
    finished: TurbineDesign, tmp_path: Path
) -> None:
    """It states observer and filters: all claims are those of the design, to the last digit.

    The cells of the running loop are stated as recorded, if those of the design are: they are
    proved for the observer and the filters that were read.
    """
    gains, out = tmp_path / "gains.json", tmp_path / "certificate.json"
    gains.write_text(dump_gains(gain_file(finished)), encoding="utf-8")
    claim = running_loop(finished)
    recorded = claim is not None and claim["cells"] == recorded_rows()

    with recorded_cells_for_sought() if recorded else nullcontext():
        assert main(["certify", "nrel5mw", "--gains", str(gains), "--out", str(out)]) == 0

    assert claim is not None
    assert check(out, gains=gains).verdict is Verdict.PROVED
    assert json.loads(out.read_text())["claims"] == finished.document["claims"]


def test_the_inequalities_hold_without_takagi(finished: TurbineDesign, tmp_path: Path) -> None:
    """The program of docs/certificate.md accepts the certificate, and refuses a larger class."""
    page = (Path(__file__).parents[2] / "docs" / "certificate.md").read_text(encoding="utf-8")
    program = page.split("```python\n")[1].split("```")[0]
    assert "import takagi" not in program and "from takagi" not in program
    path = tmp_path / "build" / "nrel5mw" / "certificate.json"
    path.parent.mkdir(parents=True)
    document = json.loads(dumps(finished.document))

    def status() -> int:
        path.write_text(json.dumps(document))
        command = [sys.executable, "-I", "-S", "-c", program]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode

    assert status() == 0
    document["claims"][0]["cells"][30]["wind_error"] *= 1.2
    assert status() == 1


def test_without_gains_they_are_designed_anew(asked: Any, tmp_path: Path, capsys: Capture) -> None:
    """One file, and the same verdict in JSON."""
    out = tmp_path / "certificate.json"

    assert main(["certify", "nrel5mw", "--out", str(out), "--json"]) == 0

    assert json.loads(capsys.readouterr().out)["verdict"] == "PROVED"
    assert [path.name for path in tmp_path.iterdir()] == ["certificate.json"]


@pytest.mark.slow
def test_a_loop_without_a_proof_names_the_winds(
    gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Inertia 0.2 to 3 of nominal: which condition, where, and what to relax; status 1."""
    out = tmp_path / "certificate.json"
    options = ["--gains", str(gains), "--out", str(out), "--inertia", "0.2", "3"]

    assert main(["certify", "nrel5mw", *options]) == 1

    told = capsys.readouterr().err
    assert "no common quadratic function" in told and "at wind 11." in told
    assert "--inertia 0.2 3; relax that first" in told
    assert not out.exists()


@pytest.mark.parametrize(
    ("entries", "told"),
    [
        ({"name": "paper"}, "a gain file is certified for the effort-sharing law ('coherent')"),
        ({"proportional": [0.1]}, "proportional: a row of 71 numbers is needed"),
        ({"overlap": "wide"}, "overlap: a number is needed"),
        ({"overlap": -0.01}, "must be positive"),
        ({"integral_rate": [-0.1] * 70}, "must be a row of positive numbers"),
    ],
)
def test_a_damaged_gain_file_is_misuse(
    gains: Path, tmp_path: Path, capsys: Capture, entries: dict[str, Any], told: str
) -> None:
    out = tmp_path / "certificate.json"
    asked_for = ["--gains", str(changed(gains, **entries)), "--out", str(out)]

    assert main(["certify", "nrel5mw", *asked_for]) == 2
    assert told in capsys.readouterr().err and not out.exists()


def test_a_gain_file_is_read_before_the_plant_s_model_is_made(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> None:
        pytest.fail("the work has begun")

    monkeypatch.setattr("takagi.cli.runs.plant.PlantMaker.certify", never)
    asked_for = ["--gains", str(tmp_path / "no"), "--out", str(tmp_path / "c.json")]

    assert main(["certify", "dc_servo", *asked_for]) == 2
    assert "cannot be read" in capsys.readouterr().err


def test_a_folder_in_the_place_of_the_certificate_is_misuse(
    tmp_path: Path, capsys: Capture
) -> None:
    assert main(["certify", "nrel5mw", "--out", str(tmp_path)]) == 2
    assert "this is a folder" in capsys.readouterr().err


def cubic_gains(path: Path, gain: float) -> Path:
    premise = {"name": "z1", "expression": "x^2", "lower": 0, "upper": 1, "unit": "-"}
    law = {
        "name": "pdc",
        "sample_time": None,
        "state_names": ["x [-]"],
        "input_names": ["u [-]"],
        "premises": [premise],
        "rules": [[0], [1]],
        "K": [[[gain]], [[gain]]],
        "trim": {"state": [0.0], "input": [0.0]},
    }
    path.write_text(json.dumps({"law": law}))
    return path


def certified(cubic: Path, gain: float, out: str, *options: str) -> int:
    gains = cubic_gains(cubic.with_name("gains.json"), gain)
    place = str(cubic.with_name(out))
    return main(["certify", str(cubic), "--gains", str(gains), "--out", place, *options])


def test_gains_from_both_sides_of_the_tolerance(cubic: Path, capsys: Capture) -> None:
    """Decay K - 2: from 4 to 3.9 it falls by 5 % of 2, to 3.8 by 10 %; and by 10 % it may."""
    old = str(cubic.with_name("old.json"))
    assert certified(cubic, 4, "old.json") == 0
    capsys.readouterr()

    assert certified(cubic, 3.95, "a.json", "--baseline", old) == 0
    assert "nothing got worse by more than 5 %" in capsys.readouterr().out
    assert certified(cubic, 3.8, "b.json", "--baseline", old) == 1
    told = capsys.readouterr().out
    words = " ".join(told.split())
    assert "WORSE slower common quadratic decay of cubic decay rate [1/s] fell from " in words
    assert "gains: K of rule 1, u [-] by x [-]: 4.0 -> 3.8" in told
    assert certified(cubic, 3.8, "c.json", "--baseline", old, "--tolerance", "15%") == 0


def test_json_has_every_figure(cubic: Path, capsys: Capture) -> None:
    old = str(cubic.with_name("old.json"))
    certified(cubic, 4, "old.json")
    capsys.readouterr()

    assert certified(cubic, 3, "new.json", "--baseline", old, "--json") == 1

    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "PROVED"
    assert (found["baseline"]["certificate"], found["baseline"]["passes"]) == (old, False)
    worse = [f["figure"] for f in found["baseline"]["figures"] if f["worse"]]
    assert "decay rate" in worse and "limit of input 1" not in worse
    assert found["baseline"]["changed"][0]["place"] == "K of rule 1, u [-] by x [-]"


def test_a_changed_parameter_is_named(cubic: Path, capsys: Capture) -> None:
    old = str(cubic.with_name("old.json"))
    certified(cubic, 4, "old.json")
    cubic.write_text(CUBIC.replace("x + x^3", "1.5*x + x^3").replace("[-1, 1]", "[-0.8, 0.8]"))
    capsys.readouterr()

    gains = cubic.with_name("gains.json")
    law = json.loads(gains.read_text())["law"]
    law["premises"][0]["upper"] = 0.64
    gains.write_text(json.dumps({"law": law}))
    out = str(cubic.with_name("new.json"))
    options = ["--gains", str(gains), "--out", out, "--baseline", old]

    assert main(["certify", str(cubic), *options]) == 1

    told = capsys.readouterr().out
    assert "WORSE narrower box box of validity" in " ".join(told.split())
    assert "model: equation of x: u + x^3 + x -> u + x^3 + 3*x/2" in told


def test_the_baseline_is_read_before_the_work_and_never_overwritten(
    cubic: Path, capsys: Capture
) -> None:
    old = cubic.with_name("old.json")
    assert certified(cubic, 4, "old.json") == 0
    before = old.read_bytes()

    assert certified(cubic, 4, "old.json", "--baseline", str(old)) == 2
    assert old.read_bytes() == before
    assert "--out is the --baseline" in capsys.readouterr().err

    old.write_text(old.read_text().replace('"decay_rate":1', '"decay_rate":2', 1))
    assert certified(cubic, 4, "new.json", "--baseline", str(old)) == 2
    assert "claims changed after" in capsys.readouterr().err
    assert not cubic.with_name("new.json").exists()


def test_compare_two_certificates(cubic: Path, tmp_path: Path, capsys: Capture) -> None:
    old, new = (str(cubic.with_name(name)) for name in ("old.json", "new.json"))
    certified(cubic, 4, "old.json")
    certified(cubic, 3, "new.json")
    capsys.readouterr()
    summary = tmp_path / "summary.md"

    assert main(["compare", new, new]) == 0
    assert main(["compare", old, new, "--summary", str(summary)]) == 1
    assert main(["compare", old, new, "--tolerance", "100%"]) == 0
    page = tmp_path / "page.html"
    assert main(["compare", old, new, old, "--html", str(page), "--summary", str(summary)]) == 1
    assert page.read_text().count("badge PROVED") == 3
    assert page.read_text().count("<strong>worse") == page.read_text().count("<strong>not") == 1

    assert (
        "| WORSE | slower | common quadratic decay of cubic | decay rate [1/s] |"
        in summary.read_text()
    )


@pytest.mark.slow
def test_a_turbine_is_compared_wind_by_wind(
    finished: TurbineDesign, tmp_path: Path, capsys: Capture
) -> None:
    """Its own certificate is no worse; one cell's class cut by a tenth is, at that wind."""
    document = json.loads(dumps(finished.document))
    old, new = tmp_path / "old.json", tmp_path / "new.json"
    old.write_text(json.dumps(document))
    assert main(["compare", str(old), str(old), "--tolerance", "0"]) == 0

    cell = document["claims"][0]["cells"][30]
    cell["wind_error"] = round(0.9 * cell["wind_error"], 6)
    new.write_text(json.dumps(resealed(document)))

    assert main(["compare", str(old), str(new)]) == 1
    low, high = cell["wind"]
    assert f"wind error [m/s], {low:g} to {high:g} m/s" in capsys.readouterr().out


def claimed(out: Path, kind: str) -> list[dict[str, Any]]:
    claims = json.loads(out.read_text(encoding="utf-8"))["claims"]
    return [claim for claim in claims if claim["kind"] == kind]


def test_noise_by_option_and_by_file(tmp_path: Path, capsys: Capture) -> None:
    """20 cm/s sqrt(s) is 0.2 m/s sqrt(s); flow counts with its whole range; both checkers agree."""
    noisy_rod, out = written(tmp_path, NOISY_ROD), tmp_path / "c.json"
    asked = ["--noise", "gust=20", "--horizon", "1min"]

    assert main(["certify", str(noisy_rod), "--out", str(out), *asked]) == 0
    (claim,) = claimed(out, "exit-probability")
    assert claim["noise"] == [0.2, 0.0] and claim["disturbance_bounds"] == [0.0, 0.05]
    assert claim["horizon"] == 60 and claim["probability"] < 0.1
    assert "reaches 1 within 60 s is at most" in capsys.readouterr().out
    assert main(["check", str(out), "--model", str(noisy_rod), "--cross"]) == 0
    assert "they agree" in capsys.readouterr().out

    wanted = "\n[design]\nnoise = { gust = 20 }\nhorizon = 60\n"
    noisy_rod.write_text(NOISY_ROD + wanted, encoding="utf-8")
    build = tmp_path / "build"
    with undrawn():
        assert main(["design", str(noisy_rod), "--out", str(build)]) == 0
    assert claimed(build / "certificate.json", "exit-probability")[0]["noise"] == [0.2, 0.0]


def test_noise_that_is_too_much(tmp_path: Path, capsys: Capture) -> None:
    noisy_rod, out = written(tmp_path, NOISY_ROD), tmp_path / "c.json"

    asked = ["--noise", "gust=5m/s", "--horizon", "600"]
    assert main(["certify", str(noisy_rod), "--out", str(out), *asked]) == 1

    assert "UNDECIDED" in capsys.readouterr().out
    assert [c.verdict.name for c in check(out).claims][-1] != "DISPROVED"
    (claim,) = claimed(out, "exit-probability")
    assert "disturbance_bounds" not in claim


def test_a_sample_time_that_is_proved(tmp_path: Path, capsys: Capture) -> None:
    """By the option, in ms; and by the file, of gains that are designed and then given."""
    rod, out = written(tmp_path, ROD), tmp_path / "c.json"

    assert main(["certify", str(rod), "--out", str(out), "--sample-time", "10ms"]) == 0
    assert [claim["sample_time"] for claim in claimed(out, "sampled-loop")] == [0.01]
    assert "with a sample every 0.01 s" in capsys.readouterr().out
    assert main(["check", str(out), "--cross"]) == 0
    assert "they agree" in capsys.readouterr().out

    rod.write_text(ROD + "\n[design]\nsample_time = 0.02\n", encoding="utf-8")
    build = tmp_path / "build"
    with undrawn():
        assert main(["design", str(rod), "--out", str(build)]) == 0
    assert [
        claim["sample_time"] for claim in claimed(build / "certificate.json", "sampled-loop")
    ] == [0.02]
    gains = ["--gains", str(build / "gains.json")]
    assert main(["certify", str(rod), *gains, "--out", str(out), "--sample-time", "0.03"]) == 0
    assert [claim["sample_time"] for claim in claimed(out, "sampled-loop")] == [0.03]


def test_a_sample_time_that_is_too_large(tmp_path: Path, capsys: Capture) -> None:
    """UNDECIDED, status 1, with the largest time that was found, which is proved."""
    rod, out = written(tmp_path, ROD), tmp_path / "c.json"

    assert main(["certify", str(rod), "--out", str(out), "--sample-time", "20s"]) == 1

    told = capsys.readouterr().out
    asked, largest = claimed(out, "sampled-loop")
    assert asked["sample_time"] == 20 and 0.05 < largest["sample_time"] < 20
    assert "the largest time found" in told
    verdicts = {claim.name: claim.verdict.name for claim in check(out).claims}
    assert verdicts[asked["name"]] == "UNDECIDED" and verdicts[largest["name"]] == "PROVED"


TURBINE = nrel5mw()
DEFAULTS: dict[str, Any] = {
    "torque_setpoint": None,
    "effectiveness_share": 1.0,
    "wind_filter": 12.0,
}
DEFAULTS |= {"ramp_shape": "smooth", "ramp_placement": 0.0, "speed_filter": 30.0}


@pytest.mark.parametrize(
    ("options", "fields"),
    [
        ({}, {"torsion_filter": 9.3}),  # 0.9 of the turbine's torsion mode
        ({"torque_setpoint": "80%"}, {"torque_setpoint": pytest.approx(0.8 * 43093.55)}),
        ({"torque_setpoint": "40 kNm", "law": "paper"}, {"torque_setpoint": 40e3}),
        ({"pitch_effectiveness_share": 0.8}, {"effectiveness_share": 0.8}),
        ({"law": "paper", "ramp_shape": "linear"}, {"ramp_shape": "linear"}),
        ({"law": "paper", "ramp_placement": 0.25}, {"ramp_placement": 0.25}),
        ({"wind_filter": 0.3}, {"wind_filter": 0.3}),
        # 0 leaves the low-pass out; without the band-stop it is slower.
        ({"speed_filter": 0.0}, {"speed_filter": 0.0, "torsion_filter": 0.0}),
        ({"speed_filter": 0.5}, {"speed_filter": 0.5}),
        ({"speed_filter": 4.0, "law": "paper"}, {"speed_filter": 4.0}),
        ({"torsion_filter": 0.0}, {"speed_filter": 8.0, "torsion_filter": 0.0}),
        ({"torsion_filter": 12.0, "speed_filter": 20.0}, {"speed_filter": 20.0}),
        # Too little at full speed, and enough at 11 rpm.
        ({"torque_setpoint": "70%", "speed_setpoint": "11rpm"},
         {"torque_setpoint": pytest.approx(0.7 * 43093.55)}),
    ],
)  # fmt: skip
def test_each_option_sets_its_field(options: dict[str, Any], fields: dict[str, Any]) -> None:
    """Of both laws; what is not given keeps its default."""
    found = design_settings(TURBINE, **options)
    expected = DEFAULTS | fields
    assert {name: getattr(found, name) for name in expected} == expected


@pytest.mark.parametrize(
    ("options", "words"),
    [
        *(({"speed_filter": f}, "-filter: .* at least 0.5") for f in (-1.0, 0.49, inf, nan)),
        *(({"torsion_filter": f}, "-filter: .* at least 2") for f in (-1.0, 1.9, inf, nan)),
        *(({"wind_filter": f}, "-filter: .* positive") for f in (0.0, -1.0, inf, nan)),
        ({"torsion_filter": 9.0, "speed_filter": 0.0}, "needs a low-pass behind it"),
        ({"law": "paper", "wind_filter": 1.0}, "--wind-filter belongs to the effort-sharing law"),
        ({"torque_setpoint": "70%"}, r"--torque-setpoint 70%: .*lower the speed set-point"),
        ({"torque_setpoint": "80"}, "a number with its unit"),
        ({"torque_setpoint": "80 rpm"}, "--torque-setpoint 80 rpm: unit 'rpm'"),
        ({"lowest_torque_setpoint": "60%"}, "--lowest-torque-setpoint 60%: .*raise the torque"),
        ({"lowest_speed_setpoint": "10"}, "--lowest-speed-setpoint 10: .*unit"),
        ({"lowest_speed_setpoint": "9rpm"}, "25 m/s"),
        ({"law": "paper", "lowest_speed_setpoint": "10rpm"}, "effort-sharing"),
        ({"torque_setpoint": "120%"}, "at or below the rated torque"),
        ({"torque_setpoint": "-5%"}, "above 0"),
        ({"pitch_effectiveness_share": 0.0}, "--pitch-effectiveness-share: 0 was given"),
        ({"pitch_effectiveness_share": float("nan")}, "--pitch-effectiveness-share: nan"),
        ({"wind_filter": 101.0}, "--wind-filter: 101 was given; .* at most 100 s"),
        ({"ramp_shape": "linear"}, "--ramp-shape belongs to Schulte's law"),
        ({"law": "switched"}, "not continuous: the pitch reference jumps"),
        ({"law": "paper", "ramp_shape": "cubic"}, "smooth or linear"),
        ({"law": "paper", "ramp_placement": 1.5}, "--ramp-placement: 1.5"),
        ({"law": "paper", "pitch_effectiveness_share": 0.6}, "belongs to the effort-sharing law"),
    ],
)
def test_nonsense_is_refused_by_name(options: dict[str, Any], words: str) -> None:
    """The option, what was given, and what is needed."""
    with pytest.raises(ModelError, match=words):
        design_settings(TURBINE, **options)


def test_names_of_laws_are_those_of_files_or_those_to_type() -> None:
    assert set(IN_FILES.values()) == set(LAWS)
    assert [typed_name(law_in_files(name)) for name in IN_FILES] == list(IN_FILES)
    assert law_in_files([*LAWS, "baseline"]) == [*LAWS, "baseline"]
    assert law_in_files(["published", "baseline", "coherent"]) == ["paper", "baseline", "coherent"]
    assert law_in_files(None) is None


@pytest.mark.parametrize("name", ["schulte", "published", "paper"])
def test_an_option_of_another_law_is_refused_by_either_name(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["design", "nrel5mw", "--law", name, "--overlap", "0.1", "--out", "never-written"]

    assert main(asked) == 2
    assert (
        "--overlap belongs to the effort-sharing law, but --law schulte" in capsys.readouterr().err
    )


SPRING = PlantFile.of("mass_spring_damper")


@pytest.mark.parametrize("written", ["2s", "2", "2000 ms"])
def test_a_settling_time_is_the_rate_that_leaves_two_percent(written: str) -> None:
    rate = plant_settings(SPRING, {"settle": written}).decay_rate

    assert isinstance(rate, float) and math.isclose(math.exp(-2 * rate), 0.02)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"settle": "0s"}, "a time above 0"),
        ({"settle": "2kg"}, "option --settle 2kg: 'kg' is no unit of time"),
        ({"settle": "soon"}, "a time such as"),
        ({"settle": "2s", "decay_rate": "1"}, "leave one out"),
    ],
)
def test_no_time_is_refused(given: dict[str, str], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        plant_settings(SPRING, given)
