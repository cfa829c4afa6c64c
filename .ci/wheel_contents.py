"""Compare a wheel with the folders it was built from: `wheel_contents.py WHEEL`."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path
from zipfile import ZipFile

ROOT = Path(__file__).resolve().parents[1]


def expected() -> set[str]:
    """Every file of the package folders, by its path in the wheel."""
    config = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders: dict[str, str] = config["tool"]["setuptools"]["package-dir"]
    return {
        f"{name.replace('.', '/')}/{path.relative_to(ROOT / folder).as_posix()}"
        for name, folder in folders.items()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def main(wheel: str) -> int:
    """Print what differs; return 1 if anything does."""
    with ZipFile(wheel) as archive:
        shipped = {name for name in archive.namelist() if ".dist-info/" not in name}
        licensed = any(name.endswith("/LICENSE") for name in archive.namelist())
    wanted = expected()
    for name in sorted(wanted - shipped):
        print(f"missing from the wheel: {name}")
    for name in sorted(shipped - wanted):
        print(f"in the wheel, not in the tree: {name}")
    if not licensed:
        print("missing from the wheel: LICENSE")
    return int(wanted != shipped or not licensed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
