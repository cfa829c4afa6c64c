"""Signals of a plant file: what schedules, what is uncertain, and what is measured."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.models import (
    Interval,
    ModelError,
    Output,
    Plant,
    TSModel,
    Variable,
    load_model,
    sector_model,
)
from takagi.models.plant_files.loader import load_plant
from tests.plant_files import filed_plant

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


@settings(max_examples=12)
@given(st.floats(-0.5, 0.5), st.floats(100, 400), st.floats(-1, 1))
def test_matrices_depend_on_it(
    tmp_path_factory: pytest.TempPathFactory, a: float, q: float, flap: float
) -> None:
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
    assert old in WING

    with pytest.raises(ModelError, match=f"(?s){words}"):
        wing(tmp_path, WING.replace(old, new, 1))


def test_only_a_disturbance_with_a_range_may_schedule() -> None:
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


SPRING = """
format = 1
kind = "plant"
name = "cart"

[states]
x = { unit = "m", range = [-1, 1] }
v = { unit = "m/s", range = [-3, 3] }

[inputs]
F = { unit = "N", range = [-20, 20] }

[parameters]
m = "[900, 1100] g"
k = { range = [4, 6], value = 4.5, unit = "N/m", source = "measured" }
c = { value = "tau*k", unit = "kg/s" }
tau = { value = 0.1, unit = "s" }

[equations]
x = "v"
v = "(F - k*x - c*v)/m"
"""


def cart(folder: Path, *changes: tuple[str, str]) -> Plant:
    text = SPRING
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return filed_plant(folder, text, "cart.toml")


def test_it_is_a_signal_that_no_law_knows(tmp_path: Path) -> None:
    plant = cart(tmp_path)
    mass, stiffness = plant.uncertain

    assert (mass.name, mass.unit, mass.rest) == ("m", "kg", Fraction(1))
    assert mass.range is not None
    assert (mass.range.lower, mass.range.upper) == (Fraction(9, 10), Fraction(11, 10))
    assert (stiffness.rest, stiffness.description) == (
        Fraction(9, 2),
        "uncertain parameter: measured",
    )
    assert [p.symbol.name for p in plant.parameters] == ["tau"]
    v, k, tau = (sp.Symbol(name, real=True) for name in ("v", "k", "tau"))
    assert sp.expand(plant.equations[1] * sp.Symbol("m", real=True)).coeff(v) == -k * tau


def test_the_ways_of_writing_one_are_equal(tmp_path: Path) -> None:
    table = ('"[900, 1100] g"', '{ range = [0.9, 1.1], unit = "kg" }')
    assert cart(tmp_path) == cart(tmp_path, table)

    bare = cart(tmp_path, ("tau = { value = 0.1,", "tau = { range = [0.1, 0.2],"))
    assert [v.name for v in bare.uncertain] == ["m", "k", "tau"]


def test_the_model_is_the_plant_for_every_value(tmp_path: Path) -> None:
    """Corners and random values of m and k: the blend gives (F - k x - k v/10)/m."""
    model = sector_model(cart(tmp_path))
    draw = np.random.default_rng(1)
    for _ in range(50):
        x, v, F = draw.uniform([-1, -3, -20], [1, 3, 20])
        m, k = draw.choice([0.9, 1.0, 1.1]), draw.choice([4.0, 4.7, 6.0])
        z = model.premise_values(x=x, v=v, F=F, delta_m=m - 1, delta_k=k - 4.5)
        now = model.blend(z)
        moved = now.A @ [x, v] + now.B @ [F]
        assert moved == pytest.approx([v, (F - k * x - 0.1 * k * v) / m], abs=1e-9)
    assert not np.any(model.E)


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("[900, 1100]", "[1100, 900]", "parameters.m.range", "smaller end first"),
        ("[900, 1100]", "[900, 900]", "parameters.m.range", "has no width"),
        ("[900, 1100]", "[-900, 1100]", "parameters.m.range", "divides by m, which may be 0"),
        ("value = 4.5", "value = 7", "parameters.k.value", "outside the range [4, 6] N/m"),
        ("value = 4.5", 'value = "tau"', "parameters.k.value", "a range of its own"),
        ("value = 4.5,", "vague = 1,", "parameters.k.vague", "is not known"),
        ("range = [4, 6], value = 4.5,", "", "parameters.k.value", "is missing"),
        ("[900, 1100] g", "[900, 1100] furlong", "parameters.m.unit", "not known"),
        ("value = 0.1, unit", 'value = "c/k", unit', "parameters.c", "depends on itself"),
        ('"tau*k", unit = "kg/s"', '"tau*k", unit = "kg"', "parameters.c", "correct one"),
    ],
)
def test_a_wrong_one_is_refused_at_its_place(
    tmp_path: Path, old: str, new: str, place: str, words: str
) -> None:
    with pytest.raises(ModelError) as caught:
        cart(tmp_path, (old, new))
    assert f"field '{place}'" in str(caught.value)
    assert words in str(caught.value)


def test_a_rest_that_is_given_by_one_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="moves with k, m, which is known within a range only"):
        cart(tmp_path, ("x = { unit", 'x = { rest = "tau^2*k/m*x0", unit'),
             ("tau = {", 'x0 = { value = 1, unit = "m" }\ntau = {'))  # fmt: skip


def test_a_rest_that_moves_with_one_is_refused(tmp_path: Path) -> None:
    """F = m g holds the mass: at 0.9 and 1.1 kg 1.09 and -0.892 m/s^2 are left."""
    plant = cart(
        tmp_path,
        ("- c*v)/m", "- c*v)/m - g"),
        ("tau = {", 'g = { value = 9.81, unit = "m/s^2" }\ntau = {'),
        ("range = [-20, 20]", "range = [-20, 20], rest = 9.81"),
    )
    with pytest.raises(ModelError, match=r"moves with the uncertain m: .* 1\.09 at m = 0\.9 and"):
        sector_model(plant)


def test_two_masses_of_wie_and_bernstein() -> None:
    """Problem 1: x1'' = u - k (x1 - x2), x2'' = k (x1 - x2), 0.5 < k < 2: poles 0, 0, +-i sqrt(2k).

    Wie and Bernstein (1992), J. Guidance, Control, and Dynamics 15(5), 1057-1059.
    """
    plant = load_model("two_mass_spring")
    assert isinstance(plant, Plant)
    model = sector_model(plant)
    frequencies = [np.abs(np.linalg.eigvals(A).imag).max() for A in model.A]

    assert frequencies == pytest.approx([1.0, 2.0], abs=1e-6)
    assert model.B[:, :, 0] == pytest.approx(np.array([[0, 0, 1, 0]] * 2))
    assert float(plant.uncertain[0].rest) == 1


TEXT = """
format = 1
kind = "plant"
{measured}
[states]
theta = {{ unit = "rad", range = [-1, 1] }}
omega = {{ unit = "rad/s", range = [-4, 4] }}
[inputs]
tau = {{ unit = "rad/s^2" }}
[disturbances]
w = {{ unit = "rad/s^2" }}
[parameters]
l = {{ value = 500, unit = "mm" }}
g = {{ value = 20, unit = "rad/s^2" }}
[equations]
theta = "omega"
omega = "g*sin(theta) + tau + w"
[outputs]
height = {{ expression = "l*cos(theta)", unit = "m" }}
omega = {{ expression = "2*omega", unit = "rad/s" }}
"""


def read(folder: Path, measured: str) -> tuple[tuple[str, ...] | None, dict[str, Output]]:
    """Return what is measured of the plant with this line, and its outputs."""
    path = folder / "pendulum.toml"
    path.write_text(TEXT.format(measured=measured), encoding="utf-8")
    plant = load_plant(path)
    return plant.measured, {y.name: y for y in plant.outputs}


def test_a_state_gets_an_output_of_its_name(tmp_path: Path) -> None:
    measured, outputs = read(tmp_path, 'measured = ["theta"]')

    assert measured == ("theta",)
    assert outputs["theta"] == Output("theta", sp.Symbol("theta", real=True), "rad")
    assert set(outputs) == {"height", "omega", "theta"}


def test_an_output_is_measured_by_its_name(tmp_path: Path) -> None:
    assert read(tmp_path, 'measured = ["height"]')[0] == ("height",)


def test_an_expression_has_a_name_and_a_unit(tmp_path: Path) -> None:
    line = 'measured = ["theta", { name = "place", expression = "l*sin(theta)", unit = "m" }]'
    measured, outputs = read(tmp_path, line)

    theta, length = sp.symbols("theta l", real=True)
    assert measured == ("theta", "place")
    assert outputs["place"] == Output("place", length * sp.sin(theta), "m")


def test_without_it_all_states_are_known(tmp_path: Path) -> None:
    assert read(tmp_path, "")[0] is None


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('["thta"]', "neither an output nor a state .did you mean 'theta'"),
        ("[]", "nothing is measured"),
        ('["theta", "theta"]', "twice"),
        ('"theta"', "a list is needed"),
        ("[3]", "a name in quotes"),
        ('["g"]', "neither an output nor a state"),
        ('["tau"]', "neither an output nor a state"),
        ('["omega"]', "a state and another output"),
        ('[{ name = "theta", unit = "rad" }]', "a unit of its own"),
        ('[{ name = "theta", expression = "theta", unit = "rad" }]', "a meaning already"),
        ('[{ name = "y", expression = "w", unit = "rad/s^2" }]', "comes from outside"),
        ('[{ name = "y", expression = "l*thta", unit = "m" }]', "thta"),
        ('[{ name = "y", expression = "l*theta", unit = "rad" }]', "has the unit"),
        ('[{ name = "y", expression = "l*theta", unit = "mm" }]', "write 'm'"),
        ('[{ name = "y", expresion = "l*theta", unit = "m" }]', "expression"),
    ],
)
def test_what_is_refused_names_place_reason_and_cure(tmp_path: Path, line: str, words: str) -> None:
    with pytest.raises(ModelError, match=words) as error:
        read(tmp_path, f"measured = {line}")

    assert "pendulum.toml" in str(error.value)
    assert "measured" in str(error.value)


def test_a_plant_without_inputs_measures_nothing(tmp_path: Path) -> None:
    path = tmp_path / "free.toml"
    text = TEXT.format(measured='measured = ["theta"]')
    path.write_text(text.replace('[inputs]\ntau = { unit = "rad/s^2" }\n', "").replace("+ tau", ""))
    with pytest.raises(ModelError, match="no input"):
        load_plant(path)
