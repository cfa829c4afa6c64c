"""Forged files of the kind ``schedule-rate``: the P(v_s) of the file, and what the sentence shows.

The certificate is the first line of ``recorded/schedule-rate.jsonl``: three cells with functions at
four schedule winds.
"""

from __future__ import annotations

import json
import math
import re
from copy import deepcopy
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import check_document
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import sealed, verdicts

LAG = 3


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("schedule-rate"))[1]))


@pytest.mark.parametrize("place", [17.0341, 17.3, 18.5275])
@pytest.mark.parametrize("factor", [1e-6, 1.0, -1.0])
def test_a_function_inside_a_cell_is_refused(
    stored: dict[str, Any], place: float, factor: float
) -> None:
    """P would not be linear over the cell; with 1e-6 the set grows by 1000 within a cell."""
    document = deepcopy(stored)
    functions = document["claims"][0]["functions"]
    scaled = [[factor * value for value in row] for row in functions[0]["P"]]
    functions.append({"wind": place, "P": scaled})
    assert verdicts(document) == ("refused", "refused")


def test_a_cell_that_skips_a_function_is_refused(stored: dict[str, Any]) -> None:
    """Two cells stated as one, whose ends have the functions; the one between them stays."""
    document = deepcopy(stored)
    claim = document["claims"][0]
    claim["cells"] = claim["cells"][1:]
    claim["cells"][0]["wind"] = [17.034, 18.0297]
    assert verdicts(document) == ("refused", "refused")


def test_a_function_beside_the_cells_is_no_part_of_the_claim(stored: dict[str, Any]) -> None:
    document = deepcopy(stored)
    functions = document["claims"][0]["functions"]
    functions.append({"wind": 19.0, "P": [[-value for value in row] for row in functions[0]["P"]]})
    assert verdicts(document) == ("PROVED", "PROVED")


def test_functions_may_stand_in_any_order(stored: dict[str, Any]) -> None:
    document = deepcopy(stored)
    document["claims"][0]["functions"].reverse()
    assert verdicts(document) == ("PROVED", "PROVED")


def test_no_narrower_range_of_schedule_winds_is_shown_than_is_kept(stored: dict[str, Any]) -> None:
    """The start may be rounded inward, but what is kept may not: the range is shown as it is.

    v_s can come as near to the cells' first wind as the wind's range leaves room, here 1e-9 m/s.
    """
    document = deepcopy(stored)
    claim = document["claims"][0]
    first = 17.0340004
    claim["cells"][0]["wind"][0] = claim["functions"][0]["wind"] = first
    width = math.sqrt(np.linalg.inv(np.array(claim["functions"][0]["P"]))[LAG, LAG])
    claim["winds"][0][0] = first + width + 1e-9
    assert verdicts(document) == ("PROVED", "PROVED")
    found = re.search(
        r"a schedule wind within (\S+) to (\S+) m/s keeps both",
        check_document(sealed(document)).claims[0].text,
    )
    assert found is not None
    assert (Fraction(found[1]), Fraction(found[2])) == (Fraction(str(first)), Fraction("18.5276"))


@pytest.mark.parametrize("side", ["speed", "measured"])
def test_a_rotor_that_may_turn_backward_is_not_proved(stored: dict[str, Any], side: str) -> None:
    """lambda is negative there; a table may have been forged to hold such ones."""
    document = deepcopy(stored)
    knots = document["model"]["torque_surface"]["tip_speed_ratio_knots"]
    knots[:4] = [-20.0] * 4
    for size, reason in ((1.26, False), (1.27, True)):
        document["claims"][0]["cells"][1]["sides"][side] = size
        assert "PROVED" not in verdicts(document)
        said = check_document(sealed(document)).claims[0].text
        assert ("the rotor's speed may reach zero" in said) == reason
