"""`check --model` compares what the law measures with what the plant file lists."""

from __future__ import annotations

import tomllib
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import check, read_text
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_parts import compare_measured
from takagi.certificates.document.certificate_file import certificate_document, content_of, dumps
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import law_members, observer_member, plant_data
from takagi.models import sector_model
from takagi.models.plant_files.loader import PlantFile, load_plant

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
    """Compare a law with the field of a file."""
    compare_measured(gains, tomllib.loads(path.read_text("utf-8"), parse_float=Decimal), path)


def filed(folder: Path, listed: str) -> Path:
    path = folder / "line.toml"
    path.write_text(PLANT.replace(LISTED, listed), encoding="utf-8")
    return path


def certified(folder: Path, listed: str, measured: list[str]) -> Path:
    """A certificate for the file with this field; its law, with these outputs, is proved."""
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
    document = certificate_document(model=data, gains=gains, claims=claims, provenance={})
    found = folder / "certificate.json"
    found.write_text(dumps(document), encoding="utf-8")
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
