"""Certificates with the facts that the checker has told of them, to compare it with itself.

``<kind>.jsonl`` holds a line for each: the answer, and the file as text.  The files are those that
the tests of this folder's neighbours give to the checker, honest and forged, one or a few for every
answer that differs in more than its numbers.  An answer is the verdict of the file, and of every
claim verdict, name and the numbers that its sentence states; or that the file is refused, and the
place of the refusal.  Words may change, and numbers of what is not proved.

``python -m tests.certificates.recorded.answers`` writes the answers of today.  A line that differs
then is a change of what a certificate is worth: read it before it is committed.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from takagi.certificates import CertificateError, Checked, check

FOLDER = Path(__file__).parent
Answer = list[list[str]]
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?")


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
    return facts_of(lambda: check(path), str(path))


def facts_of(work: Callable[[], Checked], path: str) -> Answer:
    """Return the facts of what a check answers; the file's place is left out."""
    try:
        checked = work()
    except CertificateError as error:
        return [["refused", str(error).replace(path, "FILE").partition(":")[0]]]
    return [
        [checked.verdict.name],
        *(facts(c.verdict.name, c.name, c.text) for c in checked.claims),
    ]


def facts(verdict: str, name: str, sentence: str) -> list[str]:
    """Return verdict and name of a claim, and what its sentence states in numbers."""
    stated = verdict in ("PROVED", "DISPROVED")
    return [verdict, name, *([" ".join(NUMBER.findall(sentence))] if stated else [])]


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
