"""One entry of a certificate is changed: the checker says what it has said, with its numbers."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.certificates.recorded.answers import answer_of
from tests.certificates.recorded.damages import damaged, damages, names

TOGETHER = 40
PARTS = [(name, first) for name in names() for first in range(0, len(damages(name)[1]), TOGETHER)]


@pytest.mark.parametrize(("name", "first"), PARTS)
def test_it_says_the_same(name: str, first: int, tmp_path: Path) -> None:
    document, listed = damages(name)
    for place, value, answer in listed[first : first + TOGETHER]:
        found = answer_of(damaged(document, place, value), tmp_path / "certificate.json")
        assert found == answer, (place, value)
