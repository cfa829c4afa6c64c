"""The section "How premises are bounded" of docs/models.md prints what it shows."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[3] / "docs" / "models.md"
BLOCK = re.compile(r"^```python\n(.*?)^```$\n\n^```text\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def test_every_block_prints_what_the_page_shows() -> None:
    """The blocks run in order and share their names."""
    page = PAGE.read_text(encoding="utf-8")
    section = page.split("\n## How premises are bounded\n", 1)[1].split("\n## ", 1)[0]
    names: dict[str, object] = {}
    found = BLOCK.findall(section)
    for code, shown in found:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(code, str(PAGE), "exec"), names)
        assert out.getvalue() == shown, code

    assert len(found) == section.count("```python") == 3
