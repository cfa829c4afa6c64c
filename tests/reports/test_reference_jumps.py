"""What the summary and the report say of a plant that follows a reference."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.reports.loops.plant_loop import plant_loop
from takagi.reports.sections.plant.page import plant_report_files
from takagi.reports.sections.plant.summary import summary_rows
from takagi.reports.simulation.plant import jump_motions, proved_jumps
from tests.reports.test_tracking_gain_file import servo


def test_motions_after_the_proved_jumps_arrive_within_all_ranges() -> None:
    """The servo's angle ends at the new reference; states and voltage keep the file's ranges."""
    runs = jump_motions(servo(), plant_loop(servo()))
    targets = [jump["target"] for jump in proved_jumps(servo())]

    assert len(runs) == len(targets) == 2 and targets[0] < 0 < targets[1]
    variables = (*servo().plant.states, *servo().plant.inputs)
    for run, target in zip(runs, targets, strict=True):
        assert run.state[-1][0] == pytest.approx(target, rel=1e-2)
        largest = np.abs(np.hstack([run.state, run.input])).max(axis=0)
        for variable, most in zip(variables, largest, strict=True):
            assert variable.range is None or most <= float(variable.range.upper)


def test_the_summary_says_what_follows_what() -> None:
    """In a row of its own, as a share of the range; no reference among the disturbances."""
    rows = {row.name: row for row in summary_rows(servo())}
    steps = max(abs(jump["target"]) for jump in proved_jumps(servo()))

    (number,) = rows["follows"].numbers
    assert (number.quantity, number.unit) == ("target", "deg")
    assert number.value == pytest.approx(np.degrees(steps))
    assert number.share == pytest.approx(steps / np.radians(90)) and rows["follows"].partial
    assert "target" not in {number.quantity for number in rows["disturbance"].numbers}


@pytest.mark.slow
def test_the_report_has_the_jumps_as_a_figure_and_as_numbers() -> None:
    files = plant_report_files(servo())

    assert "After jumps of the reference" in files.html
    assert "jumps.csv" in files.figures and "jumps.svg" in files.figures
    lines = files.figures["jumps.csv"].decode("utf-8").splitlines()
    first, last = lines[0], lines[-1]
    assert "theta" in first and len(last.split(",")) == len(first.split(","))
