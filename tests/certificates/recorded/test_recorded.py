"""The checker answers every recorded certificate as it has: verdicts, names and numbers."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import pytest

from tests.certificates.recorded.answers import Case, answer_in_words, cases, kinds
from tests.certificates.recorded.damages import Damage, answer_to, damages, names

TOGETHER = 16


@cache
def listed_cases(kind: str) -> list[Case]:
    return list(cases(kind))


PARTS = [(kind, first) for kind in kinds() for first in range(0, len(listed_cases(kind)), TOGETHER)]


@pytest.mark.parametrize(("kind", "first"), PARTS)
def test_the_answer_is_the_same(kind: str, first: int, tmp_path: Path) -> None:
    """Honest and forged ones; ``answers`` tells how the answers are written anew."""
    for number, case in enumerate(listed_cases(kind)[first : first + TOGETHER]):
        found, said = answer_in_words(case.text, tmp_path / "certificate.json")
        where = f"{kind}.jsonl, line {first + number + 1}: {case.what}"
        assert found == case.answer, where
        assert case.words in said, where


def test_both_answers_are_recorded_of_every_kind() -> None:
    """What is proved alone, or refused alone, would notice half; ``document`` is read, no more."""
    for kind in set(kinds()) - {"document"}:
        first = {case.answer[0][0] for case in listed_cases(kind)}
        assert "PROVED" in first or "DISPROVED" in first, kind
        assert first & {"UNDECIDED", "refused"}, kind


DAMAGES_TOGETHER = 12
kept = cache(damages)
DAMAGED_PARTS = [
    (name, first) for name in names() for first in range(0, len(kept(name)[1]), DAMAGES_TOGETHER)
]


@pytest.mark.parametrize(("name", "first"), DAMAGED_PARTS)
def test_the_answer_to_a_damaged_one_is_the_same(name: str, first: int) -> None:
    listed: list[Damage]
    document: dict[str, Any]
    document, listed = kept(name)
    for damage in listed[first : first + DAMAGES_TOGETHER]:
        said: list[str] = []
        assert answer_to(document, damage.changes, said) == damage.answer, damage
        assert damage.words in " ".join(said), damage
