"""Laws without bumps: rates against the laws themselves, and damaged claims."""

from __future__ import annotations

from copy import deepcopy
from fractions import Fraction
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.turbine.effort_sharing.bumpless import Bumpless
from takagi.certificates.checker.words.figure import Figure
from takagi.certificates.claims.turbine.loop_claims import bumpless_claim, published_bumpless_claim
from takagi.certificates.claims.turbine.published import published_candidate, published_claim
from takagi.models.laws.protocol import Measurement
from takagi.models.ramps import effort_ramp
from takagi.models.turbine.data import rotor_torque
from tests.certificates.kinds.claims import resealed
from tests.certificates.test_paper_certificate import document, make_law

PROVED, UNDECIDED = "PROVED", "UNDECIDED"
SLOW_GENERATOR = 5000.0  # N m/s; the turbine has 15000


@pytest.fixture(scope="session")
def rates(built: Any) -> dict[str, Any]:
    document = built.document
    return bumpless_claim(document["model"], document["gains"], document["claims"][0])


def test_the_default_loop_is_proved(built: Any, rates: dict[str, Any]) -> None:
    document = resealed(built.document | {"claims": [built.document["claims"][0], rates]})
    found = check_document(document).claims[1]

    assert found.verdict.name == PROVED
    limit = built.turbine.torque_rate_limit
    beyond = [cell["torque_rate"] > limit for cell in rates["cells"]]
    assert not any(beyond)
    assert "and in 70 within the turbine's limit of 15000 N m/s" in found.text
    numbers = [figure for figure in found.figures if isinstance(figure, Figure)]
    assert [number.value for number in numbers if "jump" in number.name] == [0, 0]
    assert all(cell["pitch_rate"] <= built.turbine.pitch_rate_limit for cell in rates["cells"])


def test_winds_beyond_the_generators_rate_are_named(built: Any) -> None:
    """A generator that is slower: the words name the winds that ask for more than it can."""
    document = deepcopy(built.document)
    document["model"]["torque_rate_limit"] = limit = SLOW_GENERATOR
    loop = document["claims"][0]
    rates = bumpless_claim(document["model"], document["gains"], loop)
    found = check_document(resealed(document | {"claims": [loop, rates]})).claims[1]
    beyond = [cell["torque_rate"] > limit for cell in rates["cells"]]
    assert 0 < sum(beyond) < 30
    low = loop["cells"][beyond.index(True)]["wind"][0]
    high = loop["cells"][len(beyond) - 1 - beyond[::-1].index(True)]["wind"][1]
    assert f"{low:g} to " in found.text and f" {high:g} m/s" in found.text
    assert ", NOT for " in found.text
    within = f"in {len(beyond) - sum(beyond)} within the turbine's limit of {limit:g} N m/s"
    assert within in found.text


@pytest.mark.parametrize("limit", ["15000.00001", "14999.99999"])
def test_a_limit_of_torque_is_told_as_it_is_stated(limit: str) -> None:
    """With more digits than other numbers: a cell at the limit itself is within it."""
    text = torque_words(limit)

    assert f"in 1 within the turbine's limit of {limit} N m/s" in text


def torque_words(limit: str) -> str:
    cell = {"pitch_rate": Number("0.1"), "torque_rate": Number(limit)}
    model = {"pitch_rate_limit": Number("0.2"), "torque_rate_limit": Number(limit)}
    claim = {"loop": 0, "cells": [cell]}
    rates = Bumpless(claim, {"model": model}, "here", "rates", None, "")
    law = SimpleNamespace(wind=[Fraction(5), Fraction(8)])
    rates.__dict__.update(subject=SimpleNamespace(law=law))
    return rates.sentence()


def point(built: Any, k: int, draw: Any) -> tuple[Any, ...]:
    """Return a state on the edge of the set in cell k, winds in its class, and the plant's motion.

    Of the nominal turbine's equations, written out here.
    """
    turbine, law, loop = built.turbine, built.law, built.document["claims"][0]
    table, cell = law.schedule, loop["cells"][k]
    v_s = float(draw.uniform(*cell["wind"]))
    rate = cell["wind_rate"] * draw.choice([-1.0, 1.0])
    root = np.linalg.cholesky(np.linalg.inv(np.array(loop["P"])))
    toward = draw.normal(size=3)
    e, zeta, x = root @ (toward / np.linalg.norm(toward))
    speed, q, b, gamma = (
        float(np.interp(v_s, table.wind, column))
        for column in (
            table.rotor_speed,
            table.trim_effort,
            table.effectiveness,
            law.gains.proportional,
        )
    )
    shed = float(effort_ramp(q + gamma * (e - x), table.overlap))
    pitch = turbine.pitch_min + max((shed - zeta) / b, 0.0)
    v = v_s + cell["wind_error"] * draw.choice([-1.0, 1.0])
    state, seen = np.array([x, v_s]), v_s + law.wind_filter * rate
    measured = Measurement(speed + e, pitch, seen)
    asked = law.command(state, measured)
    inertia = turbine.inertia * draw.choice([0.9, 1.1])
    torque = float(rotor_torque(turbine, speed + e, pitch, v))
    turned = (torque - turbine.gear_ratio * asked.torque) / inertia
    drive = (asked.pitch - pitch) / turbine.pitch_time_constant
    limit = turbine.pitch_rate_limit
    return state, measured, asked, turned, min(max(drive, -limit), limit), rate


def test_the_law_on_the_plant_moves_no_faster(built: Any, rates: dict[str, Any]) -> None:
    """Differences of the law's own commands along the plant's motion, 40 states in every cell."""
    law, draw, step = built.law, np.random.default_rng(3), 1e-5
    used, turned_most = [], []
    for k, bound in enumerate(rates["cells"]):
        edge = 0.0
        for _ in range(40):
            state, seen, asked, turned, drive, rate = point(built, k, draw)
            assert abs(drive) <= bound["pitch_rate"] * (1 + 1e-9)
            turned_most.append(abs(drive) / bound["pitch_rate"])
            later = state + step * law.state_rate(state, seen)
            wind = float(later[1]) + law.wind_filter * rate
            if not built.document["claims"][0]["cells"][k]["wind"][0] < later[1]:
                continue
            if later[1] >= built.document["claims"][0]["cells"][k]["wind"][1]:
                continue
            after = Measurement(seen.rotor_speed + step * turned, seen.pitch + step * drive, wind)
            moved = abs(law.command(later, after).torque - asked.torque) / step
            edge = max(edge, moved)
            # Second order in the step: far below the rounding up of a bound.
            assert moved <= bound["torque_rate"] * (1 + 1e-6) + 1.0
        used.append(edge / max(bound["torque_rate"], 1.0))
    # The bounds are not idle: somewhere most of them is used.
    assert max(used) > 0.5
    assert max(turned_most) > 0.7


def test_commands_are_continuous_across_every_node(built: Any) -> None:
    """Just below and just above each wind node, for speeds and integrals of the set: no jump.

    A table that is constant between its nodes, in the place of a line, jumps by far more.
    """
    law, draw, near = built.law, np.random.default_rng(5), 1e-9
    peak = built.document["claims"][0]["peaks"]
    for node, speed in zip(law.schedule.wind[1:-1], law.schedule.rotor_speed[1:-1], strict=True):
        e = float(draw.uniform(-1, 1)) * peak["speed_error"]
        x = float(draw.uniform(-1, 1)) * peak["integral"]
        below, above = (
            law.command(np.array([x, v]), Measurement(float(speed) + e, 0.1, float(node)))
            for v in (node - near, node + near)
        )
        assert abs(above.torque - below.torque) < 1e-2  # N m
        assert abs(above.pitch - below.pitch) < 1e-7  # rad


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
