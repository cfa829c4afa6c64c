"""What is asked of a claim about a law of the paper, beside that each of its cells holds."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker.kernel.result import Claim
from takagi.certificates.checker.replay.claim_kinds import replay
from tests.certificates.recorded.inputs import as_read, document

Data = dict[str, Any]


def recorded(*cells: Data) -> tuple[Data, Data, Data]:
    """Return claim, model and gains, with one recorded cell as often, each with other parts."""
    data = document("paper")
    claim, gains = data["claims"][0], data["gains"]
    own = claim["cells"][4]
    claim |= {"cells": [{**own, **changed} for changed in cells], "winds": [own["wind"]]}
    return claim, data["model"], gains


def answer(claim: Data, model: Data, gains: Data) -> Claim:
    data = as_read({"claims": [claim], "model": model, "gains": gains})
    return replay(data["claims"][0], data, None, [], "here").in_words()


@pytest.mark.parametrize(("top", "refused"), [(44000, False), (43999.9, True), (44001, False)])
def test_the_rounded_corner_ends_at_the_top_torque_at_the_latest(top: float, refused: bool) -> None:
    """The corner at 43000 N m is 2000 N m wide; a claim without cells is read all the same."""
    claim, model, gains = recorded()
    claim["torque_overlap"], gains["rated_torque"] = 2000, 43000
    gains["coupling"]["top_torque"] = top

    if refused:
        with pytest.raises(CertificateError, match="the rounded corner goes beyond it"):
            answer(claim, model, gains)
    else:
        assert answer(claim, model, gains).verdict is Verdict.UNDECIDED


@pytest.mark.parametrize("limit", ["pitch_min", "pitch_max"])
def test_law_and_turbine_have_the_same_pitch_limits(limit: str) -> None:
    claim, model, gains = recorded()
    gains[limit] += 0.1 if limit == "pitch_max" else -0.1

    with pytest.raises(CertificateError, match="pitch limits differ from the model's"):
        answer(claim, model, gains)


CORNER: Data = document("paper")["claims"][0]["cells"][4]["corners"][0]
# Part of the ranges of the loop's matrix alone.
NARROW = {"low": CORNER["low"], "high": CORNER["low"]}
LEAVES = "the loop's matrix leaves the stated ranges"
EXCEEDS = "the field at the centre exceeds the stated bound"


@pytest.mark.parametrize(
    ("cells", "failures"),
    [
        ([{}], []),
        ([{"corners": [NARROW, CORNER]}], []),
        ([{"corners": [NARROW]}], [LEAVES]),
        ([{"disturbance": [0.0038, 0.002, 0.000002]}], [EXCEEDS]),
        # The first one covers its winds; that the other was stated in vain is said all the same.
        ([{}, {"corners": [NARROW]}], [LEAVES]),
    ],
)
def test_each_cell_has_to_hold(cells: list[Data], failures: list[str]) -> None:
    found = answer(*recorded(*cells))

    assert found.verdict is (Verdict.UNDECIDED if failures else Verdict.PROVED)
    proved = len(cells) - len(failures)
    assert [why for why in (LEAVES, EXCEEDS) if why in found.text] == failures
    assert (f"{proved} cells)" in found.text) == bool(proved)
    assert ("no stated cell holds" in found.text) == (not proved)


WIND = document("paper")["claims"][0]["cells"][4]["wind"]
STATES = len(CORNER["low"])


@pytest.mark.parametrize(
    "wrong",
    [
        {"wind": WIND[::-1]},
        {"box": [0.01] * (STATES - 1) + [0]},
        {"box": [0.01] * (STATES + 1)},
        {"centre": [[1.2, 0.1, -4][:STATES], [1.2, -0.1, -4][:STATES]]},
        {"centre": [[1.2, 0.1, -4][:STATES]]},
        {"P": [[2, 0], [0, 2]]},
        {"P": [[2, 0, 0.5], [0, 2, 0], [0, 0, 2]]},
        {"corners": []},
        {"corners": [{**CORNER, "low": CORNER["low"][:-1]}]},
        {"corners": [CORNER] * 9},
        {"decay_rate": 0},
        {"multiplier": -1},
        {"disturbance": [-1e-4] * STATES},
    ],
    ids=str,
)
def test_a_cell_that_cannot_be_is_refused(wrong: Data) -> None:
    claim, model, gains = recorded({}, wrong)
    with pytest.raises(CertificateError, match="cells"):
        answer(claim, model, gains)


def test_every_pair_of_winds_increases() -> None:
    claim, model, gains = recorded({})
    for winds in ([WIND, WIND[::-1]], [[0, 1], WIND], [[*WIND, 20]]):
        with pytest.raises(CertificateError, match=r"winds: pairs of increasing winds"):
            answer({**claim, "winds": winds}, model, gains)
