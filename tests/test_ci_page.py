"""docs/ci.md: its commands run, and fail as it says; workflow files: test_ci_workflows."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.cli.main import main
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_files.loader import PlantFile, load_plant
from takagi.reports.gains_file.envelope import dump_gains
from takagi.reports.gains_file.plant import plant_gain_file
from tests.undrawn import undrawn

Capture = pytest.CaptureFixture[str]
PAGE = (Path(__file__).parents[1] / "docs" / "ci.md").read_text(encoding="utf-8")
PLANT = """
format = 1
kind = "plant"
name = "cart on a spring"

[parameters]
mass = { value = 1, unit = "kg" }
k = { value = 2, unit = "N/m" }
k3 = { value = 0.5, unit = "N/m^3" }

[states]
x = { unit = "m", range = [-1, 1] }
v = { unit = "m/s", range = [-2, 2] }

[inputs]
F = { unit = "N" }

[equations]
x = "v"
v = "(F - k*x + k3*x^3)/mass"
"""


def commands(language: str) -> list[list[str]]:
    """Return the takagi commands of the page's blocks in a language, as arguments."""
    blocks = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines()]
    found = [re.search(r"(?:^|- (?:run: )?|run: )takagi (.*)$", line) for line in lines]
    return [shlex.split(match[1]) for match in found if match]


def shell() -> list[list[str]]:
    """Return the three commands of the page's block for the shell."""
    return commands("sh")


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A repository as the page wants it: plant, gains and certificate."""
    folder = tmp_path_factory.mktemp("repository")
    (folder / "plant.toml").write_text(PLANT, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch, undrawn():
        patch.chdir(folder)
        design = re.search(r"^    takagi (design .*)$", PAGE, re.MULTILINE)
        assert design is not None
        assert main(shlex.split(design[1])) == 0
    return folder


@pytest.fixture
def inside(repository: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(repository)
    return repository


@pytest.mark.slow
def test_the_commands_of_the_page_pass(inside: Path) -> None:
    """Three lines, three times status 0, and the reports are there to be read."""
    (inside / "base.json").write_bytes((inside / "build" / "certificate.json").read_bytes())
    assert [command[0] for command in shell()] == ["check", "certify", "compare"]
    for command in shell():
        assert main(command) == 0, command

    suite = ElementTree.parse(inside / "checks.xml").getroot()[0]
    assert suite.get("failures") == "0" and len(suite.findall("testcase")) > 3
    assert json.loads((inside / "checks.sarif").read_text())["runs"][0]["results"] == []
    assert "PROVED" in (inside / "checks.md").read_text()
    assert "nothing got worse" in (inside / "comparison.md").read_text()


def told(edited: Path, old: str, new: str, command: list[str], capsys: Capture) -> tuple[int, str]:
    """Run a command with one file changed; return its status and all that it prints."""
    before = edited.read_text(encoding="utf-8")
    assert old in before
    edited.write_text(before.replace(old, new, 1), encoding="utf-8")
    try:
        status = main(command)
    finally:
        edited.write_text(before, encoding="utf-8")
    printed = capsys.readouterr()
    return status, printed.out + printed.err


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("mass = { value = 1", "mass = { value = 2", "parameters.mass.value is 2 there, 1 in"),
        ("range = [-1, 1]", "range = [-0.5, 1]", "states.x.range[0] is -0.5 there, -1 in"),
        ("- k*x ", "- 3*k*x ", "equations.v is (F - 3*k*x + k3*x^3)/mass there, (F - k*x +"),
        ('name = "cart', 'name = "Cart', "name is Cart on a spring there, cart on a spring in"),
    ],
)
def test_a_changed_model_is_refused_with_what_changed(
    inside: Path, capsys: Capture, old: str, new: str, what: str
) -> None:
    """Status 1, the field and both values, though every proof in the file is right."""
    status, text = told(inside / "plant.toml", old, new, shell()[0], capsys)

    assert status == 1
    assert "not the certificate's model" in text and what in text


def test_a_changed_gain_is_refused_with_both_numbers(inside: Path, capsys: Capture) -> None:
    gains = inside / "build" / "gains.json"
    law = json.loads(gains.read_text())["law"]
    before = gains.read_text()
    first = law["K"][0][0][0]
    law["K"][0][0][0] = 123.5
    gains.write_text(json.dumps({"law": law}))
    try:
        status = main(shell()[0])
    finally:
        gains.write_text(before)

    assert status == 1
    text = capsys.readouterr().err
    assert f"K[0][0][0] is 123.5 there, {first!r} in the certificate" in text


def test_a_worse_design_fails_against_the_baseline(inside: Path, capsys: Capture) -> None:
    """A smaller decay rate is asked for: proved, and worse; the option is named."""
    (inside / "base.json").write_bytes((inside / "build" / "certificate.json").read_bytes())
    command = [part for part in shell()[1] if part not in ("--gains", "build/gains.json")]

    assert main([*command, "--decay-rate", "0.05"]) == 1

    text = capsys.readouterr().out
    assert "new.json: PROVED" in text and "WORSE" in text
    assert "configuration: decay_rate: nothing -> 0.05" in text


FOLDER = Path(__file__).parents[1] / "docs" / "ci"
GITHUB, GITLAB = ((FOLDER / name).read_text("utf-8") for name in ("github.yml", "gitlab.yml"))
WHO = ("-c", "user.name=test", "-c", "user.email=test@example.invalid")


def git(place: Path, *arguments: str) -> str:
    """Run git; return what it prints."""
    done = subprocess.run(
        ["git", *WHO, *arguments], cwd=place, check=True, capture_output=True, text=True
    )
    return done.stdout


def github_steps() -> list[tuple[str, bool, str]]:
    """Return (name, whether it runs after a failure, script) of the steps that run commands."""
    pattern = r"- name: (\w[\w ]*)\n( +if: always\(\)\n)? +run: \|\n((?: {10}.*\n)+)"
    found = re.findall(pattern, GITHUB)
    return [(name, bool(always), script) for name, always, script in found]


def gitlab_script() -> str:
    """Return the lines of ``script`` as one shell script."""
    block = re.search(r"\n  script:\n((?:    .*\n)+)", GITLAB)
    assert block is not None
    return "".join(f"{line}\n" for line in re.findall(r"^    - (.*)$", block[1], re.MULTILINE))


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bare repository whose branch main has a plant and its design, in two commits."""
    work = tmp_path_factory.mktemp("work")
    git(work, "init", "--quiet", "--initial-branch=main")
    (work / "plant.toml").write_text(PLANT, encoding="utf-8")
    path = work / "plant.toml"
    asked = PlantSettings(decay_rate=0.2)
    # As `takagi design` does, without its drawings.
    found = design_plant(load_plant(path), asked, files=PlantFile.of(path).files)
    assert isinstance(found, PlantDesign) and found.proved
    (work / "build").mkdir()
    (work / "build" / "certificate.json").write_text(dumps(found.document), encoding="utf-8")
    (work / "build" / "gains.json").write_text(dump_gains(plant_gain_file(found)), "utf-8")
    for text in ("first", "second"):
        (work / "note.txt").write_text(text, encoding="utf-8")
        git(work, "add", ".")
        git(work, "commit", "--quiet", "-m", text)
    bare = tmp_path_factory.mktemp("bare") / "origin.git"
    git(work, "clone", "--quiet", "--bare", str(work), str(bare))
    return bare


def changed(base: Path, folder: Path, change: Callable[[Path], object]) -> Path:
    """Return a clone with a branch on which something was changed and committed."""
    place = folder / "clone"
    git(folder, "clone", "--quiet", str(base), str(place))
    git(place, "checkout", "--quiet", "-b", "change")
    change(place)
    (place / "note.txt").write_text("of the branch", encoding="utf-8")
    git(place, "commit", "--quiet", "-a", "-m", "a change")
    return place


def nothing(_: Path) -> None:
    """Change nothing that counts."""


def worse(place: Path) -> None:
    """Gains of a tenth of the rate, with a certificate of their own beside them."""
    command = ["certify", str(place / "plant.toml"), "--gains", str(place / "slow.json")]
    content = json.loads((place / "build" / "gains.json").read_text("utf-8"))
    law = content["law"]
    law["K"] = [[[0.3 * gain for gain in row] for row in matrix] for matrix in law["K"]]
    (place / "slow.json").write_text(json.dumps(content), "utf-8")
    own = [*command, "--out", str(place / "build" / "certificate.json")]
    assert main([*own, "--gains-out", str(place / "build" / "gains.json")]) == 0
    (place / "slow.json").unlink()


def edited(place: Path) -> None:
    """A limit of the gain file alone: the certificate is not about it any more."""
    path = place / "build" / "gains.json"
    content = json.loads(path.read_text("utf-8"))
    content["states"][0]["range"] = [-2, 2]
    path.write_text(json.dumps(content), "utf-8")


def environment(folder: Path, **more: str) -> Mapping[str, str]:
    """Return an environment in which ``takagi`` is this checkout's, with nothing of a real job."""
    tools = folder / "tools"
    tools.mkdir(exist_ok=True)
    script = tools / "takagi"
    script.write_text(
        f'#!/bin/sh\nexec "{sys.executable}" -c '
        '"import sys; from takagi.cli.main import main; sys.exit(main(sys.argv[1:]))" "$@"\n'
    )
    script.chmod(0o755)
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("CI", "GIT"))}
    return {**kept, "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}", **more}


def bash(place: Path, script: str, env: Mapping[str, str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["bash", "-eo", "pipefail", "-c", script],
        cwd=place,
        env=env,
        capture_output=True,
        text=True,
    )


def on_github(place: Path, folder: Path) -> tuple[dict[str, int], str]:
    """Run the steps as GitHub does; return the status of each that ran, and the summary."""
    summary = folder / "summary.md"
    env = environment(folder, TARGET="main", GITHUB_STEP_SUMMARY=str(summary))
    found: dict[str, int] = {}
    for name, always, script in github_steps():
        if always or not any(found.values()):
            found[name] = bash(place, script, env).returncode
    return found, summary.read_text("utf-8") if summary.exists() else ""


@pytest.mark.slow
def test_an_unchanged_branch_passes(base: Path, tmp_path: Path) -> None:
    place = changed(base, tmp_path, nothing)

    statuses, summary = on_github(place, tmp_path)

    names = ["baseline of the target branch", "check", "certify", "compare", "summary"]
    assert statuses == dict.fromkeys(names, 0)
    assert "PROVED" in summary and "nothing got worse" in summary


@pytest.mark.slow
def test_a_branch_that_brings_its_own_baseline_fails(base: Path, tmp_path: Path) -> None:
    """Its certificate is PROVED and its files fit; but the target branch had a better loop."""
    place = changed(base, tmp_path, worse)

    statuses, summary = on_github(place, tmp_path)

    assert statuses["check"] == 0
    assert statuses["certify"] == statuses["compare"] == 1
    assert "decay rate" in summary


@pytest.mark.slow
def test_where_check_fails_the_comparison_is_shown(base: Path, tmp_path: Path) -> None:
    """The job fails by its first step; the others run, and the summary has both."""
    place = changed(base, tmp_path, edited)

    statuses, summary = on_github(place, tmp_path)

    assert statuses["check"] == 1
    assert statuses["certify"] == statuses["compare"] == statuses["summary"] == 0
    assert "states[0].range" in summary and "nothing got worse" in summary


@pytest.mark.slow
def test_gitlab_notices_the_same(base: Path, tmp_path: Path) -> None:
    """A changed limit: the script fails by its check, and the comparison is there."""
    place = changed(base, tmp_path, edited)

    done = bash(
        place,
        gitlab_script(),
        environment(tmp_path, CI_MERGE_REQUEST_TARGET_BRANCH_NAME="main", CI_COMMIT_BRANCH=""),
    )

    assert done.returncode == 1, done.stderr
    assert (place / "comparison.md").exists() and (place / "checks.xml").exists()


def test_on_the_target_branch_the_commit_before_is_the_baseline(base: Path, tmp_path: Path) -> None:
    """There the tip is what is checked; it must not be compared with itself."""
    place = changed(base, tmp_path, nothing)
    git(place, "push", "--quiet", "origin", "change:main-2")
    env = environment(tmp_path, TARGET="main-2")
    (name, _, script) = github_steps()[0]

    done = bash(place, script.replace("git show", "echo"), env)

    assert name.startswith("baseline") and done.returncode == 0, done.stderr
    assert (place / "base.json").read_text("utf-8").strip() == (
        f"{git(place, 'rev-parse', 'HEAD').strip()}^:build/certificate.json"
    )


def test_no_address_of_a_registry_stands_in_the_files() -> None:
    for text in (GITHUB, GITLAB):
        assert "http" not in text and "://" not in text and "index-url" not in text
