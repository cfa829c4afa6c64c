"""Certificates with the answers that the checker has given to them, to compare it with itself.

``<kind>.jsonl`` holds a line for each: the answer, and the file as text.  The files are those that
the tests of this folder's neighbours give to the checker, honest and forged, one or a few for every
answer that differs in more than its numbers.  An answer is the verdict of the file and of every
claim: what is proved or disproved in full, with what it assumes; of the rest, and of a refusal, the
words that hold a digit.

``python -m tests.certificates.recorded.answers`` writes the answers of today.  A line that differs
then is a change of what a certificate is worth: read it before it is committed.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from takagi.certificates import CertificateError, Verdict, check
from takagi.certificates.checker.kernel.result import Claim

FOLDER = Path(__file__).parent
Answer = list[list[str]]


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
    try:
        found = check(path)
    except CertificateError as error:
        return [["refused", *_with_digits(str(error).replace(str(path), ""))]]
    return [[found.verdict.name], *(_said(claim) for claim in found.claims)]


def _said(claim: Claim) -> list[str]:
    if claim.verdict is Verdict.UNDECIDED:
        return [claim.verdict.name, *_with_digits(f"{claim.name} {claim.text}")]
    return [claim.verdict.name, claim.name, claim.text, *claim.assumes]


def _with_digits(sentence: str) -> list[str]:
    return [word.strip(".,;:()'\"") for word in re.findall(r"\S*\d\S*", sentence)]


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
