"""`takagi new`: a template, options, questions and files, each a plant that is designed."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

from takagi.certificates.checker import Verdict, check
from takagi.cli.main import main
from takagi.models import Plant, load_model, statespace

Capture = pytest.CaptureFixture[str]
PENDULUM = [
    "--state", "theta = -60..60 deg: angle from upright",
    "--state", "omega = -4..4 rad/s",
    "--input", "tau = -20..20 N m",
    "--parameter", "m = 2 kg",
    "--parameter", "l = 500 mm",
    "--parameter", "g=9.81 m/s^2",
    "--equation", "theta = omega",
    "--equation", "omega' = (m*g*l*sin(theta) + tau)/(m*l^2)",
]  # fmt: skip


class Terminal:
    def isatty(self) -> bool:
        return True


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], list[str]]:
    """Let answers, one a line, come from a terminal; the questions are kept."""

    def prepare(text: str) -> list[str]:
        lines, asked = iter(text.splitlines()), []

        def answered(question: str = "") -> str:
            asked.append(question)
            try:
                return next(lines)
            except StopIteration:
                raise EOFError from None

        monkeypatch.setattr(sys, "stdin", Terminal())
        monkeypatch.setattr("builtins.input", answered)
        return asked

    return prepare


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """In a folder of its own, without a terminal: a question there would be an error."""
    monkeypatch.chdir(tmp_path)

    def refuse(question: str = "") -> str:
        raise AssertionError(f"asked {question!r} without a terminal")

    monkeypatch.setattr("builtins.input", refuse)


def plant_of(name: str) -> Plant:
    plant = load_model(name)
    assert isinstance(plant, Plant)
    return plant


@pytest.mark.parametrize("options", [[], PENDULUM], ids=["template", "options"])
def test_what_is_written_is_designed_and_proved(options: list[str], capsys: Capture) -> None:
    """From nothing to exported code by the commands that each one names."""
    assert main(["new", "pendulum.toml", *options]) == 0
    following = re.findall(r"^  takagi (.*)$", capsys.readouterr().out, flags=re.MULTILINE)
    assert following == ["design pendulum.toml --out build/pendulum"]
    assert main([*following[0].split(), "--no-report"]) == 0
    export = next(line for line in capsys.readouterr().out.splitlines() if "takagi export" in line)
    assert main(export.split()[1:]) == 0

    assert list(Path("build/pendulum/c").glob("*.c"))
    checked = check(Path("build/pendulum/certificate.json"), model=Path("pendulum.toml"))
    assert checked.verdict is Verdict.PROVED


def test_the_template_is_commented_and_says_so(capsys: Capture) -> None:
    assert main(["new", "a.toml"]) == 0

    text = Path("a.toml").read_text(encoding="utf-8")
    assert "a template, since nothing was given: change it" in capsys.readouterr().out
    assert text.startswith("# Written by `takagi new`. Next: takagi design a.toml")
    assert all(f"[{section}]" in text for section in ("states", "inputs", "parameters", "design"))


def test_options_say_ranges_units_and_rests() -> None:
    assert main(
        ["new", "a.toml", "--state", "T = 340..360 K, rest 350: tank", "--state", "x = m",
         "--input", "q = 0..300 K/s, rest solve", "--disturbance", "d = -1..1 K/s",
         "--parameter", "k = 0.9..1.1 1/s", "--parameter", "c = 2*k", "--parameter", "r = 0.5 1/s",
         "--equation", "T = q - r*T + d", "--equation", "x = -c*x", "--measured", "T",
         "--name", "Tank"]
    ) == 0  # fmt: skip
    plant = plant_of("a.toml")
    T, _, q = (*plant.states, *plant.inputs)

    assert (plant.name, plant.units, plant.measured) == ("Tank", "checked", ("T",))
    assert (float(T.rest), T.description, T.written) == (350.0, "tank", "K")
    assert float(q.rest) == 175.0
    assert plant.uncertain[0].name == "k"


def test_a_plant_in_discrete_time_without_units() -> None:
    assert main(
        ["new", "a.toml", "--state", "x", "--input", "u", "--equation", "x = 1.1*x + u",
         "--sample-time", "0.1", "--no-units"]
    ) == 0  # fmt: skip

    assert plant_of("a.toml").sample_time == 0.1
    assert "The right-hand sides of x(t + T)" in Path("a.toml").read_text(encoding="utf-8")


def test_questions_at_a_terminal_give_the_same_file(answers: Callable[[str], list[str]]) -> None:
    """An answer that cannot be read is asked again, and so is what does not fit in the end."""
    asked = answers(
        "theta omega\n\ndeg\n-60 60\n-60..60\n\nrad/s\n-4..4\n\ntau\nNm\nN m\n-20..20\n0\nomega\n"
        "(m*g*l*sin(theta) + tau)/(m*l^2\n(m*g*l*sin(theta) + tau)/(m*l^2)\n"
        "9.81\n500 mm\n2 kg\ng = 9.81 m/s^2\n"
    )
    assert main(["new", "pendulum.toml"]) == 0
    by_answers = plant_of("pendulum.toml")
    assert main(["new", "again.toml", *PENDULUM, "--name", "pendulum"]) == 0
    by_options = plant_of("again.toml")

    assert by_answers.equations == by_options.equations
    assert by_answers.box == by_options.box and by_answers.values == by_options.values
    assert any("What is right" in question for question in asked)


def test_enter_at_the_first_question_gives_an_example(answers: Callable[[str], list[str]]) -> None:
    asked = answers("\n")

    assert main(["new", "a.toml"]) == 0
    assert len(asked) == 1 and plant_of("a.toml").name == "Pendulum with a motor"


@pytest.mark.parametrize(
    ("given", "words", "found"),
    [
        # Neither a value that is left out nor a correction without a name loses the answers.
        ("x\n\n-\n\n\n\n-k*x\n\n2 kg\n2 1/s\nk = 2 1/s\n",
         ["k needs a value", '"m = 2 kg" is the form'], ("checked", "1/s")),
        ("x\n\n-\n\n\n\n-k*x\n2 kg\nno units\n", [], ("unchecked", "")),
        # Nothing is written where the input ends, or nothing is changed.
        ("theta omega\n\ndeg\n", ["the input ended at"], None),
        ("x\n\n-\n\n\n\nk*x\n2 kg\n\n", ["has the unit"], None),
    ],
)  # fmt: skip
def test_an_answer_that_cannot_be_read_is_asked_again(
    given: str,
    words: list[str],
    found: tuple[str, str] | None,
    answers: Callable[[str], list[str]],
    capsys: Capture,
) -> None:
    answers(given)

    assert main(["new", "a.toml"]) == (0 if found else 2)
    told = capsys.readouterr().err
    assert all(word in told for word in words)
    assert Path("a.toml").exists() == bool(found)
    if found:
        plant = plant_of("a.toml")
        assert plant.units == found[0]
        assert not found[1] or plant.parameters[0].written == found[1]


def test_a_file_that_is_there_is_replaced_by_force_alone(capsys: Capture) -> None:
    Path("a.toml").write_text("mine", encoding="utf-8")
    assert main(["new", "a.toml"]) == 2
    assert "--force to replace it" in capsys.readouterr().err
    assert Path("a.toml").read_text(encoding="utf-8") == "mine"

    assert main(["new", "a.toml", "--force"]) == 0


A, B = np.array([[0, 1], [17.3, 0]]), np.array([[0], [-0.18]])


def matrices() -> None:
    for name, value in (("A", A), ("B", B)):
        np.savetxt(f"{name}.csv", value, delimiter=",")
        scipy.io.savemat("both.mat", {"A": A, "B": B})


@pytest.mark.parametrize(
    "source", [["A.csv", "B.csv", "--from-linear"], ["--from-mat", "both.mat"]]
)
def test_matrices_become_a_file(source: list[str]) -> None:
    """Names and ranges beside them; the linear system of the file is that of the matrices."""
    matrices()
    names = ["--state", "theta = -60..60 deg", "--state", "omega", "--input", "force = -300..300 N"]
    assert main(["new", "cart.toml", *source, *names]) == 0
    plant = plant_of("cart.toml")
    system = statespace(plant)

    assert np.array_equal(system.A, A) and np.array_equal(system.B, B)
    assert plant.states[0].written == "deg" and plant.name == "cart"
    assert plant.inputs[0].range is not None and float(plant.inputs[0].range.upper) == 300


def test_a_plant_of_matrices_is_proved() -> None:
    matrices()
    assert main(["new", "cart.toml", "--from-mat", "both.mat"]) == 0
    assert main(["design", "cart.toml", "--out", "out", "--no-report"]) == 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["a.csv"], "the file to write comes first, and ends in .toml"),
        (["a.toml", "A.csv"], "the files of matrices and --from-linear go together"),
        (["a.toml", "--from-linear"], "the files of matrices and --from-linear go together"),
        (["a.toml", "--from-mat", "x.mat"], "x.mat: cannot be read (no such file)"),
        (["a.toml", "--from-fast-lin", "x.lin"], "x.lin: no such file"),
        (
            ["a.toml", "--from-fast-lin", "x.lin", "--sample-time", "0.1"],
            "--sample-time was given, and a .lin file is about x'",
        ),
        (["a.toml", "--from-rosco", "x"], "x: no such file or folder"),
        (
            ["a.toml", "--from-mat", "x.mat", "--from-rosco", "x"],
            "--from-mat and --from-rosco were given; a file has one source",
        ),
        (["a.toml", "--from-mat", "x.mat", "--equation", "x=1"], "--equation was given beside"),
        (["a.toml", "--from-rosco", "x", "--state", "x"], "--figure changes a turbine"),
        (["a.toml", "--table", "x"], "--table was given beside no turbine's files"),
        (["a.toml", "--equation", "x = 1"], "no state was given"),
        (["a.toml", "--state", "x"], "no equation for x was given"),
        (["a.toml", "--state", "x", "--state", "x = m"], "--state of x was given twice"),
        (
            ["a.toml", "--state", "x = -1...1", "--equation", "x = -x", "--no-units"],
            "unit '-1...1'",
        ),
        (["a.toml", "--state", "x!"], "'x!' was given; \"theta = -60..60 deg\""),
        (["a.toml", "--state", "x", "--equation", "-x"], '"theta = omega" is the form'),
        (
            ["a.toml", "--state", "x", "--equation", "x = x", "--parameter", "k"],
            '"m = 2 kg" is the form',
        ),
        (
            ["a.toml", "--state", "x", "--equation", "x = k*x"],
            "Error: field 'equations.x': column 1: 'k' is not known",
        ),
        (
            ["a.toml", "--state", "x = m", "--parameter", "k = 2 kgg", "--equation", "x = k*x"],
            "'kgg' is not known",
        ),
        (["a.toml", "--state", "x = 0..2", "--equation", "x = 1 - x", "--no-units"], "at rest"),
        (["a.toml", "--state", "x", "--equation", "x = x^2", "--no-units"], "no range was given"),
        (
            ["a.toml", "--from-mat", "both.mat", "--state", "a, rest 1", "--state", "b"],
            "a rest was given, and matrices are about theirs",
        ),
        (["a.toml", "--from-mat", "both.mat", "--state", "a"], "states: 1 names were given (a)"),
    ],
)
def test_misuse_is_told_and_nothing_written(words: list[str], told: str, capsys: Capture) -> None:
    matrices()

    assert main(["new", *words]) == 2
    printed: Any = capsys.readouterr()
    assert told in printed.err and "internal error" not in printed.err
    assert not Path("a.toml").exists()
