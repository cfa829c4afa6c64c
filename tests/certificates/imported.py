"""Which modules the sources of a folder import, wherever the import stands."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.syntax import syntax


def imported_modules(folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield (file, module) of each import; none may be relative."""
    for file in sorted(folder.rglob("*.py")):
        source = syntax(file)
        assert not source.relative, file.name
        yield from ((file, module) for module, _ in source.imports)
