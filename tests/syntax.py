"""What tests of the code's shape ask of a source file; each file is parsed and walked once."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Syntax:
    """(module, name) of each import, the name of ``import x`` empty; whether any is relative."""

    imports: tuple[tuple[str, str], ...]
    relative: bool


@cache
def syntax(path: Path) -> Syntax:
    imports: list[tuple[str, str]] = []
    relative = False
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            imports += [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            relative = relative or node.level > 0
            imports += [(node.module or "", alias.name) for alias in node.names]
    return Syntax(tuple(imports), relative)


def imported_modules(folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield (file, module) of each import in a folder; none may be relative."""
    for file in sorted(folder.rglob("*.py")):
        source = syntax(file)
        assert not source.relative, file.name
        yield from ((file, module) for module, _ in source.imports)
