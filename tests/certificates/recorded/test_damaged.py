"""One entry of a certificate is changed: the checker answers as it has answered."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from tests.certificates.recorded.damages import Damage, answer_to, damages, names

TOGETHER = 12
kept = cache(damages)
PARTS = [(name, first) for name in names() for first in range(0, len(kept(name)[1]), TOGETHER)]


@pytest.mark.parametrize(("name", "first"), PARTS)
def test_the_answer_is_the_same(name: str, first: int) -> None:
    listed: list[Damage]
    document: dict[str, Any]
    document, listed = kept(name)
    for place, value, answer in listed[first : first + TOGETHER]:
        assert answer_to(document, place, value) == answer, (place, value)
