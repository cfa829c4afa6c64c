"""The rate at which the whole loop settles is one that a positive definite function shows."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates.checker import Verdict, check_document


@pytest.mark.parametrize("rate", [50.0, 5.0, None])
def test_a_function_that_is_not_positive_definite_shows_no_rate(
    short: Any, reseal: Any, rate: float | None
) -> None:
    """With R = -P the inequality -(A'R + RA + 2 r R) > 0 holds for every large r, and says nothing.

    That the inequality holds at every corner is what makes the forgery: -R = P > 0, and
    A'P + PA + 2 r P > 0 as soon as r is beyond the fastest motion.  Without a rate R is indefinite.
    """
    settling = short["claims"][0]["settling"]
    if rate is None:
        settling["P"][1][1] = -settling["P"][1][1]
    else:
        settling["P"] = [[-entry for entry in row] for row in settling["P"]]
        settling["decay_rate"] = rate

    claim = check_document(reseal(short)).claims[0]

    assert claim.verdict is Verdict.UNDECIDED
    assert "common decay rate is not positive definite" in claim.text
    if rate == 50.0:
        # The inequality itself holds, so that nothing else would have refused the file.
        assert "inequality fails" not in claim.text
