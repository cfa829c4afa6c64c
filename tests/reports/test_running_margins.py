"""Margins of the loop that runs: against the simulation's own steps, and in time."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.design.given.turbine_law import effort_sharing_law_from_data, read_law
from takagi.certificates.design.turbine.effort_sharing_gains import (
    wind_by_wind_law,
    wind_observer_design,
)
from takagi.certificates.design.turbine.result import speed_filter
from takagi.certificates.design.turbine.scale import default_settings
from takagi.models import Floats, ModelError, WindObserver
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.protocol import Command, Measurement, SampledLaw
from takagi.models.simulation import closed_loop, turbine_plant
from takagi.models.simulation.turbine_plant import SimulatedTurbine, validation_plant
from takagi.models.turbine.loader import load_turbine, nrel5mw
from takagi.reports.figures.loops import MarginLine, running_margins_figure
from takagi.reports.margins import running_loop
from takagi.reports.margins.margins import loop_margins
from takagi.reports.margins.response import broken_loops
from takagi.reports.margins.running_loop import (
    WAKES,
    LoopEquilibrium,
    RunningLoops,
    linearised_loop,
    loop_equilibrium,
    slopes,
    with_inertia,
)
from takagi.reports.margins.running_over_wind import (
    RunningMargins,
    plant_modes,
    running_margins,
    searched_margins,
    winds_between,
)

LAW = Path(__file__).parents[1] / "models" / "openfast" / "swinging_law.json"


PERIOD = 0.02


@lru_cache(maxsize=1)
def swinging() -> tuple[EffortSharingLaw, WindObserver]:
    """The law that swings in OpenFAST with a wind filter of 0.05 s, and its observer."""
    stated = json.loads(LAW.read_text(encoding="utf-8"))["observer"]
    observer = WindObserver(nrel5mw(), float(stated["l1"]), float(stated["l2"]))
    return effort_sharing_law_from_data(read_law(LAW)), observer


def law_with(wind_filter: float) -> EffortSharingLaw:
    return replace(swinging()[0], wind_filter=wind_filter)


@lru_cache(maxsize=4)
def plant(speed_filter: float | None = 8.0) -> SimulatedTurbine:
    return replace(validation_plant(nrel5mw()), speed_filter=speed_filter)


def measured(machine: SimulatedTurbine) -> int:
    place = machine.index("filtered")
    assert place is not None
    return place


# --- slopes --------------------------------------------------------------------------------------


def test_a_stop_has_the_slope_of_the_side_that_is_allowed() -> None:
    """max(x, 0) has slope 1 upwards and 0 downwards, and never the mean."""

    def stopped(x: Floats) -> Floats:
        return np.array([max(x[0], 0.0) + 3 * x[1], x[1] ** 2])

    up = slopes(stopped, np.array([0.0, 2.0]), np.ones(2))
    down = slopes(stopped, np.array([0.0, 2.0]), -np.ones(2))
    assert up.kinks == down.kinks == (0,)
    assert up.matrix == pytest.approx(np.array([[1, 3], [0, 4]]), abs=1e-6)
    assert down.matrix == pytest.approx(np.array([[0, 3], [0, 4]]), abs=1e-6)
    away = slopes(stopped, np.array([0.1, 2.0]), np.ones(2))
    assert away.kinks == ()


# --- against the simulation ----------------------------------------------------------------------


def simulated_step(program: SampledLaw, wind: float, rest: LoopEquilibrium) -> Any:
    """One sample of ``simulate`` differenced as a whole, with its own steps and limits."""
    machine, observer = plant(), swinging()[1]
    n, k, inner = len(rest.plant), len(rest.law), 2
    late = round(inner * program.computation_time / program.sample_time)
    at = np.concatenate([rest.plant, rest.law, rest.observer, rest.commands])

    def step(s: Floats) -> Floats:
        before = Command(float(s[-2]), float(s[-1]))
        state, estimate = s[:n].copy(), s[n + k : -2]
        seen = Measurement(
            float(state[measured(machine)]), float(state[1]), observer.wind_estimate(estimate)
        )
        within = program.start(wind, before)._replace(law_state=s[n : n + k])
        command, later = program.step(within, seen)
        torque = closed_loop.limit_torque(
            machine, before.torque, command.torque, program.sample_time
        )
        mean = torque + late / inner * (before.torque - torque)
        rate = observer.state_rate(estimate, seen.rotor_speed, seen.pitch, mean)
        sent = np.array([*before, torque, command.pitch])
        winds = np.full(2 * inner + 1, wind)
        moved = turbine_plant.advance(
            machine, state, sent, late, winds, program.sample_time / inner
        )
        after = [moved, later.law_state, estimate + program.sample_time * rate]
        return np.concatenate([*after, [torque, command.pitch]])

    assert step(at) == pytest.approx(at, rel=1e-7, abs=1e-7)
    sizes = 2e-6 * np.maximum(np.abs(at), 0.1)
    # A blade that stands at its stop can only leave it, and only begin to move upwards.
    stopped = {1, 2} if at[1] <= machine.turbine.pitch_min else set()
    columns = []
    for place, unit in enumerate(np.diag(sizes)):
        below, width = (at, 1) if place in stopped else (at - unit, 2)
        columns.append((step(at + unit) - step(below)) / (width * sizes[place]))
    return slow(np.linalg.eigvals(np.array(columns).T))


def slow(multipliers: Any) -> Any:
    return np.sort_complex(multipliers[np.abs(multipliers) > 0.3])


@pytest.mark.parametrize(
    ("wind", "computing"),
    [(6.1, 0.0), (10.1, 0.01), (11.3, 0.02), (12.1, 0.0), (18.1, 0.01), (24.1, 0.02)],
)
def test_poles_are_those_of_the_simulation(wind: float, computing: float) -> None:
    program = SampledLaw(law_with(5.0), PERIOD, computing)
    loop = linearised_loop(plant(), program, swinging()[1], wind)
    # What remains is the simulation's integration error of its fastest mode.
    simulated = simulated_step(program, wind, loop.rest)
    assert slow(loop.multipliers) == pytest.approx(simulated, abs=1e-5)


def test_sampling_hardly_moves_the_slow_poles() -> None:
    poles = [
        linearised_loop(plant(), SampledLaw(law_with(5.0), T), swinging()[1], 12.1).poles[:1]
        for T in (0.02, 0.01)
    ]
    assert poles[0] == pytest.approx(poles[1], rel=1e-3)


@pytest.mark.parametrize(
    ("wind", "loop", "computing"),
    [(8.1, "torque", 0.0), (11.1, "torque", 0.01), (13.1, "pitch", 0.0), (18.1, "pitch", 0.02)],
)
def test_the_gain_margin_is_where_the_loop_begins_to_grow(
    wind: float, loop: str, computing: float
) -> None:
    """By the multipliers of a sample, which are the simulation's, as the test above shows."""
    program = SampledLaw(law_with(5.0), PERIOD, computing)
    found = linearised_loop(plant(), program, swinging()[1], wind)
    margin = loop_margins(getattr(broken_loops(found), loop)).gain_increase

    def largest(factor: float) -> float:
        gains = np.ones(2)
        gains[("torque", "pitch").index(loop)] = factor * margin
        return float(np.abs(np.linalg.eigvals(found.A - found.B * gains @ found.C)).max())

    assert largest(0.99) < 1 < largest(1.01)


# --- what is known of the laws -------------------------------------------------------------------


def row_at(
    wind: float, wind_filter: float = 5.0, *, speed_filter: float | None = 8.0
) -> RunningMargins:
    law, observer = law_with(wind_filter), swinging()[1]
    loops = RunningLoops.of(nrel5mw(), law, observer, speed_filter=speed_filter)
    (row,) = running_margins(loops, [wind], plants=[(1.0, "dynamic")])
    return row


def test_the_law_that_swings_in_openfast_has_no_margins() -> None:
    both = {wind_filter: row_at(12.1, wind_filter) for wind_filter in (0.05, 5.0)}
    assert both[0.05].decay_rate < 0 and both[0.05].both.alpha == 0
    assert [m.gain_increase for _, m in both[0.05].loops] == [1.0]
    assert both[5.0].decay_rate > 0 and both[5.0].both.alpha > 0.3


def test_pitch_at_its_stop_is_no_loop_and_its_reference_goes_up_alone() -> None:
    row = row_at(8.0)
    assert row.pitch is None and row.torque is not None
    loop = linearised_loop(plant(), SampledLaw(law_with(5.0), PERIOD), swinging()[1], 8.0)
    assert "pitch reference" in loop.kinks
    free = linearised_loop(plant(), SampledLaw(law_with(5.0), PERIOD), swinging()[1], 14.1)
    # A pitch drive answers its reference the same at its stop, on the side it may go to.
    assert loop.B[1, 1] == pytest.approx(free.B[1, 1], rel=1e-4)


def test_modes_at_the_crossover_are_named() -> None:
    tower, torsion = plant_modes(plant())
    assert (tower.name, torsion.name) == ("tower", "torsion")
    assert tower.frequency / 2 / np.pi == pytest.approx(0.324, abs=0.02)
    row = row_at(10.1, speed_filter=None)
    assert [(loop, mode.name) for loop, mode in row.modes_met] == [("torque", "torsion")]


def test_wakes_and_inertia_change_what_they_should() -> None:
    program, observer = SampledLaw(law_with(5.0), PERIOD), swinging()[1]
    rest = loop_equilibrium(plant(), program.law, observer, 14.1)
    size = {}
    for wake in WAKES:
        loop = linearised_loop(plant(), program, observer, 14.1, rest=rest, wake=wake)
        size[wake] = abs(broken_loops(loop).pitch.evaluate(np.array([0.3]))[0, 0, 0])
    assert size["equilibrium"] < size["dynamic"] < size["frozen"]
    heavy = with_inertia(plant(), 1.1)
    assert heavy.turbine.inertia == pytest.approx(1.1 * plant().turbine.inertia)
    assert plant_modes(heavy)[1].frequency == pytest.approx(plant_modes(plant())[1].frequency)


def test_all_winds_are_searched_and_all_plants_where_it_counts() -> None:
    turbine = replace(nrel5mw(), cut_in=11.0, cut_out=13.0)
    loops = RunningLoops.of(turbine, law_with(5.0), swinging()[1], speed_filter=8.0)
    found = searched_margins(loops)
    assert found.whole == (11.0, 12.0, 13.0) and found.none == ()
    assert found.least and all(11.0 < wind < 13.0 for wind in found.least)
    for wind in (*found.whole, *found.least):
        plants = {(row.inertia, row.wake) for row in found.rows if row.wind == wind}
        assert len(plants) == 7
    pitch = {row.wind: row.pitch.disk.alpha for row in found.rows if row.nominal and row.pitch}
    assert min(pitch, key=pitch.__getitem__) in (*found.least, *found.whole)


def test_the_picture_needs_as_many_figures_as_winds() -> None:
    winds = np.array([8.0, 9.0, 10.0])
    some = dict.fromkeys(("gain", "phase", "delay", "disk"), np.array([2.0, np.inf, np.nan]))
    drawn = running_margins_figure(winds, [MarginLine("torque", some, some)])
    assert len(drawn.axes) == 4
    with pytest.raises(ModelError, match="torque, gain"):
        running_margins_figure(winds[:2], [MarginLine("torque", some, some)])


# --- what is refused -----------------------------------------------------------------------------


def test_slow_sampling_is_refused_with_what_fits() -> None:
    with pytest.raises(
        ModelError, match=r"torsion mode has a period.*sample at least every 0\.1 s"
    ):
        running_margins(
            RunningLoops.of(
                nrel5mw(), law_with(5.0), swinging()[1], speed_filter=8.0, sample_time=0.2
            ),
            [12.0],
        )


def test_a_stalled_rotor_is_refused_with_its_wind(monkeypatch: pytest.MonkeyPatch) -> None:
    def stalled(*_: object) -> tuple[float, float, float]:
        return 0.0, 0.0, -1e4

    monkeypatch.setattr(running_loop, "rotor_torque_gradient", stalled)
    with pytest.raises(ModelError, match=r"at 9 m/s more wind gives no more torque.*set-point"):
        loops = RunningLoops.of(nrel5mw(), law_with(5.0), swinging()[1], speed_filter=8.0)
        running_margins(loops, [9.0])


def test_a_rest_that_newton_runs_away_from_is_found_by_following_the_motion() -> None:
    """x' = -atan x: Newton's steps from 3 grow; a loop that has no rest is told so."""

    def moving(s: Floats) -> Floats:
        return np.array([-np.arctan(s[0]), -s[1]])

    def found(move: Any, times: Floats) -> Floats | None:
        return running_loop._at_rest(move, np.array([3.0, 0.2]), np.ones(2), times, (0.0, 1.0))

    assert found(moving, running_loop.NEWTON) is None
    rest = found(moving, running_loop.PATIENT)
    assert rest is not None and rest == pytest.approx([0.0, 0.0], abs=1e-8)
    assert found(lambda s: np.array([1.0, -s[1]]), running_loop.PATIENT) is None


def test_unknown_wake_is_refused() -> None:
    with pytest.raises(ModelError, match="wake 'still' is not known"):
        linearised_loop(
            plant(), SampledLaw(law_with(5.0), PERIOD), swinging()[1], 9.0, wake="still"
        )


def least(rows: Iterable[RunningMargins]) -> list[float]:
    loops = [margins for row in rows for _, margins in row.loops]
    return [
        min(one.phase for one in loops),
        min(one.delay for one in loops),
        min(one.disk.alpha for one in loops),
        min(one.gain_increase for one in loops),
    ]


@pytest.mark.slow
def test_a_margin_that_is_least_where_pitch_begins_to_act_is_found() -> None:
    """IEA 15-MW: 29.3 deg at 10.8 m/s, between whole winds, where the nominal has 58 deg."""
    turbine = load_turbine("iea15mw")
    settings = default_settings(turbine)
    law = wind_by_wind_law(turbine, settings)[1]
    observer = wind_observer_design(turbine, settings).observer
    around = replace(turbine, cut_in=10.4, cut_out=12.4)

    loops = RunningLoops.of(around, law, observer, speed_filter=speed_filter(settings))
    found = searched_margins(loops)

    assert math.degrees(least(found.rows)[0]) == pytest.approx(29.3, abs=0.1)
    assert 10.8 in found.least


@pytest.mark.slow
def test_no_plant_has_a_smaller_margin_between_the_winds_that_are_searched() -> None:
    """All seven plants at every 0.2 m/s: the search, which looks at fewer, has their least."""
    cut = (10.4, 12.4)
    turbine = replace(nrel5mw(), cut_in=cut[0], cut_out=cut[1])
    stated = json.loads(LAW.read_text(encoding="utf-8"))["observer"]
    observer = WindObserver(nrel5mw(), float(stated["l1"]), float(stated["l2"]))
    law = replace(effort_sharing_law_from_data(read_law(LAW)), wind_filter=12.0)

    loops = RunningLoops.of(turbine, law, observer, speed_filter=8.0)
    found = searched_margins(loops)
    every = running_margins(loops, winds_between(*cut, 0.2))

    assert least(found.rows) == pytest.approx(least(every), rel=1e-9)
    assert len(found.rows) < len(every)
