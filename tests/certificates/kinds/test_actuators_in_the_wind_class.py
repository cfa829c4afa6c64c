"""The rates of the actuators in every wind of the claim on the wind's rate, or a NOT."""

from __future__ import annotations

from copy import deepcopy
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range
from takagi.certificates.claims.turbine.loop_claims import loop_claims
from takagi.certificates.cross_check.comparison import cross_checked_document

RATE, ACTUATORS = 1, 2
# Cells from 9 m/s on, where the torque is fed v_s', to beyond the last of them.
FROM, CELLS = 9.0, 6
Document = dict[str, Any]


def narrow(built: Any, wind_filter: float) -> Document:
    """Return the certificate of a few cells, with all claims that hold."""
    document = deepcopy(built.document)
    gains, loop = document["gains"], document["claims"][0]
    gains["wind_filter"] = wind_filter
    first = next(k for k, v in enumerate(gains["wind"]) if v >= FROM)
    for name, column in gains.items():
        if isinstance(column, list):
            between = name in ("integral_rate", "inertia_feedforward", "feedforward_limit")
            gains[name] = column[first : first + CELLS + (not between)]
    loop["cells"] = loop["cells"][first : first + CELLS]
    claims, left_out = loop_claims(document["model"], gains, loop)
    assert not left_out
    return dict(document | {"claims": claims})


@pytest.fixture(scope="module")
def slow(built: Any) -> Document:
    return narrow(built, 5.0)


def verdicts(document: Document, reseal: Any) -> tuple[str, str]:
    row = cross_checked_document(reseal(document)).rows[ACTUATORS]
    return row.first, row.second


def test_the_slow_filter_keeps_to_the_rate_that_is_stated(slow: Document, reseal: Any) -> None:
    """(r + phi) / 5 s is below what the torque's rate limit leaves: no NOT for the class."""
    text = check_document(reseal(slow)).claims[ACTUATORS].text

    assert slow["claims"][ACTUATORS]["wind_rate"] == RATE
    assert verdicts(slow, reseal) == ("PROVED", "PROVED")
    assert "as in every wind of the claim on the wind's rate" in text
    assert "NOT for every wind" not in text


def test_a_fast_filter_does_not_and_the_line_says_so(built: Any, reseal: Any) -> None:
    """With 0.05 s v_s'' may reach metres per second cubed; what is stated holds up to less."""
    document = narrow(built, 0.05)
    checked = check_document(reseal(document)).claims[ACTUATORS]

    assert "wind_rate" not in document["claims"][ACTUATORS]
    assert checked.verdict.name == "PROVED"
    assert "m/s^3, NOT for every wind of the wind limits)" in checked.text


def test_a_fast_filter_that_is_said_to_keep_it_is_refused(built: Any, reseal: Any) -> None:
    document = narrow(built, 0.05)
    document["claims"][ACTUATORS]["wind_rate"] = RATE

    assert verdicts(document, reseal) == ("UNDECIDED", "UNDECIDED")


@pytest.mark.parametrize(("share", "verdict"), [(1.0, "PROVED"), (0.999, "UNDECIDED")])
def test_the_bound_is_the_threshold(
    slow: Document, reseal: Any, share: float, verdict: str
) -> None:
    """A ``schedule_bend`` just at the class's own, and a little below."""
    changed = deepcopy(slow)
    ranges = [tube(one) for one in changed["claims"][RATE]["ranges"]]
    k = next(k for k, cell in enumerate(changed["claims"][ACTUATORS]["cells"]) if fed(changed, k))
    ends = [Fraction(str(v)) for v in changed["gains"]["wind"][k : k + 2]]
    bend = max(one.bend(ends[0], ends[1], Fraction(5)) for one in ranges)
    cell = changed["claims"][ACTUATORS]["cells"][k]
    assert 0 < bend < Fraction(str(cell["schedule_bend"]))
    cell["schedule_bend"] = float(bend) * share + (1e-12 if share == 1 else 0)

    assert verdicts(changed, reseal) == (verdict, verdict)


COLUMNS = ("wind", "estimate_rate", "schedule_rate")


def tube(one: Any) -> Range:
    """Return a range of the claim, exact."""
    wind, rate, phi = ([Fraction(str(x)) for x in one[name]] for name in COLUMNS)
    return Range(wind, rate, phi, Fraction(str(one["estimate_error"])))


def fed(document: Document, k: int) -> bool:
    return bool(document["gains"]["feedforward_limit"][k] > 0)


def test_no_motion_of_the_filter_bends_more(slow: Document) -> None:
    """An estimate that turns from one way to the other at full rate, from the edge: |v_s''|."""
    one = slow["claims"][RATE]["ranges"][0]
    wind, r, phi = (np.array(one[name]) for name in COLUMNS)
    exact = tube(one)
    s = np.linspace(wind[0], wind[-1], 400)
    for way in (1, -1):
        seen = s + way * 5 * np.interp(s, wind, phi)
        inside = (seen >= wind[0]) & (seen <= wind[-1])
        turned = (np.interp(seen, wind, r) + np.interp(s, wind, phi)) / 5
        for at, bend in zip(s[inside], turned[inside], strict=True):
            here = Fraction(str(round(float(at), 9)))
            assert bend <= float(exact.bend(here, here, Fraction(5))) * (1 + 1e-6)


@pytest.mark.parametrize("place", [0, 2, -1, 3, 0.5])
def test_only_an_earlier_claim_on_the_winds_rate_is_named(
    slow: Document, reseal: Any, place: float
) -> None:
    """Not the loop, not itself, nothing that is not there."""
    changed = deepcopy(slow)
    changed["claims"][ACTUATORS]["wind_rate"] = place
    with pytest.raises(CertificateError):
        check_document(reseal(changed))


def test_a_rate_that_is_not_proved_carries_nothing(slow: Document, reseal: Any) -> None:
    changed = deepcopy(slow)
    one = changed["claims"][RATE]["ranges"][0]
    one["estimate_rate"] = [1.0 for _ in one["estimate_rate"]]

    assert verdicts(changed, reseal) == ("UNDECIDED", "UNDECIDED")
