"""The effort-sharing law's pages: read back with other readers, the front, what is not proved."""

from __future__ import annotations

import csv
import io
import json
from typing import Any
from xml.etree import ElementTree

import pytest

from takagi.certificates.sweep import Axis, PointResult, SweepMap, SweepResult, Task
from takagi.reports.maps.effort_sharing_pages import pages
from takagi.reports.maps.effort_sharing_rows import Line, front, guaranteed_pairs

RANGES = (("partial load", 3.0, 10.0), ("full load", 13.0, 25.0))
WHY = "wind cell [3, 3.25] m/s: the box leaves the table; reduce the speed error | or the share"


def never(task: Task) -> dict[str, Any]:
    """Stand where a map's point stands; the results here are given."""
    raise AssertionError(task)


def proved(error: float) -> dict[str, Any]:
    """A point of a map, as ``loop_answer`` writes it."""
    return {
        "verdict": "PROVED",
        "reason": None,
        "energy_cost [%]": 1.2,
        "overspeed [%]": 3.0,
        "common_decay [1/s]": 0.02,
        "ranges": [claim(name, low, high, 3.0, error, 2.0) for name, low, high in RANGES],
        "cells": {"wind [m/s]": [3.0, 25.0]},
    }


def claim(
    name: str, low: float, high: float, overspeed: float, error: float, rate: float
) -> dict[str, Any]:
    return {
        "name": name,
        "verdict": "PROVED",
        "reason": None,
        "winds [m/s]": [low, high],
        "overspeed [%]": overspeed,
        "mean_wind_error [m/s]": error,
        "least_wind_error [m/s]": error / 2,
        "mean_wind_rate [m/s^2]": rate,
        "least_wind_rate [m/s^2]": rate / 2,
        "least_decay [1/s]": 0.01,
        "common_decay [1/s]": 0.02,
    }


def result(axes: tuple[Axis, ...], answers: list[dict[str, Any]]) -> SweepResult:
    swept = SweepMap("coherent", axes, {"model": {"name": "toy"}}, never)
    points = zip(swept.places, answers, strict=True)
    return SweepResult(swept, tuple(PointResult(swept.at(p), a, 1.0) for p, a in points))


def traded() -> SweepResult:
    """Four boxes: the second is beaten by the first, the third has more rate, the last fails."""
    worth = [(3.0, 0.2, 1.0), (3.0, 0.1, 1.0), (3.0, 0.1, 2.0)]
    answers = [
        {
            "verdict": "PROVED",
            "reason": None,
            "claims": {name: claim(name, low, high, *each) for name, low, high in RANGES},
        }
        for each in worth
    ]
    lost = {"name": "full load", "winds [m/s]": [13.0, 25.0], "verdict": "UNDECIDED", "reason": WHY}
    answers.append({"verdict": "UNDECIDED", "reason": WHY, "claims": {"full load": lost}})
    return result((Axis("speed-error", "rad/s", (0.01, 0.02, 0.03, 0.04)),), answers)


@pytest.mark.parametrize("axes", [1, 2])
def test_a_map_leaves_figure_table_and_data(axes: int) -> None:
    """The SVG is XML, the CSV has a row a point with units, the JSON holds everything."""
    overlap = Axis("overlap", "rad/s^2", (0.01, 0.02))
    other = Axis("bandwidth", "1/s", (0.3, 0.6))
    answers = [proved(0.2), {"verdict": "UNDECIDED", "reason": WHY, "energy_cost [%]": 2.8}]
    found = pages(result((overlap, other)[:axes], answers * axes))

    (stem,) = {name.rpartition("/")[2][:-4] for name in found if name.endswith(".svg")}
    assert stem == ("effect", "pair")[axes - 1]
    ElementTree.fromstring(str(found[f"figures/{stem}.svg"]))
    rows = list(csv.DictReader(io.StringIO(str(found["points.csv"]))))
    assert len(rows) == 2 * axes
    assert rows[0]["overlap [rad/s^2]"] == "0.01"
    assert rows[0]["full load, 13 to 25 m/s: mean_wind_error [m/s]"] == "0.2"
    assert rows[1]["verdict"] == "UNDECIDED"
    assert rows[1]["reason"] == WHY
    assert len(json.loads(str(found["map.json"]))["points"]) == 2 * axes
    page = str(found["map.md"])
    assert f"{axes} PROVED, {axes} UNDECIDED" in page
    # A stroke in a reason must not end its cell.
    assert "error \\| or the share" in page


def test_a_map_of_which_nothing_is_proved_has_its_reasons_and_no_figure() -> None:
    lost = {"verdict": "UNDECIDED", "reason": WHY}
    found = pages(result((Axis("overlap", "rad/s^2", (0.01, 0.02)),), [lost, lost]))

    assert not [name for name in found if name.startswith("figures")]
    assert str(found["map.md"]).count("leaves the table") == 1
    assert "| 2 | overlap 0.01 |" in str(found["map.md"])


@pytest.mark.slow
def test_a_trade_off_lists_what_no_other_claim_beats() -> None:
    """Of three proved claims the second has neither less overspeed nor more of anything."""
    swept = traded()
    kept = front(guaranteed_pairs(swept, "full load"))

    assert [line.at["speed-error"] for line in kept] == [0.01, 0.03]
    found = pages(swept)
    ElementTree.fromstring(str(found["figures/trade-off.svg"]))
    listed = [row for row in str(found["map.md"]).splitlines() if row.startswith("| full load, 13")]
    assert [row.split("|")[2].strip() for row in listed] == ["0.01", "0.03"]


def test_claims_that_guarantee_the_same_are_listed_once() -> None:
    same = Line({"overlap": 0.01}, 3.0, 0.2, 0.1, 1.0, 0.5, 0.02)
    other = Line({"overlap": 0.02}, 3.0, 0.2, 0.1, 1.0, 0.5, 0.02)
    calmer = Line({"overlap": 0.03}, 2.0, 0.1, 0.1, 1.0, 0.5, 0.02)

    assert front([same, other, calmer]) == [same, calmer]
