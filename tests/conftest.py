"""What all tests share: repeatable property tests, and figures without a screen."""

from __future__ import annotations

import os

import pytest
from hypothesis import HealthCheck, settings

# Before anything imports a linear-algebra library: many threads on few cores only add noise.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ["MPLBACKEND"] = "Agg"

# The same examples at every run, and no deadline: a slow machine is not a failure.
settings.register_profile(
    "takagi",
    derandomize=True,
    deadline=None,
    max_examples=50,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("takagi")


@pytest.fixture(scope="session")
def reduced() -> bool:
    """Whether campaigns shall run in their reduced form (``TAKAGI_REDUCED=1``)."""
    return os.environ.get("TAKAGI_REDUCED") == "1"
