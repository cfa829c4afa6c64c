"""Certificates with the facts that the checker has told of them, to compare it with itself.

``<kind>.jsonl`` holds a line for each: the answer, the file as text, and of some what it is and the
words that its answer has to have.  The files are honest and forged: those of which it is told what
they are, and of others one or a few for every answer that differs in more than its numbers.  An
answer is the verdict of the file, and of every claim verdict, name and the numbers that its
sentence states; or that the file is refused, and the place of the refusal.  Other words may change,
and numbers of what is not proved.

``python -m tests.certificates.recorded.answers`` writes the answers of today, and begins a file for
a kind that has none; ``[[], text, what, words]`` is a line that has no answer yet.  A line that
differs then is a change of what a certificate is worth: read it before it is committed.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from takagi.certificates import CertificateError, Checked, check

FOLDER = Path(__file__).parent
Answer = list[list[str]]


class Case(NamedTuple):
    answer: Answer
    text: str
    what: str = ""
    words: str = ""


# A hyphen inside a word, as in "5-MW", is no sign.
NUMBER = re.compile(r"(?:(?<!\w)-)?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def kinds() -> list[str]:
    return sorted(path.stem for path in FOLDER.glob("*.jsonl"))


def cases(kind: str) -> Iterator[Case]:
    for line in (FOLDER / f"{kind}.jsonl").read_text(encoding="utf-8").splitlines():
        yield Case(*json.loads(line))


def recorded(kind: str) -> Iterator[tuple[Answer, str]]:
    for case in cases(kind):
        yield case.answer, case.text


def answer_of(written: str, path: Path) -> Answer:
    return answer_in_words(written, path)[0]


def answer_in_words(written: str, path: Path) -> tuple[Answer, str]:
    path.write_text(written, encoding="utf-8")
    said: list[str] = []
    return facts_of(lambda: check(path), str(path), said), " ".join(said)


def facts_of(work: Callable[[], Checked], path: str, said: list[str] | None = None) -> Answer:
    """Return the facts of what a check answers; the file's place is left out."""
    said = [] if said is None else said
    try:
        checked = work()
    except CertificateError as error:
        said.append(str(error))
        return [["refused", str(error).replace(path, "FILE").partition(":")[0]]]
    said += [claim.text for claim in checked.claims]
    return [
        [checked.verdict.name],
        *(facts(c.verdict.name, c.name, c.text) for c in checked.claims),
    ]


def facts(verdict: str, name: str, sentence: str) -> list[str]:
    stated = verdict in ("PROVED", "DISPROVED")
    return [verdict, name, *([" ".join(NUMBER.findall(sentence))] if stated else [])]


def first_recorded(kind: str, place: Path) -> list[str]:
    """Return certificates of a kind of which none is recorded, one for each different answer."""
    from tests.certificates.kinds.claims import resealed
    from tests.certificates.recorded.damages import LEFT_OUT, changes
    from tests.certificates.weights.cells import cell_document

    by_answer: dict[str, str] = {}
    for form in ("shared", "products"):
        honest = cell_document(kind, form)
        claims = [honest["claims"][-1]]
        for member, value in claims[0].items():
            altered = ({**claims[0], member: new} for new in changes(value) if new != LEFT_OUT)
            claims += altered if member not in ("kind", "name") else ()
            claims.append({name: entry for name, entry in claims[0].items() if name != member})
        for claim in claims:
            document = resealed({**honest, "claims": [*honest["claims"][:-1], claim]})
            text = json.dumps(document)
            by_answer.setdefault(json.dumps(answer_of(text, place)), text)
    return list(by_answer.values())


def taken(old: Answer, new: Answer, what: str) -> Answer:
    """Return today's answer; what was not proved is not recorded as proved."""
    shown = {"PROVED", "DISPROVED"}
    if old and old[0][0] not in shown and new[0][0] in shown:
        cure = "if this is true, write [] in the place of its answer and run this again"
        raise SystemExit(f"{old[0]} before, {new[0]} now: {what[:200]}; {cure}")
    return new


def line(answer: Answer, text: str, what: str = "", words: str = "") -> str:
    return json.dumps([answer, text, *([what, words] if what else [])])


def main() -> None:
    from tests.certificates.weights.cells import EVIDENCE

    new = {kind for kind in EVIDENCE if "," not in kind} - set(kinds())
    with TemporaryDirectory() as folder:
        place = Path(folder) / "certificate.json"
        for kind in (*kinds(), *sorted(new)):
            first = kind in new
            written = [Case([], t) for t in first_recorded(kind, place)] if first else cases(kind)
            lines = [
                line(taken(case.answer, answer_of(case.text, place), str(case[1:])), *case[1:])
                for case in written
            ]
            (FOLDER / f"{kind}.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
