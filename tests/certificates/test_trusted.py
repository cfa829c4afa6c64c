"""What a verdict ran through: only what the claims need is loaded, and the count is right."""

from __future__ import annotations

import ast
import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.audit.trusted_lines import FOLDER, Trusted, check_counted, code_lines
from takagi.certificates.checker import CertificateError, Verdict, check
from takagi.certificates.checker.kinds.decay import Decay
from takagi.certificates.claims.turbine.loop_claims import loop_claims
from takagi.cli.main import main
from tests.certificates.kinds.claims import resealed
from tests.docs_pages import catalogue
from tests.syntax import imported_modules

counted_page = catalogue("catalogue.trusted")
# A turbine's count holds the proof that the winds of one claim keep to the rates of another, and
# the lists of the members that its claims may have.  Both hold the names of all kinds.
MOST_FOR_DECAY, MOST_FOR_TURBINE = 822, 1765
TYPES = "TYPE_CHECKING"
KINDS_OR_WORDS = ("words", "kinds", "plant", "problem", "turbine")


@pytest.fixture(scope="module")
def decay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("decay") / "decay.json"
    path.write_text(json.dumps(counted_page.decay()))
    return path


@pytest.fixture(scope="module")
def turbine(short_document: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Path:
    model, gains = short_document["model"], short_document["gains"]
    claims, left_out = loop_claims(model, gains, short_document["claims"][0])
    assert not left_out
    path = tmp_path_factory.mktemp("turbine") / "turbine.json"
    path.write_text(json.dumps(resealed(short_document | {"claims": claims})))
    return path


@pytest.fixture(scope="module")
def of_turbine(turbine: Path) -> tuple[Any, Trusted]:
    return check_counted(turbine)


def test_a_decay_claim_needs_few_lines(decay: Path) -> None:
    checked, trusted = check_counted(decay)

    assert checked.verdict.name == "PROVED"
    assert trusted.lines <= MOST_FOR_DECAY
    assert 0 < trusted.executed < trusted.lines
    rooms = {file.path.partition("/")[0] for file in trusted.files}
    assert rooms == {"__init__.py", "kernel", "kinds", "loop", "replay"}
    kinds = [file.path for file in trusted.files if file.path.startswith("kinds/")]
    assert kinds == ["kinds/decay.py", "kinds/loop_claim.py"]


def test_a_turbine_loads_what_its_claims_need(of_turbine: tuple[Any, Trusted]) -> None:
    checked, trusted = of_turbine

    assert checked.verdict.name == "PROVED"
    assert len(checked.claims) == 3
    assert trusted.lines <= MOST_FOR_TURBINE
    places = {file.path for file in trusted.files}
    assert not [place for place in places if place.startswith(("kinds/", "plant/", "files/"))]
    assert not [place for place in places if "paper" in place or "rest" in place]


def test_a_check_in_a_process_of_its_own_loads_the_same(decay: Path) -> None:
    """Counted by another way: the interpreter's own list of modules."""
    program = (
        "import sys; from takagi.certificates.checker import check; check(sys.argv[1]); "
        "print(*(m.__file__ for n, m in sys.modules.items() if n.startswith('takagi.certificates"
        ".checker')), sep='\\n')"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program, str(decay)], capture_output=True, text=True, check=True
    )

    loaded = {Path(line).resolve().relative_to(FOLDER.resolve()).as_posix()
              for line in ran.stdout.split()}  # fmt: skip
    _, trusted = check_counted(decay)
    counted = {file.path for file in (*trusted.files, *trusted.words)}
    # Files without a line of code are not listed.
    assert {place for place in loaded if code_lines((FOLDER / place).read_text())} <= counted
    assert counted <= loaded


def test_a_refused_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "certificate.json"
    path.write_text('{"format": "another"}')

    with pytest.raises(CertificateError, match="the format is not"):
        check_counted(path)


def test_what_did_not_run_is_not_counted_as_executed(decay: Path) -> None:
    """A claim that fails at its first test executes less; the same files are read."""
    document = json.loads(decay.read_text())
    document["claims"][0]["decay_rate"] = -1
    wrong = decay.with_name("wrong.json")
    wrong.write_text(json.dumps(resealed(document)))

    checked, refused = check_counted(wrong)
    _, proved = check_counted(decay)

    assert checked.verdict.name == "UNDECIDED"
    assert [file.path for file in refused.files] == [file.path for file in proved.files]
    assert refused.executed < proved.executed
    definite = {file.path: file for file in refused.files}["kernel/definite.py"]
    assert definite.executed < 20


def test_words_are_imported_by_kinds_and_after_the_verdicts() -> None:
    """No room on which kinds of claims are built depends on words."""
    asking = {
        (file.relative_to(FOLDER).as_posix(), function)
        for file in FOLDER.rglob("*.py")
        if file.relative_to(FOLDER).parts[0] not in KINDS_OR_WORDS
        for function, module in _imports(file)
        if module.startswith("takagi.certificates.checker.words")
    }

    assert asking == {("kernel/claim_kind.py", TYPES), ("kernel/result.py", TYPES)}


def _imports(file: Path) -> Iterator[tuple[str, str]]:
    """Yield (function, module) of each import; no function where the file itself imports."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    inside = {id(node): own.name for own in functions for node in ast.walk(own)}
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == TYPES:
            inside |= dict.fromkeys(map(id, node.body), TYPES)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            yield inside.get(id(node), ""), str(node.module)
        elif isinstance(node, ast.Import):
            yield from ((inside.get(id(node), ""), alias.name) for alias in node.names)


@pytest.mark.parametrize("words", ["PROVED", "a lie"])
def test_words_cannot_change_a_verdict(
    decay: Path, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    document = json.loads(decay.read_text())
    document["claims"][0]["decay_rate"] = 1000
    wrong = decay.with_name("fast.json")
    wrong.write_text(json.dumps(resealed(document)))
    monkeypatch.setattr(Decay, "sentence", lambda _: words)

    assert check(decay).verdict is Verdict.PROVED
    assert check(decay).claims[0].text == words
    assert check(wrong).verdict is Verdict.UNDECIDED


def test_the_verb_prints_a_table(decay: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(decay), "--trusted"]) == 0
    printed = capsys.readouterr().out
    assert main(["check", str(decay), "--trusted", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)["trusted"]

    assert "The verdict ran through:" in printed
    for file in answer["files"]:
        assert f"  {file['file']} " in printed
    assert answer["lines"] == sum(file["lines"] for file in answer["files"])
    assert f"{len(answer['files'])} files" in printed
    assert [file["file"] for file in answer["words"]]


@pytest.mark.slow
def test_the_page_has_these_numbers(
    decay: Path, of_turbine: tuple[Any, Trusted], tmp_path: Path
) -> None:
    """Run ``make docs`` when this fails.  Which files are loaded does not depend on the winds."""
    page = counted_page.PAGE.read_text(encoding="utf-8")

    assert counted_page.row(counted_page.DECAY, check_counted(decay)[1]) in page
    assert counted_page.row(counted_page.TURBINE, of_turbine[1]) in page
    running = tmp_path / "running.json"
    running.write_text(json.dumps(counted_page.running()), encoding="utf-8")
    assert counted_page.row(counted_page.RUNNING, check_counted(running)[1]) in page


SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
from takagi.certificates.checker import check
print(check(sys.argv[2]).verdict.name)
names = {name.partition(".")[0] for name in sys.modules}
foreign = names - set(sys.stdlib_module_names) - {"takagi", "__main__"}
floors = [n for n in sys.modules if n.startswith("takagi.") and ".certificates" not in n]
print(sorted(foreign), floors)
"""


def test_check_runs_without_any_installed_package(tmp_path: Path, short: dict[str, Any]) -> None:
    """Python without site packages, and a folder that holds the checker's files alone."""
    home = tmp_path / "takagi" / "certificates" / "checker"
    shutil.copytree(FOLDER, home, ignore=shutil.ignore_patterns("__pycache__"))
    certificate = tmp_path / "certificate.json"
    certificate.write_text(json.dumps(short))

    done = subprocess.run(
        [sys.executable, "-I", "-S", "-W", "error", "-c", SCRIPT, tmp_path, certificate],
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.stderr == ""
    assert done.stdout.split("\n")[:2] == ["PROVED", "[] []"]


def test_sources_import_the_standard_library_and_each_other() -> None:
    """No import, wherever it stands, leaves the standard library or the checker's own folder."""
    for file, name in imported_modules(FOLDER):
        own = name.startswith("takagi.certificates.checker")
        assert own or name.partition(".")[0] in sys.stdlib_module_names, (file.name, name)


def test_no_float_enters_a_decision() -> None:
    """``float`` appears in messages alone: every comparison is between exact numbers."""
    rooms = ("kernel", "arithmetic", "kinds", "loop", "replay", "turbine")
    files = [file for room in rooms for file in sorted((FOLDER / room).rglob("*.py"))]
    for file in [*files, FOLDER / "plant" / "effort_blend.py"]:
        tree = ast.parse(file.read_text(encoding="utf-8"))
        refusals = [node for node in ast.walk(tree) if isinstance(node, ast.Raise)]
        said = {part for refusal in refusals for part in ast.walk(refusal)}
        assert not [n for n in ast.walk(tree) if _is_float(n) and n not in said], file.name


def _is_float(node: ast.AST) -> bool:
    literal = isinstance(node, ast.Constant) and isinstance(node.value, float)
    return literal or (isinstance(node, ast.Name) and node.id == "float")
