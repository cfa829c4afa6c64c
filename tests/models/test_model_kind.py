"""What a model file is: it states its kind, and without one the message helps to state it."""

from __future__ import annotations

from pathlib import Path

import pytest

from takagi.models import ModelError, load_model

PLANT = """[states]
x = { range = [-1, 1] }
[inputs]
u = {}
[equations]
x = "u - x"
"""
KINDS = 'a model file says kind = "plant" or kind = "turbine" above its first section'


def refused(folder: Path, text: str) -> str:
    """Return the message about a file, without the folder that it is in."""
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
    """Line, both kinds, a guess by the sections that are there; no guess where there are none."""
    assert refused(tmp_path, text) == message


def test_what_the_guess_says_is_a_cure(tmp_path: Path) -> None:
    text = f'format = 1\nunits = "unchecked"\n{PLANT}'
    assert 'write kind = "plant"' in refused(tmp_path, text)

    (tmp_path / "model.toml").write_text(f'kind = "plant"\n{text}', encoding="utf-8")

    assert load_model(tmp_path / "model.toml").name == "model"
