"""Plant files: the same plant in TOML and in Python, and what is refused with its place."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from takagi.models import (
    Interval,
    ModelError,
    Output,
    Parameter,
    Plant,
    Turbine,
    Variable,
    interpolate_curve,
    load_model,
    plant_file_schema,
    sector_model,
    table_function,
)
from takagi.models.plant_files.loader import PlantFile, check_coverage, load_plant
from takagi.models.splines.table_function import TableFunction
from takagi.models.turbine.loader import load_turbine

ROOT = Path(__file__).resolve().parents[3]

FILE = """\
#:schema plant.schema.json
format = 1
kind = "plant"
name = "Pendulum with tabulated friction"
description = "for tests"
source = "ours"

[states]
theta = { unit = "rad", range = [-1.2, 1.2], description = "angle" }
omega = { unit = "rad/s", range = [-3, 3] }

[inputs]
tau = { unit = "N m" }

[parameters]
m = { value = 2.0, unit = "kg", source = "chosen" }
l = { value = 500, unit = "mm" }
g = { value = 9.81, unit = "m/s^2" }

[tables.friction]
file = "friction.csv"
unit = "N m"
arguments = [{ name = "speed", unit = "rad/s" }]

[mass]
omega = { omega = "m*l^2" }

[equations]
theta = "omega"
omega = "m*g*l*sin(theta) + tau - friction(omega)"

[outputs]
angle = { expression = "theta", unit = "rad" }

[premises]
z = "sin(theta)/theta"
"""
CSV = "# speed, torque\n-4,-0.5\n-2,-0.3\n0,0\n2,0.3\n4,0.5\n"


def written(folder: Path, text: str = FILE, csv: str = CSV) -> Path:
    (folder / "friction.csv").write_text(csv, encoding="utf-8")
    path = folder / "plant.toml"
    path.write_text(text, encoding="utf-8")
    return path


def in_python() -> Plant:
    theta, omega, tau, m, length, g, z = (
        sp.Symbol(n, real=True) for n in ("theta", "omega", "tau", "m", "l", "g", "z")
    )
    curve = interpolate_curve([-4, -2, 0, 2, 4], [-0.5, -0.3, 0, 0.3, 0.5])
    friction = table_function("friction", curve, unit="N m", argument_units=("rad/s",))
    return Plant(
        equations=(omega, m * g * length * sp.sin(theta) + tau - friction(omega)),
        states=(
            Variable(theta, "rad", Interval.of("-1.2", "1.2"), description="angle"),
            Variable(omega, "rad/s", Interval.of(-3, 3)),
        ),
        inputs=(Variable(tau, "N m"),),
        mass=sp.diag(1, m * length**2),
        outputs=(Output("angle", theta, "rad"),),
        parameters=(
            Parameter(m, Fraction(2), "kg", "chosen"),
            Parameter(length, Fraction(1, 2), "m"),
            Parameter(g, Fraction(981, 100), "m/s^2"),
        ),
        premises={z: sp.sin(theta) / theta},
        units="checked",
        name="Pendulum with tabulated friction",
        description="for tests",
        source="ours",
    )


def test_the_same_plant_in_toml_and_in_python_is_equal(tmp_path: Path) -> None:
    found = load_model(written(tmp_path))

    assert found == in_python()
    assert hash(found) == hash(in_python())


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("9.81", "9.810000000000000001"),
        ("[-1.2, 1.2]", "[-1.2, 1.1]"),
        ("sin(theta) +", "sin(theta) -"),
        ('source = "chosen"', 'source = "measured"'),
        ('omega = "m*l^2"', 'omega = "2*m*l^2"'),
        ("sin(theta)/theta", "cos(theta)"),
        ('description = "for tests"', 'description = "other"'),
    ],
)
def test_a_plant_that_differs_anywhere_is_not_equal(
    tmp_path: Path, before: str, after: str
) -> None:
    assert load_model(written(tmp_path, FILE.replace(before, after, 1))) != in_python()


def test_values_are_converted_to_si(tmp_path: Path) -> None:
    """Exactly by rational factors, to 12 decimals with pi."""
    text = FILE.replace('unit = "rad", range = [-1.2, 1.2]', 'unit = "deg", range = [-60, 60]')

    found = load_plant(written(tmp_path, text))

    assert found.states[0].unit == "rad"
    assert found.states[0].range == Interval.of("-1.047197551197", "1.047197551197")
    assert found.values[sp.Symbol("l", real=True)] == Fraction(1, 2)


def test_a_table_of_two_arguments_is_a_bicubic_spline(tmp_path: Path) -> None:
    """x y^2 in mm and deg: a bicubic spline reproduces it at its points."""
    rows = [f"{x}," + ",".join(str(x * y * y) for y in range(0, 50, 10)) for x in range(5)]
    (tmp_path / "grid.csv").write_text(",0,10,20,30,40\n" + "\n".join(rows), encoding="utf-8")
    text = FILE.replace(
        "[mass]",
        '[tables.lift]\nfile = "grid.csv"\nunit = "mm"\n'
        'arguments = [{ name = "gap", unit = "mm" }, { name = "angle", unit = "deg" }]\n[mass]',
    ).replace("[premises]", '[premises]\nz2 = "lift(l/250, 0.1)"')

    found = load_plant(written(tmp_path, text)).premises[sp.Symbol("z2", real=True)]

    assert isinstance(found, TableFunction)
    assert found.table.x_range == (0.0, 0.004)
    assert float(found.subs(sp.Symbol("l", real=True), sp.Rational(1, 2))) == pytest.approx(
        1e-3 * 2 * (0.1 * 180 / 3.141592653589793) ** 2, rel=1e-6
    )


def test_a_number_alone_is_a_pure_parameter(tmp_path: Path) -> None:
    """``k = 0.4`` is ``k = { value = 0.4 }``: without a unit, so that a mass m = 2 does not fit."""
    text = FILE.replace('omega = "m*g*l*sin(theta) + tau', 'omega = "k*m*g*l*sin(theta) + tau')
    alone = text.replace("[parameters]", "[parameters]\nk = 0.4")
    fields = text.replace("[parameters]", "[parameters]\nk = { value = 0.4 }")

    assert load_plant(written(tmp_path, alone)) == load_plant(written(tmp_path, fields))
    with pytest.raises(ModelError, match="unit"):
        load_plant(
            written(
                tmp_path,
                FILE.replace('m = { value = 2.0, unit = "kg", source = "chosen" }', "m = 2.0"),
            )
        )
    with pytest.raises(ModelError, match="parameters.k"):
        load_plant(written(tmp_path, alone.replace("k = 0.4", "k = true")))


def test_units_can_be_left_unchecked_and_the_plant_says_so(tmp_path: Path) -> None:
    text = FILE.replace('unit = "N m" }', 'unit = "m" }', 1)
    with pytest.raises(ModelError, match="tau has the unit m and"):
        load_plant(written(tmp_path, text))

    found = load_plant(written(tmp_path, text.replace("format", 'units = "unchecked"\nformat', 1)))

    assert found.units == "unchecked"


def test_discrete_time_gives_the_next_state(tmp_path: Path) -> None:
    text = 'format = 1\nkind = "plant"\nsample_time = 0.5\n[states]\nx = { unit = "m" }\n'
    path = written(tmp_path, text + '[equations]\nx = "x/2"\n')

    found = load_plant(path)

    assert (found.sample_time, found.name) == (0.5, "plant")


BAD = [
    ("sin(theta)", "sin(thta)", True, "equations.omega", "did you mean 'theta'"),
    ("tau - friction", "tau + g - friction", True, "equations.omega", "are added"),
    ("friction(omega)", "friction(2*omega)", True, "equations.omega", "the table covers"),
    ("friction(omega)", "friction(tau/(m*l^2)*(1))", True, "equations.omega", "argument 1"),
    ("friction(omega)", "friction(omega, 1)", True, "equations.omega", "takes 1 argument"),
    ("friction(omega)", "frction(omega)", True, "equations.omega", "did you mean 'friction'"),
    ('omega = "m*g', 'omga = "m*g', True, "equations.omga", "not a state"),
    ('theta = "omega"\n', "", "[equations]", "equations", "no equation for theta"),
    ("tau = {", "omega = {", 'omega = { unit = "N m"', "inputs.omega", r"already"),
    ("g = {", "sin = {", True, "parameters.sin", "function or constant"),
    ('"rad/s", range = [-3, 3]', '"rads", range = [-3, 3]', True, "states.omega.unit", "rads"),
    ("[-3, 3]", "[3, -3]", True, "states.omega.range", "[3, -3] was given"),
    ("[-3, 3]", "[3]", True, "states.omega.range", "two numbers"),
    ("[-3, 3]", '["a", 3]', True, "states.omega.range", "without quotes"),
    ("[-3, 3]", "[1, 3]", True, "states.omega", "rests at 0 rad/s where no rest is given"),
    ('{ value = 9.81, unit = "m/s^2"', "true #", True, "parameters.g", "g = { value"),
    ("value = 2.0", "value = 1e999", True, "parameters.m.value", "finite number"),
    ("value = 2.0", "value = true", True, "parameters.m.value", "without quotes"),
    ("value = 2.0, ", "", "m = {", "parameters.m.value", "missing"),
    ("value = 2.0", "vaule = 2.0", True, "parameters.m.vaule", "did you mean 'value'"),
    ("format = 1", "format = 2", True, "format", "1"),
    ("[outputs]", "[output]", True, "output", "did you mean 'outputs'"),
    ("[equations]", "[equation]", True, "equation", "did you mean 'equations'"),
    ('unit = "rad" }\n\n[prem', 'unit = "deg" }\n\n[prem', True, "outputs.angle.unit", "SI"),
    ('unit = "rad" }\n\n[prem', 'unit = "m" }\n\n[prem', True, "outputs.angle", "'m' is stated"),
    ("m*l^2", "m*l^999", True, "mass.omega.omega", "exponent is 999"),
    ("m*l^2", "(" * 70 + "m", True, "mass.omega.omega", "50 levels"),
    ("friction.csv", "../friction.csv", True, "tables.friction.file", "in the folder"),
    ("friction.csv", "/etc/passwd", True, "tables.friction.file", "in the folder"),
    ("friction.csv", "gone.csv", True, "tables.friction.file", "is not there"),
    ("z = ", "1z = ", True, "premises.1z", "starts with a letter"),
    ("z = ", "tau = ", 'tau = "sin', "premises.tau", "already"),
]


@pytest.mark.parametrize(("before", "after", "line", "field", "words"), BAD)
def test_what_is_wrong_in_a_file_is_named_with_line_and_field(
    tmp_path: Path, before: str, after: str, line: bool | str, field: str, words: str
) -> None:
    assert before in FILE
    text = FILE.replace(before, after, 1)
    path = written(tmp_path, text)
    sought = after.partition("\n")[0] if line is True else str(line)
    number = next(n for n, row in enumerate(text.splitlines(), start=1) if sought in row)

    with pytest.raises(ModelError) as caught:
        load_model(path)

    message = str(caught.value)
    assert f"field '{field}" in message
    assert words in message
    assert message.startswith(f"{path}:{number}: ")
    assert message.count(str(path)) == 1


TINY = ",1,2,3,4\n" + "\n".join(
    f"{x}," + ",".join(f"{x * y * y}.7137e-11" for y in range(1, 5)) for x in range(4)
)
GRID = '[tables.lift]\nfile = "grid.csv"\narguments = [{ name = "a" }, { name = "b" }]\n[mass]'


@pytest.mark.parametrize(
    ("name", "table", "line", "words"),
    [
        ("friction", "0,1\n1,2\n2,3\n", None, "at least 4"),
        ("friction", "0,1\n1,2\n2,3,4\n3,4\n", 3, "two"),
        ("friction", "0,1\n1,2\n2,x\n3,4\n", 3, "finite number"),
        ("friction", "0,1\n1,2\n2,nan\n3,4\n", 3, "finite number"),
        ("friction", "0,1\n1,2\n2,1e9999999\n3,4\n", 3, "finite number"),
        ("friction", "0,1\n2,2\n1,3\n3,4\n", 3, "sort them"),
        ("grid", ",0,1,2,3\n0,1,1,1,1\n1,1,1,1\n2,1,1,1,1\n3,1,1,1,1\n", 3, "line 1 names 4"),
        ("grid", ",0,1,3,2\n0,1,1,1,1\n1,1,1,1,1\n2,1,1,1,1\n3,1,1,1,1\n", 1, "sort them"),
        ("grid", ",0,1,2,3\n0,1,1,1,1\n2,1,1,1,1\n1,1,1,1,1\n3,1,1,1,1\n", 4, "sort them"),
        ("grid", ",0,1,2,3\n0,1,1,1,1\n1,1,1,1,1\n2,1,1,1,1\n", None, "at least 5"),
        ("grid", ",0,1,2\n0,1,1,1\n1,1,1,1\n2,1,1,1\n3,1,1,1\n", 1, "at least 4"),
        # Values of 1e-10 would keep two or three digits of twelve.
        ("grid", TINY, None, "misses the table"),
    ],
)
def test_a_malformed_table_is_named_with_its_line(
    tmp_path: Path, name: str, table: str, line: int | None, words: str
) -> None:
    path = written(tmp_path, FILE if name == "friction" else FILE.replace("[mass]", GRID))
    (tmp_path / f"{name}.csv").write_text(table, encoding="utf-8")

    with pytest.raises(ModelError, match=words) as caught:
        load_model(path)

    assert f"{name}.csv:{line or ''}" in str(caught.value)


def test_a_link_out_of_the_folder_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "inner"
    folder.mkdir()
    (tmp_path / "secret.csv").write_text(CSV, encoding="utf-8")
    path = written(folder, FILE.replace("friction.csv", "link.csv"))
    (folder / "link.csv").symlink_to(tmp_path / "secret.csv")

    with pytest.raises(ModelError, match="leads out of the folder"):
        load_model(path)


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match='kind = "plant" or kind = "turbine"'):
        load_model(written(tmp_path, FILE.replace('kind = "plant"', 'kind = "plan"')))
    with pytest.raises(ModelError, match='kind = "turbine"'):
        load_turbine(written(tmp_path))
    assert isinstance(load_model("nrel5mw"), Turbine)


def test_the_files_of_a_plant_are_known(tmp_path: Path) -> None:
    path = written(tmp_path)

    assert PlantFile.of(path).files == [path, tmp_path / "friction.csv"]


def test_the_published_schema_is_current() -> None:
    """Written by ``python -m takagi.models.plant.entries > docs/plant.schema.json``."""
    published = json.loads((ROOT / "docs/plant.schema.json").read_text(encoding="utf-8"))

    assert published == plant_file_schema()


X, U = sp.symbols("x u", real=True)


def table(name: str, low: float, high: float) -> type[TableFunction]:
    x = np.linspace(low, high, 9)
    return table_function(name, interpolate_curve(x, np.sin(x), name=name))


INNER = table("inner", 0, 2)  # values up to 1
WIDE, NARROW = table("wide", -1, 1.5), table("narrow", 0, 0.5)


def plant(expression: sp.Expr, low: str = "0", high: str = "2") -> Plant:
    rest = Fraction(1, 4)
    return Plant(
        states=(Variable(X, "-", Interval.of(low, high), rest),),
        inputs=(Variable(U),),
        equations=(expression - expression.subs(X, sp.Rational(1, 4)) + U,),
        name="nested",
    )


def test_a_table_of_a_table_is_covered_and_bounded() -> None:
    """wide(inner(x)) - its value at 1/4, over x - 1/4: a removable singularity of two splines."""
    described = plant(WIDE(INNER(X)))
    check_coverage(described)
    (premise,) = sector_model(described).premises

    x = np.linspace(0, 2, 801)
    quotient = (_value(x) - _value(0.25)) / (x - 0.25 + (x == 0.25))
    quotient = quotient[x != 0.25]
    assert float(premise.lower) <= quotient.min() <= float(premise.lower) + 0.01
    assert quotient.max() <= float(premise.upper) <= quotient.max() + 0.01
    assert premise.bounds.contains(premise.replay())


def _value(x: np.ndarray | float) -> np.ndarray:
    return np.asarray(WIDE.table(INNER.table(x, 0), 0))


def test_values_of_the_inner_table_that_leave_the_outer_one_are_refused() -> None:
    """inner takes values up to 1, narrow covers [0, 1/2]: the argument is named with its range."""
    with pytest.raises(ModelError, match=r"argument 1 of narrow\(inner\(x\)\), inner\(x\), takes"):
        check_coverage(plant(NARROW(INNER(X))))
    check_coverage(plant(NARROW(INNER(X)), "0.01", "0.5"))


def test_the_inner_argument_is_refused_first() -> None:
    with pytest.raises(ModelError, match=r"argument 1 of inner\(2\*x\), 2\*x, takes values"):
        check_coverage(plant(WIDE(INNER(2 * X))))


def test_a_derived_model_refuses_what_nobody_checked() -> None:
    """A Plant in Python is not read from a file; its bounds refuse the same."""
    for expression, words in ((WIDE(INNER(2 * X)), "of inner"), (NARROW(INNER(X)), "of narrow")):
        with pytest.raises(ModelError, match=rf"an argument {words}.*the table covers"):
            sector_model(plant(expression))
