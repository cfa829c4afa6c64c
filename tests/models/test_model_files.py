"""A model's file and the door of the models: names, kinds, numbers, files that are none."""

from __future__ import annotations

from pathlib import Path

import pytest

import takagi.models
from takagi.models import ModelError, Turbine, load_model, nrel5mw
from takagi.models.files import library
from takagi.models.files.library import data_folder

PLANT = """[states]
x = { range = [-1, 1] }
[inputs]
u = {}
[equations]
x = "u - x"
"""
KINDS = 'a model file says kind = "plant" or kind = "turbine" above its first section'


def refused(folder: Path, text: str) -> str:
    path = folder / "model.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ModelError) as told:
        load_model(path)
    return str(told.value).removeprefix(f"{folder}/")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            f"format = 1\n{PLANT}",
            f"model.toml:2: field 'kind': is missing; {KINDS}. [states], [inputs], [equations] "
            'belong to a plant: write kind = "plant"',
        ),
        (
            "[rotor]\nradius = 63.0\n",
            f"model.toml:1: field 'kind': is missing; {KINDS}. [rotor] belongs to a turbine: write "
            'kind = "turbine"',
        ),
        (
            f'format = 1\nkind = "plnt"\n{PLANT}',
            f"model.toml:2: field 'kind': 'plnt' was given (did you mean 'plant'?); {KINDS}. "
            '[states], [inputs], [equations] belong to a plant: write kind = "plant"',
        ),
        ("format = 1\n", f"model.toml: field 'kind': is missing; {KINDS}"),
        (
            "kind = [1]\n[project]\nname = 'x'\n",
            f"model.toml:1: field 'kind': [1] was given; {KINDS}",
        ),
    ],
)
def test_a_file_without_a_kind_is_told_which_it_may_be(
    tmp_path: Path, text: str, message: str
) -> None:
    assert refused(tmp_path, text) == message


def test_what_the_guess_says_is_a_cure(tmp_path: Path) -> None:
    text = f'format = 1\nunits = "unchecked"\n{PLANT}'
    assert 'write kind = "plant"' in refused(tmp_path, text)

    (tmp_path / "model.toml").write_text(f'kind = "plant"\n{text}', encoding="utf-8")

    assert load_model(tmp_path / "model.toml").name == "model"


@pytest.mark.parametrize(
    "text",
    [
        'kind = "turbine"\n' + ".".join(["a"] * 900) + " = 1\n",
        'kind = "turbine"\na = ' + "[" * 600 + "]" * 600 + "\n",
    ],
    ids=["keys", "arrays"],
)
def test_a_file_that_is_nested_too_deep_is_a_misuse(text: str, tmp_path: Path) -> None:
    path = tmp_path / "deep.toml"
    path.write_text(text, encoding="utf-8")

    with pytest.raises(ModelError, match="deep.toml"):
        load_model(path)


def test_the_fixed_names_are_exported() -> None:
    """Every listed name resolves; ``import *`` gives the same names as dir()."""
    names = dir(takagi.models)
    starred: dict[str, object] = {}
    exec("from takagi.models import *", starred)

    assert {"TSModel", "Premise", "sector_model", "load_model", "nrel5mw", "ModelError"} <= set(
        names
    )
    assert all(getattr(takagi.models, name) is starred[name] for name in names)
    assert set(starred) == {*names, "__builtins__"}


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = takagi.models.nonsense


def test_load_model_reads_a_built_in_turbine() -> None:
    found = load_model("nrel5mw")

    assert isinstance(found, Turbine)
    assert found.inertia == nrel5mw().inertia


def test_load_model_offers_near_names() -> None:
    with pytest.raises(ModelError, match="nrel5mw"):
        load_model("nrel5mv")


def test_numbers_of_a_turbine_file_are_the_floats_nearest_to_them() -> None:
    path = data_folder() / "nrel5mw.toml"
    exact = library.read_document(path, parse_float=library.decimal_of)

    assert exact.in_floats() == library.read_document(path)
    for text in ("1e400", "-1e99999999999999999999", "1_000.5", "-0.0", "inf"):
        assert repr(float(library.decimal_of(text))) == repr(float(text))
