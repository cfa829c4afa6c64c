"""`check --model` compares what the law measures and uses with what the plant file lists."""

from __future__ import annotations

import tomllib
from decimal import Decimal
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import check, read_text
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.files.plant_parts import compare_measured, uncertain_in
from takagi.certificates.checker.plant.expression import Scope
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.checker.plant.reading import PlantNodes, Variable
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.certificate_file import content_of, dumps
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import law_members, observer_member, plant_data
from takagi.models import sector_model
from takagi.models.plant_files.loader import PlantFile, load_plant
from tests.certificates.kinds.claims import as_read, sealed

LISTED = 'measured = ["y"]'
PLANT = f"""
format = 1
kind = "plant"
name = "line"
units = "unchecked"
{LISTED}
[states]
x = {{ unit = "-", range = [-1, 1] }}
[inputs]
u = {{ unit = "-", range = [-2, 2] }}
[outputs]
y = {{ expression = "x", unit = "-" }}
z = {{ expression = "x + x^3", unit = "-" }}
[equations]
x = "-x - x^3/2 + u"
"""


def compared(gains: Any, path: Path) -> None:
    file = tomllib.loads(path.read_text("utf-8"), parse_float=Decimal)
    compare_measured(gains, file, path, plant_nodes(("x", "x", "-")))


def filed(folder: Path, listed: str) -> Path:
    path = folder / "line.toml"
    path.write_text(PLANT.replace(LISTED, listed), encoding="utf-8")
    return path


def certified(folder: Path, listed: str, measured: list[str]) -> Path:
    path = filed(folder, listed)
    model = sector_model(load_plant(path))
    data = plant_data(model) | content_of(PlantFile.of(path).files)
    gains = pdc_law_data(model, np.ones((2, 1, 1))) | law_members(data)
    L = np.array([[[4.0, 0.0][: len(measured)]]])
    gains["observer"] = observer_member(L, measured, at_estimate=False)
    claims: list[dict[str, Any]] = [
        {"name": "e", "kind": "sector-embedding"},
        {"name": "l", "kind": "observed-loop", "level": 0.2, "decay_rate": 0,
         "P": [[1, 0], [0, 20]]},
    ]  # fmt: skip
    found = folder / "certificate.json"
    found.write_text(dumps(sealed(data, gains, *claims)), encoding="utf-8")
    return found


@pytest.mark.parametrize(
    ("listed", "measured"),
    [
        (LISTED, ["y"]),
        ('measured = ["z", "y"]', ["y", "z"]),
        ('measured = ["y", { name = "w", expression = "2*x", unit = "-" }]', ["y", "w"]),
    ],
)
def test_law_with_the_outputs_of_the_file_is_proved(
    listed: str, measured: list[str], tmp_path: Path
) -> None:
    certificate = certified(tmp_path, listed, measured)
    assert check(certificate, model=tmp_path / "line.toml").verdict.name == "PROVED"


@pytest.mark.parametrize(
    ("listed", "measured", "words"),
    [
        (LISTED, ["y", "z"], "the law measures z, which the field measured does not list"),
        ('measured = ["z"]', ["y"], "the law measures y, which the field measured does not list"),
        (
            'measured = ["y", "z"]',
            ["y"],
            "the field measured lists z, which the law does not measure",
        ),
        ("", ["y", "z"], "the law measures y, z, without the field measured it has all states"),
    ],
)
def test_law_with_other_outputs_is_refused_with_their_names(
    listed: str, measured: list[str], words: str, tmp_path: Path
) -> None:
    """Also where the certificate's own copy of the file has the field as the file has it."""
    certificate = certified(tmp_path, listed, measured)
    assert check(certificate).verdict.name == "PROVED"
    with pytest.raises(OtherModel, match=words):
        check(certificate, model=tmp_path / "line.toml")


def test_a_law_of_all_states_is_not_one_of_outputs(tmp_path: Path) -> None:
    path = filed(tmp_path, 'measured = ["y", "z"]')
    with pytest.raises(OtherModel, match="has all states, the field measured lists y, z alone"):
        compared({"K": [[[1]]]}, path)
    compared(None, path)  # no law
    compared({"K": [[[1]]]}, filed(tmp_path, ""))


@pytest.mark.parametrize("measured", [None, 5, "y", [1], [["y"]], {"name": "y"}])
def test_no_list_of_names_is_refused(measured: Any, tmp_path: Path) -> None:
    path = filed(tmp_path, LISTED)
    gains = read_text(dumps({"observer": {"measured": measured}}), "gains")
    with pytest.raises(OtherModel, match=r"gains\.observer\.measured is no list of names"):
        compared(gains, path)
    with pytest.raises(OtherModel, match=r"gains\.observer\.measured is no list of names"):
        compared({"observer": []}, path)


@pytest.mark.parametrize("listed", ["measured = 5", 'measured = "y"', "measured = [{ unit = 1 }]"])
def test_no_list_of_names_in_the_file_is_refused(listed: str, tmp_path: Path) -> None:
    with pytest.raises(OtherModel, match="plant: measured is no list of names"):
        compared({"observer": {"measured": ["y"]}}, filed(tmp_path, listed))


@pytest.mark.parametrize(
    ("entry", "unit", "rest"),
    [
        ("[0.8, 1.3] kg", "kg", Fraction(21, 20)),
        (" [ -1e-1 , +.5 ]  m/s ", "m/s", Fraction(1, 5)),
        ("[1, 2]", "-", Fraction(3, 2)),
        ([1, 4], "-", Fraction(5, 2)),
        ({"range": [1, Decimal("1.5")], "unit": "g"}, "g", Fraction(5, 4)),
        ({"range": [1, 2], "value": Decimal("1.25")}, "-", Decimal("1.25")),
        # Ends of the largest size that is read, and no middle beyond it.
        ([Decimal("-1e100"), Decimal("3e100")], "-", Fraction(10**100)),
        ([1, Decimal("1e101")], "-", None),
        ([Decimal("1e101"), 1], "-", None),
        ([1, Decimal("1e-101")], "-", None),
        ([Decimal("NaN"), 1], "-", None),
        ([1, Decimal("Infinity")], "-", None),
        ([True, 2], "-", None),
        ([1, False], "-", None),
        (["1", 2], "-", None),
        ([1, [2]], "-", None),
        ([1, 2, 3], "-", None),
        ([1], "-", None),
        ({"range": "[1, 2]"}, "-", None),
    ],
)
def test_a_range_is_read_with_its_middle(entry: Any, unit: str, rest: Any) -> None:
    """Without a value the rest is the middle; None where the ends are no two usual numbers."""
    found = uncertain_in({"m": entry, "k": 3})

    assert list(found) == ["m"]
    assert (found["m"]["unit"], found["m"]["rest"]) == (unit, rest)


def test_the_ends_of_a_range_are_those_that_are_written() -> None:
    assert uncertain_in({"m": "[0.8, 1.3] kg"})["m"]["range"] == [Decimal("0.8"), Decimal("1.3")]
    assert uncertain_in({"m": [1, 2]})["m"]["range"] == [1, 2]


@pytest.mark.parametrize(
    "entry",
    [
        3,
        Decimal("0.5"),
        "2*k",
        "2 kg",
        "[1, 2",
        "[1, 2, 3] kg",
        {"value": 1},
        {"range": None},
        None,
    ],
)
def test_what_has_no_range_is_not_uncertain(entry: Any) -> None:
    assert uncertain_in({"m": entry}) == {}


FOLLOWED = 'r = { follow = "x", range = [-0.5, 1] }'
UNCERTAIN = f"""
format = 1
kind = "plant"
name = "drag"
units = "unchecked"
[states]
x = {{ range = [-2, 2] }}
[inputs]
u = {{ range = [-10, 10] }}
[parameters]
a = {{ range = [0.5, 1.5] }}
[outputs]
twice = {{ expression = "2*x", unit = "-" }}
[equations]
x = "u - a*x"
[reference]
{FOLLOWED}
"""


@cache
def model() -> Any:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "drag.toml"
        path.write_text(UNCERTAIN, encoding="utf-8")
        data = plant_data(secant_model(load_plant(path)))
    return read_text(dumps({"model": data}), "model")["model"]


def compared_texts(text: str, folder: Path) -> str:
    path = folder / "drag.toml"
    path.write_text(text, encoding="utf-8")
    return compare_plant(model(), path)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ("{ range = [0.5, 1.5] }", "[0.5, 1.5]"),
        ("{ range = [0.5, 1.5] }", '"[0.5, 1.5]"'),
        ("{ range = [0.5, 1.5] }", "{ range = [0.5, 1.5], value = 1 }"),
        ("range = [-0.5, 1]", "range = [-0.5, 1.0], rate = 3"),
        ("range = [-0.5, 1]", 'range = [-0.5, 1.0], unit = "-"'),
    ],
)
def test_the_same_in_other_words_passes(old: str, new: str, tmp_path: Path) -> None:
    assert "not the certificate's" not in compared_texts(UNCERTAIN.replace(old, new), tmp_path)


REFERENCE = f"[reference]\n{FOLLOWED}\n"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "{ range = [0.5, 1.5] }",
            "{ range = [0.5, 1.6] }",
            r"a.range is \[0.5, 1.6\] there",
        ),
        ("{ range = [0.5, 1.5] }", "{ range = [0.5, 1.5], value = 0.9 }", "a rests elsewhere"),
        ("{ range = [0.5, 1.5] }", "{ range = [true, 1.5] }", "a.rest is no number there"),
        ("{ range = [0.5, 1.5] }", "{ value = 1 }", "parameters are 'a' there, none in"),
        (FOLLOWED, FOLLOWED.replace('"x"', '"twice"'), "equations.r_integral is"),
        (FOLLOWED, FOLLOWED.replace('"x"', '"u"'), "reference.r.follow is no state or output"),
        (FOLLOWED, FOLLOWED.replace('"x"', "5"), "reference.r.follow is no state or output"),
        (FOLLOWED, FOLLOWED.replace("-0.5", "-0.6"), r"disturbances.r.range is \[-0.6, 1\] there"),
        (FOLLOWED, FOLLOWED.replace("r =", "s ="), "references are s there, r in the certificate"),
        (REFERENCE, "", "references are none there, r in the certificate"),
        (FOLLOWED, FOLLOWED + "\n" + FOLLOWED.replace("r =", "a2 ="), "references are a2, r there"),
        (FOLLOWED, "r = 5", r"\[reference\] is no section there"),
        (FOLLOWED, FOLLOWED + "\nq = 5", r"\[reference\] is no section there"),
        ("format = 1", "format = 1\nreference = 5", r"\[reference\] is no section there"),
    ],
)
def test_another_plant_is_refused(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert old in UNCERTAIN
    text = UNCERTAIN.replace(old, new)
    if "reference = 5" in text:
        text = text.replace(REFERENCE, "")
    with pytest.raises(OtherModel, match=words):
        compared_texts(text, tmp_path)


FILE: dict[str, Any] = {"measured": ["x"], "states": {"x": {}, "v": {}}}
LAW: dict[str, Any] = {
    "state_names": ["x [m]", "v [m/s]"],
    "premises": [{"name": "z1", "expression": "sin(x)/x"}],
    "K": [[[1.5, 0]], [[2, 0.0]]],
}
ONE_GAIN = [[[1.5, 0]], [[1.5, 0]]]
OF_V = [{"name": "z1", "expression": "sin(x)/x"}, {"name": "z2", "expression": "x*v^2"}]


def plant_nodes(*states: tuple[str, str, str], others: tuple[str, ...] = ()) -> PlantNodes:
    """The states of a certificate, each with its symbol and unit, and the names beside them."""
    graph = Graph()
    listed = [Variable(name, symbol, unit, 0, None) for name, symbol, unit in states]
    names = {*others, *(v.name for v in listed), *(v.symbol for v in listed)}
    scope = Scope({name: graph.variable(name) for name in sorted(names)})
    return PlantNodes(graph, {}, listed, [], [], None, premise_scope=scope)


AT_ZERO = plant_nodes(("x", "x", "m"), ("v", "v", "m/s"))
INTEGRATING = plant_nodes(("x", "x", "m"), ("v", "v", "m/s"), ("xi", "xi", "m s"))
ELSEWHERE = plant_nodes(
    ("x", "delta_x", "m"), ("v", "delta_v", "m/s"), others=("x_rest", "v_rest", "k")
)


def require(file: dict[str, Any] = FILE, plant: PlantNodes = AT_ZERO, **changes: Any) -> None:
    compare_measured(as_read(LAW | changes), file, Path("plant.toml"), plant)


def test_gains_of_zero_use_no_state() -> None:
    """Rules of their own need premises of what is measured; one gain needs none."""
    require()
    require(K=ONE_GAIN, premises=OF_V)
    require(FILE | {"measured": ["v", "x"]}, K=[[[1, 1]], [[2, 3]]], premises=OF_V)
    require(plant=ELSEWHERE, state_names=["delta_x [m]", "delta_v [m/s]"])
    # The integral of a reference is a state of the law.
    integrating: dict[str, Any] = {
        "state_names": ["x [m]", "v [m/s]", "xi [m s]"],
        "K": [[[1, 0, 5]]],
    }
    require(plant=INTEGRATING, references=[{"follow": "x"}], **integrating)


@pytest.mark.parametrize(
    "changes",
    [
        {"K": [[[1.5, 0]], [[2, 1e-9]]]},
        {"K": [[[1.5, 1e-30]]]},
        {"premises": OF_V},
        {"premises": [{"name": "z1", "expression": "v"}]},
        {"premises": []},
        {"premises": None},
        {"state_names": ["x [m]"]},
        {"state_names": None},
        {"K": None},
        {"K": []},
        {"state_names": ["v [m/s]", "x [m]"]},
        # A premise that does not say, or not in names of the plant, what it is computed from.
        {"premises": [{"name": "v", "lower": 0, "upper": 1}]},
        {"premises": [{"name": "z1", "expression": "hidden^2"}]},
        {"premises": [{"name": "z1", "expression": ["v"]}]},
        {"premises": {"name": "z1", "expression": "x"}},
        # The integral of v - r is computed from v, and a command over b(v) too.
        {"references": [{"follow": "v", "integral": "xi"}], "K": [[[1, 0]]]},
        {"references": [{"integral": "xi"}], "K": [[[1, 0]]]},
        {"blending": {"low": {"effectiveness": "1 + v^2"}, "high": {"effectiveness": "1"}}},
        {"blending": {"low": {"effectiveness": "1"}}},
        {"blending": 1},
    ],
)
def test_another_state_is_another_law(changes: dict[str, Any]) -> None:
    """A gain however small, a formula, or members that do not say which states are used."""
    with pytest.raises(OtherModel, match="has all states, the field measured lists x alone"):
        require(**changes)


@pytest.mark.parametrize("symbol", ["delta_v", "moved", "d"])
def test_a_deviation_under_any_name_is_its_state(symbol: str) -> None:
    """A certificate chooses the names of deviations, in labels and in premises."""
    plant = plant_nodes(("x", "delta_x", "m"), ("v", symbol, "m/s"), others=("x_rest", "v_rest"))
    names: dict[str, Any] = {"state_names": ["delta_x [m]", f"{symbol} [m/s]"]}
    require(plant=plant, **names)
    for changes in (
        {"K": [[[1.5, 0.5]]]},
        {"premises": [{"name": "z1", "expression": f"({symbol} + v_rest)^2"}]},
    ):
        with pytest.raises(OtherModel, match="has all states"):
            require(plant=plant, **names | changes)


def test_a_state_of_which_another_output_has_the_name_is_not_measured() -> None:
    """What the file calls v there is a sensor of something else."""
    both: dict[str, Any] = {"K": [[[1, 1]]]}
    require(FILE | {"measured": ["x", "v"], "outputs": {"v": {"expression": "v"}}}, **both)
    require(FILE | {"measured": ["x", {"name": "v"}]}, **both)
    for file in (
        {"measured": ["x", "v"], "outputs": {"v": {"expression": "x^2"}}},
        {"measured": ["x", {"name": "v", "expression": "x"}]},
    ):
        with pytest.raises(OtherModel, match="has all states"):
            require(FILE | file, **both)


def test_an_output_of_a_state_is_not_the_state() -> None:
    """The file names what a sensor shows; a law of states names states."""
    with pytest.raises(OtherModel, match="lists y alone"):
        require(FILE | {"measured": ["y"], "outputs": {"y": {"expression": "x"}}})
