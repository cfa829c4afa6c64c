"""The section "Fewer rules" of docs/models.md runs in order and prints what it shows."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[3] / "docs" / "models.md"
BLOCK = re.compile(r"^```python\n(.*?)^```$(?:\n\n^```text\n(.*?)^```$)?", re.DOTALL | re.MULTILINE)


def section() -> str:
    page = PAGE.read_text(encoding="utf-8")
    return page.split("\n## Fewer rules\n", 1)[1].split("\n## ", 1)[0]


@pytest.mark.slow
def test_every_block_prints_what_the_page_shows() -> None:
    names: dict[str, object] = {}
    found = list(BLOCK.finditer(section()))
    for block in found:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(block[1], str(PAGE), "exec"), names)
        assert out.getvalue() == (block[2] or ""), block[1]

    assert len(found) == 5


def test_every_output_stands_below_its_code() -> None:
    shown = sum(block[2] is not None for block in BLOCK.finditer(section()))

    assert shown == section().count("\n```text\n")
