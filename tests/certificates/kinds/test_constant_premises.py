"""A premise that is constant has one corner: claims that count on two of it are refused."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import CertificateError, Verdict
from tests.certificates.kinds.claims import model_data, said_of

Data = dict[str, Any]
A = [[[-2]], [[-4]]]
# Of two premises without ranges the first never changes its end: the lower one, or the upper one.
AT_LOWER, AT_UPPER = [[0, 0], [0, 1]], [[1, 0], [1, 1]]
HALVED: Data = {"halvings": [[1, 0, 1], [], []]}
DECAY: Data = {"name": "x", "kind": "decay", "decay_rate": 0, "P": [[1]]}
IMPOSSIBLE: Data = {"name": "x", "kind": "no-common-decay", "decay_rate": 0}


def scheduled(powers: list[list[int]]) -> Data:
    """Return a claim about a function of the weights that is the same for all of them."""
    listed = [{"powers": powers, "matrix": [[1]]}]
    base = {"name": "x", "kind": "fuzzy-decay", "decay_rate": 0, "polya": 0}
    return base | {"degrees": [0, 0], "P": listed, "rates": [None, None]}


def multiplied(blend: list[list[int]]) -> Data:
    return IMPOSSIBLE | {"multipliers": [{"blend": blend, "matrix": [[1]]}]}


@pytest.mark.parametrize(
    ("rules", "claim"),
    [
        (AT_LOWER, DECAY | HALVED),
        (AT_UPPER, DECAY | HALVED),
        (AT_LOWER, scheduled([[0], [0, 0]]) | HALVED),
        (AT_UPPER, scheduled([[0, 0], [0, 0]])),
        (AT_LOWER, multiplied([[0, 1], [1, 0]])),
    ],
)
def test_a_corner_that_there_is_not_is_refused(rules: list[list[int]], claim: Data) -> None:
    """By both checkers, though the model itself has all its corners."""
    model = model_data(A, rules=rules)

    assert said_of(model, None, DECAY).verdict is Verdict.PROVED
    with pytest.raises(CertificateError, match="leave out"):
        said_of(model, None, claim)
