"""The frozen wake of a claim is the turbine's, and the verdict says how much of it is in."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker.files.turbine_file import compare_turbine
from takagi.certificates.checker.kernel.certificate import check_document
from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.coherent import DEFAULT_UNCERTAINTY
from takagi.certificates.given_law import certify_law
from takagi.models.errors import ModelError
from takagi.models.library import data_folder
from tests.certificates.conftest import resealed


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

    monkeypatch.setattr("takagi.certificates.given_law.coherent_candidate", begun)
    asked = replace(DEFAULT_UNCERTAINTY, frozen_wake=False)
    with pytest.raises(RuntimeError, match="begun"):
        certify_law(built.turbine, replace(built.law, schedule=schedule), uncertainty=asked)
    with pytest.raises(RuntimeError, match="begun"):
        certify_law(built.turbine, built.law)


def limited(document: dict[str, Any], share: float) -> dict[str, Any]:
    changed = deepcopy(document)
    limits = changed["gains"]["effectiveness_limit"]
    changed["gains"]["effectiveness_limit"] = [round(share * one, 6) for one in limits]
    return resealed(changed)


def test_the_verdict_says_how_much_wake_is_in(short: dict[str, Any]) -> None:
    """With the table at zero nothing is called a frozen wake, whatever the claim says of it."""
    own, none = (check_document(limited(short, share)).claims[0] for share in (1.0, 0.0))
    least = min(short["gains"]["effectiveness_limit"])

    assert own.name.endswith("frozen wake included")
    assert "pitch effectiveness equilibrium to frozen wake, of at least 0." in own.text
    shown = float(own.text.split("of at least ")[1].split(" to ")[0])
    assert least - 1e-2 < shown <= least
    assert none.name.endswith("equilibrium wake")
    assert "equilibrium to frozen wake" not in none.text


def test_the_turbine_file_refuses_another_table(short: dict[str, Any]) -> None:
    """``check --model``: zeroed, it is not the file's frozen wake."""
    read = read_text(json.dumps(limited(short, 0.0)), "document")
    with pytest.raises(CertificateError, match="frozen wake's pitch effectiveness at"):
        compare_turbine(read["model"], read["gains"], data_folder() / "nrel5mw.toml")
