"""What the tests of the reports share: one finished design, made once."""

from __future__ import annotations

import pytest

from takagi.certificates.turbine_design import TurbineDesign, design_turbine
from takagi.models.library import data_folder
from takagi.models.turbine.loader import nrel5mw


@pytest.fixture(scope="session")
def turbine_design() -> TurbineDesign:
    """The NREL 5-MW design with the default law."""
    return design_turbine(nrel5mw(), files=sorted(data_folder().glob("nrel5mw*")))
