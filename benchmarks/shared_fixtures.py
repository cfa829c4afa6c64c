"""The fixtures that several tests share: which they are, that they are kept, and what they run.

A fixture that is made once is made by the code as it is.  Those that take something back at their
end, or whose value a parameter chooses, are left to pytest.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Container, Iterator
from pathlib import Path
from typing import Any

import pytest
from _pytest.fixtures import FixtureDef, FixtureRequest
from traced_lines import Lines, traced

# Whose fixtures are not the project's.
PLUGINS = ("_pytest", "pytest", "hypothesis", "xdist")


def shared(item: pytest.Item) -> Iterator[FixtureDef[Any]]:
    """Yield the fixtures of a test that several tests share and that are kept."""
    assert isinstance(item, pytest.Function)
    for definitions in item._fixtureinfo.name2fixturedefs.values():
        for definition in definitions:
            ours = not definition.func.__module__.startswith(PLUGINS)
            if definition.scope != "function" and ours and keepable(definition):
                yield definition


def name_of(definition: FixtureDef[Any]) -> str:
    return f"{definition.baseid}::{definition.argname}"


def keepable(definition: FixtureDef[Any]) -> bool:
    """Whether nothing has to be taken back, and no parameter chooses the value."""
    return definition.params is None and not inspect.isgeneratorfunction(definition.func)


def kept(finish: Callable[..., None]) -> Callable[..., None]:
    """Return the end of a fixture's life, for those that do not live until the process ends."""

    def finished(self: FixtureDef[Any], request: FixtureRequest) -> None:
        if self.scope == "function" or not keepable(self) or hasattr(request, "param"):
            finish(self, request=request)

    return finished


class Recorder:
    """Notes which lines of the checker each shared fixture runs."""

    def __init__(self, package: Path, names: Container[str]) -> None:
        self.package, self.names = package, names
        self.lines: dict[str, Lines] = {}

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef: FixtureDef[Any]) -> Iterator[None]:
        if name_of(fixturedef) not in self.names:
            yield
            return
        with traced(self.package) as lines:
            yield
        self.lines[name_of(fixturedef)] = lines
