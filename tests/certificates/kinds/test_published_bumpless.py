"""Schulte's law without bumps: rates against the law itself, and damaged claims."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine.loop_claims import published_bumpless_claim
from takagi.certificates.claims.turbine.published import published_candidate, published_claim
from takagi.models.laws.protocol import Measurement
from tests.certificates.kinds.claims import resealed
from tests.certificates.test_paper_certificate import document, make_law

# Partial load; the ramp of f_1, where both act; full load.
WINDOWS = ((8.0, 8.06), (11.6, 11.61), (20.0, 20.06))
RATES = ("pitch_rate", "torque_rate")


@cache
def certificate() -> dict[str, Any]:
    """Return the claims about the loop and about its hand-over, in short windows."""
    law = make_law()
    claim = published_claim(published_candidate(law, winds=WINDOWS))
    made = document(law, claim)
    rates = published_bumpless_claim(made["model"], made["gains"], claim)
    return dict(resealed(made | {"claims": [claim, rates]}))


def test_it_is_proved_and_tells_jumps_and_rates() -> None:
    found = check_document(certificate())
    cells = certificate()["claims"][1]["cells"]
    figures = {figure.name: figure for figure in found.claims[1].figures}

    assert found.verdict.name == "PROVED", [claim.text for claim in found.claims]
    assert not any(figure.larger for name, figure in figures.items() if "largest" in name)  # type: ignore[union-attr]
    assert figures["largest jump of torque"].value == 0  # type: ignore[union-attr]
    assert figures["largest jump of the pitch reference"].value == 0  # type: ignore[union-attr]
    for name in RATES:
        largest: Any = figures[f"largest {name.replace('_', ' ')}"]
        assert float(largest.value) == max(cell[name] for cell in cells)
    assert "at constant wind" in found.claims[1].text
    assert "neither the torque asked for nor the pitch asked for jumps" in found.claims[1].text


def test_the_bounds_are_sums_over_the_states() -> None:
    """sum_i |s_i| (sum_j |A_ij| + |d_i|) with slopes of the law by differences, at 300 points.

    Their largest values are slightly less than those that are enclosed over the box.
    """
    law, draw = make_law(), np.random.default_rng(6)
    loop, rates = certificate()["claims"]
    for cell, bound in zip(loop["cells"], rates["cells"], strict=True):
        corners = [np.maximum(-np.array(c["low"]), np.array(c["high"])) for c in cell["corners"]]
        moves = np.max(corners, axis=0).sum(axis=1) + cell["disturbance"]
        box, slopes = np.array(cell["box"]), np.zeros((2, 3))
        for _ in range(300):
            share = draw.uniform()
            v = cell["wind"][0] + share * (cell["wind"][1] - cell["wind"][0])
            first, last = np.array(cell["centre"])
            z = first + share * (last - first) + box * draw.uniform(-1, 1, 3)
            z[1] = max(z[1], law.turbine.pitch_min)
            for i in range(3):
                step = np.eye(3)[i] * box * 1e-4
                ends = (law.command(at[2:], Measurement(float(at[0]), float(at[1]), v))
                        for at in (z - step, z + step))  # fmt: skip
                moved = np.abs(np.subtract(*map(np.array, ends))) / 2e-4
                slopes[:, i] = np.maximum(slopes[:, i], moved)
        for name, least in zip(("torque_rate", "pitch_rate"), slopes @ moves, strict=True):
            assert least * (1 - 1e-6) <= bound[name] <= 1.3 * least + 1e-6
