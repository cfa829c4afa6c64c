"""The design of the turbine as a certificate is written."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import pytest

from takagi.certificates import TurbineDesign


@pytest.fixture(scope="session")
def document(turbine_design: TurbineDesign) -> dict[str, Any]:
    damage: Any = import_module("damage")
    found: dict[str, Any] = damage.as_written(turbine_design.document)
    return found
