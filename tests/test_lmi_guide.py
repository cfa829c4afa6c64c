"""docs/lmi.md does what it says: its code runs in order, and prints what the page shows."""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import pytest

PAGE = Path(__file__).resolve().parents[1] / "docs" / "lmi.md"


class Block(NamedTuple):
    """Code, where it begins on the page, and the output that is shown below it."""

    line: int
    code: str
    shown: str | None


def blocks(page: str) -> list[Block]:
    """The page's Python, each with the block of text that follows it."""
    pattern = re.compile(r"^```python\n(.*?)^```$(?:\n\n^```text\n(.*?)^```$)?", re.DOTALL | re.M)
    return [
        Block(page[: found.start()].count("\n") + 2, found[1], found[2])
        for found in pattern.finditer(page)
    ]


def printed(block: Block, names: Mapping[str, object]) -> str:
    """What the block prints, run where the blocks before it were."""
    # As many empty lines as the page has before it, so that a traceback names the page's line.
    code = compile("\n" * (block.line - 1) + block.code, str(PAGE), "exec")
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(code, names)  # type: ignore[arg-type]
    return out.getvalue()


@pytest.mark.slow
def test_every_block_prints_what_the_page_shows() -> None:
    """All blocks in one namespace, in order; a block without output prints nothing."""
    names: dict[str, object] = {}
    found = blocks(PAGE.read_text(encoding="utf-8"))
    for block in found:
        assert printed(block, names) == (block.shown or ""), f"line {block.line}"

    assert len(found) > 15


def test_every_output_stands_below_its_code() -> None:
    """A block of text that no code precedes would be shown and never checked."""
    page = PAGE.read_text(encoding="utf-8")

    assert sum(block.shown is not None for block in blocks(page)) == page.count("\n```text\n")
