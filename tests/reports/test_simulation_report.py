"""The simulation's report: numbers against the records they come from, divergence, the files."""

from __future__ import annotations

import csv
import io
import json
import math
import pickle
from decimal import Decimal
from functools import cache, lru_cache
from itertools import product

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from takagi.models import ModelError, nrel5mw
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.laws.protocol import Command, Law, Measurement, SampledLaw
from takagi.models.laws.published.law import FilteredReferenceLaw, ReferenceFilter, switched_law
from takagi.models.simulation import equations
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import Diverged, History, simulate
from takagi.models.simulation.compiled_loop import CompiledLaw, simulate_compiled
from takagi.models.simulation.turbine_plant import (
    SimulatedTurbine,
    SpeedFilter,
    design_plant,
    validation_plant,
)
from takagi.models.simulation.wind import WindSeries, class_turbulence, step_wind
from takagi.models.turbine.trim import rated_wind
from takagi.models.turbine.wind_observer import WindObserver
from takagi.reports.code.controller_program import (
    Assignment,
    Constant,
    ControllerProgram,
    Kept,
    Name,
    Near,
    Number,
    Signal,
    Spline,
    Stage,
    Value,
    parsed,
)
from takagi.reports.code.run import ProgramRun
from takagi.reports.simulation.compiled_law import compiled_law, in_threads, instructions
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
from tests.models.test_coherent_law import gains
from tests.models.test_paper_law import make_law

TURBINE = nrel5mw()


class Wild:
    """A law whose state leaves all numbers at the first step."""

    name = "wild"
    state_names = ("state [-]",)

    def initial_state(self, wind: float) -> NDArray[np.float64]:
        return np.zeros(1)

    def command(self, state: ArrayLike, measurement: Measurement) -> Command:
        return Command(TURBINE.rated_torque, 0.0)

    def state_rate(self, state: ArrayLike, measurement: Measurement) -> NDArray[np.float64]:
        return np.array([np.inf])


@lru_cache(maxsize=1)
def baseline() -> Simulation:
    """The reference's own controller in the paper's winds, for 30 s."""
    winds = requested_winds(TURBINE, duration=30.0)
    return run_simulation(TURBINE, chosen_laws(TURBINE, ["baseline"]), winds)


@lru_cache(maxsize=1)
def broken() -> Simulation:
    chosen = ChosenLaws({"wild": Wild(), "baseline": BaselineLaw(TURBINE)}, None)
    winds = requested_winds(TURBINE, ["ramp"], duration=5.0)
    return run_simulation(TURBINE, chosen, winds)


def record(simulation: Simulation, index: int) -> History:
    history = simulation.runs[index].history
    assert history is not None
    return history


def test_table_json_and_csv_say_the_same() -> None:
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
    history = record(baseline(), 2)
    lines = list(csv.reader(io.StringIO(series_csv(history))))

    assert lines[0][3] == "rotor speed [rad/s]"
    assert len(lines) == 1 + 301
    assert float(lines[-1][0]) == pytest.approx(30.0)
    assert float(lines[-1][3]) == pytest.approx(history.rotor_speed[-1], rel=1e-6)


def test_divergence_is_told_and_the_others_are_shown() -> None:
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
    end = pickle.loads(pickle.dumps(Diverged("wild", "ramp", 0.5)))

    assert str(end) == str(Diverged("wild", "ramp", 0.5))
    assert end.time == 0.5


def test_a_run_that_leaves_the_tables_says_when() -> None:
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
    for run in (*simulation.runs, *baseline().runs):
        assert run.metrics is not None
        assert ("runaway" in " ".join(run.remarks())) == (run.metrics.overspeed > 20)


@pytest.mark.parametrize("name", [name for name in FORMS if FORMS[name].alone])
def test_words_alone_have_winds_across_rated_wind(name: str) -> None:
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


OBSERVER = WindObserver(TURBINE, 3.0, 9.0)
# Of the largest value of a series; the order of operations differs, and torque reacts stiffly.
CLOSE = 1e-9
SERIES = (
    *("rotor_speed", "pitch", "pitch_rate", "torque", "torque_command", "pitch_reference"),
    *("wind", "wind_estimate", "tower_moment", "electrical_power", "thrust", "time", "flags"),
)


def effort_law(wind_filter: float) -> EffortSharingLaw:
    schedule = effort_schedule(TURBINE)
    return EffortSharingLaw.of(TURBINE, schedule, gains(schedule), wind_filter=wind_filter)


@cache
def law(name: str) -> Law:
    if name.startswith("effort"):
        return effort_law(0.0 if name.endswith("unfiltered") else 4.0)
    if name == "baseline":
        return BaselineLaw(TURBINE)
    return make_law() if name == "schulte" else switched_law(make_law())


LAWS = ("effort", "effort, unfiltered", "schulte", "switched", "baseline")


def turbulence(duration: float = 20.0) -> WindSeries:
    return class_turbulence(11.4, duration, 3, rotor_radius=63.0, hub_height=90.0)


def both(
    plant: SimulatedTurbine, name: str, wind: WindSeries, *, observed: bool = True, late: float = 0
) -> tuple[History, History]:
    observer = OBSERVER if observed and name != "baseline" else None
    compiled = compiled_law(TURBINE, law(name), observer)
    assert compiled is not None
    period = 0.04 if late else 0.02
    return (
        simulate_compiled(plant, compiled, wind, sample_time=period, computation_time=late),
        simulate(plant, SampledLaw(law(name), period, late), wind, observer=observer),
    )


def require_same(fast: History, slow: History) -> None:
    for name in SERIES:
        wanted = getattr(slow, name)
        scale = max(float(np.abs(wanted).max()), 1e-3)
        assert getattr(fast, name) / scale == pytest.approx(wanted / scale, abs=CLOSE), name
    width = fast.law_states.shape[1]
    assert fast.law_states == pytest.approx(slow.law_states[:, :width], rel=CLOSE, abs=CLOSE)


@pytest.mark.parametrize(
    ("name", "late"),
    [
        *((name, 0.02) for name in LAWS),
        ("effort", 0.0),
        ("effort", 0.04),
        *(
            pytest.param(name, late, marks=pytest.mark.slow)
            for name in LAWS[1:]
            for late in (0.0, 0.04)
        ),
    ],
)
def test_the_compiled_loop_is_the_loop_in_python(name: str, late: float) -> None:
    plant = validation_plant(TURBINE, ripple=0.01, speed_filter=SpeedFilter(30.0, 9.3))
    fast, slow = both(plant, name, turbulence(), late=late)

    require_same(fast, slow)
    # The wind moves the loop, so that the two are no two rests.
    assert np.ptp(slow.rotor_speed) > 0.01


@pytest.mark.parametrize("name", LAWS)
def test_a_step_on_the_stiff_plant_with_the_true_wind(name: str) -> None:
    fast, slow = both(design_plant(TURBINE), name, step_wind(9.0, 14.0, 12.0, begin=2.0),
                      observed=False)  # fmt: skip

    require_same(fast, slow)
    assert fast.wind_estimate == pytest.approx(fast.wind)


def test_both_loops_end_where_they_leave_all_numbers() -> None:
    """An observer whose Euler step is unstable by far: 0.02 s times 1e300 / s."""
    wild, wind = WindObserver(TURBINE, 1e300, 9.0), turbulence(2.0)
    compiled = compiled_law(TURBINE, law("effort"), wild)
    assert compiled is not None
    plant = design_plant(TURBINE)
    with pytest.raises(Diverged) as fast:
        simulate_compiled(plant, compiled, wind, sample_time=0.02)
    with np.errstate(over="ignore", invalid="ignore"), pytest.raises(Diverged) as slow:
        simulate(plant, SampledLaw(law("effort"), 0.02), wind, observer=wild)

    assert fast.value.time <= slow.value.time + 0.1
    assert "'coherent'" in str(fast.value)


def test_laws_without_a_program_are_left_to_python() -> None:
    """A reference filter, which gain files cannot express, and any other Python object."""

    class Mine(BaselineLaw):
        pass

    filtered = FilteredReferenceLaw(make_law(), ReferenceFilter(2.0))
    assert compiled_law(TURBINE, filtered, OBSERVER) is None
    assert compiled_law(TURBINE, Mine(TURBINE), OBSERVER) is None


def test_a_program_of_another_law_is_refused() -> None:
    """It keeps the states of an observer too, and there is none to start them."""
    other = compiled_law(TURBINE, law("effort"), OBSERVER)
    assert other is not None
    mixed = CompiledLaw(law("effort"), None, other.program)
    with pytest.raises(ModelError, match="keeps 4 values and it has 2 states"):
        simulate_compiled(validation_plant(TURBINE), mixed, turbulence(1.0), sample_time=0.02)


def test_threads_give_each_case_its_own_result() -> None:
    compiled, plant = compiled_law(TURBINE, law("effort"), OBSERVER), validation_plant(TURBINE)
    assert compiled is not None

    def end(duration: float) -> float:
        history = simulate_compiled(plant, compiled, turbulence(duration), sample_time=0.02)
        return float(history.rotor_speed[-1])

    durations = (30.0, 2.0, 11.0, 3.0)
    together = in_threads([lambda d=d: end(d) for d in durations], workers=3)  # type: ignore[misc]

    assert list(together) == [end(duration) for duration in durations]


# ------------------------------------------------------------------ the machine

ROWS = {
    "nodes": (Decimal(-2), Decimal(0), Decimal("0.5"), Decimal(3)),
    "values": (Decimal(1), Decimal(4), Decimal(-2), Decimal(7)),
    "weighed": (Decimal(3), Decimal(-5), Decimal(11), Decimal("0.5")),
}
KNOTS = tuple(Decimal(k) for k in (-2, -2, -2, -2, -1, 1, 3, 3, 3, 3))
RULES = tuple((Decimal(a), Decimal(b)) for a, b in product((0, 1), repeat=2))
FORMULAS = (
    *("speed + pitch*wind_estimate/(2 + sample_time)", "-speed^2", "2^pitch^2", "abs(pitch)^0.5"),
    *("min(speed, pitch)", "max(speed, pitch)", "limit(speed, -1, pitch)", "limit(speed, 1, -1)"),
    *("choose(pitch, speed, 3)", "choose(0, speed, 3)", "first(nodes) - last(values)*pi"),
    *("line(speed, nodes, values)", "slope(speed, nodes, values)", "hold(speed, nodes, values)"),
    *("spline(speed, curve)", "spline(speed, pitch, surface)"),
    *("mix(rules, weighed, pitch, speed)", "mix(rules, weighed, pitch, 1 - speed)"),
    *(f"{name}(speed/4)" for name in ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh",
                                      "tanh", "asinh", "atanh", "erf", "exp")),
    *(f"{name}(2 + speed/4 + 1)" for name in ("log", "sqrt", "acosh")),
)  # fmt: skip


def machine(formula: str, near: tuple[Near, ...] = ()) -> ControllerProgram:
    draw = np.random.default_rng(7)
    coefficients = draw.uniform(-1, 1, (6, 6)).round(3).tolist()
    rows = tuple(tuple(Decimal(str(c)) for c in row) for row in coefficients)
    constants: dict[str, Value] = {
        **ROWS,
        "rules": RULES,
        "curve": Spline((KNOTS,), rows[:1]),
        "surface": Spline((KNOTS, KNOTS), rows),
    }
    stage = Stage(
        "law",
        kept=(
            Kept("last", "-", "", Number(Decimal(0)), Name("torque")),
            Kept("older", "-", "", Number(Decimal(0)), parsed("last + torque_sent*sample_time")),
        ),
        steps=(Assignment("result", "-", "", parsed(formula), near),),
        sends=(
            Assignment("torque", "N m", "", parsed("result + last/8 + older/64")),
            Assignment("pitch_reference", "rad", "", Number(Decimal("0.1"))),
        ),
    )
    inputs = ("speed", "pitch", "wind_estimate", "torque_sent")
    return ControllerProgram(
        name="machine", plant="none", kind="turbine", sample_time=None,
        constants=tuple(Constant(k, "-", k, value) for k, value in constants.items()),
        inputs=tuple(Signal(name, "-", "") for name in inputs),
        outputs=(Signal("torque", "N m", ""),), stages=(stage,), verdict="", hashes={}, document={},
    )  # fmt: skip


def executed(program: ControllerProgram, samples: list[dict[str, float]]) -> list[float]:
    code = instructions(program)
    memory, sent = code.memory.copy(), []
    for given in samples:
        values = (given["speed"], given["pitch"], given["wind_estimate"], 0.25)
        memory[code.inputs] = (*values, given["torque_sent"])
        equations.execute(code.outputs, memory, code.tables)
        sent.append(float(memory[code.commands[0]]))
        equations.execute(code.following, memory, code.tables)
        memory[code.kept] = memory[code.after]
    return sent


@pytest.mark.parametrize("formula", FORMULAS)
def test_each_function_of_the_language(formula: str) -> None:
    program, run = machine(formula), None
    points = [-2.5, -2.0, -1.25, 0.0, 0.25, 0.5, 1.0, 2.5, 3.0, 3.5]
    samples = [
        {"speed": x, "pitch": y, "wind_estimate": 7.0, "torque_sent": x * y}
        for x, y in product(points, (-1.5, 0.0, 0.75))
    ]
    run = ProgramRun(program)
    wanted = [run.sample(0.25, given)["torque"] for given in samples]

    assert executed(program, samples) == pytest.approx(wanted, rel=1e-12, abs=1e-12)


def test_a_quotient_near_its_hole_is_replaced() -> None:
    """sin(x)/x at 0, where the step's own formula is 0/0."""
    hole = Near(Name("speed"), Decimal("1e-6"), parsed("1 - speed^2/6"))
    samples = [
        {"speed": x, "pitch": 0.0, "wind_estimate": 7.0, "torque_sent": 0.0} for x in (0.0, 0.5)
    ]
    first, second = executed(machine("sin(speed)/speed", (hole,)), samples)

    assert first == 1.0
    assert second == pytest.approx(math.sin(0.5) / 0.5 + 1.0 / 8, rel=1e-12)


def test_a_name_that_nothing_sets_is_refused() -> None:
    with pytest.raises(ModelError, match="'temperature'"):
        instructions(machine("speed*temperature"))
