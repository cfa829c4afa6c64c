"""The strict reader: numbers as written, and one kind of refusal for everything else."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from takagi.certificates.checker import CertificateError, check, read_text
from takagi.certificates.checker.kernel.reader import (
    LARGEST_FILE,
    Number,
    canonical,
    digest,
    integer,
    matrix,
    number,
    numbers,
    read_json,
    text,
)

DEEP = 900


def hidden_depth() -> str:
    """Return deep nesting in which every level carries a string that closes brackets."""
    return '{"a":' + '["]]]",' * DEEP + "1" + "]" * DEEP + "}"


@pytest.mark.parametrize(
    "written",
    [
        "",
        "[]",
        "1",
        '"x"',
        "null",
        "{",
        '{"a":1}}',
        '{"a":1,}',
        "{'a':1}",
        '{"a":NaN}',
        '{"a":Infinity}',
        '{"a":-Infinity}',
        '{"a":01}',
        '{"a":+1}',
        '{"a":.5}',
        '{"a":1.}',
        '{"a":0x10}',
        '{"a":1_0}',
        '{"a":\u0661\u0662}',
        '{"a":1e999999}',
        '{"a":1e-41}',
        '{"a":1E+00000000000000000000000000000041}',
        '{"a":' + "9" * 61 + "}",
        '{"a":' + "9" * 10**6 + "}",
        '{"a":1,"a":1}',
        '{"a":{"b":1,"b":2}}',
        '{"a":1,"\\u0061":2}',
        '{"a":"\n"}',
        '\ufeff{"a":1}',
        '{"a":' * 41 + "1" + "}" * 41,
        "[" * 10**6,
        '{"a":"' + '\\"' * 10**6,
        hidden_depth(),
    ],
    ids=lambda written: ascii(written[:24]),
)
def test_what_is_not_strict_json_is_refused(written: str) -> None:
    """RFC 8259 without its liberties: no duplicate, no non-number, nothing huge or deep."""
    with pytest.raises(CertificateError):
        read_text(written, "file")


@given(st.text(alphabet='{}[]":,.0123456789eE+-truefalsn\\ u\n', max_size=60))
@example('{"a":"\\ud800"}')
@example('{"\\ud800":{"\\ud800":1}}')
def test_any_text_is_read_or_refused(written: str) -> None:
    """No text escapes with anything but an object or a CertificateError, and reading is stable."""
    try:
        found = read_text(written, "file")
    except CertificateError:
        return
    assert read_text(canonical(found), "again") == found
    assert digest(found) == digest(read_text(canonical(found), "again"))


@given(st.binary(max_size=80))
def test_any_file_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    """Bytes that are no UTF-8, or no certificate, are refused by ``check`` itself."""
    file = tmp_path_factory.mktemp("bytes") / "certificate.json"
    file.write_bytes(data)

    with pytest.raises(CertificateError):
        check(file)


@given(st.decimals(allow_nan=False, allow_infinity=False, places=9, min_value=-1e9, max_value=1e9))
def test_numbers_are_exactly_what_is_written(value: object) -> None:
    """0.1 is one tenth; no number passes through binary floating point."""
    assert number(read_text(f'{{"a":{value}}}', "file"), "a", "file") == Fraction(str(value))


def test_more_entries_than_any_certificate_has_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Brackets and commas are counted before an object is made."""
    monkeypatch.setattr("takagi.certificates.checker.kernel.reader.MOST_PARTS", 4)
    assert read_text('{"a":[1,2,3]}', "file")["a"] == ["1", "2", "3"]
    with pytest.raises(CertificateError, match="over 4 entries"):
        read_text('{"a":[1,2,3,4]}', "file")


def test_brackets_inside_strings_are_not_depth() -> None:
    """A text of opening brackets is a text."""
    assert read_text('{"a":"' + "[" * 1000 + '"}', "file")["a"] == "[" * 1000


@pytest.mark.parametrize("value", ['"1"', "true", "false", "null", "[1]", "{}"])
def test_what_is_not_a_number_is_refused(value: str) -> None:
    data = read_text(f'{{"a":{value},"b":[{value}],"c":[[{value}]]}}', "file")

    for read, key in ((number, "a"), (integer, "a"), (numbers, "b"), (matrix, "c")):
        with pytest.raises(CertificateError):
            read(data, key, "file")


@pytest.mark.parametrize("rows", ["[]", "[[]]", "[1,2]", "[[1,2],[3]]", "[[1],[]]", "[[1],2]"])
def test_ragged_and_empty_matrices_are_refused(rows: str) -> None:
    """A matrix is a rectangle of numbers."""
    with pytest.raises(CertificateError):
        matrix(read_text(f'{{"a":{rows}}}', "file"), "a", "file")


def test_counts_and_whole_numbers() -> None:
    """A row of the wrong length and 1.5 as a version are refused; 1.0 is whole."""
    data = read_text('{"a":[1,2],"b":1.5,"c":1.0}', "file")

    assert integer(data, "c", "file") == 1
    with pytest.raises(CertificateError, match="3 numbers"):
        numbers(data, "a", "file", 3)
    with pytest.raises(CertificateError, match="whole"):
        integer(data, "b", "file")


@pytest.mark.parametrize("value", ["a\nb", "a\x1b[31mb", "\ud800", "a\u202eb", 1, True, None])
def test_only_printable_lines_are_text(value: object) -> None:
    """Names are shown in terminals: no control characters, no half characters, no numbers."""
    with pytest.raises(CertificateError, match="printable"):
        text(read_text(json.dumps({"a": value}), "file"), "a", "file")


def test_a_number_and_its_text_have_different_hashes() -> None:
    """1 and "1", 1 and 1.0, true and "true": what differs in the file differs in the hash."""
    written = ["1", '"1"', "1.0", "1e0", "true", '"true"', "null", '"null"', "[1]", '"[1]"']
    found = {digest(read_text(f'{{"a":{w}}}', "file")) for w in written}

    assert len(found) == len(written)
    assert isinstance(read_text('{"a":1}', "file")["a"], Number)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    large = tmp_path / "large.json"
    large.write_bytes(b" " * (LARGEST_FILE + 1))

    for path, words in (
        (tmp_path / "missing.json", "cannot be read: No such file"),
        (tmp_path, "a plain file is needed"),
        (large, "larger than"),
    ):
        with pytest.raises(CertificateError, match=f"{path.name}: .*{words}"):
            read_json(path)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ('{"law": {"K": [[[1, NaN]]]}}', "law.K[0][0][1]: NaN is not a number; a finite decimal"),
        ('{"a": {"b": [1, {"c": -Infinity}]}}', "a.b[1].c: -Infinity is not a number"),
        ('{"a": 1e9, "b": [1, 1e41], "c": 1e41}', "b[1]: number 1e41: exponents go to 40"),
        (f'{{"a": "NaN", "b": {"9" * 61}}}', "b: a number of 61 characters; at most 60"),
        # What is said of another part of the file is said of that part alone.
        ('{"a": {"b": 1, "b": 2}, "c": NaN}', "key 'b' appears twice"),
        ('{"a": [NaN], }', "NaN is not a number"),
        (f'{{"a": NaN, "b": {"[" * 41}1{"]" * 41}}}', "nested deeper than 40"),
    ],
)
def test_the_place_of_a_refused_number_is_named(written: str, words: str) -> None:
    with pytest.raises(CertificateError) as refused:
        read_text(written, "FILE")

    assert str(refused.value).startswith(f"FILE: {words}")
