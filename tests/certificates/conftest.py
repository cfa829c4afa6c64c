"""One certificate of the effort-sharing loop for all tests here, and a short one of six cells."""

from __future__ import annotations

import sys
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.claims.turbine.cell_loop import SHRINK, EffortSharingCandidate
from takagi.certificates.claims.turbine.effort_sharing import (
    effort_sharing_candidate,
    effort_sharing_claim,
)
from takagi.certificates.document.certificate_file import (
    effort_sharing_law_data,
    turbine_data,
)
from takagi.lmi.turbine.effort import effort_gains
from takagi.models import Floats, Turbine, nrel5mw
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from tests.certificates.kinds.claims import resealed, sealed

# The campaigns of benchmarks/ are scripts: their folder is put on the path, as Python does.
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

PER_INTERVAL = {"integral_rate"}
# P of the default loop, as the search returns it.
FUNCTION = [
    [1206.6526, -420.5312, -821.163],
    [-420.5312, 15783.6907, 154.3569],
    [-821.163, 154.3569, 2139.0917],
]
# Nodes kept in the short certificate: where the effort passes from torque to pitch.
SHORT_FROM, SHORT_CELLS = 11.2, 6


@dataclass(frozen=True)
class Built:
    """The whole chain once: turbine, law, candidate, and the document as plain data."""

    turbine: Turbine
    law: EffortSharingLaw
    candidate: EffortSharingCandidate
    document: dict[str, Any]


@pytest.fixture(scope="session")
def built() -> Built:
    """Return the certified NREL 5-MW loop; about two seconds."""
    turbine = nrel5mw()
    schedule = effort_schedule(turbine)
    law = EffortSharingLaw.of(turbine, schedule, effort_gains(turbine, schedule).gains)
    return certified(law, P=np.array(FUNCTION) / SHRINK)


def certified(law: EffortSharingLaw, P: Floats | None = None) -> Built:
    """Return the whole chain of a law of the NREL 5-MW turbine; P is tried before it is sought."""
    turbine = nrel5mw()
    candidate = effort_sharing_candidate(turbine, law, P=P)
    document = sealed(
        turbine_data(turbine, []), effort_sharing_law_data(law), effort_sharing_claim(candidate)
    )
    return Built(turbine, law, candidate, document)


@pytest.fixture
def whole(built: Built) -> dict[str, Any]:
    return deepcopy(built.document)


@pytest.fixture(scope="session")
def short_document(built: Built) -> dict[str, Any]:
    return resealed(cells_from(built.document, SHORT_FROM))


def cells_from(document: dict[str, Any], wind: float, count: int = SHORT_CELLS) -> dict[str, Any]:
    """Return a copy of a certificate with the wind cells from the first node at a wind on."""
    document = deepcopy(document)
    gains, claim = document["gains"], document["claims"][0]
    first = next(k for k, v in enumerate(gains["wind"]) if v >= wind)
    for name, column in gains.items():
        if isinstance(column, list):
            gains[name] = column[first : first + count + (name not in PER_INTERVAL)]
    claim["cells"] = claim["cells"][first : first + count]
    return document


@pytest.fixture
def short(short_document: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(short_document)
