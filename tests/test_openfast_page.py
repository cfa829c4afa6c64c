"""docs/openfast.md and README say what docs/figures/openfast-table.csv holds."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "openfast.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTROLLERS = ("takagi", "ROSCO", "ROSCO with peak shaving", "published")


def measured() -> list[dict[str, str]]:
    path = ROOT / "docs" / "figures" / "openfast-table.csv"
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def tower_share(wind: str, other: str) -> str:
    at = {row["controller"]: row for row in measured() if row["mean_wind_mps"] == wind}
    return f"{float(at['takagi']['tower_del_MNm']) / float(at[other]['tower_del_MNm']):.2f}"


def test_the_page_has_the_table_of_the_file() -> None:
    """What benchmarks/openfast_table.py --table prints, line by line."""
    command = [sys.executable, "benchmarks/openfast_table.py", "--table"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT).stdout

    assert len(printed.splitlines()) == 2 + len({row["mean_wind_mps"] for row in measured()})
    assert printed in PAGE


def test_every_wind_has_every_controller_once() -> None:
    rows = [(row["mean_wind_mps"], row["controller"]) for row in measured()]

    assert sorted(rows) == sorted(
        (wind, name) for wind in {row[0] for row in rows} for name in CONTROLLERS
    )


def test_the_first_number_of_the_readme_is_the_file_s() -> None:
    """The tower's fatigue at 11 and 13 m/s over ROSCO's, then over the published controller's."""
    said = re.search(
        r"fatigue load is (\S+) and (\S+) times that of a re-tuned\s+ROSCO, and (\S+) and (\S+) "
        r"times that of the published",
        README,
    )

    assert said is not None
    assert list(said.groups()) == [
        tower_share(wind, other) for other in ("ROSCO", "published") for wind in ("11", "13")
    ]
