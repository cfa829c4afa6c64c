"""The simulation's report: numbers against the records they come from, divergence, the files."""

from __future__ import annotations

import csv
import io
import json
import pickle
from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from takagi.models import ModelError, nrel5mw
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import Diverged, History
from takagi.models.simulation.wind import step_wind
from takagi.models.turbine.trim import rated_wind, trim
from takagi.reports.simulation.laws import ChosenLaws, chosen_laws
from takagi.reports.simulation.runs import PlantParts, Simulation, run_simulation
from takagi.reports.simulation.tables import (
    COLUMNS,
    as_csv,
    as_json,
    as_markdown,
    notes,
    series_csv,
    table_rows,
)
from takagi.reports.simulation.winds import FORMS, requested_winds

TURBINE = nrel5mw()


class Wild:
    """A law whose state leaves all numbers at the first step."""

    name = "wild"
    state_names = ("state [-]",)

    def initial_state(self, wind: float) -> NDArray[np.float64]:
        """Return a state that is still a number."""
        return np.zeros(1)

    def command(self, state: ArrayLike, measurement: Measurement) -> Command:
        """Return rated torque and fine pitch."""
        return Command(TURBINE.rated_torque, 0.0)

    def state_rate(self, state: ArrayLike, measurement: Measurement) -> NDArray[np.float64]:
        """Return no number."""
        return np.array([np.inf])


@lru_cache(maxsize=1)
def baseline() -> Simulation:
    """The reference's own controller in the paper's winds, for 30 s."""
    winds = requested_winds(TURBINE, duration=30.0)
    return run_simulation(TURBINE, chosen_laws(TURBINE, ["baseline"]), winds)


@lru_cache(maxsize=1)
def broken() -> Simulation:
    """A law that diverges beside one that does not."""
    chosen = ChosenLaws({"wild": Wild(), "baseline": BaselineLaw(TURBINE)}, None)
    winds = requested_winds(TURBINE, ["ramp"], duration=5.0)
    return run_simulation(TURBINE, chosen, winds)


def record(simulation: Simulation, index: int) -> History:
    """The record of a run that reached its end."""
    history = simulation.runs[index].history
    assert history is not None
    return history


@pytest.mark.parametrize("index", [0, 1, 2])
def test_energy_follows_from_the_rotor_balance(index: int) -> None:
    """E / eta = integral of T_r omega minus what the inertia keeps: never touches the torque."""
    simulation = baseline()
    history, metrics = record(simulation, index), simulation.runs[index].metrics
    assert metrics is not None
    gained = np.trapezoid(history.rotor_torque * history.rotor_speed, history.time)
    kept = TURBINE.inertia / 2 * (history.rotor_speed[-1] ** 2 - history.rotor_speed[0] ** 2)
    energy = TURBINE.generator_efficiency * (gained - kept) / 3.6e6

    assert metrics.energy == pytest.approx(energy, rel=2e-3)
    assert metrics.mean_power == pytest.approx(metrics.energy * 3600 / 30.0, rel=1e-12)


def test_overspeed_and_pitch_travel_are_those_of_the_record() -> None:
    """From the plant's own states, turning point by turning point."""
    simulation = baseline()
    for index, run in enumerate(simulation.runs):
        states = record(simulation, index).plant_states
        assert run.metrics is not None
        fastest = max(states[:, 0].tolist()) / TURBINE.rated_rotor_speed
        pitch = np.degrees(states[:, 1])
        steps = np.diff(pitch)
        turns = np.flatnonzero(np.sign(steps[1:]) != np.sign(steps[:-1])) + 1
        ends = pitch[[0, *turns.tolist(), -1]]

        assert run.metrics.overspeed == pytest.approx(100 * (fastest - 1), abs=1e-9)
        assert run.metrics.pitch_travel == pytest.approx(float(np.abs(np.diff(ends)).sum()))


def test_table_json_and_csv_say_the_same() -> None:
    """Laws stand under one another by wind; all digits in the files; units in the headers."""
    simulation = baseline()
    rows = table_rows(simulation)
    text = json.loads(as_json(simulation))
    lines = list(csv.reader(io.StringIO(as_csv(simulation))))

    assert [row["wind"] for row in rows] == [wind.name for wind in simulation.winds]
    assert text["rows"] == rows
    assert text["units"]["energy"] == "kWh"
    assert lines[0][2] == "energy [kWh]"
    assert [float(line[2]) for line in lines[1:]] == [row["energy"] for row in rows]
    assert f"| {rows[1]['energy']:.2f} |" in as_markdown(simulation)


def test_series_hold_the_record() -> None:
    """Every tenth of a second, SI units named in the header."""
    history = record(baseline(), 2)
    lines = list(csv.reader(io.StringIO(series_csv(history))))

    assert lines[0][3] == "rotor speed [rad/s]"
    assert len(lines) == 1 + 301
    assert float(lines[-1][0]) == pytest.approx(30.0)
    assert float(lines[-1][3]) == pytest.approx(history.rotor_speed[-1], rel=1e-6)


def test_divergence_is_told_and_the_others_are_shown() -> None:
    """A dash in the table, a sentence below it, no figure line, and the other law's numbers."""
    simulation = broken()
    first, second = table_rows(simulation)
    markdown, text = as_markdown(simulation), json.loads(as_json(simulation))

    assert [run.law for run in simulation.diverged] == ["wild"]
    assert first["diverged"] == pytest.approx(0.02)
    assert all(first[name] is None for name in COLUMNS)
    assert second["energy"] > 0
    assert "| law wild | – |" in markdown
    assert any(
        note.startswith("law wild in ramp") and "diverged" in note for note in notes(simulation)
    )
    assert text["rows"][0]["energy"] is None
    assert simulation.runs[0].history is None


def test_divergence_comes_back_whole_from_another_process() -> None:
    """What is pickled on the way keeps its message and its time."""
    end = pickle.loads(pickle.dumps(Diverged("wild", "ramp", 0.5)))

    assert str(end) == str(Diverged("wild", "ramp", 0.5))
    assert end.time == 0.5


def test_remarks_count_the_flags() -> None:
    """A pitch drive at its rate limit is told with the share that the record holds."""
    slow = ChosenLaws({"baseline": BaselineLaw(TURBINE)}, None)
    (wind,) = requested_winds(TURBINE, ["ramp"], duration=2.0)
    simulation = run_simulation(TURBINE, slow, [wind])
    row = table_rows(simulation)[0]

    assert set(row["flags"]) >= {"pitch_rate_limited", "tip_speed_ratio_clipped"}
    for name, share in row["flags"].items():
        told = any("torque at its rate limit" in remark for remark in row["remarks"])
        assert name != "torque_rate_limited" or told == (share >= 0.01)


def test_a_run_that_leaves_the_tables_says_when() -> None:
    """A gale on a rotor that turns slowly: tip-speed ratios below the table's."""
    law = ChosenLaws({"baseline": BaselineLaw(TURBINE)}, None)
    wind = step_wind(4.0, 60.0, 12.0, begin=3.0)
    simulation = run_simulation(TURBINE, law, [wind])
    history, (remark,) = (
        record(simulation, 0),
        [remark for remark in simulation.runs[0].remarks() if "tip-speed ratio" in remark],
    )
    ratio = history.rotor_speed * TURBINE.rotor_radius / history.wind
    first = float(history.time[np.argmax(ratio < TURBINE.torque.x_range[0])])

    assert 2.9 < first < 3.2
    # What the blades meet differs a little from the wind, by the wake and the moving parts.
    assert float(remark.split("from ")[1].split(" s")[0]) == pytest.approx(first, abs=0.2)


@pytest.mark.parametrize("name", [name for name in FORMS if FORMS[name].alone])
def test_words_alone_have_winds_across_rated_wind(name: str) -> None:
    """Together the winds of a word lie on both sides; default durations hold."""
    winds = requested_winds(TURBINE, [name])
    rated = rated_wind(TURBINE)

    assert min(float(wind.speed.min()) for wind in winds) < rated
    assert max(float(wind.speed.max()) for wind in winds) > rated
    assert {round(wind.duration, 6) for wind in winds} == {FORMS[name].duration}


def test_laws_and_wakes_that_are_not_known_are_refused() -> None:
    with pytest.raises(ModelError, match="no law"):
        chosen_laws(TURBINE, [])
    with pytest.raises(ModelError, match="did you mean 'dynamic'"):
        PlantParts("dynamics")


def test_a_run_starts_at_the_trim_of_its_first_wind() -> None:
    """So nothing needs to be dropped before measuring."""
    history = record(baseline(), 2)
    point = trim(TURBINE, float(history.wind[0]))

    assert history.rotor_speed[0] == pytest.approx(point.rotor_speed)
    assert history.pitch[0] == pytest.approx(point.pitch)
