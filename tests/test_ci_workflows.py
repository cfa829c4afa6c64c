"""The workflow files of `takagi new --ci`: their commands run, pass and fail as they should."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
import yaml

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.cli.main import main
from takagi.cli.runs.ci_workflow import FILES
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_files.loader import PlantFile
from takagi.reports.design_folder import law_files
from takagi.reports.output import write_folder
from tests.takagi_tool import path_with_takagi
from tests.undrawn import undrawn

WHO = ("-c", "user.name=test", "-c", "user.email=test@example.invalid")


def git(place: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["git", *WHO, *arguments], cwd=place, check=True, capture_output=True, text=True
    )
    return done.stdout


def written(place: Path, service: str, subject: str) -> str:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        assert main(["new", subject, "--ci", service, "--force"]) == 0
        return (place / FILES[service]).read_text(encoding="utf-8")


def github_steps(text: str) -> list[tuple[str, bool, str]]:
    """Return (name, whether it runs after a failure, script) of the steps, but the installation."""
    (job,) = yaml.safe_load(text)["jobs"].values()
    steps = [step for step in job["steps"] if "run" in step]
    assert [step["run"].split() for step in steps[:1]] == [["pip", "install", "takagi"]]
    return [(step["name"], step.get("if") == "always()", step["run"]) for step in steps[1:]]


def gitlab_script(text: str) -> str:
    return "\n".join(yaml.safe_load(text)["takagi"]["script"])


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bare repository whose branch main has a plant and its design, in two commits."""
    work = tmp_path_factory.mktemp("work")
    git(work, "init", "--quiet", "--initial-branch=main")
    (work / "plant.toml").write_text(PLANT, encoding="utf-8")
    # As `takagi design` does in this folder, without its drawings.
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(work)
        source = PlantFile.of(Path("plant.toml"))
        asked = PlantSettings(decay_rate=0.2)
        found = design_plant(source.model, asked, files=source.files)
        assert isinstance(found, PlantDesign) and found.proved
        write_folder(work / "build", law_files(found, source=source))
    for text in ("first", "second"):
        (work / "note.txt").write_text(text, encoding="utf-8")
        git(work, "add", ".")
        git(work, "commit", "--quiet", "-m", text)
    bare = tmp_path_factory.mktemp("bare") / "origin.git"
    git(work, "clone", "--quiet", "--bare", str(work), str(bare))
    return bare


def changed(base: Path, folder: Path, change: Callable[[Path], object]) -> Path:
    place = folder / "clone"
    git(folder, "clone", "--quiet", str(base), str(place))
    git(place, "checkout", "--quiet", "-b", "change")
    change(place)
    (place / "note.txt").write_text("of the branch", encoding="utf-8")
    git(place, "commit", "--quiet", "-a", "-m", "a change")
    return place


def nothing(_: Path) -> None:
    return


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
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("CI", "GIT"))}
    return {**kept, "PATH": path_with_takagi(folder / "tools"), **more}


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
    for name, always, script in github_steps(written(place, "github", "build")):
        if always or not any(found.values()):
            found[name] = bash(place, script, env).returncode
    return found, summary.read_text("utf-8") if summary.exists() else ""


@pytest.mark.slow
def test_an_unchanged_branch_passes(base: Path, tmp_path: Path) -> None:
    place = changed(base, tmp_path, nothing)

    statuses, summary = on_github(place, tmp_path)

    names = ["base", "check", "compare", "summary"]
    assert statuses == dict.fromkeys(names, 0)
    assert "PROVED" in summary and "nothing got worse" in summary


@pytest.mark.slow
def test_a_branch_that_brings_its_own_baseline_fails(base: Path, tmp_path: Path) -> None:
    """Its certificate is PROVED and its files fit; but the target branch had a better loop."""
    place = changed(base, tmp_path, worse)

    statuses, summary = on_github(place, tmp_path)

    assert statuses["check"] == 0
    assert statuses["compare"] == 1
    assert "decay rate" in summary


@pytest.mark.slow
def test_where_check_fails_the_comparison_is_shown(base: Path, tmp_path: Path) -> None:
    place = changed(base, tmp_path, edited)

    statuses, summary = on_github(place, tmp_path)

    assert statuses["check"] == 1
    assert statuses["compare"] == statuses["summary"] == 0
    assert "states[0].range" in summary and "nothing got worse" in summary


@pytest.mark.slow
def test_gitlab_notices_the_same(base: Path, tmp_path: Path) -> None:
    place = changed(base, tmp_path, edited)

    done = bash(
        place,
        gitlab_script(written(place, "gitlab", "build")),
        environment(tmp_path, CI_MERGE_REQUEST_TARGET_BRANCH_NAME="main", CI_COMMIT_BRANCH=""),
    )

    assert done.returncode == 1, done.stderr
    names = ("comparison.md", "comparison.html", "checks.xml", "checks.sarif")
    assert all((place / "takagi-ci" / name).exists() for name in names)


def test_on_the_target_branch_the_commit_before_is_the_baseline(base: Path, tmp_path: Path) -> None:
    """There the tip is what is checked; it must not be compared with itself."""
    place = changed(base, tmp_path, nothing)
    git(place, "push", "--quiet", "origin", "change:main-2")
    env = environment(tmp_path, TARGET="main-2")
    (name, _, script) = github_steps(written(place, "github", "build"))[0]

    done = bash(place, script, env)

    assert name == "base" and done.returncode == 0, done.stderr
    assert git(place / "takagi-base", "rev-parse", "HEAD") == git(place, "rev-parse", "HEAD^")


@pytest.mark.slow
def test_a_plant_is_designed_on_both_branches(base: Path, tmp_path: Path) -> None:
    def slower(place: Path) -> None:
        plant = place / "plant.toml"
        plant.write_text(plant.read_text() + "\n[design]\ndecay_rate = 0.05\n")

    place = changed(base, tmp_path, slower)
    env = environment(tmp_path, TARGET="main", GITHUB_STEP_SUMMARY=str(tmp_path / "summary.md"))
    statuses = {
        name: bash(place, script, env).returncode
        for name, _, script in github_steps(written(place, "github", "plant.toml"))
    }

    assert statuses == {"base": 0, "design": 0, "check": 0, "compare": 1, "summary": 0}
    page = (place / "takagi-ci" / "comparison.html").read_text(encoding="utf-8")
    links = re.findall(r'href="([^#"]*)"', page)
    assert links == ["base/report.html", "now/report.html"]
    assert all((place / "takagi-ci" / link).is_file() for link in links)


def test_without_a_base_the_comparison_says_so(base: Path, tmp_path: Path) -> None:
    """The target branch has no such design: status 0, and a line in the summary."""
    place = changed(base, tmp_path, lambda place: (place / "build").rename(place / "new"))
    script = gitlab_script(written(place, "gitlab", "new"))

    done = bash(place, script, environment(tmp_path, CI_COMMIT_BRANCH="main"))

    assert done.returncode == 0, done.stderr
    assert "nothing to compare" in (place / "takagi-ci" / "comparison.md").read_text("utf-8")


@pytest.mark.parametrize("service", ["github", "gitlab"])
@pytest.mark.parametrize("subject", ["plant.toml", "build"])
def test_no_address_of_a_registry_stands_in_the_files(
    base: Path, tmp_path: Path, service: str, subject: str
) -> None:
    for text in [written(changed(base, tmp_path, nothing), service, subject)]:
        assert "http" not in text and "://" not in text and "index-url" not in text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["build", "--ci", "jenkins"], "github or gitlab is needed"),
        (["nothing.toml", "--ci", "github"], "no such file"),
        (["note", "--ci", "github"], "holds no design"),
        (["..", "--ci", "github"], "lies outside of the repository"),
        (["build", "--ci", "github", "--name", "x"], "--name was given beside --ci"),
        (["build", "a.csv", "--ci", "github"], "CSV files were given beside --ci"),
    ],
)
def test_what_cannot_be_proved_in_ci_is_refused(
    base: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    message: str,
) -> None:
    place = changed(base, tmp_path, lambda place: (place / "note").mkdir())
    monkeypatch.chdir(place)

    assert main(["new", *words]) == 2

    assert message in capsys.readouterr().err
    assert not (place / ".github").exists()


def test_a_workflow_is_replaced_with_force_only(
    base: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    place = changed(base, tmp_path, nothing)
    monkeypatch.chdir(place / "build")
    (place / ".gitlab-ci.yml").write_text("mine: {}")

    assert main(["new", ".", "--ci", "gitlab"]) == 2
    assert "--force" in capsys.readouterr().err
    assert (place / ".gitlab-ci.yml").read_text() == "mine: {}"
    assert main(["new", ".", "--ci", "gitlab", "--force"]) == 0
    script = (place / ".gitlab-ci.yml").read_text(encoding="utf-8")
    assert "--gains build/gains.json --model plant.toml" in script


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
    blocks = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines()]
    found = [re.search(r"(?:^|- (?:run: )?|run: )takagi (.*)$", line) for line in lines]
    return [shlex.split(match[1]) for match in found if match]


def shell() -> list[list[str]]:
    return commands("sh")


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Path:
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
    (inside / "base.json").write_bytes((inside / "build" / "certificate.json").read_bytes())
    command = [part for part in shell()[1] if part not in ("--gains", "build/gains.json")]

    assert main([*command, "--decay-rate", "0.05"]) == 1

    text = capsys.readouterr().out
    assert "new.json: PROVED" in text and "WORSE" in text
    assert "configuration: decay_rate: nothing -> 0.05" in text
