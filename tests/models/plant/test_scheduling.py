"""[scheduling]: signals from outside that stand in coefficients alone."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.models import Interval, ModelError, Plant, TSModel, Variable, load_model, sector_model

WING = """
format = 1
kind = "plant"
name = "wing section"

[states]
a = { unit = "rad", range = [-0.5, 0.5] }
p = { unit = "rad/s" }

[inputs]
flap = { unit = "rad" }

[disturbances]
gust = { unit = "rad/s^2", range = [-1, 1] }

[scheduling]
q = { unit = "Pa", range = [100, 400], rest = 200, description = "dynamic pressure" }

[parameters]
J = { value = 2.0, unit = "kg m^2" }
k = { value = 3.0, unit = "m^3/rad" }

[equations]
a = "p"
p = "-q*k*sin(a)/J + q*k*flap/(2*J) + gust"

[outputs]
load = { expression = "q*k*a", unit = "N m" }
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "wing.toml"
    path.write_text(text, encoding="utf-8")
    return path


def wing(folder: Path, text: str = WING) -> tuple[Plant, TSModel]:
    plant = load_model(written(folder, text))
    assert isinstance(plant, Plant)
    return plant, sector_model(plant)


def test_it_is_a_disturbance_that_schedules(tmp_path: Path) -> None:
    """Listed last among the disturbances, with a column of E that is 0."""
    plant, model = wing(tmp_path)

    assert [(v.name, v.schedules) for v in plant.disturbances] == [("gust", False), ("q", True)]
    assert model.disturbances == ("gust [rad/s^2]", "delta_q [Pa]")
    np.testing.assert_array_equal(model.E, np.broadcast_to([[0, 0], [1, 0]], model.E.shape))


@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.floats(-0.5, 0.5), st.floats(100, 400), st.floats(-1, 1))
def test_matrices_depend_on_it(
    tmp_path_factory: pytest.TempPathFactory, a: float, q: float, flap: float
) -> None:
    """A, B and C at any point of the box are the plant's coefficients."""
    plant, model = wing(tmp_path_factory.mktemp("wing"))
    values = {"a": a, "p": 0.3, "flap": flap, "gust": 0.0, "delta_q": q - 200}
    now = model.blend(model.premise_values(**values))
    rate = float(-q * 3 * np.sin(a) / 2 + q * 3 * flap / 4)

    x = np.array([a, 0.3])
    assert float((now.A @ x + now.B[:, 0] * flap)[1]) == pytest.approx(rate, rel=1e-9, abs=1e-9)
    assert float((now.C @ x)[0]) == pytest.approx(3 * q * a, rel=1e-9, abs=1e-9)


def test_what_enters_linearly_is_told_apart(tmp_path: Path) -> None:
    """The same signal among the disturbances: w x is then its own column, x w, in E."""
    text = WING.replace("[scheduling]\n", "").replace('"q*k*a"', '"a"')
    _, model = wing(tmp_path, text.replace('unit = "N m"', 'unit = "rad"'))

    assert np.any(model.E[:, 1, 1] != 0)


def test_without_a_rest_it_is_counted_from_the_middle_of_its_range(tmp_path: Path) -> None:
    """No rest of the plant needs one: [100, 400] Pa is 250 +- 150 Pa."""
    plant, model = wing(tmp_path, WING.replace("rest = 200, ", ""))

    assert plant.disturbances[-1].rest == 250
    assert model.box["delta_q [Pa]"] == (Fraction(-150), Fraction(150))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("range = [100, 400], ", "", r"wing.toml:17: field 'scheduling.q': q has no range"),
        ("q = {", "gust = {", r"scheduling.gust.*in \[disturbances\] already"),
        ("+ gust", "+ gust + q*k/J", "at rest .*q = 200.*not 0"),
        ("rest = 200, ", "rest = 50, ", "q rests at 50 .*, outside its range"),
        ("[scheduling]", "[schedule]", "schedule.* is not known.*did you mean 'scheduling'"),
    ],
)
def test_misuse(old: str, new: str, words: str, tmp_path: Path) -> None:
    """Told with the place and what to do."""
    assert old in WING

    with pytest.raises(ModelError, match=f"(?s){words}"):
        wing(tmp_path, WING.replace(old, new, 1))


def test_only_a_disturbance_with_a_range_may_schedule() -> None:
    """In Python, where no section says so."""
    x, w = sp.symbols("x w", real=True)
    side = Interval(Fraction(-1), Fraction(1))
    with pytest.raises(ModelError, match="x .* schedules, but it is a state"):
        Plant(equations=(-x,), states=(Variable(x, range=side, schedules=True),))
    with pytest.raises(ModelError, match="w .* schedules and has no range"):
        Plant(
            equations=(-w * x,),
            states=(Variable(x),),
            disturbances=(Variable(w, schedules=True),),
        )


def test_a_term_that_no_state_carries_is_refused() -> None:
    """x' = w - x with w as a schedule: it moves the equilibrium, which no coefficient can."""
    x, w = sp.symbols("x w", real=True)
    signal = Variable(w, range=Interval(Fraction(-1), Fraction(1)), schedules=True)
    plant = Plant(equations=(w - x,), states=(Variable(x),), disturbances=(signal,))

    with pytest.raises(ModelError, match="w does not vanish with any state"):
        sector_model(plant)
