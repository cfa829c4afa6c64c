"""A model file that is nested without end is refused by name."""

from __future__ import annotations

from pathlib import Path

import pytest

from takagi.models import ModelError, load_model


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
