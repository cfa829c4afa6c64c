"""What docs/plants.md says is what happens."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from takagi.models import ModelError, load_model
from takagi.models.expressions.parser import FUNCTIONS
from takagi.models.files.units import parse_unit
from tests.docs_pages import fenced, text_of

PAGE = text_of("plants.md")


def test_the_pages_example_is_read_and_equals_its_python_form(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """docs/plants.md, followed to the letter; its Python block ends with the assertion."""
    (tmp_path / "friction.csv").write_text(fenced(PAGE, "csv")[0], encoding="utf-8")
    (tmp_path / "pendulum.toml").write_text(fenced(PAGE, "toml")[0], encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    scope: dict[str, object] = {}

    exec(fenced(PAGE, "python")[0], scope)

    assert scope["plant"] == load_model("pendulum.toml")


def test_the_pages_error_is_what_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "friction.csv").write_text(fenced(PAGE, "csv")[0], encoding="utf-8")
    wrong = fenced(PAGE, "toml")[0].replace("sin(theta)", "sin(thta)")
    (tmp_path / "pendulum.toml").write_text(wrong, encoding="utf-8")
    monkeypatch.chdir(tmp_path)

    with pytest.raises(ModelError) as caught:
        load_model("pendulum.toml")

    assert str(caught.value) == fenced(PAGE, "text")[0].rstrip()


def test_the_page_lists_functions_and_units_that_are_read() -> None:
    listed = re.findall(r"^- (kg, .*|g, t, .*)$", PAGE, flags=re.MULTILINE)

    assert set(FUNCTIONS) <= set(re.findall(r"\w+", PAGE))
    assert len(listed) == 2
    for name in ", ".join(listed).split(", "):
        assert parse_unit(name).text == name
