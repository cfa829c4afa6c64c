"""A certificate of one wind cell: each single demand of the claim, on both sides of its limit."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, Verdict, check_document
from tests.certificates.kinds.claims import resealed

Document = dict[str, Any]
PER_INTERVAL = ("integral_rate", "inertia_feedforward", "feedforward_limit")


@pytest.fixture(scope="session")
def cell_document(short_document: Document) -> Document:
    """Return the third cell of the short certificate as a certificate of its own."""
    document = deepcopy(short_document)
    gains, claim = document["gains"], document["claims"][0]
    for name, column in gains.items():
        if isinstance(column, list):
            gains[name] = column[2 : 3 if name in PER_INTERVAL else 4]
    claim["cells"] = claim["cells"][2:3]
    sealed: Document = resealed(document)
    return sealed


@pytest.fixture
def one(cell_document: Document) -> Document:
    return deepcopy(cell_document)


@pytest.fixture
def said() -> Any:
    """Return the function that says the verdict and the text of a forger's certificate."""

    def say(document: Document) -> tuple[Verdict, str]:
        claim = check_document(resealed(document)).claims[0]
        return claim.verdict, claim.text

    return say


def test_it_is_proved(one: Document, said: Any) -> None:
    assert said(one)[0] is Verdict.PROVED


@pytest.mark.parametrize(
    ("part", "value", "words"),
    [
        ("wind_rate", -1e-6, "a negative wind rate"),
        ("wind_error", -1e-6, "outside the enclosed one"),
        ("multiplier", 0, "wrong sign"),
        ("multiplier", -0.1, "wrong sign"),
        ("decay_rate", -1e-7, "wrong sign"),
        ("decay_rate", 9, "decay inequality"),
        ("multiplier", 9, "invariance inequality"),
        ("settling", 9, "common decay inequality fails"),
    ],
)
def test_a_number_of_the_cell(
    part: str, value: float, words: str, one: Document, said: Any
) -> None:
    """What is wrong is named, and it is all that is."""
    claim = one["claims"][0]
    if part == "settling":
        claim["settling"]["decay_rate"] = value
    else:
        claim["cells"][0][part] = value

    verdict, text = said(one)

    assert verdict is Verdict.UNDECIDED
    assert words in text and text.count(";") == 0


@pytest.mark.parametrize("part", ["wind_rate", "wind_error", "decay_rate"])
def test_zero_is_allowed(part: str, one: Document, said: Any) -> None:
    one["claims"][0]["cells"][0][part] = 0

    assert said(one)[0] is Verdict.PROVED


def test_a_wind_error_at_the_boxs_share_is_enclosed(one: Document, said: Any) -> None:
    """The share is of the cell's lower wind: at it the class is enclosed, beyond it not."""
    claim, wind = one["claims"][0], one["gains"]["wind"][0]
    claim["cells"][0]["wind_error"] = wind * 2**-8
    claim["box"]["wind_share"] = 2**-8
    assert "outside the enclosed one" not in said(one)[1]

    claim["cells"][0]["wind_error"] = wind * 2**-8 + 1e-9
    assert "outside the enclosed one" in said(one)[1]


@pytest.mark.parametrize("name", ["speed_error", "effort_lag", "speed_signal", "integral"])
def test_a_peak(name: str, one: Document, said: Any) -> None:
    """Positive, no larger than the box or the law's limit, and no smaller than the set's extent."""
    claim = one["claims"][0]
    peak = claim["peaks"][name]
    limit = one["gains"]["integral_limit"] if name == "integral" else claim["box"][name]

    for wrong in (0, -peak, 0.98 * peak, limit + 1e-9):
        claim["peaks"][name] = wrong
        verdict, text = said(one)
        assert verdict is Verdict.UNDECIDED
        assert f"stated bound on {name}" in text
    claim["peaks"][name] = limit
    assert said(one)[0] is Verdict.PROVED


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("claims", 0, "P"), [[1, 0], [0, 1]]),
        (("claims", 0, "P"), [[1, 0, 0], [0, 1, 0]]),
        (("claims", 0, "P"), [[1, 0], [0, 1], [0, 0]]),
        (("claims", 0, "cells"), {}),
        (("claims", 0, "cells"), []),
        (("claims", 0, "cells"), "x"),
        (("claims", 0, "cells"), 1),
        (("claims", 0, "cells", 0, "wind", 0), 1),
        (("claims", 0, "cells", 0, "wind", 1), 30),
        (("claims", 0, "cells", 0, "integral_rate"), 0.5),
        (("gains", "pitch_min"), -0.25),
        (("gains", "pitch_max"), 1.75),
        (("model", "pitch_min"), -0.25),
        (("model", "pitch_max"), 1.75),
    ],
)
def test_parts_that_do_not_fit_are_refused(
    path: tuple[Any, ...], value: Any, one: Document, said: Any
) -> None:
    place: Any = one
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value

    with pytest.raises(CertificateError):
        said(one)


def test_a_cell_more_than_the_winds_is_refused(one: Document, said: Any) -> None:
    one["claims"][0]["cells"] *= 2

    with pytest.raises(CertificateError, match="a list of 1 to 1"):
        said(one)


@pytest.mark.parametrize(
    "P", [[[-1, 0, 0], [0, 1, 0], [0, 0, 1]], [[1, 2, 0], [0, 1, 0], [0, 0, 1]]]
)
def test_a_function_that_is_not_one(P: Any, one: Document, said: Any) -> None:
    one["claims"][0]["P"] = P

    assert said(one) == (Verdict.UNDECIDED, "P is not symmetric positive definite")


@pytest.mark.parametrize("part", ["multiplier", "decay_rate", "stiffness", "integral_rate"])
def test_eight_decimals_are_refused(part: str, one: Document, said: Any) -> None:
    """Corner matrices are integers over 10^14: a coefficient with more decimals has no place."""
    cell = one["claims"][0]["cells"][0]
    if part == "stiffness":
        cell[part][0] -= 1e-8
    elif part == "integral_rate":
        cell[part] = one["gains"]["integral_rate"][0] = cell[part] + 1e-8
    else:
        cell[part] = round(cell[part], 7) + 1e-8

    with pytest.raises(CertificateError, match="more than seven decimals"):
        said(one)
