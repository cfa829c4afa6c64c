"""Pages of docs/ for tests: their text, their code, and the modules that make them."""

from __future__ import annotations

import contextlib
import io
import re
import sys
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


def text_of(page: str) -> str:
    return (DOCS / page).read_text(encoding="utf-8")


def fenced(text: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


@cache
def catalogue(name: str) -> Any:
    sys.path.insert(0, str(DOCS))
    try:
        return import_module(name)
    finally:
        sys.path.remove(str(DOCS))


class Block(NamedTuple):
    """Code, where it begins on the page, and the output that is shown below it."""

    line: int
    code: str
    shown: str | None


def blocks(text: str) -> list[Block]:
    """Return the page's Python, each with the block of text that follows it."""
    pattern = re.compile(r"^```python\n(.*?)^```$(?:\n\n^```text\n(.*?)^```$)?", re.DOTALL | re.M)
    return [
        Block(text[: found.start()].count("\n") + 2, found[1], found[2])
        for found in pattern.finditer(text)
    ]


def printed(block: Block, names: Mapping[str, object], page: str) -> str:
    """Return what the block prints, run where the blocks before it were."""
    # As many empty lines as the page has before it, so that a traceback names the page's line.
    code = compile("\n" * (block.line - 1) + block.code, str(DOCS / page), "exec")
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(code, names)  # type: ignore[arg-type]
    return out.getvalue()
