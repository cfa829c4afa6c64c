"""What all tests share: repeatable property tests, figures without a screen, one design."""

from __future__ import annotations

import gc
import os
from collections import Counter
from functools import cache
from pathlib import Path
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

# The same examples at every run, and no deadline: a slow machine is not a failure.  `.ci/run` looks
# at more of them.
settings.register_profile(
    "takagi",
    derandomize=True,
    deadline=None,
    max_examples=int(os.environ.get("TAKAGI_EXAMPLES", "20")),
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("takagi")


def pytest_collection_finish() -> None:
    """Let no search for garbage, a twentieth of all time, look at what is collected and stays."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)
    gc.enable()


# What takes long to make, and the name by which a file asks for it.  All files that ask for the
# same run in one process, so that it is made once.
SHARED = {
    "turbine_design": "the turbine's design",
    "tests.paper_models": "the paper's law",
    "tests.certificates.test_paper_certificate": "the paper's law",
    "tests.reports.plant_designs": "designs of plants",
    "library_plants": "models of the library",
}
# They take longest and begin first: later one process would be busy while the others wait.
LONGEST = (
    "the turbine's design",
    "models of the library",
    "designs of plants",
)


@cache
def group_of(file: str) -> str:
    """Return what a file of tests runs with: something that takes long to make, or itself."""
    path = Path(__file__).parent.parent / file
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    return next((SHARED[name] for name in SHARED if name in text), file)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Give one process all tests of a group: pytest 9.2 does not read xdist's mark of a group."""
    from xdist.scheduler import LoadScopeScheduling

    class GroupScheduling(LoadScopeScheduling):  # type: ignore[misc, unused-ignore]
        def _split_scope(self, nodeid: str) -> str:
            return group_of(nodeid.split("::", 1)[0])

    return GroupScheduling(config, log)


def pytest_configure(config: pytest.Config) -> None:
    """Let several processes keep to the order of the tests."""
    config.option.loadscopereorder = False


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Where several processes share the tests, large groups begin first."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return
    groups = {item: group_of(item.nodeid.split("::", 1)[0]) for item in items}
    sizes = Counter(groups.values())

    def rank(item: pytest.Item) -> tuple[int, int, str]:
        name = groups[item]
        first = LONGEST.index(name) if name in LONGEST else len(LONGEST)
        return first, -sizes[name], name

    items.sort(key=rank)


@pytest.fixture(scope="session")
def reduced() -> bool:
    """Whether campaigns shall run in their reduced form (``TAKAGI_REDUCED=1``)."""
    return os.environ.get("TAKAGI_REDUCED") == "1"


@pytest.fixture(scope="session")
def turbine_design() -> TurbineDesign:
    """The default design of the NREL 5-MW turbine, made once: fifteen seconds."""
    from tests.turbine_designs import design_with_recorded_cells

    return design_with_recorded_cells()
