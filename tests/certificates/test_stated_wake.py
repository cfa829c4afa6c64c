"""A frozen wake that is stated as a factor: the checker works it out again from the table."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.arithmetic.spline import Spline
from takagi.certificates.checker.files.turbine_file import compare_turbine, scaled_slopes
from takagi.certificates.checker.kernel.reader import matrix, member, numbers
from takagi.certificates.claims.turbine.effort_sharing import (
    DEFAULT_UNCERTAINTY,
    effort_sharing_claim,
)
from takagi.certificates.design.given.turbine_law import certify_law
from takagi.certificates.document.certificate_file import turbine_data
from takagi.models import ModelError
from takagi.models.files.library import data_folder
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.turbine.data import rotor_torque_gradient
from takagi.models.turbine.loader import load_turbine, model_files
from takagi.models.turbine.trim import trim
from tests.certificates.kinds.claims import resealed

FILE = model_files("iea15mw")[0]


@lru_cache
def written(file: Path = FILE) -> str:
    turbine = load_turbine(file)
    schedule = effort_schedule(turbine, overlap=0.0066)
    gains = {
        "rated_torque": turbine.rated_torque,
        "wind": schedule.wind.tolist(),
        "effectiveness_limit": schedule.effectiveness_limit.tolist(),
    }
    model = turbine_data(turbine, model_files(file))
    return json.dumps({"model": model, "gains": gains})


def document() -> Any:
    return read_text(written(), "document")


def edited(folder: Path, old: str, new: str) -> Path:
    for file in model_files("iea15mw"):
        (folder / file.name).write_bytes(file.read_bytes())
    path = folder / FILE.name
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def test_the_limit_is_found_again() -> None:
    """At every wind node, from kappa and the exact slope at the exact trim."""
    read = document()

    compare_turbine(read["model"], read["gains"], FILE)


@pytest.mark.parametrize(
    "node", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in (20, 45)), -1]
)
def test_a_forged_limit_is_refused(node: int) -> None:
    """Three units in the last decimal, at low wind, near rated and at cut-out."""
    read = json.loads(written())
    read["gains"]["effectiveness_limit"][node] -= 3e-6
    forged = read_text(json.dumps(read), "document")

    with pytest.raises(CertificateError, match="frozen wake's pitch effectiveness at"):
        compare_turbine(forged["model"], forged["gains"], FILE)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[2.12, 1.73", "[2.13, 1.73", "frozen wake's pitch effectiveness at 3 m/s"),
        ("1.19, 1.16]", "1.19, 1.17]", "frozen wake's pitch effectiveness at 20"),
        ("[2.12, 1.73", "[1.73", "columns of different length"),
        ("[11.0, 11.5", "[10.0, 11.5", "at 10 m/s: no pitch gives rated torque"),
        ("[11.0, 11.5", "[0.0, 11.5", "frozen_wake.factor at 0 m/s"),
        (
            "factor = {",
            'power_sensitivity = { unit = "MW/rad", values = [-1.0] }\nfactor = {',
            "a factor beside published columns",
        ),
    ],
)
def test_another_statement_is_another_wake(old: str, new: str, words: str, tmp_path: Path) -> None:
    """The certificate is not that file's, and the message says where."""
    read = document()

    with pytest.raises(CertificateError, match=words):
        compare_turbine(read["model"], read["gains"], edited(tmp_path, old, new))


@pytest.mark.parametrize("without", [pytest.param("", marks=pytest.mark.slow), "[wake]"])
def test_a_wake_that_nobody_states_is_computed_again(without: str, tmp_path: Path) -> None:
    """By momentum theory, with the file's induction and the default; a forged limit is refused."""
    path = edited(tmp_path, "cut_out = { value = 25.0", "cut_out = { value = 13.2")
    text = path.read_text(encoding="utf-8")
    for section in ("[frozen_wake]", without):
        if section:
            head, _, rest = text.partition(f"{section}\n")
            text = head + rest[rest.index("\n[") + 1 :]
    path.write_text(text, encoding="utf-8")
    read = json.loads(written(path))
    honest = read_text(json.dumps(read), "document")
    read["gains"]["effectiveness_limit"][-3] -= 3e-6
    forged = read_text(json.dumps(read), "document")

    assert compare_turbine(honest["model"], honest["gains"], path) == ""
    with pytest.raises(CertificateError, match="frozen wake's pitch effectiveness at"):
        compare_turbine(forged["model"], forged["gains"], path)


def test_slopes_meet_the_loaders() -> None:
    """Two root searches that share no code: 1e-9 of each other, at winds of no table."""
    read, turbine = document(), load_turbine("iea15mw")
    surface = member(read["model"], "torque_surface", "model")
    spline = Spline(
        numbers(surface, "tip_speed_ratio_knots", "s"),
        numbers(surface, "pitch_knots", "s"),
        matrix(surface, "coefficients", "s"),
    )
    winds = [Fraction("10.7"), Fraction("13.3"), Fraction("24.9")]
    found = scaled_slopes(
        read["model"],
        Fraction(turbine.rated_torque),
        spline,
        (winds, [Fraction(1)] * 3),
        FILE,
    )

    for wind, slope in zip(map(float, winds), found, strict=True):
        pitch = trim(turbine, wind).pitch
        by_pitch = rotor_torque_gradient(turbine, turbine.rated_rotor_speed, pitch, wind)[1]
        assert np.isclose(float(slope), turbine.rated_rotor_speed * float(by_pitch), rtol=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.5])
def test_a_table_that_is_not_the_turbines_is_not_certified(built: Any, share: float) -> None:
    """Zero, less, more, and one node alone; the message has wind, both numbers and the cure."""
    schedule = built.law.schedule
    other = replace(schedule, effectiveness_limit=share * schedule.effectiveness_limit)
    one = schedule.effectiveness_limit.copy()
    one[40] *= share
    words = r"effectiveness_limit is .* at [0-9.]+ m/s; .*NREL 5-MW needs .*--equilibrium-wake"
    for changed in (other, replace(schedule, effectiveness_limit=one)):
        with pytest.raises(ModelError, match=words):
            certify_law(built.turbine, replace(built.law, schedule=changed))


def test_without_the_frozen_wake_the_table_does_not_count(
    built: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The refusal is about what would be claimed: the work begins."""
    schedule = replace(
        built.law.schedule, effectiveness_limit=np.zeros(len(built.law.schedule.wind))
    )

    def begun(*_: Any, **__: Any) -> None:
        raise RuntimeError("begun")

    monkeypatch.setattr(
        "takagi.certificates.design.given.turbine_law.effort_sharing_candidate", begun
    )
    asked = replace(DEFAULT_UNCERTAINTY, frozen_wake=False)
    with pytest.raises(RuntimeError, match="begun"):
        certify_law(built.turbine, replace(built.law, schedule=schedule), uncertainty=asked)
    with pytest.raises(RuntimeError, match="begun"):
        certify_law(built.turbine, built.law)


def limited(document: dict[str, Any], share: float, *, claim: bool = True) -> dict[str, Any]:
    """Return a forger's certificate: another wake in the gains, and in the claim where asked."""
    changed = deepcopy(document)
    limits = [round(share * one, 6) for one in changed["gains"]["effectiveness_limit"]]
    changed["gains"]["effectiveness_limit"] = limits
    if claim:
        for cell, ends in zip(changed["claims"][0]["cells"], pairwise(limits), strict=True):
            cell["effectiveness_limit"] = sorted(ends)
    return resealed(changed)


def test_the_files_name_of_a_claim_is_the_verdicts(built: Any) -> None:
    """What the claim is called in certificate and gain file says no more than what is proved."""
    stated = [claim["name"] for claim in built.document["claims"]]

    assert stated[0].startswith("effort-sharing loop, 3 to 25 m/s, pitch effectiveness up to ")
    assert stated == [claim.name for claim in check_document(built.document).claims]
    calm = replace(built.candidate, uncertainty=replace(DEFAULT_UNCERTAINTY, frozen_wake=False))
    assert (
        effort_sharing_claim(calm)["name"] == "effort-sharing loop, 3 to 25 m/s, equilibrium wake"
    )


@pytest.mark.parametrize("share", [1.0, 0.1, 0.0])
def test_the_verdict_says_how_much_wake_is_in(short: dict[str, Any], share: float) -> None:
    """Nothing but the turbine's is called the frozen wake, whatever the claim says of it."""
    found = check_document(limited(short, share)).claims[0]

    assert "frozen wake included" not in found.name
    if share == 0:
        assert found.name.endswith("equilibrium wake") and "is no frozen wake's" in found.text
        return
    least = share * min(short["gains"]["effectiveness_limit"])
    told = float(found.name.split("pitch effectiveness up to ")[1].split(" to ")[0])
    shown = float(found.text.split("claim's bound of at least ")[1].split(" to ")[0])
    assert least - 1e-3 < told <= least and least - 1e-2 < shown <= least
    assert found.verdict is Verdict.PROVED
    assert "the turbine's frozen wake if its model file states that wake" in found.text


@pytest.mark.parametrize("share", [0.0, 0.1])
def test_the_turbine_file_refuses_another_table(short: dict[str, Any], share: float) -> None:
    """``check --model``: it is not the file's frozen wake."""
    read = read_text(json.dumps(limited(short, share)), "document")
    with pytest.raises(CertificateError, match="frozen wake's pitch effectiveness at"):
        compare_turbine(read["model"], read["gains"], data_folder() / "nrel5mw.toml")
