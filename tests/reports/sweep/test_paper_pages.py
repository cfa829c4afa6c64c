"""The files of the paper's map: read back by other readers, and the same for the same numbers."""

from __future__ import annotations

import csv
import io
import json
import xml.etree.ElementTree as ElementTree
from typing import Any

import numpy as np
import pytest

from takagi.certificates.sweep import Axis, PointResult, SweepMap, SweepResult, WindowResult
from takagi.certificates.sweep.published_point import point_result
from takagi.reports.maps.published_overlaps import edges
from takagi.reports.maps.published_pages import figures, tables
from takagi.reports.maps.published_rows import grid, reason_counts

WINDS = [(6.0, 6.004), (12.0, 12.004)]
SETTINGS = {
    "windows": [list(span) for span in WINDS],
    "sets [rad/s]": [0.002, 2e-5],
    "model": {"name": "Test turbine"},
}
REASON = "stable where it rests (slowest at 0.003 1/s), but nothing contracts"


def nothing(_: Any) -> dict[str, Any]:
    """Never called: the points are made here."""
    raise AssertionError


def window(k: int, rate: float | None, rest: str = "intended") -> WindowResult:
    """One window, proved at a rate or not at all."""
    if rate is None:
        return WindowResult(WINDS[k], False, None, None, rest, 0.6, REASON)
    return WindowResult(WINDS[k], True, rate, 5e-4, rest, 1.0, None)


def made(
    speeds: tuple[float, ...] = (0.02, 0.1), torques: tuple[float, ...] = (500.0, 2000.0)
) -> SweepResult:
    """A map in which narrow speed overlaps lose the second wind, and one point has no answer."""
    axes = (Axis("speed-overlap", "rad/s", speeds), Axis("torque-overlap", "N m", torques))
    coherent = SweepMap("coherent", (), SETTINGS, nothing)
    row = PointResult({}, point_result([window(0, 0.05), window(1, 0.1)]), 1.0)
    swept = SweepMap("paper", axes, SETTINGS, nothing)
    points = []
    for place in swept.places:
        second = None if place[0] < 0.05 else 0.002
        result = point_result([window(0, 0.03), window(1, second, "shifted")])
        if place == (0.1, 2000.0):
            result = {"verdict": "UNDECIDED", "reason": "no such filter"}
        points.append(PointResult(swept.at(place), result, 0.5))
    return SweepResult(swept, tuple(points), 0, (SweepResult(coherent, (row,)),))


def test_tables_read_back() -> None:
    """CSV and JSON by the standard library's readers, with units, and nothing lost."""
    files = tables(made())
    rows = list(csv.DictReader(io.StringIO(str(files["points.csv"]))))
    assert [row["verdict"] for row in rows] == ["PARTLY", "PARTLY", "PROVED", "UNDECIDED"]
    assert rows[0]["speed-overlap [rad/s]"] == "0.02"
    assert rows[0]["first_failing_wind [m/s]"] == "12.0"
    assert rows[2]["least_decay_rate [1/s]"] == "0.002"
    assert (rows[2]["proved_windows"], rows[2]["proved_at_trim"]) == ("2", "1")
    assert rows[2]["smallest_half_width [rad/s]"] == "0.0005"
    assert rows[3]["reason"] == "no such filter" and rows[3]["proved_windows"] == ""
    windows = list(csv.DictReader(io.StringIO(str(files["windows.csv"]))))
    assert len(windows) == 3 * 2 + 2
    assert windows[1]["from [m/s]"] == "12.0" and windows[1]["reason"] == REASON
    assert [row["law"] for row in windows[-2:]] == ["coherent"] * 2
    data = json.loads(str(files["map.json"]))
    assert data["axes"][1] == {"name": "torque-overlap", "unit": "N m", "values": [500.0, 2000.0]}
    assert data["points"][0]["windows"][1]["verdict"] == "UNDECIDED"
    assert data["beside"][0]["points"][0]["least_decay_rate [1/s]"] == 0.05
    assert data["sha256"] == made().map.digest


def test_the_page_says_what_fails() -> None:
    """Counts, the law beside, and reasons that differ in numbers alone as one row."""
    page = str(tables(made())["map.md"])
    assert "| some winds proved | 2 |" in page and "| all winds proved | 1 |" in page
    assert "The effort-sharing law" in page and "2 of 2 proved, decay 0.05 to 0.1 1/s" in page
    words = "stable where it rests (slowest at ... 1/s), but nothing contracts"
    assert f"| {words} | 2 | 12 to 12 |" in page
    assert "| no such filter | a whole point | |" in page
    assert reason_counts(made()) == [(words, 2, 12.0, 12.0)]


def test_arrays() -> None:
    """Rows are speed overlaps, columns torque overlaps; what has no answer is NaN."""
    found = grid(made())
    assert found.proved[:, 0].tolist() == [1.0, 2.0] and np.isnan(found.proved[1, 1])
    assert np.isnan(found.first_failing[1]).all() and (found.first_failing[0] == 12.0).all()
    assert found.decay[1, 0] == 0.002
    assert found.at_trim[:, 0].tolist() == [1.0, 1.0] and np.isnan(found.at_trim[1, 1])
    assert edges(np.array([1.0, 2.0, 4.0])).tolist() == [0.5, 1.5, 3.0, 5.0]
    assert edges(np.array([2.0])).tolist() == [1.9, 2.1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speeds", "torques"), [((0.02, 0.1), (500.0, 2000.0)), ((0.1,), (2000.0,))]
)
def test_figures(speeds: tuple[float, ...], torques: tuple[float, ...]) -> None:
    """Figures are SVG that a reader of XML reads; a single point without an answer has them too."""
    for text in figures(made(speeds, torques)).values():
        root = ElementTree.fromstring(str(text))
        assert root.tag.endswith("svg") and len(list(root.iter())) > 50
