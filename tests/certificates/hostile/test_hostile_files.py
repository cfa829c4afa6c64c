"""Files made to harm: refused in bounded memory, with one message, never a traceback or a pass.

They go through ``takagi check`` in a process of their own with a bound on its memory.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, Verdict, check
from takagi.certificates.checker.files.given_files import compare_model
from takagi.certificates.document.certificate_file import dumps
from tests.certificates.kinds.claims import resealed, sealed
from tests.certificates.recorded.inputs import of_model, texts_of

Document = dict[str, Any]
MEMORY, SECONDS = 800_000_000, 120


def line(**claim: Any) -> Document:
    """Return a certificate of x' = -x, true unless ``claim`` says otherwise."""
    model = {"kind": "takagi-sugeno", "sample_time": None, "state_names": ["x"], "A": [[[-1]]]}
    own = {"name": "line", "kind": "decay", "decay_rate": 0.5, "P": [[1]], **claim}
    return sealed(model, None, own)


# Each file through the command line, in turn: status, standard output, standard error.
EACH = """
import contextlib, io, json, sys
from takagi.cli.main import main
for file in sys.argv[1:]:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main(["check", file])
    print(json.dumps([status, out.getvalue(), err.getvalue()]))
"""
Outcome = tuple[int, str, str]


def ran(program: str, files: list[Path]) -> list[str]:
    command = [sys.executable, "-c", program, *map(str, files)]
    found = subprocess.run(
        command, capture_output=True, text=True, check=False, preexec_fn=bounded, timeout=SECONDS
    )
    assert (found.returncode, found.stderr) == (0, "")
    return list(found.stdout.splitlines())


def checked(place: Path, *texts: str | bytes) -> list[Outcome]:
    files = [place / f"{k}.json" for k in range(len(texts))]
    for file, text in zip(files, texts, strict=True):
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return [json.loads(line) for line in ran(EACH, files)]


def bounded() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def refused(found: Outcome) -> str:
    status, out, err = found
    assert (status, out) == (2, ""), found
    assert err.startswith("Error: ") and err.count("\n") == 1
    assert len(err) < 1000
    return err


def in_place_of_p(text: str) -> Callable[[], str]:
    return lambda: dumps(line()).replace('"P":[[1]]', f'"P":{text}')


def forged(document: Document) -> str:
    return json.dumps(resealed(document))


def many_bits() -> str:
    """80 states with numbers from 1e-40 to 1e40 would take many minutes of exact elimination."""
    n, names = 80, [f"x{k}" for k in range(80)]
    A = [
        [-1e38 if i == j else (1 + i + n * j) * 1.23456789e-40 for j in range(n)] for i in range(n)
    ]
    P = [[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)]
    model = {"kind": "takagi-sugeno", "sample_time": None, "state_names": names, "A": [A]}
    claim = {"name": "d", "kind": "decay", "decay_rate": 0, "P": P}
    document = {"format": "takagi-certificate", "version": 1, "model": model, "gains": None}
    return forged(document | {"claims": [claim]})


FILES: dict[str, tuple[Callable[[], str | bytes], str]] = {
    "exponent": (in_place_of_p("[[1e999999999]]"), "exponents go to"),
    "small exponent": (in_place_of_p("[[1e-999999999]]"), "exponents go to"),
    "digits": (lambda: in_place_of_p(f"[[{'9' * 10**6}]]")(), "characters; at most"),
    "fraction digits": (lambda: in_place_of_p(f"[[0.{'1' * 10**6}]]")(), "characters; at most"),
    "NaN": (in_place_of_p("[[NaN]]"), "is not a number"),
    "infinity": (in_place_of_p("[[-Infinity]]"), "is not a number"),
    "twice": (in_place_of_p('[[1]],"P":[[2]]'), "appears twice"),
    "deep": (lambda: in_place_of_p("[" * 10**6 + "]" * 10**6)(), "nested deeper"),
    "open": (lambda: "[" * 10**6, "nested deeper"),
    "deep objects": (lambda: '{"a":' * 10**6, "nested deeper"),
    "bits": (many_bits, "bits"),
    "numbers": (lambda: in_place_of_p(f"[[{'1,' * 7_000_000}1]]")(), "entries"),
    "lists": (lambda: in_place_of_p(f"[{'[],' * 5_000_000}[]]")(), "entries"),
    "shallow lists": (
        lambda: in_place_of_p(f"[{('[' * 30 + ']' * 30 + ',') * 200_000}1]")(),
        "ent",
    ),
    "large": (lambda: " " * 16_000_001, "larger than"),
    "strings": (lambda: '{"a":' + '"x' * 7_000_000, "not JSON"),
    "backslashes": (lambda: '{"a":"' + "\\" * 15_000_000, "not JSON"),
    "bytes": (lambda: b"\xff\xfe{}", "not UTF-8"),
    "half a pair": (in_place_of_p('"\\ud800"'), ""),
    "zero bytes": (lambda: "\x00" * 1000, "not JSON"),
    "nothing": (lambda: "", "not JSON"),
    "words": (lambda: '"certificate"', "an object is needed"),
}


VERSIONS = ("0", "2", "1.5", '"1"', "true", "null", "1e40", "[1]")


def test_files_that_a_reader_must_not_swallow(tmp_path: Path) -> None:
    """The certificate that they are made from passes with the same bound on memory."""
    right = dumps(line())
    others = {f"version {v}": right.replace('"version":1,', f'"version":{v},') for v in VERSIONS}
    texts = {name: make() for name, (make, _) in FILES.items()} | others
    first, *found = checked(tmp_path, right, *texts.values())

    assert first[0] == 0
    for name, outcome in zip(texts, found, strict=True):
        assert FILES.get(name, ("", "version"))[1] in refused(outcome), name


@pytest.mark.slow
def test_as_many_entries_as_are_read_fit_into_memory(tmp_path: Path) -> None:
    """Just below the bound on entries: read, and refused for what they are."""
    numbers = "0.123456," * 1_700_000

    refused(checked(tmp_path, in_place_of_p(f"[[{numbers}1]]")())[0])


EXPRESSIONS = {
    "power": "x^999999999",
    "tower": "x^9^9^9^9",
    "number": "9" * 10**5 + "*x",
    "exponent": "1e999999999*x",
    "brackets": "(" * 10**5 + "x" + ")" * 10**5,
    "signs": "-" * 10**5 + "x",
    "sums": "+".join(["x"] * 10**5),
    "product": "*".join(["(x+1)"] * 10**4),
    "nested": "sin(" * 10**4 + "x" + ")" * 10**4,
    "squares": "((((((((x+1)^64)^64)^64)^64)^64)^64)^64)",
    "call": "__import__('os').system('id')",
    "member": "x.__class__",
    "zero": "x/0",
    "line": "x\n",
}


MANY = """
import sys
from takagi.certificates.checker import CertificateError, check
for file in sys.argv[1:]:
    try:
        print(file, check(file).verdict.name)
    except CertificateError as error:
        print(file, "refused", len(str(error)) < 1000)
"""


def test_expressions_made_to_grow(tmp_path: Path) -> None:
    """x' = -x with an expression that is too long, too deep or too large in one place of three."""
    files = []
    for member in ("equations", "premise", "entry"):
        for name, text in EXPRESSIONS.items():
            files.append(tmp_path / f"{member} {name}")
            files[-1].write_text(forged(plant_with(member, text)))

    outcomes = ran(MANY, files)

    assert len(outcomes) == len(files)
    assert all(line.endswith(("refused True", "UNDECIDED")) for line in outcomes), outcomes


def plant_with(member: str, text: str) -> Document:
    premise = {"name": "z1", "expression": "x^2", "lower": 0, "upper": 1, "unit": "-"}
    model = {
        "kind": "plant",
        "name": "plant",
        "sample_time": None,
        "states": [{"name": "x", "unit": "-", "range": [-1, 1], "rest": 0}],
        "inputs": [],
        "disturbances": [],
        "parameters": {},
        "equations": [text if member == "equations" else "-x"],
        "outputs": [],
        "embedding": {
            "premises": [premise | ({"expression": text} if member == "premise" else {})],
            "A": [[text if member == "entry" else "-1"]],
            "B": [[]],
        },
    }
    claim = {"name": "is its model", "kind": "sector-embedding"}
    document = {"format": "takagi-certificate", "version": 1, "model": model, "gains": None}
    return document | {"claims": [claim]}


def test_the_plant_they_are_made_from_passes(tmp_path: Path) -> None:
    """What is refused above is refused for its expression."""
    file = tmp_path / "certificate.json"
    file.write_text(forged(plant_with("equations", "-x")))

    assert check(file).verdict is Verdict.PROVED


# ------------------------------------------------------------- names of files


def cart(place: Path, table: str = "rub.csv") -> Path:
    texts = texts_of("cart")
    file, *_ = names = list(texts)
    for name in names:
        (place / name).write_text(texts[name].replace('"rub.csv"', json.dumps(table)))
    return place / file


def test_the_file_itself_may_be_a_link(tmp_path: Path) -> None:
    """The user has named it; nothing is hidden from him."""
    inside = tmp_path / "models"
    inside.mkdir()
    file = cart(inside)
    file.rename(tmp_path / "elsewhere")
    file.symlink_to(tmp_path / "elsewhere")

    assert "tables pass their files' values" in compare_model(of_model("cart"), file)


@pytest.mark.parametrize("target", ["../secret", "/etc/hostname", "/dev/zero", "/dev/stdin"])
def test_a_table_that_is_a_link_out_of_the_folder(target: str, tmp_path: Path) -> None:
    inside = tmp_path / "models"
    inside.mkdir()
    (tmp_path / "secret").write_text(texts_of("cart")["rub.csv"])
    (inside / "table.csv").symlink_to(target)

    with pytest.raises(CertificateError, match="leads out"):
        compare_model(of_model("cart"), cart(inside, "table.csv"))


@pytest.mark.parametrize(
    "name", ["/dev/zero", "/etc/passwd", "../../x", "a/../../x", "~", "C:x", "\\\\host\\x", "a\nb"]
)
def test_a_table_that_leads_out_of_the_folder(name: str, tmp_path: Path) -> None:
    with pytest.raises(CertificateError):
        compare_model(of_model("cart"), cart(tmp_path, name))


def test_a_folder_or_a_pipe_in_the_place_of_a_table(tmp_path: Path) -> None:
    """A pipe that nobody writes to would keep a reader waiting for ever."""
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    for name in ("folder", "pipe"):
        with pytest.raises(CertificateError, match="not a file"):
            compare_model(of_model("cart"), cart(tmp_path, name))


def test_a_pipe_in_the_place_of_a_certificate_or_gain_file(tmp_path: Path) -> None:
    """Nobody writes to it: takagi says so and ends, it does not wait."""
    (tmp_path / "c.json").write_text(json.dumps(line()))
    os.mkfifo(tmp_path / "pipe")
    for files in (["pipe"], ["c.json", "--gains", "pipe"]):
        command = [sys.executable, "-m", "takagi.cli", "check", *files]
        found = subprocess.run(
            command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=SECONDS
        )

        assert found.returncode == 2
        assert found.stderr.startswith("Error: pipe: ") and "a plain file is needed" in found.stderr


@pytest.mark.parametrize("name", ["gains", "model"])
@pytest.mark.parametrize(
    "text", ["", "[" * 10**6, '{"law":1e999999999}', "\x00", "a = 1e999999999"]
)
def test_companions_are_no_more_trusted(name: str, text: str, tmp_path: Path) -> None:
    about_it = tmp_path / "certificate.json"
    about_it.write_text(json.dumps(line()))
    other = tmp_path / ("plant.toml" if name == "model" else "gains.json")
    other.write_text(text)

    with pytest.raises(CertificateError):
        compare_model(of_model("cart"), other)
    companion: dict[str, Any] = {name: other}
    with pytest.raises(CertificateError):
        check(about_it, **companion)


@pytest.mark.parametrize("claims", [True, 1, None, "x", {}, [], [1], [None], [{}], [{"kind": 1}]])
@pytest.mark.parametrize("controller", [{}, {"controller": {"version": "1"}}])
def test_claims_of_another_type_beside_a_gain_file(
    claims: Any, controller: dict[str, Any], tmp_path: Path
) -> None:
    """The file is compared before the claims are replayed: what it needs of them is read first."""
    law = {"name": "pdc", "K": [[[1]]]}
    document = {
        "format": "takagi-certificate",
        "version": 1,
        "model": {"kind": "plant"},
        "gains": law,
        "claims": claims,
        **controller,
    }
    (tmp_path / "c.json").write_text(json.dumps(resealed(document)), "utf-8")
    (tmp_path / "gains.json").write_text(json.dumps({"law": law}), "utf-8")

    with pytest.raises(CertificateError, match="claims"):
        check(tmp_path / "c.json", gains=tmp_path / "gains.json")
