"""The files of a sweep, read back with other readers."""

from __future__ import annotations

import csv
import io
from typing import Any
from xml.etree import ElementTree

import pytest

from takagi.certificates.sweep.sweep import Axis, Sweep
from takagi.reports.sweep.campaigns import sweep_files

WHY = "the box leaves the table; reduce the speed error | or the share"
SPEED = Axis("speed-overlap", "rad/s", (0.02, 0.1))
TORQUE = Axis("torque-overlap", "N m", (500.0, 2000.0))


def effort(error: float | None) -> dict[str, Any]:
    if error is None:
        return {"verdict": "UNDECIDED", "reason": WHY}
    return {
        "verdict": "PROVED",
        "reason": None,
        "overspeed [%]": 3.0,
        "common_decay [1/s]": 0.02,
        "mean_wind_error [m/s]": error,
        "mean_wind_rate [m/s^2]": 2 * error,
    }


def published(proved: int) -> dict[str, Any]:
    """A point of a published law, with two windows of wind."""
    windows = [
        {"from [m/s]": v, "decay_rate [1/s]": 0.01 if k < proved else None, "reason": None}
        for k, v in enumerate((6.0, 12.0))
    ]
    return {
        "verdict": "PROVED" if proved == 2 else "PARTLY",
        "reason": None,
        "proved_windows": proved,
        "proved_at_trim": 1,
        "first_failing_wind [m/s]": None if proved == 2 else 12.0,
        "least_decay_rate [1/s]": 0.01,
        "windows": windows,
    }


def sweep(law: str, axes: tuple[Axis, ...], results: list[dict[str, Any]]) -> Sweep:
    places: list[dict[str, float]] = [{}]
    for axis in axes:
        places = [{**place, axis.label: value} for place in places for value in axis.values]
    rows = tuple(place | result for place, result in zip(places, results, strict=True))
    return Sweep(law, "toy", axes, rows, 0)


def table(text: object) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(str(text))))


@pytest.mark.parametrize("axes", [(SPEED,), (SPEED, TORQUE)])
@pytest.mark.parametrize("law", ["coherent", "paper"])
def test_a_sweep_leaves_page_table_and_figure(law: str, axes: tuple[Axis, ...]) -> None:
    results = [effort(0.2), effort(None)] if law == "coherent" else [published(2), published(1)]
    files = sweep_files(sweep(law, axes, results * len(axes)))
    page, rows = str(files["map.md"]), table(files["points.csv"])

    root = ElementTree.fromstring(str(files["figures/map.svg"]))
    assert len(list(root.iter())) > 50
    assert len(rows) == 2 * len(axes)
    assert rows[0]["speed-overlap [rad/s]"] == "0.02"
    lines = [line for line in page.splitlines() if line.startswith("| ")]
    assert len(lines) == 1 + len(rows)
    assert len({line.replace("\\|", "").count("|") for line in lines}) == 1
    if law == "coherent":
        assert rows[0]["mean_wind_error [m/s]"] == "0.2"
        assert (rows[1]["verdict"], rows[1]["reason"]) == ("UNDECIDED", WHY)
        assert f"{len(axes)} PROVED, {len(axes)} UNDECIDED" in page
        assert "error \\| or the share" in page
    else:
        windows = table(files["windows.csv"])
        assert len(windows) == 4 * len(axes)
        assert (windows[3]["from [m/s]"], windows[3]["decay_rate [1/s]"]) == ("12.0", "")


def test_three_axes_have_a_figure_but_nothing_proved_or_one_point_has_none() -> None:
    three = (SPEED, TORQUE, Axis("bandwidth", "1/s", (0.3, 0.6)))
    assert "figures/map.svg" in sweep_files(sweep("coherent", three, [effort(0.1)] * 8))
    for law, axes, results in (
        ("coherent", (SPEED,), [effort(None)] * 2),
        ("paper", (), [published(1)]),
    ):
        assert "figures/map.svg" not in sweep_files(sweep(law, axes, results))
