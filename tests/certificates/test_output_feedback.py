"""Designs of laws with measured outputs, and their motions in a simulation that is not takagi's."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import ModelError
from takagi.models.files.library import data_folder
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_files.loader import load_plant
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.gains_file.envelope import dump_gains, plant_gain_file
from takagi.reports.sections.plant.page import plant_report_files
from takagi.reports.sections.plant.summary import summary_rows
from takagi.reports.simulation.plant import simulate_plant, simulation_data
from tests.certificates.kinds.claims import resealed, verdicts
from tests.plant_files import filed_plant

FILE = data_folder() / "flexible_link.toml"
PENDULUM = """
format = 1
kind = "plant"
name = "Pendulum"
measured = ["theta"]
[states]
theta = { unit = "deg", range = [-60, 60] }
omega = { unit = "rad/s", range = [-4, 4] }
[inputs]
tau = { unit = "N m", range = [-15, 15] }
[parameters]
m = { value = 2.0, unit = "kg" }
l = { value = 0.5, unit = "m" }
g = { value = 9.81, unit = "m/s^2" }
[equations]
theta = "omega"
omega = "(m*g*l*sin(theta) + tau) / (m*l^2)"
"""


@cache
def link() -> PlantDesign:
    return done(load_plant(FILE))


def done(plant: Any, settings: PlantSettings | None = None) -> PlantDesign:
    found = design_plant(plant, settings)
    assert isinstance(found, PlantDesign), found
    return found


def pendulum(folder: Path, text: str = PENDULUM) -> Any:
    return filed_plant(folder, text, "pendulum.toml")


def test_the_design_is_proved() -> None:
    found = link()

    kinds = [claim["kind"] for claim in found.document["claims"]]
    assert kinds == ["sector-embedding", "slope-embedding", "observed-loop"]
    assert found.proved
    assert found.output_law is not None and found.output_law.at_estimate and found.law is None


def test_starts_at_the_edge_settle_in_another_simulation() -> None:
    """Plant from the TOML text, law from the certificate's numbers; neither by takagi's classes.

    The observer is written as f(xhat, u) + L (y - yhat), with f as the file has it.
    """
    document = link().document
    file = tomllib.loads(FILE.read_text(encoding="utf-8"))
    names = list(file["states"])
    f = _rates(file)
    K = np.resize(np.array(document["gains"]["K"], dtype=float), (2, 1, 4))  # one for all, or two
    L = np.array(document["gains"]["observer"]["L"], dtype=float)[0]
    (premise,) = document["gains"]["premises"]
    low, high = float(premise["lower"]), float(premise["upper"])
    claim = document["claims"][-1]
    P, level = np.array(claim["P"], dtype=float), float(claim["level"])
    n, seen = len(names), [names.index(name) for name in file["measured"]]
    ends = np.array([v["range"][1] for v in file["states"].values()])
    most = float(file["inputs"]["u"]["range"][1])

    def command(s: Any) -> float:
        z = np.sinc(s[2] / np.pi)
        h = (z - low) / (high - low)
        return float(-((1 - h) * K[0] + h * K[1])[0] @ s)

    def motion(_: float, both: Any) -> Any:
        plant, s = both[:n], both[n:]
        gap = plant[seen] - s[seen]
        push = command(s)
        return np.concatenate([f(plant, push), f(s, push) + L @ gap])

    known = np.zeros((n, n))
    known[seen, seen] = 1.0
    N = np.vstack([known, np.eye(n) - known])
    sizes, axes = np.linalg.eigh(N.T @ P @ N)
    for size, axis in zip(sizes, axes.T, strict=True):
        start = 0.999 * np.sqrt(level / size) * axis
        run = solve_ivp(
            motion, (0, 12), np.concatenate([start, known @ start]), rtol=1e-8, atol=1e-10
        )
        x, s = run.y[:n], run.y[n:]
        assert np.all(np.abs(x) <= ends[:, None]) and np.all(np.abs(s) <= ends[:, None])
        assert max(abs(command(one)) for one in s.T) <= most
        z = np.vstack([s, x - s])
        value = np.einsum("it,ij,jt->t", z, P, z) / level
        assert np.all(np.diff(value) <= 1e-6)
        alpha = float(claim["decay_rate"])
        assert np.all(value <= np.exp(-2 * alpha * run.t) + 1e-6)
        assert np.abs(x[:, -1]).max() < 0.02


def _rates(file: dict[str, Any]) -> Callable[[Any, float], Any]:
    values = {name: entry["value"] for name, entry in file["parameters"].items()}
    symbols = {name: sp.Symbol(name) for name in (*file["states"], *file["inputs"])}
    rows = [
        sp.sympify(text.replace("^", "**"), locals=symbols).subs(values)
        for text in file["equations"].values()
    ]
    compiled = sp.lambdify(list(symbols.values()), rows, "numpy")
    return lambda state, push: np.array(compiled(*state, push), dtype=float)


def test_program_and_law_are_the_same(tmp_path: Path) -> None:
    """One sample of the program is one step of Euler's method with the law's own rate."""
    found = link()
    law = found.output_law
    assert law is not None
    run = program_of(found, tmp_path)
    step = 0.003
    s = np.array([0.4, 0.0, 0.0, 0.0])
    rng = np.random.default_rng(5)
    for k in range(20):
        y = 0.4 if k == 0 else float(rng.uniform(-0.5, 0.5))
        sent = run.sample(step, {"tm_measured": y})
        u = law.feedback.input_rest + (law.command(s, [y]) - law.feedback.input_rest)
        assert sent["u"] == pytest.approx(float(np.clip(u[0], -20, 20)), rel=1e-9, abs=1e-12)
        s = s + step * law.following(s, [y], [sent["u"]])
        assert [run.kept[name] for name in ("tm", "wm", "tl", "wl")] == pytest.approx(list(s))


def program_of(found: PlantDesign, folder: Path) -> ProgramRun:
    path = folder / "gains.json"
    path.write_text(dump_gains(plant_gain_file(found)), encoding="utf-8")
    return ProgramRun(read_controller(path))


@pytest.mark.slow
def test_measured_premises_take_the_plants_own_weights(tmp_path: Path) -> None:
    """Angle measured, sin(theta)/theta is known; the set is that of the design with all states."""
    found = done(pendulum(tmp_path))

    kinds = [claim["kind"] for claim in found.document["claims"]]
    assert kinds == ["sector-embedding", "observed-loop"]
    assert found.proved and found.output_law is not None and not found.output_law.at_estimate
    runs = simulation_data(simulate_plant(found))["runs"]
    assert all(not run["diverged"] and not run["left_the_box"] for run in runs)
    assert all(run["settled_after"] is not None for run in runs)


def test_a_rate_and_a_limit_that_are_asked_for_are_proved(tmp_path: Path) -> None:
    found = done(pendulum(tmp_path), PlantSettings(decay_rate=1.5, input_limit={"tau": 14.0}))

    assert found.proved
    claim = found.document["claims"][-1]
    assert claim["decay_rate"] == 1.5 and claim["input_limits"] == [14.0]


@pytest.mark.slow
def test_an_expression_is_measured_with_an_input_in_it(tmp_path: Path) -> None:
    """An accelerometer: omega' by its formula, with the torque in it; and the angle."""
    line = (
        'measured = ["theta", { name = "a", '
        'expression = "(m*g*l*sin(theta) + tau)/(m*l^2)", unit = "rad/s^2" }]'
    )
    text = PENDULUM.replace('measured = ["theta"]', line)
    found = done(pendulum(tmp_path, text))

    assert found.proved
    law = found.output_law
    assert law is not None
    run = program_of(found, tmp_path)
    sent = run.sample(0.01, {"theta": 0.2, "a_measured": 3.0})
    s = np.array([0.2, 0.0])
    following = s + 0.01 * law.following(s, [0.2, 3.0], [sent["tau"]])
    kept = [run.kept[name] for name in ("theta_estimate", "omega_estimate")]
    assert kept == pytest.approx(list(following))


@pytest.mark.slow
def test_a_rest_that_is_not_zero(tmp_path: Path) -> None:
    """Held at 30 degrees by a torque: y* and u* are in program and law."""
    text = PENDULUM.replace(
        'theta = { unit = "deg", range = [-60, 60] }',
        'theta = { unit = "deg", range = [0, 60], rest = 30 }',
    ).replace("[-15, 15] }", '[-25, 10], rest = "solve" }')
    found = done(pendulum(tmp_path, text))

    assert found.proved
    runs = simulation_data(simulate_plant(found))["runs"]
    assert all(run["settled_after"] is not None and not run["left_the_box"] for run in runs)


def test_a_forged_observer_in_the_certificate_is_noticed() -> None:
    """L is a part of the law: its hash, and the inequality, go with it."""
    document: Any = deepcopy(link().document)
    document["gains"]["observer"]["L"][0][0][0] *= -1
    assert verdicts(resealed(document))[-1] == "UNDECIDED"


def test_what_no_output_shows_is_refused_at_once(tmp_path: Path) -> None:
    """Without gravity the angle is an integral of the rate, and no rate shows where it began."""
    text = PENDULUM.replace('["theta"]', '["omega"]').replace("m*g*l*sin(theta) + ", "")
    with pytest.raises(ModelError, match="shows in nothing that is measured") as error:
        design_plant(pendulum(tmp_path, text))

    assert "it moves theta" in str(error.value) and "measure one of theta too" in str(error.value)


@pytest.mark.slow
def test_with_gravity_the_rate_shows_the_angle(tmp_path: Path) -> None:
    """sin(theta) in omega' shows it; the premise is at the estimate."""
    found = done(pendulum(tmp_path, PENDULUM.replace('["theta"]', '["omega"]')))

    assert found.proved and found.output_law is not None and found.output_law.at_estimate


@pytest.mark.parametrize(
    ("settings", "word"),
    [
        (PlantSettings(damping=0.7), "damping"),
        (PlantSettings(sample_time=0.01), "sample_time"),
        (PlantSettings(initial={"theta": 0.1}), "initial"),
        (PlantSettings(gain_bound=10.0), "gain_bound"),
    ],
)
def test_wishes_that_are_not_proved_are_refused(
    tmp_path: Path, settings: PlantSettings, word: str
) -> None:
    with pytest.raises(ModelError, match=word):
        design_plant(pendulum(tmp_path), settings)


@pytest.mark.slow
def test_the_report_is_about_the_law_with_outputs() -> None:
    page = plant_report_files(link()).html

    rows = {row.name: row for row in summary_rows(link())}
    assert rows["input"].proved and rows["settles"].claim == "loop with the observer"
    assert "The law has tm exactly, without noise" in page
    assert "Gains L of the observer" in page and "whose projection onto the states" in page
    assert "The law knows the whole state exactly" not in page
    # Beside gains with an observer no regulator of all states is shown.
    assert not any(row.regulator for row in rows.values())
