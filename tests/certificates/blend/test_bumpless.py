"""Claims ``bumpless`` of a plant with two actuators: bounds by hand and sampled."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import check_document
from takagi.certificates.cross_check.comparison import cross_checked_document
from takagi.certificates.document.plant_embedding import plant_and_claim
from takagi.models.blending.substitution import blended_model
from takagi.models.ramps import effort_ramp
from tests.certificates.blend.test_effort_blend import design, draughty
from tests.certificates.kinds.claims import Data, resealed
from tests.models.blending.plants import plant_of
from tests.models.library_plants import library_model

ABOUT = ("sector-embedding", "effort-blend", "bumpless")


def changed(change: Callable[[Data], None], kinds: tuple[str, ...] = ABOUT) -> Data:
    found = copy.deepcopy(dict(design().document))
    found["claims"] = [c for c in found["claims"] if c["kind"] in kinds]
    change(found)
    return resealed(found)


def claim_of(document: Data) -> Data:
    return next(dict(c) for c in document["claims"] if c["kind"] == "bumpless")


# Heating has b = 2 + x.  At x = -1, effort -3, with the largest share and all errors against it,
# x' = -1/2 - 1/8 + 1/16 + 1.2 (1/16 - 3 23/24) - 1.1 (3/24) = -4.075: 20 + 3 * 4.075 in all, since
# the checker takes psi(U) and U apart.
HEATING = 32.225


def test_the_bounds_are_those_found_by_hand() -> None:
    """Cooling has b = 2, so that it moves at most at 20/2."""
    claim = claim_of(dict(design().document))
    assert claim["low"] == 10.0
    assert HEATING <= claim["high"] < 1.002 * HEATING
    found = check_document(changed(lambda _: None)).claims[-1]
    figures: dict[str, Any] = {figure.name: figure for figure in found.figures}
    assert found.verdict.name == "PROVED" and "neither actuator is told to jump" in found.text
    assert f"cooling 10 1/s, heating {claim['high']:.6g} 1/s" in found.text
    assert figures["largest jump of heating"].value == 0
    assert not any(figure.larger for figure in figures.values())
    assert float(figures["largest rate of heating"].value) == claim["high"]


def test_no_command_moves_faster_on_the_box() -> None:
    """Commands a step later less those a step before, for 20000 states, rates and errors."""
    claim, draw, step = claim_of(dict(design().document)), np.random.default_rng(2), 1e-6
    x, effort, rate, cool, heat = (
        np.where(draw.uniform(size=20000) < 0.3, np.sign(one) * side, one)
        for side, one in ((s, draw.uniform(-s, s, 20000)) for s in (1, 3, 20, 0.1, 0.2))
    )
    cooling, heating = 1 / 16, 1 / 16  # the commands at rest

    def commands(x: Any, U: Any) -> tuple[Any, Any]:
        return effort_ramp(-U, 0.5) / 2, effort_ramp(U, 0.5) / (2 + x)

    low, high = commands(x, effort)
    low, high = cooling + (1 + cool) * (low - cooling), heating + (1 + heat) * (high - heating)
    moved = 0.5 * x - 2 * low + (2 + x) * high
    pairs = zip(
        commands(x - step * moved, effort - step * rate),
        commands(x + step * moved, effort + step * rate),
        strict=True,
    )
    for end, (before, after) in zip(("low", "high"), pairs, strict=True):
        largest = np.abs(after - before).max() / (2 * step)
        assert 0.9 * claim[end] < largest <= claim[end] * (1 + 1e-6)


@pytest.mark.parametrize(
    ("end", "rate", "verdict"),
    [
        ("low", 10, "PROVED"),
        ("low", 9.9999, "UNDECIDED"),
        ("high", HEATING + 0.001, "PROVED"),
        ("high", HEATING - 0.001, "UNDECIDED"),
        ("high", -40, "UNDECIDED"),
    ],
)
def test_both_sides_of_the_thresholds(end: str, rate: float, verdict: str) -> None:
    document = changed(lambda d: d["claims"][-1].update({end: rate}))

    # The checker's verdicts, with which the second reader agrees.
    compared = cross_checked_document(document)
    assert compared.agrees
    assert [row.first for row in compared.rows if row.is_claim] == ["PROVED", "PROVED", verdict]


def test_no_bound_without_a_rate_of_what_commands(tmp_path: Path) -> None:
    """An effort without a rate, and an effectiveness by a signal, which may jump."""
    free = blended_model(plant_of(tmp_path, a=", rate = 20 -> "))
    _, claims, notes = plant_and_claim(free)
    assert [c["kind"] for c in claims] == ["sector-embedding", "effort-blend"] and not notes
    document = copy.deepcopy(dict(draughty().document))
    assert "bumpless" not in [c["kind"] for c in document["claims"]]
    forged = copy.deepcopy({**claim_of(dict(design().document)), "name": "forged"})
    document["claims"].append(forged)
    found = check_document(resealed(document)).claims[-1]
    assert found.verdict.name == "UNDECIDED" and "is told by air, whose rate" in found.text


@pytest.mark.parametrize(
    "name", [pytest.param("split_range", marks=pytest.mark.slow), "boost_throttle"]
)
def test_built_in_plants_have_it(name: str) -> None:
    """boost_throttle by hand: 2000 kPa/s^2 over 340 and 1600 kPa/s."""
    _, claims, notes = plant_and_claim(library_model(name))
    claim = claims[-1]
    assert claim["kind"] == "bumpless" and not notes
    if name == "boost_throttle":
        assert claim["low"] == pytest.approx(2000 / 340, rel=1e-3)
        assert claim["high"] == 1.25
