"""What the site makes of pages and docstrings; ``make site`` builds all, warnings being errors."""

from __future__ import annotations

import importlib
import re
import sys
from types import ModuleType

import pytest

from tests.docs_pages import DOCS


@pytest.fixture(scope="module")
def hooks() -> ModuleType:
    return beside("hooks")


def beside(name: str) -> ModuleType:
    sys.path.insert(0, str(DOCS / "site"))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(DOCS / "site"))


@pytest.mark.parametrize(
    "package",
    ["models", "lmi", "certificates", "certificates.checker", "certificates.requests"],
)
def test_every_public_name_has_its_place(hooks: ModuleType, package: str) -> None:
    module = importlib.import_module(f"takagi.{package}")
    text = hooks.public_names(f"takagi.{package}")
    named = re.findall(rf"^::: takagi\.{re.escape(package)}\.(\w+)$", text, re.MULTILINE)

    public = {name for name in dir(module) if not name.startswith("_")}
    if package == "certificates.checker":
        # Its names are imported at once, so that its rooms are there too.
        public = {name for name in public if isinstance(getattr(module, name), type)} | {
            "check",
            "check_document",
            "read_text",
        }
    assert sorted(named) == sorted(set(named)) and set(named) == public


def test_a_formula_of_several_rows_and_sets_is_typeset(hooks: ModuleType) -> None:
    source = "\\begin{aligned}\n\\text{find} & P \\\\\n & \\{1\\} \\tfrac12 X\n\\end{aligned}"

    block = hooks.formula_block(source)

    assert 'class="formula aligned"' in block
    assert "<mo>{</mo>" in block and "<mo>}</mo>" in block
    assert block.count("<mtr>") == 2 and block.count("<mfrac>") == 1


def test_a_formula_that_is_not_converted_ends_the_build(hooks: ModuleType) -> None:
    """The extension passes over every other exception, and shows the formula as code."""
    with pytest.raises(hooks.SuperFencesException, match="nosuch"):
        hooks.formula_block("\\begin{nosuch} x \\end{nosuch}")


def test_links_lead_to_pages_of_the_site(hooks: ModuleType) -> None:
    class File:
        src_uri = "changelog.md"

    class Page:
        file = File()
        meta: dict[str, object] = {}

    page = hooks.on_page_markdown(
        "See [laws](docs/laws.md#x), [how](CONTRIBUTING.md), [top](README.md),\n"
        "[a plant](models/data/tora.toml) and [there](https://example.org/docs/a.md).\n- one\n",
        page=Page(),
    )

    assert "(laws.md#x)" in page and "(contributing.md)" in page and "(index.md)" in page
    assert (
        "(repository/models/data/tora.toml)" in page and "(https://example.org/docs/a.md)" in page
    )
    assert "\n\n- one" in page


DOCSTRING = """Return gains K_i for u = -sum_i h_i K_i x with V' <= -2 alpha V.

    P*A + A'*P < 0

Parameters
----------
model : A (r, n, n) and *B*.
    More of ``it``.
x, y : two.

Raises
------
ModelError : shapes.
"""


def test_a_docstring_keeps_its_signs() -> None:
    text = beside("docstrings").as_markdown(DOCSTRING)

    assert "K\\_i" in text and "&lt;= -2 alpha" in text
    assert "```text\nP*A + A'*P < 0\n```" in text
    assert "**Parameters**" in text and "\n-   `model`: A (r, n, n) and \\*B\\*." in text
    assert "``it``" in text and "-   `x, y`: two." in text and "-   `ModelError`: shapes." in text
