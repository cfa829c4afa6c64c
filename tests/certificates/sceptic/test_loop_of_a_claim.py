"""The loop of a claim: every rule counts, names agree, and too much work is refused."""

from __future__ import annotations

import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.reader import MOST_CLAIMS
from takagi.certificates.checker.loop.polytopic_loop import bounded
from tests.certificates.kinds.claims import Data, model_data, said_of, sealed, verdicts

ONE = [[1, 0], [0, 1]]
KEPT: Data = {"name": "a", "P": ONE, "level": 1, "multiplier": 1, "disturbance": "inputs"}
KEPT |= {"disturbance_norm": 0.1}


def test_limit_of_work_has_two_sides() -> None:
    bounded(10**4, 10)
    with pytest.raises(CertificateError, match="too many"):
        bounded(10**4 + 1, 10)


def test_more_claims_than_a_chain_has_are_refused() -> None:
    claim = {"name": "a", "kind": "decay", "P": [[1]], "decay_rate": 0}
    model = model_data([[[-1]]])
    assert len(verdicts(sealed(model, None, *[claim] * MOST_CLAIMS))) == MOST_CLAIMS
    with pytest.raises(CertificateError, match="claims"):
        check_document(sealed(model, None, *[claim] * (MOST_CLAIMS + 1)))


def test_polynomial_of_many_terms_is_refused_before_it_is_made() -> None:
    """Two hundred rules, raised eight times: more than 10^15 terms."""
    r = 200
    model = model_data([[[-1]]] * r)
    powers = [[int(i == j) for j in range(r)] for i in range(r)]
    P = [{"powers": [row], "matrix": [[1]]} for row in powers]
    claim = {"name": "a", "kind": "fuzzy-decay", "decay_rate": 0, "degrees": [1], "P": P}

    with pytest.raises(CertificateError, match="terms"):
        said_of(model, None, claim | {"polya": 8, "rates": [[1] * r]})
