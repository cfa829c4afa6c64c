"""docs/openfast.md and README say what docs/figures/openfast-table.csv holds."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "openfast.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTROLLERS = ("takagi", "ROSCO", "ROSCO with peak shaving", "reference")
COLUMNS = ("power_kW", "largest_speed_rpm", "pitch_travel_deg", "tower_del_MNm")


def measured() -> list[dict[str, str]]:
    path = ROOT / "docs" / "figures" / "openfast-table.csv"
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


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


@pytest.mark.parametrize("column", COLUMNS)
def test_the_readme_has_all_winds_of_the_file(column: str) -> None:
    """Those too where the law is worse; takagi, reference controller, ROSCO in each cell."""
    winds = {row["mean_wind_mps"]: row for row in measured()}
    for wind in winds:
        at = {row["controller"]: row[column] for row in measured() if row["mean_wind_mps"] == wind}
        line = re.search(rf"^\| {wind} \|.*$", README, flags=re.MULTILINE)

        assert line is not None
        assert " / ".join(at[name] for name in ("takagi", "reference", "ROSCO")) in line[0]
