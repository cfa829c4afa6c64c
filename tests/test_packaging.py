"""The folder names are not the import names; these tests keep the two maps honest."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
CONFIG = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
SETUPTOOLS = CONFIG["tool"]["setuptools"]
FOLDERS: dict[str, str] = SETUPTOOLS["package-dir"]


def files_on_disk() -> list[Path]:
    """Every file under a package folder, except what Python itself leaves there."""
    return [
        path
        for folder in FOLDERS.values()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    ]


def packages_on_disk() -> dict[str, Path]:
    """Import name -> folder, for every folder under a package folder that holds a file."""
    return {
        ".".join([name, *path.parent.relative_to(ROOT / folder).parts]): path.parent
        for name, folder in FOLDERS.items()
        for path in files_on_disk()
        if path.is_relative_to(ROOT / folder)
    }


def test_links_mirror_the_package_map() -> None:
    """A missing or broken link makes mypy check an empty tree and report success."""
    links = (ROOT / ".links/takagi").iterdir()

    floors = {name: folder for name, folder in FOLDERS.items() if "." in name}
    expected = {name: (ROOT / folder).resolve() for name, folder in floors.items()}

    assert {f"takagi.{link.name}": link.resolve() for link in links} == expected


def test_every_package_on_disk_is_shipped() -> None:
    """An unlisted sub-package imports in an editable install and is absent from the wheel."""
    assert sorted(SETUPTOOLS["packages"]) == sorted(packages_on_disk())


def test_every_package_says_what_it_holds() -> None:
    inits = {folder / "__init__.py" for folder in packages_on_disk().values()}

    silent = [
        str(init.relative_to(ROOT))
        for init in sorted(inits)
        if not init.is_file() or not ast.get_docstring(ast.parse(init.read_text("utf-8")))
    ]

    assert silent == []


def test_every_data_file_is_shipped() -> None:
    """A file that no pattern matches works in an editable install and is absent from the wheel."""
    patterns = SETUPTOOLS["package-data"]["*"]

    forgotten = [
        str(path.relative_to(ROOT))
        for path in files_on_disk()
        if path.suffix != ".py" and not any(fnmatch(path.name, pattern) for pattern in patterns)
    ]

    assert forgotten == []


def test_every_floor_is_typed() -> None:
    """Without `py.typed`, type checkers ignore the annotations of an installed package."""
    assert all((ROOT / folder / "py.typed").is_file() for folder in FOLDERS.values())


def test_both_lists_of_development_tools_are_the_same() -> None:
    """One is for installers that know dependency groups, the other for plain pip."""
    assert CONFIG["dependency-groups"]["dev"] == CONFIG["project"]["optional-dependencies"]["dev"]


@pytest.mark.parametrize("name", ["pyproject.toml", "Makefile", ".ci/run"])
def test_no_address_is_named(name: str) -> None:
    """Where packages come from is the installer's business, never the project's."""
    assert "://" not in (ROOT / name).read_text(encoding="utf-8")


def test_the_release_is_one_number_everywhere() -> None:
    program = "import takagi, takagi.models; print('takagi', takagi.__version__)"
    said = [
        subprocess.run([sys.executable, *how], capture_output=True, text=True, check=True).stdout
        for how in (["-c", program], ["-m", "takagi.cli", "--version"])
    ]
    assert said == [f"takagi {CONFIG['project']['version']}\n"] * 2


def test_a_foreign_models_folder_in_the_way_is_not_imported(tmp_path: Path) -> None:
    """The folders have everyday names: one of the user's own must not be taken for ours."""
    for folder in FOLDERS.values():
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "__init__.py").write_text("raise RuntimeError('foreign folder')\n")

    # `-m` puts the working directory first on the path: the hardest case.
    ran = subprocess.run(
        [sys.executable, "-m", "takagi.cli", "models"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )

    assert (ran.returncode, ran.stderr) == (0, "")
    assert "nrel5mw" in ran.stdout
