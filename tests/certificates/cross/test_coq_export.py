"""Certificates in Coq: what is written is definite, and coqc believes it only when it is true."""

from __future__ import annotations

import re
import shutil
import subprocess
from operator import mul
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import CertificateError
from takagi.certificates.coq.coq_export import CoqFile, coq_file, shorter, text_of
from takagi.certificates.document.certificate_file import dumps
from takagi.cli.verbs.export import run as export_verb
from tests.certificates.kinds.claims import Data, model_data, resealed, sealed

needs_coq = pytest.mark.skipif(shutil.which("coqc") is None, reason="coqc is not installed")


def small_certificate(decay_rate: float = 0.3) -> Data:
    """Return a certificate with definite matrices and, on its edge, semidefinite ones.

    x1' = -x1, x2' = -2 x2 - x1: {x'x <= 1} touches its box |x1| <= 1, so that one matrix is
    singular.
    """
    model = model_data(
        [[[-1, 0], [-1, -2]], [[-1, 0], [0, -2]]],
        box={"x1 [-]": [-1, 1], "x2 [-]": [-1, 1]},
    )
    decay = {"name": "any", "kind": "decay", "P": [[1, 0], [0, 1]], "decay_rate": decay_rate}
    ellipsoid: Data = {"name": "any", "kind": "invariant-ellipsoid", "P": [[1, 0], [0, 1]]}
    ellipsoid |= {"level": 1, "multiplier": 0.1}
    return sealed(model, None, decay, ellipsoid)


def exported(document: Data) -> CoqFile:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "certificate.json"
        path.write_text(dumps(document), encoding="utf-8")
        return coq_file(path)


def written(document: Data) -> str:
    return exported(document).text


def coqc(text: str, folder: Path) -> subprocess.CompletedProcess[str]:
    (folder / "certificate.v").write_text(text, encoding="utf-8")
    return subprocess.run(
        ["coqc", "certificate.v"], cwd=folder, capture_output=True, text=True, check=False
    )


@given(st.integers(1, 4), st.integers(-20, 20), st.data())
def test_shorter_numbers_show_the_same(n: int, power: int, data: Any) -> None:
    """For M = L L' + I, badly scaled: x'Mx >= y'Ny with y = s x, as a semidefinite difference."""
    rows = st.lists(st.integers(-9, 9), min_size=n, max_size=n)
    L = [data.draw(rows) for _ in range(n)]
    scale = [10 ** (abs(power) if (i % 2 == 1) == (power > 0) else 0) for i in range(n)]
    found = shorter([
        [
            scale[i] * scale[j] * (sum(map(mul, L[i], L[j])) + int(i == j))
            for j in range(n)
        ]
        for i in range(n)
    ])  # fmt: skip

    assert found is not None
    M, s, N = found
    for i in range(n):
        assert s[i] ** 2 * (N[i][i] + n - 1) <= M[i][i]
        for j in range(i):
            assert abs(M[i][j] - s[i] * s[j] * N[i][j]) <= s[i] * s[j]
    assert max(abs(v) for row in N for v in row) < 10**6


def test_nearly_singular_matrix_gets_the_digits_it_needs() -> None:
    found = shorter([[10**30, 10**30], [10**30, 10**30 + 1]])

    assert found is not None
    assert max(map(max, found.rounded)) > 10**29
    assert shorter([[1, 1], [1, 1]]) is None
    assert shorter([[-1]]) is None


def test_upper_triangle_as_text() -> None:
    assert text_of([[1, -2, 3], [-2, 5, 0], [3, 0, 7]]) == "1,-2,3,/5,0,/7,/;"


def test_every_matrix_of_every_claim_is_there() -> None:
    """Two blends and P once for decay; the second claim repeats P and adds semidefinite ones."""
    found = exported(small_certificate())

    assert found.matrices == {1: 3, 2: 5}
    assert len(re.findall(r"^Theorem claim_\d+_(?:strict|weak)_\d+ :", found.text, re.M)) == 3


def test_false_claim_has_no_theorem() -> None:
    with pytest.raises(CertificateError, match="is not proved"):
        written(small_certificate(decay_rate=3.0))


def test_no_text_of_the_certificate_enters_the_file() -> None:
    """A name that ends Coq's comment and begins a false axiom stays outside."""
    hostile = small_certificate()
    hostile["claims"][0]["name"] = "*) Axiom false : False. (*"

    assert "Axiom" not in written(resealed(hostile))


def test_verb_writes_the_file(tmp_path: Path, capsys: Any) -> None:
    certificate, target = tmp_path / "certificate.json", tmp_path / "certificate.v"
    certificate.write_text(dumps(small_certificate()))

    assert export_verb([str(certificate), "--coq", str(target)]) == 0
    assert "8 matrices of 2 claims" in capsys.readouterr().out
    assert target.read_text() == written(small_certificate())

    certificate.write_text(dumps(small_certificate(decay_rate=3.0)))
    assert export_verb([str(certificate), "--coq", str(target)]) == 2


def test_verb_writes_the_turbine(short: Data, tmp_path: Path, capsys: Any) -> None:
    """The turbine's matrices are written; that its ranges enclose the plant was decided before."""
    certificate = tmp_path / "certificate.json"
    certificate.write_text(dumps(short))

    assert export_verb([str(certificate), "--coq", str(tmp_path / "short.v")]) == 0
    assert "matrices of 1 claims" in capsys.readouterr().out


@needs_coq
@pytest.mark.coq
def test_coq_believes_a_certificate(tmp_path: Path) -> None:
    """The proof compiles, and rests on the two axioms of Coq's real numbers alone."""
    done = coqc(written(small_certificate()), tmp_path)

    assert done.returncode == 0, done.stderr
    axioms = re.findall(r"^(\S+)$|^(\S+) ?:", done.stdout, re.M)
    names = {first or second for first, second in axioms} - {"Axioms:", "Axioms"}
    assert names == {
        "ClassicalDedekindReals.sig_forall_dec",
        "FunctionalExtensionality.functional_extensionality_dep",
    }


@needs_coq
@pytest.mark.coq
@pytest.mark.parametrize("change", ["entry", "pivot", "rounding", "count", "singular", "gone"])
def test_coq_does_not_believe_a_changed_matrix(change: str, tmp_path: Path) -> None:
    """A sign, a pivot, a rounded entry too large, a number of matrices that is not there."""
    text = written(small_certificate())
    changed = CHANGES[change](text)
    assert changed != text

    done = coqc(changed, tmp_path)

    assert done.returncode != 0
    assert "Error" in done.stderr


def _first_matrix(text: str, matrix: str) -> str:
    place = text.index("Theorem claim_1_strict_1")
    start = text.index('"\n', place) + 2
    return text[:start] + matrix + text[text.index(";", start) + 1 :]


CHANGES = {
    "entry": lambda text: _first_matrix(text, "2048,4096,/2048,/;"),
    "pivot": lambda text: _first_matrix(text, "-2048,0,/2048,/;"),
    "rounding": lambda text: _first_matrix(text, "2000,0,/2048,/;"),
    "count": lambda text: re.sub(r"(claim_1_strict_1 : hold )3", r"\g<1>4", text),
    "singular": lambda text: re.sub(
        r'(claim_2_weak_1 : hold_semi )\d+ "\n[^"]*"', r'\g<1>1 "\n1,2,/3,/;\n"', text
    ),
    "gone": lambda text: re.sub(r'(hold 3 ")[^"]*"', r'\g<1>"', text, count=1),
}


@needs_coq
@pytest.mark.coq
@pytest.mark.slow
def test_coq_believes_the_turbine(whole: Data, short: Data, reduced: bool, tmp_path: Path) -> None:
    """All matrices of all wind cells; about a minute (reduced: of six cells at rated wind)."""
    found = exported(short if reduced else whole)

    assert found.count > (300 if reduced else 4_000)
    done = coqc(found.text, tmp_path)
    assert done.returncode == 0, done.stderr
