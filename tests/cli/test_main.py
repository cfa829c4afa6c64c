"""The front door: help, misuse, and one clear message for whatever goes wrong."""

from __future__ import annotations

import errno
import io
import json
import os
import re
import shutil
import subprocess
import sys
import threading
from importlib.metadata import version
from pathlib import Path

import pytest

from takagi.cli.command import guard
from takagi.cli.main import VERBS, Verb, main
from takagi.cli.progress import Step, StepLine, progress
from takagi.cli.verbs.help import SUBJECTS
from takagi.models import ModelError
from tests.certificates.kinds.claims import sealed
from tests.takagi_tool import path_with_takagi

Capture = pytest.CaptureFixture[str]


def test_no_verb_at_all_is_misuse(capsys: Capture) -> None:
    """The help goes to standard error then: a script must not take it for an answer."""
    assert main([]) == 2

    captured = capsys.readouterr()
    assert captured.out == "" and "Usage:" in captured.err


@pytest.mark.parametrize(
    ("words", "near"),
    [(["chek"], "'check'"), (["--halp"], "'--help'"), (["help", "margin"], "'margins'")],
)
def test_a_mistyped_word_is_answered_with_the_near_one(
    words: list[str], near: str, capsys: Capture
) -> None:
    assert main(words) == 2

    error = capsys.readouterr().err
    assert f"did you mean {near}?" in error
    assert "help" not in words or "`takagi help` lists all" in error


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.name)
def test_every_verb_explains_itself(verb: Verb, capsys: Capture) -> None:
    """Every line of the table leads to a module whose help works and shows the usage."""
    assert main([verb.name, "--help"]) == 0
    assert f"Usage: takagi {verb.name}" in capsys.readouterr().out


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.name)
def test_every_verb_refuses_an_unknown_option(verb: Verb, capsys: Capture) -> None:
    """Status 2, the usage, and no traceback, whichever parser reads the options."""
    assert main([verb.name, "--no-such-option"]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and "Usage: takagi" in captured.err and "Error:" in captured.err


@pytest.mark.parametrize(
    ("given", "where"),
    [
        (["design", "cart_pole", "--out", ""], "for --out"),
        (["design", "cart_pole", "-o", ""], "for -o"),
        (["certify", "cart_pole", "--out="], "for --out"),
        (["check", "c.json", "--junit", ""], "for --junit"),
        (["simulate", "cart_pole", "--out", ""], "for --out"),
        (["check", ""], "as argument 1"),
        (["compare", "old.json", ""], "as argument 2"),
    ],
)
def test_an_empty_text_is_no_place(
    given: list[str], where: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """``--out "$UNSET"`` would else fill the folder that a script happens to be in."""
    monkeypatch.chdir(tmp_path)

    assert main(given) == 2

    told = capsys.readouterr().err
    assert f"Error: an empty text was given {where}; write what is needed" in told
    assert not list(tmp_path.iterdir())


def test_version_is_the_distribution_s(capsys: Capture) -> None:
    """The version is written once, in the project's metadata."""
    assert main(["--version"]) == 0

    assert capsys.readouterr().out == f"takagi {version('takagi')}\n"


def test_models_lists_names_that_design_takes(capsys: Capture) -> None:
    """Text for people, JSON for machines, the same names."""
    assert main(["models"]) == 0
    text = capsys.readouterr().out
    assert main(["models", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)

    assert [line.split()[0] for line in text.splitlines()] == [model["name"] for model in listed]
    assert "nrel5mw" in text


FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "out/gains.json")


@pytest.mark.parametrize(
    ("error", "status", "told"),
    [
        (ModelError("vertex 3: not finite"), 2, "Error: vertex 3: not finite\n$"),
        (FULL, 2, "Error: out/gains.json: the disk is full; free some space"),
        (KeyboardInterrupt(), 130, "\nInterrupted.\n$"),
        (ZeroDivisionError("a\nb"), 70, r".*internal error \(ZeroDivisionError: a b\).*report it"),
    ],
)
def test_an_error_is_one_line(
    error: BaseException, status: int, told: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """TAKAGI_DEBUG=1 shows the traceback; nothing else does."""

    def work() -> int:
        raise error

    assert guard(work) == status
    message = capsys.readouterr().err
    assert re.match(told, message) and message.strip("\n").count("\n") == 0

    monkeypatch.setenv("TAKAGI_DEBUG", "1")
    guard(work)
    assert ("Traceback" in capsys.readouterr().err) == (status != 130)


def run_shell(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    script = f'takagi() {{ "{sys.executable}" -m takagi.cli "$@"; }}\n{command}'
    return subprocess.run(
        ["bash", "-c", script], cwd=folder, capture_output=True, text=True, check=False
    )


def test_a_reader_that_leaves_early_is_no_error(tmp_path: Path) -> None:
    """`takagi ... | head` prints no complaint."""
    assert run_shell("takagi --help | true", tmp_path).stderr == ""


@pytest.mark.parametrize("encoding", ["ascii", "latin-1:strict"])
def test_letters_that_the_terminal_lacks_are_escaped(encoding: str, tmp_path: Path) -> None:
    """A name in another alphabet is no error of takagi, on neither output."""
    model = {"kind": "takagi-sugeno", "sample_time": None, "state_names": ["x"], "A": [[[-1]]]}
    claim = {"name": "\u2200 \u03b4", "kind": "decay", "decay_rate": 0.5, "P": [[1]]}
    (tmp_path / "c.json").write_text(json.dumps(sealed(model, None, claim)))

    shown = run_shell(f"PYTHONIOENCODING={encoding} takagi check c.json", tmp_path)
    refused = run_shell(f"PYTHONIOENCODING={encoding} takagi check \u03b4.json", tmp_path)

    assert (shown.returncode, shown.stderr) == (0, "")
    assert r'PROVED  "\u2200 \u03b4"' in shown.stdout
    assert refused.returncode == 2 and r"Error: \u03b4.json: " in refused.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs the full device")
def test_a_full_standard_output_is_told(tmp_path: Path) -> None:
    """An answer that could not be written must not exit with 0."""
    ran = run_shell("takagi models > /dev/full", tmp_path)

    assert ran.returncode == 2
    assert "the disk is full" in ran.stderr and "Traceback" not in ran.stderr


class Terminal(io.StringIO):
    def __init__(self) -> None:
        super().__init__()
        self.written = threading.Event()

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        self.written.set()
        return super().write(text)


@pytest.mark.parametrize(("stream", "patience"), [(io.StringIO(), 0.0), (Terminal(), 3600.0)])
def test_quiet_in_a_file_and_while_the_work_is_short(stream: io.StringIO, patience: float) -> None:
    with progress("Design", stream=stream, patience=patience) as tell:
        tell("gains", 0.5)

    assert stream.getvalue() == ""


@pytest.mark.parametrize("steps", [False, True])
def test_a_bar_appears_though_the_work_tells_nothing(steps: bool) -> None:
    """A solver calls nobody for a minute; square brackets, as of units, are no markup."""
    stream, line = Terminal(), StepLine(STEPS) if steps else None

    with progress("Design", line=line, stream=stream, patience=0.0) as tell:
        tell("model [m]", 0.25)
        assert stream.written.wait(timeout=10.0)

    assert ("1 of 4  model [m]" if steps else "Design: model [m]") in stream.getvalue()


STEPS = (Step("model", 2.0), Step("gains", 3.0, varies=True), Step("proof", 1.0), Step("page", 4.0))


def test_a_line_counts_steps_and_says_honestly_how_long() -> None:
    """Twice the usual times: no time before the step that varies has ended, nor in an overrun."""
    times = [0.0]
    line = StepLine(STEPS, now=lambda: times[-1])
    shown = []
    for seconds, words in (
        (0.0, "model"),
        (4.0, "gains"),
        (30.0, "gains of rule 2"),
        (40.0, "proof"),
        (42.0, "page"),
        (44.0, ""),
        (51.0, ""),
    ):
        times.append(seconds)
        if words:
            line.tell(words)
        shown.append(str(line))

    assert shown == [
        "1 of 4  model  0 %",
        "2 of 4  gains  20 %",
        "2 of 4  gains of rule 2  48 %",
        "3 of 4  proof  50 %  about 10 s left",
        "4 of 4  page  60 %  about 8 s left",
        "4 of 4  page  70 %  about 6 s left",
        "4 of 4  page  98 %",
    ]


def test_no_time_is_told_in_the_first_seconds() -> None:
    """From both sides of four seconds; a line without steps has the words alone."""
    clock = 0.0
    line = StepLine((Step("model", 1.0), Step("page", 9.0)), now=lambda: clock)
    line.tell("model")
    clock = 1.0
    line.tell("page")
    clock = 3.9
    assert "left" not in str(line)
    clock = 4.1
    assert str(line).endswith("about 6 s left")

    plain = StepLine(())
    plain.tell("Schulte's law")
    assert str(plain) == "Schulte's law"


def test_the_help_of_many_options_is_short_and_complete(capsys: Capture) -> None:
    """At most 60 lines that name every option; --all-options explains each of them."""
    assert main(["design", "--help"]) == 0
    short = capsys.readouterr().out
    assert main(["design", "--all-options"]) == 0
    long = capsys.readouterr().out
    assert len(short.splitlines()) <= 60 < len(long.splitlines())
    named = set(re.findall(r"--[a-z][a-z-]+", long)) - {"--all-options"}
    assert named <= set(re.findall(r"--[a-z][a-z-]+", short))
    assert {"--law", "--settle", "--objective"} <= named


ROOT = Path(__file__).parents[2]


def test_help_lists_every_verb_and_subject(capsys: Capture) -> None:
    assert main(["help"]) == 0

    listed = re.findall(r"^  (\w+)  ", capsys.readouterr().out, flags=re.MULTILINE)
    assert listed == [*SUBJECTS, *(verb.name for verb in VERBS)]
    assert main(["--help"]) == 0
    printed = capsys.readouterr().out
    assert all(f"  {verb.name} " in printed and verb.help in printed for verb in VERBS)


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
        # No word is offered where a file is expected, so that the shell offers its files.
        ("takagi check bui", ""),
    ],
)
@pytest.mark.parametrize("shell", ["bash", "fish"])
def test_a_line_is_completed(
    line: str, word: str, shell: str, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """Of verbs that are read by typer, by argparse, and by a table of their own."""
    offered = completed(line, shell, monkeypatch, capsys)
    assert word in offered if word else offered == []


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
