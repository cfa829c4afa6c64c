"""Plants that do not rest at decimals: textbook plants are proved."""

from __future__ import annotations

import copy
import json
import math
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import Verdict, check
from takagi.certificates.checker import CertificateError, read_text
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.cross_check.comparison import cross_checked_document
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.plant_embedding import embedding_claim, plant_data
from takagi.models import ModelError, TSModel, sector_model
from takagi.models.plant_files.loader import PlantFile, load_plant
from tests.certificates.embedding.plants import embedding_outcome
from tests.solved_rest_plants import ARM, FAN, MAGNET, PLANTS


def filed(folder: Path, text: str, name: str = "plant.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def document(model: TSModel) -> dict[str, Any]:
    return {"model": plant_data(model), "claim": embedding_claim(model)}


def verdict(given: dict[str, Any]) -> tuple[Verdict, str]:
    read = read_text(json.dumps(given), "document")
    found = embedding_outcome(read["model"], claim=read["claim"]).in_words()
    return found.verdict, found.text


@pytest.fixture(scope="module")
def documents(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("plants")
    return {
        name: document(sector_model(load_plant(filed(folder, text, f"{name}.toml"))))
        for name, text in PLANTS.items()
    }


@cache
def design_at(path: Path) -> PlantDesign:
    found = design_plant(load_plant(path), files=PlantFile.of(path).files)
    assert isinstance(found, PlantDesign)
    return found


@pytest.fixture(scope="module")
def fan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return filed(tmp_path_factory.mktemp("fan"), FAN)


@pytest.mark.parametrize("name", ["magnet", pytest.param("tank", marks=pytest.mark.slow), "fan"])
def test_a_textbook_plant_is_proved_as_its_book_prints_it(
    tmp_path: Path, fan: Path, name: str
) -> None:
    """Design, certificate, replay from the file: all claims about the plant at its own rest."""
    path = fan if name == "fan" else filed(tmp_path, PLANTS[name])
    design = design_at(path)

    assert design.proved
    written = tmp_path / "certificate.json"
    written.write_text(json.dumps(design.document), encoding="utf-8")
    found = check(written, model=path)
    assert found.verdict is Verdict.PROVED
    assert "its own rest is proved to lie in" in found.claims[0].text

    fields = path.read_text(encoding="utf-8").replace("near = 350", "near = 351")
    fields = fields.replace('w0 = "2*pi*n0"', 'w0 = { value = "pi*n0*2" }')
    same = filed(tmp_path, fields, "same.toml")
    assert check(written, model=same).verdict is Verdict.PROVED


def test_the_rests_are_those_of_the_equations(tmp_path: Path) -> None:
    """Closed forms by hand: i0 = z0 sqrt(m g/c), u0 = R i0; ln 2; asin(2/3); 50 pi."""
    found = {}
    for name, text in PLANTS.items():
        plant = load_plant(filed(tmp_path, text))
        found[name] = {v.name: (float(v.rest), float(v.within)) for v in plant.variables}
    current = 0.01 * math.sqrt(0.05 * 9.81 / 5e-5)
    speed = 50 * math.pi
    for name, variable, wanted in (
        ("magnet", "i", current),
        ("magnet", "u", 10 * current),
        ("fan", "w", speed),
        ("fan", "i", 500 / speed / 0.8),
        ("discrete", "q", math.log(2)),
        ("arm", "q", math.asin(2 / 3)),
    ):
        value, within = found[name][variable]
        assert 0 < within < 1e-10
        assert value == pytest.approx(wanted, rel=1e-14)
    assert found["arm"]["p"] == (0.0, 0.0)
    assert found["magnet"]["z"] == (0.01, 0.0)


@pytest.mark.parametrize("name", PLANTS)
def test_each_embedding_is_proved_and_says_where_it_rests(
    documents: dict[str, dict[str, Any]], name: str
) -> None:
    found, words = verdict(documents[name])

    assert found is Verdict.PROVED
    assert "its own rest is proved to lie in" in words


@pytest.mark.parametrize("name", ["tank", "fan"])
def test_secants_are_proved_about_the_same_rest(tmp_path: Path, name: str) -> None:
    given = document(secant_model(load_plant(filed(tmp_path, PLANTS[name]))))
    assert verdict(given)[0] is Verdict.PROVED

    forged = moved(given, ("states", 1), Fraction(1, 10**9))
    assert verdict(forged)[0] is Verdict.UNDECIDED


def moved(given: dict[str, Any], place: tuple[str, int], by: Fraction) -> dict[str, Any]:
    found = copy.deepcopy(given)
    rest = found["model"][place[0]][place[1]]["rest"]
    rest["value"] = str(Fraction(repr(rest["value"])) * (1 + by))
    return found


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("fan", 'value = "P/w0^3"', 'value = "P/w0^3*1.001"', "parameters.c is another expression"),
        ("fan", '"2*pi*n0"', '"2*pi*n0 + n0"', "is another expression there, "),
        ("fan", 'rest = "w0"', 'rest = "1.1*w0"', "w rests elsewhere there"),
        ("fan", 'rest = "w0"', "rest = 157", "w rests elsewhere there"),
        ("fan", '"2*pi*n0"', '"2*pi*n0*c/c"', "parameters.c depends on itself"),
        ("tank", "range = [340, 360]", "range = [340, 361]", "states.T.range"),
        ("tank", "rest = { near = 350 }", "rest = 350", "T rests elsewhere there"),
        ("magnet", 'rest = "z0"', 'rest = "z0/2"', "z rests elsewhere there"),
    ],
)
def test_another_file_is_told_from_the_certificate_s(
    documents: dict[str, dict[str, Any]],
    tmp_path: Path,
    name: str,
    old: str,
    new: str,
    message: str,
) -> None:
    assert PLANTS[name].count(old) == 1
    model = read_text(json.dumps(documents[name]), "document")["model"]
    compare_plant(model, filed(tmp_path, PLANTS[name]))
    other = filed(tmp_path, PLANTS[name].replace(old, new), "other.toml")
    with pytest.raises((OtherModel, CertificateError), match=message):
        compare_plant(model, other)


def test_the_same_numbers_written_otherwise_are_the_same_plant(
    documents: dict[str, dict[str, Any]], tmp_path: Path
) -> None:
    """Another order, another form of the expressions, a number for what is one."""
    model = read_text(json.dumps(documents["fan"]), "document")["model"]
    text = FAN.replace('w0 = "2*pi*n0"\n', "").replace("[equations]", 'w0 = "n0*pi*2"\n[equations]')
    text = text.replace('"P/w0^3"', '"P/(w0*w0^2)"')
    said = "the file leaves the rest of {} to be solved; any proved rest passes"
    assert compare_plant(model, filed(tmp_path, text)).endswith(said.format("i, u"))

    magnet = read_text(json.dumps(documents["magnet"]), "document")["model"]
    given = MAGNET.replace('rest = "z0"', "rest = 10")
    assert compare_plant(magnet, filed(tmp_path, given)).endswith(said.format("i, u"))


CUBIC = """
format = 1
kind = "plant"
name = "A parameter with the name of a rest"
units = "unchecked"
[states]
x = { range = [-0.5, 0.5] }
[inputs]
u = { range = [-8, 8] }
[parameters]
x_rest = "sqrt(2)"
[equations]
x = "u + x^3 - x_rest*x"
"""


def test_a_parameter_is_no_rest_whatever_its_name(tmp_path: Path) -> None:
    """`x_rest` is a parameter here: the state x rests at 0, and no sentence says otherwise."""
    plant = load_plant(filed(tmp_path, CUBIC))
    given = document(sector_model(plant))
    found, told = verdict(given)
    assert found is Verdict.PROVED
    assert "its own rest" not in told and "with x_rest = 1.41421356" in told
    model = read_text(json.dumps(given), "document")["model"]
    assert compare_plant(model, tmp_path / "plant.toml") == ""

    elsewhere = CUBIC.replace("range = [-0.5, 0.5]", 'range = [0.9, 1.9], rest = "x_rest"')
    with pytest.raises((OtherModel, CertificateError), match=r"x\.(range|rest)"):
        compare_plant(model, filed(tmp_path, elsewhere, "other.toml"))


def test_a_parameter_does_not_stand_in_for_a_rest(tmp_path: Path) -> None:
    """The file rests at 1, the certificate at 0: a ball `x_rest` of 1 shifts rest and range."""
    text = CUBIC.replace('x_rest = "sqrt(2)"', "x_rest = { value = 1 }")
    forged = document(sector_model(load_plant(filed(tmp_path, text))))["model"]
    forged["states"][0]["range"] = ["-0.4999999", "0.4999999"]
    forged["parameters"]["x_rest"] = {"value": 1, "within": "1e-7", "equals": "1"}
    model = read_text(json.dumps(forged), "model")

    other = text.replace("range = [-0.5, 0.5]", 'range = [0.5, 1.5], rest = "x_rest"')
    with pytest.raises(OtherModel, match=r"states\.x\.range"):
        compare_plant(model, filed(tmp_path, other))


def test_both_deciders_agree(fan: Path) -> None:
    found = cross_checked_document(design_at(fan).document)

    assert found.agrees
    assert {row.second for row in found.rows} == {"PROVED"}


def test_a_rest_where_an_equation_is_a_limit_is_refused(tmp_path: Path) -> None:
    text = ARM.replace("3*sin(q)", "2*sin(p)/p")
    with pytest.raises(ModelError, match="equation of p: it divides by 0 at rest"):
        load_plant(filed(tmp_path, text.replace('-1, 1], rest = "solve"', "-1, 1], rest = 0")))
