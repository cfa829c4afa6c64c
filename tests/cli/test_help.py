"""`takagi help` and the completion of the shell."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from takagi.cli.main import VERBS, main
from takagi.cli.verbs.help import SUBJECTS
from tests.takagi_tool import path_with_takagi

Capture = pytest.CaptureFixture[str]
ROOT = Path(__file__).parents[2]


def test_help_lists_every_verb_and_subject(capsys: Capture) -> None:
    assert main(["help"]) == 0

    listed = re.findall(r"^  (\w+)  ", capsys.readouterr().out, flags=re.MULTILINE)
    assert listed == [*SUBJECTS, *(verb.name for verb in VERBS)]


@pytest.mark.parametrize("subject", SUBJECTS)
def test_a_subject_is_a_screen_and_names_a_page_that_exists(subject: str, capsys: Capture) -> None:
    """30 lines of 80 columns at most; the options that it shows exist."""
    assert main(["help", subject.upper()]) == 0

    text = capsys.readouterr().out
    assert len(text.splitlines()) < 30 and max(map(len, text.splitlines())) <= 80
    pages = re.findall(r"docs/[a-z-]+\.md", text.splitlines()[-1])
    assert pages and all((ROOT / page).is_file() for page in pages)
    source = "".join(path.read_text("utf-8") for path in (ROOT / "cli").rglob("*.py"))
    options = re.findall(r"--([a-z][a-z-]+)", text)
    assert [o for o in options if o not in source and o.replace("-", "_") not in source] == []


@pytest.mark.parametrize("words", [["check"], ["design"], ["study"], ["study", "overlap"]])
def test_the_topic_of_a_verb_is_its_help(words: list[str], capsys: Capture) -> None:
    assert main([*words, "--help"]) == 0
    expected = capsys.readouterr().out
    assert main(["help", *words]) == 0
    assert capsys.readouterr().out == expected


def test_an_unknown_topic_is_answered_with_the_near_ones(capsys: Capture) -> None:
    assert main(["help", "margin"]) == 2

    error = capsys.readouterr().err
    assert "did you mean 'margins'?" in error and "`takagi help` lists all" in error


def completed(line: str, shell: str, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> list[str]:
    """Return the words that a shell is offered for a line, the last word being unfinished."""
    words = line.split(" ")
    monkeypatch.setenv("_TAKAGI_COMPLETE", f"complete_{shell}")
    if shell == "bash":
        monkeypatch.setenv("COMP_WORDS", "\n".join(words))
        monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    else:
        monkeypatch.setenv("_TYPER_COMPLETE_ARGS", line)
        monkeypatch.setenv("_TYPER_COMPLETE_FISH_ACTION", "get-args")
    assert main([]) == 0
    return capsys.readouterr().out.split()


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("takagi comp", "compare"),
        ("takagi compare build/a --ht", "--html"),
        ("takagi check --gai", "--gains"),
        ("takagi design nrel", "nrel5mw"),
        ("takagi study over", "overlap"),
        ("takagi study overlap --see", "--seeds"),
        ("takagi simulate x --dur", "--duration"),
        ("takagi help marg", "margins"),
    ],
)
@pytest.mark.parametrize("shell", ["bash", "fish"])
def test_a_line_is_completed(
    line: str, word: str, shell: str, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """Of verbs that are read by typer, by argparse, and by a table of their own."""
    assert word in completed(line, shell, monkeypatch, capsys)


def test_files_are_left_to_the_shell(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """No word is offered where a file is expected, so that the shell offers its files."""
    assert completed("takagi check bui", "bash", monkeypatch, capsys) == []


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_the_script_is_installed_and_bash_runs_it(tmp_path: Path) -> None:
    """In an empty home; the script calls the command that is on the path."""
    path = path_with_takagi(tmp_path / "bin")
    environment = {**os.environ, "HOME": str(tmp_path), "PATH": path}
    script = (
        "takagi --install-completion bash >&2 && . ~/.bashrc && "
        "COMP_WORDS=(takagi compare --ht) && COMP_CWORD=2 && "
        '_takagi_completion takagi && echo "${COMPREPLY[@]}"'
    )

    done = subprocess.run(
        ["bash", "--norc", "-c", script], env=environment, capture_output=True, text=True
    )

    assert (done.returncode, done.stdout) == (0, "--html\n"), done.stderr
