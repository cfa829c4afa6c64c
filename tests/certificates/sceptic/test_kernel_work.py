"""Small files that ask for much work are refused before it is begun."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.reader import MOST_CLAIMS
from takagi.certificates.checker.loop.polytopic_loop import bounded
from takagi.certificates.document.certificate_file import certificate_document
from tests.certificates.kinds.claims import law_data, model_data, said_of

Data = dict[str, Any]


def unit(size: int, factor: int = 1) -> list[list[int]]:
    return [[factor * (i == j) for j in range(size)] for i in range(size)]


def test_limit_of_work_has_two_sides() -> None:
    bounded(10**4, 10)
    with pytest.raises(CertificateError, match="too many"):
        bounded(10**4 + 1, 10)


def test_more_claims_than_a_chain_has_are_refused() -> None:
    claim = {"name": "a", "kind": "decay", "P": [[1]], "decay_rate": 0}
    model = model_data([[[-1]]])
    most, more = (
        certificate_document(model=model, gains=None, claims=[claim] * count, provenance={})
        for count in (MOST_CLAIMS, MOST_CLAIMS + 1)
    )

    assert len(check_document(most).claims) == MOST_CLAIMS
    with pytest.raises(CertificateError, match="claims"):
        check_document(more)


def test_polynomial_of_many_terms_is_refused_before_it_is_made() -> None:
    """Two hundred rules, raised eight times: more than 10^15 terms."""
    r = 200
    model = model_data([[[-1]]] * r)
    powers = [[int(i == j) for j in range(r)] for i in range(r)]
    P = [{"powers": [row], "matrix": [[1]]} for row in powers]
    claim = {"name": "a", "kind": "fuzzy-decay", "decay_rate": 0, "degrees": [1], "P": P}

    with pytest.raises(CertificateError, match="terms"):
        said_of(model, None, claim | {"polya": 8, "rates": [[1] * r]})


WIDE: list[tuple[str, Data]] = [
    ("l2-gain", {"gain": 1000, "disturbance": "disturbances"}),
    ("h2-norm", {"norm": 1000, "disturbance": "disturbances"}),
    ("peak", {"gain": 1, "disturbance": "disturbances", "disturbance_norm": 1}),
]


@pytest.mark.parametrize(("kind", "others"), WIDE)
def test_many_disturbances_count_as_order(kind: str, others: Data) -> None:
    """Four rules of one state with eighty disturbances have matrices of eighty-one rows."""
    model = model_data([[[-1]], [[-2]], [[-3]], [[-4]]], E=[[[1] * 80]], C=[[[1]]])
    claim = {"name": "a", "kind": kind, "P": [[1]], "level": 1, "multiplier": 1, **others}

    with pytest.raises(CertificateError, match="order 81"):
        said_of(model, None, claim)


def test_parts_of_a_region_and_the_error_of_an_observer_count_as_order() -> None:
    part = {"L": unit(4, -1), "M": unit(4)}
    region = {"name": "a", "kind": "region", "P": unit(40), "parts": [part]}
    with pytest.raises(CertificateError, match="order 160"):
        said_of(model_data([unit(40, -1)]), None, region)

    model = model_data([unit(60, -1)], B=[[[0]] * 60], C=[[[0] * 60]])
    claim = {"name": "a", "kind": "observed-feedback", "decay_rate": 0, "P": [[1] * 80] * 80}
    with pytest.raises(CertificateError, match="120"):
        said_of(model, law_data([[[0] * 60]]), claim | {"L": [[[0]] * 60]})


def test_more_multipliers_than_a_reader_waits_for_are_refused() -> None:
    claim: Data = {"name": "a", "kind": "no-common-decay", "decay_rate": 0}
    one = {"blend": 0, "factor": [[1]] * 80}
    model = model_data([unit(80, 1)])

    with pytest.raises(CertificateError, match="a list"):
        said_of(model, None, claim | {"multipliers": []})
    with pytest.raises(CertificateError, match="3 inequalities of order 80"):
        said_of(model, None, claim | {"multipliers": [one] * 3})
