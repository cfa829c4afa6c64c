"""The order in which several processes are handed the tests, and which stay together."""

from __future__ import annotations

import pytest

from tests import scheduler
from tests.scheduler import ROOT, SECONDS, SHARED, group, in_order

FIRST, SECOND = "tests/test_layers.py", "tests/test_packaging.py"


def test_every_known_group_exists() -> None:
    """A file that was renamed would silently begin last."""
    wrong = [name for name in SECONDS if name not in SHARED and not (ROOT / name).is_file()]

    assert wrong == []


def test_a_group_is_a_file_or_all_that_share_something() -> None:
    assert group("tests/test_packaging.py") == "tests/test_packaging.py"
    assert group("tests/reports/test_appendix.py") == "the turbine's design"


def test_long_groups_come_first_then_those_of_many_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests of a group keep their order."""
    monkeypatch.setattr(scheduler, "SECONDS", {"tests/test_readme.py": 9.0})
    names = [f"{SECOND}::a", f"{FIRST}::b", f"{FIRST}::c", "tests/test_readme.py::d"]

    assert in_order(names) == [3, 1, 2, 0]
