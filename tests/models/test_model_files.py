"""A model's file and the door of the models: names, kinds, numbers, files that are none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

import takagi.models
from takagi.models import ModelError, load_model, load_ts_model
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


def test_load_model_offers_near_names() -> None:
    with pytest.raises(ModelError, match="nrel5mw"):
        load_model("nrel5mv")


def test_numbers_of_a_turbine_file_are_the_floats_nearest_to_them() -> None:
    path = data_folder() / "nrel5mw.toml"
    exact = library.read_document(path, parse_float=library.decimal_of)

    assert exact.in_floats() == library.read_document(path)
    for text in ("1e400", "-1e99999999999999999999", "1_000.5", "-0.0", "inf"):
        assert repr(float(library.decimal_of(text))) == repr(float(text))


rng = np.random.default_rng(5)


def stored(folder: Path, **content: Any) -> Path:
    savemat(folder / "model.mat", content)
    return folder / "model.mat"


@pytest.mark.parametrize(("n", "m", "r"), [(2, 1, 3), (3, 2, 2), (1, 1, 4), (2, 1, 1), (2, 2, 2)])
def test_vertices_come_back(n: int, m: int, r: int, tmp_path: Path) -> None:
    A, B = rng.standard_normal((r, n, n)), rng.standard_normal((r, n, m))
    path = stored(tmp_path, A=np.moveaxis(A, 0, 2), B=np.moveaxis(B, 0, 2))
    model = load_ts_model(path)
    np.testing.assert_array_equal(model.A, A)
    np.testing.assert_array_equal(model.B, B)
    assert model.sample_time is None


def test_a_matrix_without_rules_is_the_same_in_every_rule(tmp_path: Path) -> None:
    A, B, C = rng.standard_normal((2, 2, 3)), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    model = load_ts_model(stored(tmp_path, A=A, B=B, C=C, sample_time=0.5))
    for k in range(3):
        np.testing.assert_array_equal(model.A[k], A[:, :, k])
        np.testing.assert_array_equal(model.B[k], B)
        np.testing.assert_array_equal(model.C[k], C)
    assert model.sample_time == 0.5


@pytest.mark.parametrize("n", [2, 3])
def test_a_shared_matrix_with_as_many_columns_as_rules_is_not_taken_for_rules(
    n: int, tmp_path: Path
) -> None:
    A, B, C = rng.standard_normal((n, n, n)), rng.standard_normal((n, n)), np.eye(n)
    model = load_ts_model(stored(tmp_path, A=A, B=B, C=C))
    for k in range(n):
        np.testing.assert_array_equal(model.B[k], B)
        np.testing.assert_array_equal(model.C[k], C)


def test_a_struct_as_the_export_writes_it(tmp_path: Path) -> None:
    A = rng.standard_normal((2, 2, 3))
    content = {"A": A, "B": np.ones((2, 1, 3)), "sample_time": [], "name": "x"}
    model = load_ts_model(stored(tmp_path, takagi=content))
    np.testing.assert_array_equal(model.A[2], A[:, :, 2])


A2 = np.array([[[0.0, 1.0], [-2.0, -1.0]], [[0.0, 1.0], [-3.0, -1.5]]])
B1 = np.array([[0.0], [1.0]])


def cells(matrices: Any) -> Any:
    made = np.empty((1, len(matrices)), dtype=object)
    made[0, :] = list(matrices)
    return made


def struct_array(**members: Any) -> Any:
    made = np.zeros((1, 2), dtype=[(name, "O") for name in members])
    for name, values in members.items():
        made[name][0, :] = list(values)
    return made


@pytest.mark.parametrize(
    ("content", "step"),
    [
        ({"A": cells(A2), "B": cells([B1, B1])}, None),
        ({"A": cells(A2), "B": B1, "Ts": 0.1}, None),
        ({"A1": A2[0], "A2": A2[1], "B1": B1, "B2": B1}, None),
        ({"sys": {"A": np.moveaxis(A2, 0, 2), "B": B1, "Ts": 0.5}, "K": B1}, 0.5),
        ({"sys": {"A": cells(A2), "B": B1, "Ts": 0}}, None),
        ({"plant": struct_array(A=A2, B=[B1, B1], Ts=[0.5, 0.5])}, 0.5),
        ({"plant": {"A1": A2[0], "A2": A2[1], "B": B1}}, None),
    ],
)
def test_the_forms_that_matlab_users_have(
    content: dict[str, Any], step: float | None, tmp_path: Path
) -> None:
    model = load_ts_model(stored(tmp_path, **content))
    np.testing.assert_array_equal(model.A, A2)
    np.testing.assert_array_equal(model.B, np.array([B1, B1]))
    assert model.sample_time == step


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ({"B": np.ones((2, 1))}, "has no A"),
        ({"A": np.ones((2, 3, 4))}, r"A has shape \(2, 3, 4\)"),
        ({"A": np.ones((2, 1))}, r"A has shape \(2, 1\)"),
        ({"A": np.ones((2, 2)) * 1j}, "A is of type complex128; real numbers are needed"),
        ({"A": "abc"}, "A is of type <U3; real numbers are needed"),
        ({"A": np.eye(2), "sample_time": "x"}, "sample_time is of type"),
        ({"A": np.eye(2), "sample_time": [0.1, 0.2]}, "sample_time has 2 numbers"),
        ({"takagi": np.eye(2)}, "has no A"),
        ({"sys1": {"A": np.eye(2)}, "sys2": {"A": np.eye(2)}}, r"has sys1, sys2; write A = cat"),
        ({"A1": np.eye(2), "A3": np.eye(2)}, "has A1, A3"),
        ({"A1": np.eye(2), "A": np.eye(2)}, "has A, A1"),
        ({"A": cells([np.eye(2), np.eye(3)])}, r"A has shapes \(2, 2\), \(3, 3\)"),
        ({"A": cells([np.eye(2), "x"])}, "A, rule 2 is of type"),
        ({"sys": {"A": np.eye(2), "Ts": -1}}, "Ts has"),
        ({"A": np.full((2, 2, 2), np.nan)}, "every entry must be finite"),
        (
            {"A": np.ones((2, 2, 2)), "B": np.ones((3, 1, 2))},
            r"B has shape \(2, 3, 1\), .* B must be \(2, 2, 1\)",
        ),
    ],
)
def test_what_does_not_fit_is_told(content: dict[str, Any], told: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=told):
        load_ts_model(stored(tmp_path, **content))


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="cannot be read"):
        load_ts_model(tmp_path / "nowhere.mat")
    with pytest.raises(ModelError, match="load_ts_model"):
        load_model(stored(tmp_path, A=np.eye(2)))
    text = tmp_path / "text.mat"
    text.write_text("A = [1 2; 3 4]\n" * 20, encoding="utf-8")
    with pytest.raises(ModelError, match="MAT-file"):
        load_ts_model(text)
    newer = tmp_path / "newer.mat"
    head = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(400)
    newer.write_bytes(head)
    with pytest.raises(ModelError, match="version 7.3"):
        load_ts_model(newer)
