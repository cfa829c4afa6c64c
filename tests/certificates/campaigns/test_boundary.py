"""The published laws' boundary on paper: rows and figures from made-up outcomes, read back."""

from __future__ import annotations

import csv
import io
from importlib import import_module
from typing import Any

import numpy as np
import pytest

figure: Any = import_module("boundary_figure")
trials: Any = import_module("disturbance_trials")
CYCLES, LOST, STAYS = trials.CYCLES, trials.LOST, trials.STAYS


@pytest.fixture
def boundary() -> Any:
    """Two overlaps, three winds, two disturbances: one place cycles, one is lost."""
    codes = np.full((2, 3, 2), STAYS)
    codes[0, 2] = [CYCLES, LOST]
    codes[1, 2, 1] = CYCLES
    proved = np.array([[True, True, False], [True, False, False]])
    return figure.Boundary(
        "paper",
        (13.0, 19.0, 25.0),
        (0.05, 0.1),
        ("speed −1 %", "gust +3 m/s"),
        proved,
        {"first-order pitch drive": codes},
        {"first-order pitch drive": np.linspace(0, 0.11, 12).reshape(2, 3, 2)},
    )


def test_summary_counts_where_proved_and_elsewhere(boundary: Any) -> None:
    """Six places, three of them proved, two runs each."""
    found = boundary.summary()

    assert (found["places"], found["proved"]) == (6, 3)
    assert found["first-order pitch drive, where proved"] == {
        "stays": 6,
        "cycles": 0,
        "loses the trim": 0,
    }
    assert found["first-order pitch drive, elsewhere"] == {
        "stays": 3,
        "cycles": 2,
        "loses the trim": 1,
    }
    assert found["first-order pitch drive, largest overspeed [%]"] == pytest.approx(11)


def test_every_run_is_a_line(boundary: Any) -> None:
    """With units in the header, and what was proved beside what was seen."""
    rows = list(csv.DictReader(io.StringIO(figure.boundary_csv(boundary))))

    assert len(rows) == 12
    lost = [row for row in rows if row["outcome"] == "loses the trim"]
    assert [(row["wind [m/s]"], row["speed overlap [rad/s]"], row["proved"]) for row in lost] == [
        ("25.0", "0.05", "no")
    ]


def test_figure_rings_what_is_proved(boundary: Any) -> None:
    """One panel per drive; the worst outcome of each place, and a ring around the proved ones."""
    drawn = figure.boundary_figure(boundary)
    (axes,) = drawn.axes
    points = {c.get_label(): len(np.asarray(c.get_offsets())) for c in axes.collections}

    assert axes.get_title() == "first-order pitch drive"
    assert axes.get_xlabel() == "wind [m/s]"
    assert "[rad/s]" in axes.get_ylabel()
    assert points[figure.RING] == 3
    assert sum(n for label, n in points.items() if label != figure.RING) == 6
