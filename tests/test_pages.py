"""Pages of docs/: code prints what is shown, and what is made from the code is not stale."""

from __future__ import annotations

import csv
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from takagi.certificates import Verdict
from takagi.certificates.checker.replay.claim_kinds import KINDS
from takagi.certificates.design.plant.design import certify_plant
from takagi.cli import command as cli_command
from takagi.cli.main import VERBS, main
from takagi.cli.verbs import check as check_verb
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


PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
# Pages whose Python a test of another file runs, and how many blocks it runs.
ELSEWHERE = {
    "README.md": ("tests/test_pages.py", 1),
    "certificate.md": ("tests/cli/test_certify.py", 1),
    "gain-file.md": ("tests/reports/test_gain_file_alone.py", 2),
    "models.md": ("tests/models/control_systems/test_systems.py", 1),
    "plants.md": ("tests/models/plant/test_plants_page.py", 1),
}


def shell(text: str) -> Iterator[str]:
    """Yield the commands of takagi in blocks of a shell: fenced, or indented by four spaces."""
    indented = re.findall(r"^    (?:\$ )?(takagi .*(?:(?<=\\)\n.*)*)", text, flags=re.MULTILINE)
    for block in [*fenced(text, "sh"), *fenced(text, "bash"), *indented]:
        for line in block.replace("\\\n", " ").splitlines():
            for part in re.split(r"&&|;|\|", line):
                if part.strip().startswith("takagi "):
                    yield part.strip().partition(" < ")[0].partition(" > ")[0]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_is_understood(
    page: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cli_command, "guard", lambda work, as_json=False: 0)
    monkeypatch.setattr(check_verb, "_check", lambda options: 0)

    wrong = [
        f"{line}\n{capsys.readouterr().err}"
        for line in shell(page.read_text(encoding="utf-8"))
        if main(shlex.split(line, comments=True)[1:]) != 0
    ]

    assert wrong == []


def test_a_wrong_option_is_noticed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cli_command, "guard", lambda work, as_json=False: 0)

    assert main(["design", "cart_pole", "--out", "build/x", "--decay-rate", "2"]) == 0
    assert main(["design", "cart_pole", "--out", "build/x", "--decay-speed", "2"]) == 2


def test_every_block_of_python_runs_in_a_test() -> None:
    """A page that gets a block is named here, or in the list of tests/test_pages.py."""
    run = {str(getattr(entry, "values", entry)[0]) for entry in CODE}
    without = []
    for page in PAGES:
        count = len(fenced(page.read_text(encoding="utf-8"), "python"))
        file, blocks = ELSEWHERE.get(page.name, ("", 0))
        if blocks:
            assert page.name in (ROOT / file).read_text(encoding="utf-8")
        if count and page.name not in run and count != blocks:
            without.append(f"{page.name}: {count} blocks, {blocks} of them run")

    assert without == []


def test_the_python_example_runs_as_it_stands(tmp_path: Path) -> None:
    (example,) = fenced(README, "python")
    command = [sys.executable, "-c", example]

    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "Verdict.PROVED\n", "")


@pytest.mark.slow
def test_the_first_plant_is_proved_as_it_stands(tmp_path: Path) -> None:
    (tmp_path / "pendulum.toml").write_text(fenced(README, "toml")[0], encoding="utf-8")

    assert main(["design", str(tmp_path / "pendulum.toml"), "--out", str(tmp_path / "out")]) == 0
    made = (tmp_path / "out/figures/phase.svg").read_text(encoding="utf-8")
    shown = (ROOT / "docs/figures/pendulum-set.svg").read_text(encoding="utf-8")
    assert made.count("<path") == shown.count("<path")


def test_every_verb_is_in_the_table() -> None:
    named = set(re.findall(r"^\| `takagi (\w+)", README, flags=re.MULTILINE))

    assert named == {verb.name for verb in VERBS}


def test_every_option_in_the_pages_exists() -> None:
    ours = "design|certify|report|check|simulate|appendix|models"
    source = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "cli").rglob("*.py"))
    text = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if re.search(rf"takagi ({ours})|^\| `--", line)]
    options = {name for line in lines for name in re.findall(r"--([a-z][a-z-]+)", line)}

    missing = {n for n in options if f"--{n}" not in source and n.replace("-", "_") not in source}

    assert options and missing == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    targets = re.findall(r"\]\(([^)#\s]+)[^)]*\)", text)

    broken = [t for t in targets if "://" not in t and not (page.parent / t).exists()]

    assert broken == []
