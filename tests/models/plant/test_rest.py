"""Where a plant rests: solved inputs, and what is said where no rest is."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest
import sympy as sp

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Interval, ModelError, Plant, Variable, sector_model, solve_rest
from takagi.models.plant_files.loader import PlantFile

SQUARE = """
format = 1
kind = "plant"
units = "unchecked"
[states]
x = {{ range = [0.5, 1.5], rest = 1 }}
[inputs]
u = {{ range = {range} }}
[equations]
x = "{equation}"
[design]
rest = "solve inputs"
"""


def filed(path: Path, text: str) -> PlantFile:
    path.write_text(text, encoding="utf-8")
    return PlantFile.of(path)


@pytest.mark.parametrize("side", ["[0, 4]", "[-4, 2]", "[-1, 4]"])
def test_an_input_s_range_need_not_centre_on_its_solved_rest(tmp_path: Path, side: str) -> None:
    """x' = u - x^2 rests at x = 1 with u = 1: the law has the room about that."""
    file = filed(tmp_path / "square.toml", SQUARE.format(range=side, equation="u - x^2"))
    design = design_plant(file.model, file.settings)

    assert isinstance(design, PlantDesign)
    assert design.proved
    assert design.document["gains"]["trim"] == {"state": [1.0], "input": [1.0]}


def test_a_solved_input_outside_its_range_is_named(tmp_path: Path) -> None:
    file = filed(tmp_path / "far.toml", SQUARE.format(range="[-2, 2]", equation="u - 5*x^2"))
    with pytest.raises(ModelError, match=r"u \[-\] has to be 5 to hold .* outside its range"):
        sector_model(file.model, rest="solve inputs")


TWO = """
format = 1
kind = "plant"
[states]
q = { unit = "m", range = [0.5, 1.5], rest = 1 }
v = { unit = "m/s", range = [-1, 1], rest = 0.5 }
[inputs]
u = { unit = "m/s^2" }
[parameters]
k = { value = 2, unit = "1/s^2" }
p = { value = 1, unit = "m" }
c = { value = 1, unit = "m^2/s^2" }
[equations]
q = "v"
v = "u - k*q"
"""


def test_every_residual_is_listed_with_its_equation_and_unit(tmp_path: Path) -> None:
    file = filed(tmp_path / "two.toml", TWO)
    with pytest.raises(ModelError) as found:
        sector_model(file.model)

    told = str(found.value)
    assert "q' is 0.5 m per second, not 0; v' is -2 m/s per second, not 0" in told


def test_an_equation_without_a_value_at_rest_says_which_part(tmp_path: Path) -> None:
    pole = TWO.replace("u - k*q", "u - c/(q - p)")
    with pytest.raises(ModelError, match=r"q - 1 is 0, and the equation divides by it") as found:
        sector_model(filed(tmp_path / "pole.toml", pole).model)
    assert "zoo" not in str(found.value)

    root = TWO.replace("u - k*q", "u - k*p*sqrt(q/p - 2)")
    with pytest.raises(ModelError, match=r"is negative, and the equation takes its root"):
        sector_model(filed(tmp_path / "root.toml", root).model)


PARTS = """
format = 1
kind = "plant"
units = "unchecked"
[states]
x = { range = [0.5, 1.5], rest = REST }
[inputs]
u = { range = [0, 20], rest = INPUT }
[parameters]
a = "b + 1"
b = "c*2"
c = { value = THREE }
[equations]
x = "u - a*x^2"
"""


def parts(path: Path, rest: str = "1", given: str = '"solve"', three: str = "3") -> PlantFile:
    text = PARTS.replace("REST", rest).replace("INPUT", given).replace("THREE", three)
    return filed(path / "parts.toml", text)


def test_derived_parameters_are_exact_in_any_order(tmp_path: Path) -> None:
    plant = parts(tmp_path).model

    assert {p.symbol.name: p.value for p in plant.parameters} == {"a": 7, "b": 6, "c": 3}
    assert plant.inputs[0].rest == 7
    assert plant.inputs[0].within == 0
    assert parts(tmp_path, rest='"a/7"').model.states[0].rest == 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"three": '"a - 1"'}, r"parts.toml:10: field 'parameters.a': .* a -> b -> c -> a; give"),
        ({"three": '"1/(2 - 2)"'}, "parameters.c': .*division by zero"),
        ({"three": '"sqrt(-2)"'}, "takes a root or logarithm of what is negative"),
        ({"three": '"u"'}, "parameters.c': column 1: 'u' is not known"),
        ({"three": '"7"'}, "a number is needed, without quotes"),
        ({"three": "true"}, "a number without quotes, or an expression in quotes"),
        ({"rest": '"solve"'}, "the rests of x, u are to be found, but only 1 of the equations"),
        ({"rest": '"nowhere"'}, "states.x.rest': column 1: 'nowhere' is not known"),
        ({"rest": "{ close = 1 }"}, "write rest = { near = 350 }"),
        ({"rest": '{ near = "1" }'}, "a number is needed, without quotes"),
        ({"rest": "{ near = 9 }", "given": "7"}, r"x rests at 9, outside its range \[0.5, 1.5\]"),
        ({"rest": '"sqrt(2)*c"', "given": "7"}, "outside its range"),
        ({"rest": '"solve"', "given": "20"}, r"x = 1.69031 outside \[0.5, 1.5\]; widen"),
        ({"three": "9", "rest": "1.2"}, r"u = 27.36 outside \[0, 20\]; widen the ranges"),
    ],
)
def test_what_cannot_be_is_named_with_place_and_cure(
    tmp_path: Path, changes: dict[str, str], message: str
) -> None:
    with pytest.raises(ModelError, match=message) as found:
        sector_model(parts(tmp_path, **changes).model)
    assert not any(word in str(found.value) for word in ("zoo", "nan", "*I", "oo,"))


STEADY = """
format = 1
kind = "plant"
units = "unchecked"
[states]
x = { range = [-2, 2], rest = X }
y = { range = [-9, 9], rest = "solve" }
[inputs]
u = { range = [-5, 5], rest = U }
[equations]
x = "x^3 - x + u"
y = "x - y"
"""


def steady(path: Path, x: str, u: str) -> PlantFile:
    return filed(path / "steady.toml", STEADY.replace("= X", f"= {x}").replace("= U", f"= {u}"))


def test_several_rests_are_all_listed_and_one_is_chosen_near(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"several rests .*: x = .*; or x = .*; or x = .*; say"):
        sector_model(steady(tmp_path, '"solve"', "0").model)

    one = steady(tmp_path, "{ near = 0.9 }", "0").model
    assert all(v.rest == 1 and v.within == 0 for v in one.states)


def test_where_no_rest_exists_every_residual_is_listed(tmp_path: Path) -> None:
    text = STEADY.replace("x^3 - x + u", "x^2 + 1 + y - x").replace("= X", '= "solve"')
    with pytest.raises(ModelError, match=r"x' is .*, not 0.*no rest of x, y was found"):
        sector_model(filed(tmp_path / "none.toml", text.replace("= U", "= 0")).model)


def test_more_equations_than_values_are_refused(tmp_path: Path) -> None:
    """Both rows vanish at x = sqrt(2) alone, but a ball of one value cannot show both."""
    text = STEADY.replace("x^3 - x + u", "x^2 - 2").replace("x - y", "2*x^2 - 4 + y")
    text = text.replace("[-2, 2], rest = X", "[1, 2], rest = X").replace(
        'rest = "solve"', "rest = 0"
    )
    with pytest.raises(ModelError, match="more equations than values to find"):
        sector_model(
            filed(
                tmp_path / "both.toml", text.replace("= X", '= "solve"').replace("= U", "= 0")
            ).model
        )


def test_a_disturbance_rests_at_a_number(tmp_path: Path) -> None:
    text = PARTS.replace("REST", "1").replace("INPUT", '"solve"').replace("THREE", "3")
    text = text.replace("[parameters]", '[disturbances]\nw = { rest = "solve" }\n[parameters]')
    with pytest.raises(ModelError, match="no equation says where w rests"):
        sector_model(filed(tmp_path / "w.toml", text.replace('"u - a', '"w + u - a')).model)


def test_a_plant_in_python_has_its_rest_found() -> None:
    """x' = u - x^2, rest u = 2: x = sqrt(2), within 13 digits."""
    x, u = sp.symbols("x u", real=True)
    states = (Variable(x, range=Interval.of("0.5", 2), rest=Fraction(1)),)
    plant = Plant(equations=(u - x**2,), states=states, inputs=(Variable(u, rest=Fraction(2)),))

    for start in (None, 1.5):
        (found,) = solve_rest(plant, {x: start}).states
        assert abs(float(found.rest) - 2**0.5) < 1e-15
        assert found.within == Fraction(1, 10**13)
    with pytest.raises(ModelError, match="only states and inputs rest where"):
        solve_rest(plant, {sp.Symbol("y"): None})
