"""What all tests share: repeatable property tests, figures without a screen, one design."""

from __future__ import annotations

import gc
import os
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, settings

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

# Before anything imports a linear-algebra library: many threads on few cores only add noise.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ["MPLBACKEND"] = "Agg"

# While tests are imported and collected next to nothing is garbage, and all is looked at again.
gc.disable()

# The same examples at every run, and no deadline: a slow machine is not a failure.
settings.register_profile(
    "takagi",
    derandomize=True,
    deadline=None,
    max_examples=50,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("takagi")


def pytest_collection_finish() -> None:
    """What is imported and collected stays to the end: let no search for garbage look at it.

    It begins after 50000 new objects instead of 700: a twentieth of all time was spent on it.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)
    gc.enable()


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Where several processes share the tests, put those first that take longest."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        from tests.scheduler import in_order

        items[:] = [items[place] for place in in_order([item.nodeid for item in items])]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Where files are kept together, keep those together too that need the same dear thing."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadScopeScheduling

    from tests.scheduler import group

    # The tests come in the order in which they shall be handed out: ``in_order``.
    config.option.loadscopereorder = False
    scheduler = LoadScopeScheduling(config, log)
    scheduler._split_scope = lambda nodeid: group(nodeid.split("::", 1)[0])
    return scheduler


@pytest.fixture(scope="session")
def reduced() -> bool:
    """Whether campaigns shall run in their reduced form (``TAKAGI_REDUCED=1``)."""
    return os.environ.get("TAKAGI_REDUCED") == "1"


@pytest.fixture(scope="session")
def turbine_design() -> TurbineDesign:
    """The default design of the NREL 5-MW turbine, made once: fifteen seconds."""
    from tests.turbine_designs import design_with_recorded_cells

    return design_with_recorded_cells()
