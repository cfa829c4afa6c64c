"""Schulte's law without bumps: rates against the law itself, and damaged claims."""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine.loop_claims import published_bumpless_claim
from takagi.certificates.claims.turbine.published import published_candidate, published_claim
from takagi.models.laws.protocol import Measurement
from takagi.models.laws.published.law import PublishedLaw, switched_law
from tests.certificates.kinds.claims import resealed
from tests.certificates.test_paper_certificate import TURBINE, document, make_law
from tests.paper_models import loop_rate

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


def changed(**cell: float) -> dict[str, Any]:
    """Return the certificate with other numbers in the first cell of its rates."""
    damaged = deepcopy(certificate())
    damaged["claims"][1]["cells"][0].update(cell)
    return dict(resealed(damaged))


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


@pytest.mark.parametrize("name", RATES)
def test_a_rate_that_is_a_little_less_is_not_proved(name: str) -> None:
    """The stated rates are the checker's, rounded up at the seventh decimal: both sides of it."""
    k = max(range(3), key=lambda i: certificate()["claims"][1]["cells"][i][name])
    rate = certificate()["claims"][1]["cells"][k][name]
    for factor, verdict in ((1.0, "PROVED"), (1 + 1e-6, "PROVED"), (1 - 1e-5, "UNDECIDED")):
        damaged = deepcopy(certificate())
        damaged["claims"][1]["cells"][k][name] = rate * factor
        found = check_document(resealed(damaged)).claims[1]
        assert found.verdict.name == verdict
    assert f"the {name.partition('_')[0]} asked for may move faster" in found.text


def test_the_law_on_the_plant_moves_no_faster() -> None:
    """Differences of the law's own commands along the plant's motion, 200 states of every set."""
    law, draw, step = make_law(), np.random.default_rng(4), 1e-6
    loop, rates = certificate()["claims"]
    used: dict[str, list[float]] = {name: [] for name in RATES}
    for cell, bound in zip(loop["cells"], rates["cells"], strict=True):
        root = np.linalg.cholesky(np.linalg.inv(np.array(cell["P"])))
        edge = dict.fromkeys(RATES, 0.0)
        for _ in range(200):
            share, way = draw.uniform(), draw.normal(size=3)
            v = cell["wind"][0] + share * (cell["wind"][1] - cell["wind"][0])
            first, last = np.array(cell["centre"])
            y = root @ (way / np.linalg.norm(way))
            z = first + share * (last - first) + np.array(cell["box"]) * y
            if z[1] < law.turbine.pitch_min:
                continue
            moves = loop_rate(law, v, z)
            before, after = (
                law.command(at[2:], Measurement(float(at[0]), float(at[1]), v))
                for at in (z - step * moves, z + step * moves)
            )
            edge["pitch_rate"] = max(edge["pitch_rate"], abs(after.pitch - before.pitch))
            edge["torque_rate"] = max(edge["torque_rate"], abs(after.torque - before.torque))
        for name in RATES:
            moved = edge[name] / (2 * step)
            assert moved <= bound[name] * (1 + 1e-4) + 1e-4
            used[name].append(moved / max(bound[name], 1e-3))
    # The bounds are not idle.
    assert all(max(shares) > 0.4 for shares in used.values()), used


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


def test_every_corner_of_a_cell_counts() -> None:
    """A second corner, a little wider: the loop is still proved, and may now move faster."""
    wider = deepcopy(certificate())
    corners = wider["claims"][0]["cells"][0]["corners"]
    spread = {"low": -1e-5, "high": 1e-5}
    corners.append(
        {end: (np.array(corners[0][end]) + by).round(7).tolist() for end, by in spread.items()}
    )
    found = check_document(resealed(wider)).claims

    assert [claim.verdict.name for claim in found] == ["PROVED", "UNDECIDED"]


def test_what_it_names_has_to_be_the_loop_of_this_law() -> None:
    """Another kind of loop, a loop that is not proved, and numbers of the other law's claim."""
    undecided = deepcopy(certificate())
    undecided["claims"][0]["cells"][0]["decay_rate"] = 9.0
    found = check_document(resealed(undecided)).claims[1]
    assert found.verdict.name == "UNDECIDED" and "rests on is not proved" in found.text
    with pytest.raises(CertificateError, match="'signal_rate' is not known"):
        check_document(changed(signal_rate=0.1))
    other = deepcopy(certificate())
    other["claims"][0]["kind"] = "coherent-loop"
    with pytest.raises(CertificateError):
        check_document(resealed(other))


def test_no_claim_is_made_of_a_switch() -> None:
    """A law without overlaps jumps: it is refused under its name, and under the other's."""
    switched = switched_law(make_law())
    for name, words in (("switched", "gains.name"), ("paper", "overlaps must be positive")):
        law: PublishedLaw = switched
        made = document(law, certificate()["claims"][0])
        made["gains"]["name"] = name
        for overlap in ("speed_overlap", "torque_overlap"):
            made["claims"][0][overlap] = made["gains"]["coupling"][overlap]
        with pytest.raises(CertificateError, match=words):
            check_document(resealed(made))
    assert TURBINE.rated_rotor_speed == switched.coupling.speed_ramp.start
