"""Claims of kind ``effort-blend``: designs with it, and its file."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from takagi.certificates import CertificateError, Verdict, load_certificate
from takagi.certificates.checker import check, check_document, read_text
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.models.arrays import Floats
from takagi.models.blending.blending import RunTimeBlending, blending_of
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_files.loader import PlantFile
from takagi.models.plant_simulation.runs import COMPLETE, ExperimentRun, run
from takagi.reports.gains_file.envelope import plant_gain_file
from takagi.reports.loops.plant_loop import PlantLoop, plant_loop
from takagi.reports.loops.plant_motion import Outside, experiment_of
from tests.certificates.kinds.claims import Data, resealed, verdicts
from tests.models.blending.plants import ROOM, plant_of

GAIN = [[4.0, 6.0]]
# The claims about model and blend alone.
BLEND = "effort-blend"
ABOUT = ("sector-embedding", BLEND)


@cache
def design() -> PlantDesign:
    with TemporaryDirectory() as folder:
        plant = plant_of(Path(folder))
    return certify_plant(plant, lambda model: np.array([GAIN] * len(model.A)), PlantSettings())


def changed(change: Callable[[Data], None]) -> Data:
    found = copy.deepcopy(dict(design().document))
    found["claims"] = [c for c in found["claims"] if c["kind"] in ABOUT]
    change(found)
    return resealed(found)


def test_the_blend_is_proved() -> None:
    document = changed(lambda _: None)

    assert design().verdict is Verdict.PROVED
    assert verdicts(document) == ["PROVED", "PROVED"]
    text = check_document(document).claims[1].text
    assert "heating has a share between 0.0416666 and 0.958334 of its motion" in text
    assert "heating keeps [0, 3] and moves the plant 0.8 to 1.2 times as much as told" in text
    assert "cooling keeps [0, 1.5] and moves the plant 0.9 to 1.1 times" in text


def test_the_error_that_is_covered_is_rounded_inward() -> None:
    """6/7 is 0.857142..., and 8/7 is 1.142857...: nothing is said of an error beyond them."""

    def sevenths(document: Data) -> None:
        for signal in document["model"]["disturbances"]:
            if signal["name"] != "share" and signal["range"] is not None:
                signal["range"] = ["-1/7", "1/7"]

    text = check_document(changed(sevenths)).claims[1].text

    assert "moves the plant 0.857143 to 1.14285 times as much as told" in text


@cache
def draughty() -> PlantDesign:
    """The room with heating that is as effective as the air outside allows, which is measured."""
    changes = {
        "a": "[inputs] -> [scheduling]\nair = { range = [1.8, 2.2], rest = 2 }\n\n[inputs]",
        "b": "(2 + x)*heating -> (air + x)*heating",
        "c": 'effectiveness = "2 + x", error = 0.2 -> effectiveness = "air + x"',
        "d": "effort = { range = [-3, 3] -> effort = { range = [-2, 2]",
    }
    with TemporaryDirectory() as folder:
        plant = plant_of(Path(folder), **changes)
    return certify_plant(plant, lambda model: np.array([GAIN] * len(model.A)), PlantSettings())


def test_the_law_knows_what_it_divides_by() -> None:
    """heating = psi(U)/(air + x): an unknown air could not be commanded by."""
    document = copy.deepcopy(dict(draughty().document))
    document["claims"] = [c for c in document["claims"] if c["kind"] in (*ABOUT, "decay")]
    document = resealed(document)
    assert verdicts(document) == ["PROVED"] * 3

    air = next(s for s in document["model"]["disturbances"] if s["name"] == "air")
    air["unknown"] = True
    document = resealed(document)

    assert verdicts(document) == ["PROVED", "UNDECIDED", "UNDECIDED"]
    assert "by what it does not know" in check_document(document).claims[1].text


def test_a_program_reads_what_it_divides_by() -> None:
    """No premise depends on the air, and the command of heating does."""
    program = plant_gain_file(draughty())["programs"][0]

    assert [one["name"] for one in program["read"]] == ["x", "air"]
    assert "/(air + x)" in program["send"][-1]["formula"]


def test_gains_may_go_with_what_is_known() -> None:
    """Regional gains by the share: the same in all rules that differ in errors alone."""

    def by_share(document: Data) -> None:
        names = [p["name"] for p in document["model"]["embedding"]["premises"]]
        assert names == ["high_share", "cooling_off", "heating_off"]
        document["gains"]["K"] = [[[4.0 + (k >= 4), 6.0]] for k in range(8)]

    document = changed(by_share)

    assert verdicts(document)[-1] == "PROVED"


@cache
def of_two_rules() -> PlantDesign:
    """Actuators without errors cancel all but x in x' = a x^2 + U: two rules."""
    changes = {
        "low": '"2", error = 0.1 -> "2"',
        "high": '"2 + x", error = 0.2 -> "2 + x"',
        "equation": "a*x - -> a*x^2 -",
    }
    with TemporaryDirectory() as folder:
        plant = plant_of(Path(folder), **changes)
    return certify_plant(plant, lambda model: np.array([GAIN] * len(model.A)), PlantSettings())


@pytest.mark.parametrize(("premise", "verdict"), [("x", "PROVED"), ("effort/3", "UNDECIDED")])
def test_two_gains_go_by_the_weights_of_the_model(premise: str, verdict: str) -> None:
    """Two rules, and two gains."""
    document = copy.deepcopy(dict(of_two_rules().document))
    document["claims"] = [c for c in document["claims"] if c["kind"] in ABOUT]
    law = document["gains"]
    (own,) = law["premises"]
    assert own["expression"] == "x" and law["rules"] == [[0], [1]]
    # Not in place: in memory model and law share their premises.
    law["premises"] = [{**own, "expression": premise}]
    law["K"] = [[[4.0, 6.0]], [[5.0, 6.0]]]
    document = resealed(document)

    assert verdicts(document) == ["PROVED", verdict]


def test_a_plant_behind_a_blend_needs_the_claim_beside_its_file(tmp_path: Path) -> None:
    """Without it nothing says that the file's two actuators make the certificate's equations."""
    plant = plant_of(tmp_path)
    model = tmp_path / "room.toml"
    gains = np.array(GAIN)
    found = certify_plant(plant, gains, PlantSettings(), files=PlantFile.of(model).files)
    path = tmp_path / "certificate.json"
    found.certificate.save(path)
    assert check(path, model=model).verdict is Verdict.PROVED
    assert load_certificate(path).verdict is Verdict.PROVED

    document = copy.deepcopy(dict(found.document))
    document["claims"] = [c for c in document["claims"] if c["kind"] != "effort-blend"]
    path.write_text(dumps(resealed(document)), encoding="utf-8")
    with pytest.raises(CertificateError, match="no claim 'effort-blend'"):
        check(path, model=model)


OTHER_FILES = (
    "overlap = 0.5 -> overlap = 0.51",
    "rate = 20 -> rate = 21",
    "range = [-3, 3], overlap -> range = [-2.9, 3], overlap",
    '"2 + x", error -> "2 + x^3", error',
    "error = 0.1 -> error = 0.05",
    "heating = { range = [0, 3] } -> heating = { range = [0, 4] }",
    "heating = { range = [0, 3] } -> heating = {}",
    "heating = { range = [0, 3] } -> heating = { range = [0, 3], rest = 0.1 }",
    "+ (2 + x)*heating -> + (2 + 2*x)*heating",
    "a = { value = 0.5 } -> a = { value = 0.6 }",
)


@pytest.mark.parametrize("change", OTHER_FILES)
def test_another_file_is_told_apart(change: str, tmp_path: Path) -> None:
    """By the numbers and equations of the file, not by its hash."""
    model = read_text(json.dumps(design().document["model"]), "model")
    plant_of(tmp_path, a="direction = -1, -> direction = -1.0,")
    assert compare_plant(model, tmp_path / "room.toml") == ""
    old, new = change.split(" -> ")
    (tmp_path / "room.toml").write_text(ROOM.replace(old, new, 1), encoding="utf-8")
    words = (
        "the rest of heating is 0.1 there" if "rest" in change else "not the certificate's plant"
    )
    with pytest.raises(CertificateError, match=words):
        compare_plant(model, tmp_path / "room.toml")


STRANGE = (
    "error = 0.1 -> error = 'a lot'",
    "rate = 20 -> rate = 'fast'",
    "overlap = 0.5 -> overlap = [1]",
    "direction = -1 -> direction = 'down'",
    "direction = -1 -> direction = -1.5",
    "direction = -1 -> direction = nan",
    "direction = -1 -> direction = [-1.5]",
    "direction = -1 -> direction = 2026-01-01",
    "heating = { range = [0, 3] } -> heating = 3",
    "heating = { range = [0, 3] } -> heating = { range = 3 }",
    'input = "cooling" -> input = 3',
    '"2 + x", error -> 2, error',
    "effort = { range = [-3, 3], overlap = 0.5, rate = 20 } -> effort = 3",
    "[blending] -> [other]",
)


@pytest.mark.parametrize("change", STRANGE)
def test_a_strange_file_is_refused_without_a_traceback(change: str, tmp_path: Path) -> None:
    """Files that `takagi design` would not read, given to the checker."""
    model = read_text(json.dumps(design().document["model"]), "model")
    old, new = change.split(" -> ")
    path = tmp_path / "room.toml"
    path.write_text(ROOM.replace(old, new, 1), encoding="utf-8")

    with pytest.raises(CertificateError):
        compare_plant(model, path)


GAINS = [[40.0, 20.0]]


def certified(folder: Path, error: str) -> PlantDesign:
    plant = plant_of(
        folder,
        a="a = { value = 0.5 } -> a = { value = 1 }",
        b=", error = 0.1 -> ",
        c="error = 0.2 -> error = " + error,
        d=", rate = 20 -> ",
    )
    return certify_plant(plant, lambda m: np.array([GAINS] * len(m.A)), PlantSettings())


def with_error(loop: PlantLoop, error: float, start: Floats, duration: float) -> ExperimentRun:
    """Return a motion whose heating moves the plant 1 + error times as much as told."""
    blending = blending_of(loop.plant)
    assert blending is not None
    rate = RunTimeBlending(blending, {"heating": error}).disturbed_rate((), told=False)
    return run(replace(experiment_of(loop, Outside()), rate=rate), start, duration)


def test_up_to_the_threshold_decay_is_proved(tmp_path: Path) -> None:
    """45 % of 50 %: the motions with either error come to rest too."""
    design = certified(tmp_path, "0.45")
    loop = plant_loop(design)

    assert design.verdict is Verdict.PROVED
    for error in (-0.45, 0.0, 0.45):
        motion = with_error(loop, error, np.array([-0.05, 0.3]), 40.0)
        assert motion.ended == COMPLETE
        assert abs(motion.state[-1]).max() < 1e-3


def test_beyond_it_decay_is_refuted_and_a_motion_leaves(tmp_path: Path) -> None:
    """55 %: at -55 %, heated alone, the loop has a root at +0.1; from far enough it drifts away.

    Nearer to rest cooling, which does as it is told, still has its share.
    """
    design = certified(tmp_path, "0.55")
    loop = plant_loop(design)

    kinds = [claim["kind"] for claim in design.document["claims"]]
    assert kinds == ["sector-embedding", "effort-blend", "no-common-decay"]
    assert design.verdict is Verdict.DISPROVED
    start = np.array([-0.9, 1.79])
    motion = with_error(loop, -0.55, start, 60.0)
    assert abs(motion.state[-1, 0]) > 1.0  # outside the box
    sure = with_error(loop, 0.0, start, 60.0)
    assert abs(sure.state[-1, 0]) < 1e-3


def test_a_file_with_an_error_that_the_certificate_leaves_out_is_told_apart(tmp_path: Path) -> None:
    """Heating as told in the certificate, a fifth off in the file."""
    exact = plant_of(tmp_path, error='"2 + x", error = 0.2 -> "2 + x"')
    told = certify_plant(exact, lambda model: np.array([GAIN] * len(model.A)), PlantSettings())
    model = read_text(json.dumps(told.document["model"]), "model")
    path = tmp_path / "room.toml"
    assert compare_plant(model, path) == ""

    path.write_text(ROOM, encoding="utf-8")

    with pytest.raises(CertificateError, match=r"blending\.high\.error is 0\.2 there"):
        compare_plant(model, path)
