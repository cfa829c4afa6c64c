"""Certificates with the answers that the checker has given to them, to compare it with itself.

``<kind>.jsonl`` holds a line for each: the answer, and the file as text.  The files are those that
the tests of this folder's neighbours give to the checker, honest and forged, one or a few for every
answer that differs in more than its numbers.  An answer is the verdict of the file, and verdict,
name, sentence and assumptions of every claim; or the words of a refusal.

``python -m tests.certificates.recorded.answers`` writes the answers of today.  A line that differs
then is a change of what a certificate is worth, or of what is said of it: read it before it is
committed.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from takagi.certificates import CertificateError, Checked, check

FOLDER = Path(__file__).parent
Answer = list[list[str]]
# What json or the decoder says behind these words differs between versions of Python.
CUT = ("not JSON:", "not UTF-8:")


def kinds() -> list[str]:
    """Return the kinds of claims that there are recorded certificates of."""
    return sorted(path.stem for path in FOLDER.glob("*.jsonl"))


def recorded(kind: str) -> Iterator[tuple[Answer, str]]:
    """Yield (answer, text of the certificate)."""
    for line in (FOLDER / f"{kind}.jsonl").read_text(encoding="utf-8").splitlines():
        answer, written = json.loads(line)
        yield answer, written


def answer_of(written: str, path: Path) -> Answer:
    """Return the answer to a certificate with this text, in a file that is made for it."""
    path.write_text(written, encoding="utf-8")
    return said(lambda: check(path), str(path))


def said(work: Callable[[], Checked], path: str) -> Answer:
    """Return what a check answers; the file's place is left out."""
    try:
        found = work()
    except CertificateError as error:
        words = str(error).replace(path, "FILE")
        for cut in CUT:
            head, mark, _ = words.partition(cut)
            words = head + mark
        return [["refused", words]]
    claims = ([c.verdict.name, c.name, c.text, *c.assumes] for c in found.claims)
    return [[found.verdict.name], *claims]


def main() -> None:
    """Write the answers of today."""
    with TemporaryDirectory() as folder:
        place = Path(folder) / "certificate.json"
        for kind in kinds():
            written = [text for _, text in recorded(kind)]
            lines = [json.dumps([answer_of(text, place), text]) for text in written]
            (FOLDER / f"{kind}.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
