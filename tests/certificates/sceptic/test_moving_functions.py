"""Forged functions of a claim of kind ``running-rate``: the P(v) of the file is what is proved.

The certificate is the last line of ``recorded/running-rate.jsonl``: two cells that share a wind,
with functions at three winds.
"""

from __future__ import annotations

import json
from copy import deepcopy
from typing import Any

import pytest

from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import verdicts


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    *_, (_, written) = recorded("running-rate")
    return dict(json.loads(written))


@pytest.mark.parametrize("place", [15.0426, 15.2, 15.2913])
@pytest.mark.parametrize("factor", [1e-6, 1.0, -1.0])
def test_a_function_inside_a_cell_is_refused(
    stored: dict[str, Any], place: float, factor: float
) -> None:
    """P would not be linear over the cell; with 1e-6 the set grows by 1000 within 0.13 m/s."""
    document = deepcopy(stored)
    functions = document["claims"][0]["functions"]
    scaled = [[factor * value for value in row] for row in functions[0]["P"]]
    functions.insert(1, {"wind": place, "P": scaled})
    assert verdicts(document) == ("refused", "refused")


def test_a_cell_that_skips_a_function_is_refused(stored: dict[str, Any]) -> None:
    """Two cells stated as one, whose ends have the functions; the one between them stays."""
    document = deepcopy(stored)
    claim = document["claims"][0]
    claim["cells"] = claim["cells"][:1]
    claim["cells"][0]["wind"] = [15.0425, 15.5403]
    claim["winds"] = [[15.0425, 15.5403]]
    assert verdicts(document) == ("refused", "refused")


def test_a_function_beside_the_cells_is_no_part_of_the_claim(stored: dict[str, Any]) -> None:
    document = deepcopy(stored)
    claim = document["claims"][0]
    claim["cells"], claim["winds"] = claim["cells"][:1], [claim["cells"][0]["wind"]]
    assert len(claim["functions"]) == 3
    assert verdicts(document) == ("PROVED", "PROVED")
