"""Pages of docs/: code prints what is shown, and what is made from the code is not stale."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from takagi.certificates import Verdict
from takagi.certificates.checker.replay.claim_kinds import KINDS
from takagi.certificates.design.plant.design import certify_plant
from takagi.models import ModelError
from takagi.models.blending.blending import blending_of
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.entries import ActuatorEntry, EffortEntry
from tests.docs_pages import DOCS, ROOT, blocks, catalogue, fenced, printed, text_of
from tests.lmi.fixed_order.plants import PRINTED, best_of_hifoo, hifoo, names
from tests.plant_files import filed_plant

CODE = [
    pytest.param("claims.md", "", 3, marks=pytest.mark.slow),
    pytest.param("lmi.md", "", 16, marks=pytest.mark.slow),
    ("plant-theorems.md", "", 2),
    ("output-feedback.md", "", 1),
    ("models.md", "How premises are bounded", 3),
    ("new.md", "In Python", 3),
]


@pytest.mark.parametrize(("page", "section", "least"), CODE)
def test_every_block_prints_what_the_page_shows(page: str, section: str, least: int) -> None:
    shared: dict[str, object] = {}
    text = text_of(page)
    if section:
        text = text.split(f"\n## {section}\n", 1)[1].split("\n## ", 1)[0]
    found = blocks(text)
    for block in found:
        assert printed(block, shared, page) == (block.shown or ""), f"line {block.line}"

    assert len(found) >= least and len(found) == text.count("\n```python\n")


def test_every_output_stands_below_its_code() -> None:
    page = text_of("lmi.md")

    assert sum(block.shown is not None for block in blocks(page)) == page.count("\n```text\n")


@pytest.mark.parametrize("page", catalogue("make_pages").PAGES)
def test_a_page_is_what_its_generator_gives(page: str) -> None:
    """Run ``make docs`` when this fails."""
    assert catalogue("make_pages").PAGES[page]() == (DOCS / page).read_text(encoding="utf-8")


def test_every_kind_of_claim_is_on_the_page() -> None:
    page = text_of("claims.md")

    assert {kind for kind in KINDS if f"`{kind}`" not in page} == set()


def rows() -> dict[str, list[str]]:
    """Return the cells after the plant's name of the table of static output feedback."""
    text = text_of("output-feedback.md")
    table = text.split("<!-- begin table -->")[1].split("<!-- end table -->")[0]
    cells = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in table.strip().splitlines()[2:]
    ]
    return {name: rest for name, *rest in cells}


def test_the_table_has_every_plant_with_hifoos_figures() -> None:
    table = rows()

    assert list(table) == names()
    for name, (*shown, _, _) in table.items():
        figures = [f"{value:.5g}" if value is not None else "-" for value in hifoo(name)]
        assert shown == figures


def test_every_bound_is_proved_and_within_five_per_cent() -> None:
    for name, cells in rows().items():
        bound, ratio = cells[2], cells[3]
        found = re.fullmatch(r"(\S+)( \*)?", bound)
        assert found is not None, f"{name}: {bound}"
        gain = float(found[1])
        assert gain <= 1.05 * best_of_hifoo(name) + PRINTED
        if ratio != "both 0":
            assert abs(gain / best_of_hifoo(name) - float(ratio)) < 2e-3


MOST_STOPS = 25
MOST_ROOT_FILES = 10


def test_every_room_says_what_lies_in_it() -> None:
    rooms = catalogue("catalogue.rooms")
    dumb = [room.path for floor in rooms.FLOORS for room in rooms.rooms(floor) if not room.about]

    assert dumb == []


@pytest.mark.parametrize("floor", ["models", "lmi", "certificates", "reports", "cli"])
def test_few_files_lie_in_the_root_of_a_floor(floor: str) -> None:
    assert len(list((ROOT / floor).glob("*.py"))) <= MOST_ROOT_FILES


def test_one_number_can_be_followed() -> None:
    text = text_of("architecture.md").partition("## Follow one number")[2]
    stops = re.findall(r"^(\d+)\. `([^`]+)` `([^`]+)`:", text.partition("\n## ")[0], re.MULTILINE)

    assert [int(number) for number, _, _ in stops] == list(range(1, len(stops) + 1))
    assert 15 <= len(stops) <= MOST_STOPS
    for _, place, name in stops:
        content = (ROOT / place).read_text(encoding="utf-8")
        assert re.search(rf"\b{re.escape(name)}\b", content), f"{place} has no {name}"


OPENFAST = (ROOT / "docs" / "openfast.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTROLLERS = ("takagi", "ROSCO", "ROSCO with peak shaving", "reference")
COLUMNS = ("power_kW", "largest_speed_rpm", "pitch_travel_deg", "tower_del_MNm")


def measured() -> list[dict[str, str]]:
    path = ROOT / "docs" / "figures" / "openfast-table.csv"
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def test_the_page_has_the_tables_of_the_file() -> None:
    command = [sys.executable, "benchmarks/openfast_table.py", "--table"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT).stdout

    tables = printed.split("\n\n")
    winds = {row["mean_wind_mps"] for row in measured()}
    assert [len(table.splitlines()) for table in tables] == [2 + len(winds)] * 2
    assert all(table.strip() in OPENFAST for table in tables)


def test_every_wind_has_every_controller_once() -> None:
    rows = [(row["mean_wind_mps"], row["controller"]) for row in measured()]

    assert sorted(rows) == sorted(
        (wind, name) for wind in {row[0] for row in rows} for name in CONTROLLERS
    )


@pytest.mark.parametrize("column", COLUMNS)
def test_the_readme_has_all_winds_of_the_file(column: str) -> None:
    winds = {row["mean_wind_mps"]: row for row in measured()}
    for wind in winds:
        at = {row["controller"]: row[column] for row in measured() if row["mean_wind_mps"] == wind}
        line = re.search(rf"^\| {wind} \|.*$", README, flags=re.MULTILINE)

        assert line is not None
        assert " / ".join(at[name] for name in ("takagi", "reference", "ROSCO")) in line[0]


BLENDING = text_of("blending.md")


@pytest.mark.slow
def test_the_vessel_is_proved_under_one_gain(tmp_path: Path) -> None:
    """The gains that `takagi design` gives it, to four digits: everything, both valves 20 % off."""
    plant = filed_plant(tmp_path, fenced(BLENDING, "toml")[0], "vessel.toml")
    gains = [[1.059, 0.2606, 4.218]]

    found = certify_plant(plant, lambda m: np.array([gains] * len(m.A)), PlantSettings())
    assert found.verdict is Verdict.PROVED
    assert {"effort-blend", "invariant-ellipsoid", "input-limits"} <= {
        claim["kind"] for claim in found.document["claims"]
    }


def test_the_opening_that_is_worked_out_on_the_page(tmp_path: Path) -> None:
    """-0.8 bar/s at 3 bar: the vent is open by 0.8; the supply idles."""
    from takagi.models.blending.blending import RunTimeBlending

    plant = filed_plant(tmp_path, fenced(BLENDING, "toml")[0], "vessel.toml")
    blending = blending_of(plant)
    assert blending is not None
    commands = RunTimeBlending(blending).commands(np.array([3e5, 0.0, -0.8e5]))

    assert commands == pytest.approx([0.8, 0.0])


def test_the_message_is_the_one_that_is_shown(tmp_path: Path) -> None:
    with pytest.raises(ModelError) as refused:
        filed_plant(
            tmp_path,
            fenced(BLENDING, "toml")[0].replace("range = [3, 5]", "range = [3, 9]"),
            "vessel.toml",
        )
    shown = re.search(r"```text\n(vessel.toml.*?)\n```", BLENDING, re.DOTALL)

    assert shown is not None
    # The page's file begins without the empty line of a comment.
    assert str(refused.value).endswith(shown.group(1).partition(": ")[2])


def test_every_field_is_on_the_page() -> None:
    names = {*EffortEntry.model_fields, *ActuatorEntry.model_fields}

    assert not [
        name for name in names if f"`{name}`" not in BLENDING and f"`effort.{name}`" not in BLENDING
    ]
