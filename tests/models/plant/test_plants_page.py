"""What docs/plants.md says is what happens."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path

import pytest
import sympy as sp

from takagi.models import (
    Interval,
    ModelError,
    Output,
    Parameter,
    Plant,
    Variable,
    interpolate_curve,
    load_model,
    table_function,
)
from takagi.models.expressions.parser import FUNCTIONS
from takagi.models.files.units import parse_unit
from tests.docs_pages import fenced, text_of

PAGE = text_of("plants.md")


def pendulum_in_python() -> Plant:
    theta, omega, tau, m, length, g = (
        sp.Symbol(name, real=True) for name in ("theta", "omega", "tau", "m", "l", "g")
    )
    curve = interpolate_curve([-4, -2, 0, 2, 4], [-0.5, -0.3, 0, 0.3, 0.5])
    friction = table_function("friction", curve, unit="N m", argument_units=("rad/s",))
    return Plant(
        states=(
            Variable(
                theta,
                "rad",
                Interval.of("-1.047197551197", "1.047197551197"),
                description="angle from upright",
            ),
            Variable(omega, "rad/s", Interval.of(-4, 4), description="its rate"),
        ),
        inputs=(Variable(tau, "N m", description="torque of the motor"),),
        parameters=(
            Parameter(m, Fraction(2), "kg", "chosen"),
            Parameter(length, Fraction(1, 2), "m", "chosen"),
            Parameter(g, Fraction("9.81"), "m/s^2", "rounded"),
        ),
        equations=(
            omega,
            (m * g * length * sp.sin(theta) + tau - friction(omega)) / (m * length**2),
        ),
        outputs=(Output("angle", theta, "rad"),),
        units="checked",
        name="Pendulum with a motor",
        description="Inverted pendulum, motor at the joint, friction from a table",
        source="figures chosen for this page",
    )


def test_the_pages_example_is_read_and_equals_its_python_form(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "friction.csv").write_text(fenced(PAGE, "csv")[0], encoding="utf-8")
    (tmp_path / "pendulum.toml").write_text(fenced(PAGE, "toml")[0], encoding="utf-8")
    monkeypatch.chdir(tmp_path)

    assert pendulum_in_python() == load_model("pendulum.toml")


def test_the_pages_error_is_what_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "friction.csv").write_text(fenced(PAGE, "csv")[0], encoding="utf-8")
    wrong = fenced(PAGE, "toml")[0].replace("sin(theta)", "sin(thta)")
    (tmp_path / "pendulum.toml").write_text(wrong, encoding="utf-8")
    monkeypatch.chdir(tmp_path)

    with pytest.raises(ModelError) as caught:
        load_model("pendulum.toml")

    assert str(caught.value) == fenced(PAGE, "text")[0].rstrip()


def test_the_page_lists_functions_and_units_that_are_read() -> None:
    listed = re.findall(r"^- (kg, .*|g, t, .*)$", PAGE, flags=re.MULTILINE)

    assert set(FUNCTIONS) <= set(re.findall(r"\w+", PAGE))
    assert len(listed) == 2
    for name in ", ".join(listed).split(", "):
        assert parse_unit(name).text == name
