"""The campaigns of benchmarks/ are scripts: their folder is put on the path, as Python does."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import TurbineDesign

BENCHMARKS = Path(__file__).resolve().parents[3] / "benchmarks"

if str(BENCHMARKS) not in sys.path:
    sys.path.insert(0, str(BENCHMARKS))


@pytest.fixture(scope="session")
def document(turbine_design: TurbineDesign) -> dict[str, Any]:
    damage: Any = import_module("damage")
    found: dict[str, Any] = damage.as_written(turbine_design.document)
    return found
