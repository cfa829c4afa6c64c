"""The size of a relaxation is known beforehand, and what is too large is refused."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import relaxation_named, relaxation_size
from takagi.lmi.sums.relaxations import RELAXATIONS
from takagi.models import ModelError
from tests.lmi.sums.known import combinations_of, known_sum, random_theta


@pytest.mark.parametrize(
    "name", [*RELAXATIONS, "polya-0", "polya-3", "product-0", "product-1", "product-3"]
)
@pytest.mark.parametrize("active_rules", [None, 2])
def test_sizes_are_known_before_anything_is_built(name: str, active_rules: int | None) -> None:
    """The closed form counts what is posed: LMIs, widths, slack variables."""
    corners = combinations_of(2, 3)
    known = {"corners": corners, "active_rules": active_rules}
    loop, _ = known_sum(random_theta(0, 6, 2), **known)
    slack, lmis = relaxation_named(name)(loop)
    size = relaxation_size(name, 6, corners, size=2, active_rules=active_rules)
    if name == "common-gain":
        size = relaxation_size("wang-tanaka-griffin", 6, size=2, active_rules=active_rules)

    assert size.slack_variables == sum(unknown.length for unknown in slack)
    assert size.width == max(lmi.size for lmi in lmis)
    if name.startswith("product") and active_rules:
        assert size.lmis >= sum(lmi.count for lmi in lmis)
    else:
        assert size.lmis == sum(lmi.count for lmi in lmis)


def test_products_of_corners_are_fewer_than_pairs() -> None:
    """Four premises of two corners: 3^4 coefficients in the place of 16 17 / 2 pairs."""
    corners = combinations_of(2, 2, 2, 2)

    assert relaxation_size("product", 16, corners).lmis == 3**4
    assert relaxation_size("wang-tanaka-griffin", 16).lmis == 136
    assert relaxation_size("polya-2", 16).lmis == 3876
    assert relaxation_size("product-2", 16, corners).lmis == 5**4


def test_what_is_too_large_is_refused_with_what_is_not() -> None:
    """A hundred rules with Polya's degree 6 are not begun; the message names what can be."""
    loop, _ = known_sum(np.zeros((100, 100, 4, 4)))

    with pytest.raises(ModelError, match=r"5\d{9} LMIs.*'wang-tanaka-griffin' \(5050 LMIs"):
        relaxation_named("polya-6")(loop)
    with pytest.raises(ModelError, match="'tanaka-wang'"):
        relaxation_named("liu-zhang")(loop)
