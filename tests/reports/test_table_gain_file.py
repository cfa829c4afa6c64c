"""Plants with tables, from the file to the running law: proved, written in the file's language."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker.controller.content import file_content
from takagi.certificates.checker.controller.plant_program import with_splines
from takagi.certificates.checker.files.gain_file import compare_gains
from takagi.certificates.checker.kernel.reader import read_json
from takagi.certificates.checker.kernel.refusal import OtherGains
from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Plant, load_model
from takagi.models.plant.design_settings import PlantSettings
from takagi.reports.simulation.plant import simulate_plant
from tests.reports.test_gain_file_alone import controller, written

PENDULUM = """
format = 1
kind = "plant"
name = "pendulum with friction"

[states]
theta = { unit = "deg", range = [-60, 60] }
omega = { unit = "rad/s", range = [-4, 4] }

[inputs]
tau = { unit = "N m", range = [-20, 20] }

[parameters]
m = { value = 2.0, unit = "kg" }
l = { value = 500, unit = "mm" }
g = { value = 9.81, unit = "m/s^2" }

[tables]
friction = { file = "friction.csv", unit = "N m", arguments = [{ name = "w", unit = "rad/s" }] }

[equations]
theta = "omega"
omega = "(m*g*l*sin(theta) + tau - friction(omega)) / (m*l^2)"
"""
ODD = "-4, -0.5\n-2, -0.3\n0, 0.0\n2, 0.3\n4, 0.5\n"
# At rest the friction holds 0.05 N m, so that the premise is (friction(omega) - 0.05)/omega.
HELD = "-4, -0.5\n-2, -0.25\n0, 0.05\n2, 0.3\n4, 0.5\n"


@cache
def design(table: str) -> PlantDesign:
    text = PENDULUM if table == ODD else PENDULUM.replace("[-20, 20]", '[-20, 20], rest = "solve"')
    with TemporaryDirectory() as folder:
        (Path(folder) / "friction.csv").write_text(table, encoding="utf-8")
        path = Path(folder) / "pendulum.toml"
        path.write_text(text, encoding="utf-8")
        plant = load_model(path)
        assert isinstance(plant, Plant)

        def gains(model: Any) -> Any:
            low = [rule[0] for rule in model.rules]
            return np.array([[[20.0, 4.0]] if one else [[18.0, 3.0]] for one in low])

        return certify_plant(plant, gains, PlantSettings())


@pytest.mark.parametrize("table", [ODD, HELD], ids=["odd", "held"])
def test_the_plant_is_its_model_and_the_loop_is_proved(table: str) -> None:
    found = {c.name: c.verdict.name for c in design(table).checked.claims}

    assert found["pendulum with friction is its Takagi-Sugeno model"] == "PROVED"
    assert found["common quadratic decay of pendulum with friction"] == "PROVED"


@pytest.mark.parametrize("table", [ODD, HELD], ids=["odd", "held"])
def test_the_controller_of_the_page_gives_the_law(table: str, tmp_path: Path) -> None:
    """At states at, near and away from 0/0, to 1e-9 of the law of the model."""
    found = design(table)
    law, run = found.law, controller(written(dict(found.document), tmp_path))
    assert law is not None
    draw = np.random.default_rng(5)
    sizes = (0.0, 1e-13, 1e-9, 1e-6, 3.9e-4, 4.1e-4, 1e-2, 0.3, 1.0)
    for size in sizes:
        for _ in range(4):
            x = size * draw.uniform([-1, -4], [1, 4])
            sent = run.sample(0.01, theta=float(x[0]), omega=float(x[1]))["tau"]
            assert np.isfinite(sent)
            if size >= 1e-6:
                wanted = float(law.sent(x)[0])
                assert sent == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_every_premise_that_is_a_quotient_has_a_stand_in() -> None:
    """friction(omega)/omega has one cubic on each side of 0; for an odd table they are one."""
    for table, sides in ((ODD, 1), (HELD, 2)):
        near = design(table).document["controller"]["removable"]
        ((one,),) = [entries for entries in near.values() if entries[0]["of"] == "omega"]
        assert ("choose(" in one["formula"]) is (sides == 2)


def test_programs_call_tables_by_the_language(tmp_path: Path) -> None:
    path = written(dict(design(ODD).document), tmp_path)
    file = json.loads(path.read_text())
    formulas = [step["formula"] for step in file["programs"][0]["steps"]]

    assert "spline(omega, friction)/omega" in formulas
    assert not any("friction(" in formula for formula in formulas)
    assert "spline(x, S), spline(x, y, S)" in file["language"]


def test_a_gain_file_from_before_is_the_certificates_too(tmp_path: Path) -> None:
    document = dict(design(ODD).document)
    path = written(document, tmp_path)
    data = read_json(tmp_path / "certificate.json")
    assert "earlier" not in compare_gains(data, path)

    own = {**document["controller"]}
    earlier = file_content(document["model"], document["gains"], own, called=True)
    file = json.loads(path.read_text())
    file["programs"] = earlier["programs"]
    old = tmp_path / "old.json"
    old.write_text(json.dumps(file, default=str), encoding="utf-8")
    assert "calls tables by their names, as earlier files do" in compare_gains(data, old)

    old.write_text(
        old.read_text().replace("friction(omega)/omega", "friction(omega)/theta"), encoding="utf-8"
    )
    with pytest.raises(OtherGains):
        compare_gains(data, old)


@pytest.mark.parametrize(
    ("formula", "found"),
    [
        ("f(x)", "spline(x, f)"),
        ("2*f (x + g(y, 1)) - ff(x)", "2*spline(x + spline(y, 1, g), f) - ff(x)"),
        ("f(f(x))", "spline(spline(x, f), f)"),
        ("f + x.f(1)", "f + x.f(1)"),
    ],
)
def test_calls_become_splines(formula: str, found: str) -> None:
    assert with_splines(formula, ["f", "g"]) == found


K = np.array([[[40.0, 4.0, 1.5, 30.0]]])
STEP = 0.001


@cache
def servo() -> PlantDesign:
    plant = load_model("dc_servo")
    assert isinstance(plant, Plant)
    return certify_plant(plant, K, PlantSettings())


@cache
def run(target: float, end: float) -> Any:
    """The motor by small steps of Euler under the controller: time, states and voltage."""
    with TemporaryDirectory() as folder:
        law = controller(written(dict(servo().document), Path(folder)))
    x, rows = np.zeros(3), []
    for k in range(int(end / STEP)):
        sent = law.sample(STEP, theta=x[0], omega=x[1], i=x[2], target=target)
        V = sent["V"]
        rows.append([k * STEP, *x, V])
        rate = [x[1], (0.01 * x[2] - 0.1 * x[1]) / 0.01, (V - x[2] - 0.01 * x[1]) / 0.5]
        x = x + STEP * np.array(rate)
    return np.array(rows)


def test_the_controller_follows_as_the_simulation_does() -> None:
    """Theta after a jump to 0.2 rad, every half second, to a thousandth of the jump's size."""
    found = run(0.2, 5.0)
    motion = next(
        m
        for m in simulate_plant(
            servo(), starts=[], references=[{"target": 0.2}], duration=5.0
        ).motions
    )
    for time in np.arange(0.5, 5.0, 0.5):
        own = np.interp(time, found[:, 0], found[:, 1])
        assert own == pytest.approx(np.interp(time, motion.time, motion.state[:, 0]), abs=1e-3)
    assert found[-1, 1] == pytest.approx(0.2, abs=1e-2)


@pytest.mark.slow
def test_the_integral_stands_still_while_the_command_is_held() -> None:
    """A jump of 12 rad holds the voltage at 12 V; theta arrives without a turn too much."""
    found = run(12.0, 25.0)

    assert np.abs(found[:, 4]).max() == 12.0
    assert found[-1, 1] == pytest.approx(12.0, abs=0.05)
    assert found[:, 1].max() < 12.0 * 1.25


def test_the_law_in_the_file_says_what_follows_what() -> None:
    law = servo().document["gains"]

    assert law["references"] == [
        {"reference": "target", "integral": "target_integral", "follow": "theta"}
    ]
    assert len(law["K"]) == 1
    assert "premises" not in law
