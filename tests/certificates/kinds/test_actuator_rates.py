"""How fast pitch and torque move on the certified set: against the law itself, and damaged."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.turbine.effort_sharing.actuator_rates import (
    ActuatorRates,
    torque_step,
)
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range
from takagi.certificates.claims.turbine.loop_claims import actuator_rates_claim, loop_claims
from takagi.models.laws.protocol import Measurement
from takagi.models.ramps import effort_ramp
from takagi.models.turbine.data import rotor_torque
from tests.certificates.conftest import cells_from
from tests.certificates.kinds.claims import resealed

PROVED, UNDECIDED = "PROVED", "UNDECIDED"
SLOW_GENERATOR = 9000.0  # N m/s; the turbine has 15000


@pytest.fixture(scope="session")
def rates(built: Any) -> dict[str, Any]:
    """Return the claim about the whole loop."""
    document = built.document
    return actuator_rates_claim(document["model"], document["gains"], document["claims"][0])


@pytest.fixture(scope="session")
def short_rates(short_document: dict[str, Any]) -> dict[str, Any]:
    """Return the short certificate with its own claim about rates."""
    document = deepcopy(short_document)
    loop = document["claims"][0]
    claim = actuator_rates_claim(document["model"], document["gains"], loop)
    return dict(resealed(document | {"claims": [loop, claim]}))


def verdict_on_rates(document: dict[str, Any]) -> str:
    """Return the verdict on the claim about rates."""
    return check_document(resealed(document)).claims[1].verdict.name


def test_the_default_loop_is_proved(built: Any, rates: dict[str, Any]) -> None:
    """No wind asks for torque faster than the turbine allows."""
    document = resealed(built.document | {"claims": [built.document["claims"][0], rates]})
    found = check_document(document).claims[1]

    assert verdict_on_rates(document) == PROVED
    limit = built.turbine.torque_rate_limit
    beyond = [cell["torque_rate"] > limit for cell in rates["cells"]]
    assert not any(beyond)
    assert "and in 70 within the turbine's limit of 15000 N m/s" in found.text
    assert "in 12 of them, while |v_s''| is at most" in found.text
    fed = [cell for cell in rates["cells"] if cell["schedule_bend"] > 0]
    assert fed
    assert all(cell["torque_rate"] == limit for cell in fed)
    assert all(cell["pitch_rate"] <= built.turbine.pitch_rate_limit for cell in rates["cells"])


def test_winds_beyond_the_generators_rate_are_named(built: Any) -> None:
    """A generator that is slower: the words name the winds that ask for more than it can."""
    document = deepcopy(built.document)
    document["model"]["torque_rate_limit"] = limit = SLOW_GENERATOR
    loop = document["claims"][0]
    rates = actuator_rates_claim(document["model"], document["gains"], loop)
    found = check_document(resealed(document | {"claims": [loop, rates]})).claims[1]
    beyond = [cell["torque_rate"] > limit for cell in rates["cells"]]
    assert 0 < sum(beyond) < 30
    low = loop["cells"][beyond.index(True)]["wind"][0]
    high = loop["cells"][len(beyond) - 1 - beyond[::-1].index(True)]["wind"][1]
    assert f"{low:g} to " in found.text and f" {high:g} m/s; it steps" in found.text
    assert ", NOT for " in found.text
    within = f"in {len(beyond) - sum(beyond)} within the turbine's limit of {limit:g} N m/s"
    assert within in found.text


def test_no_limit_is_told_higher_than_it_is(built: Any, rates: dict[str, Any]) -> None:
    """8 deg/s are 0.139626... rad/s: told as 0.139626, and what is below it is below that."""
    document = resealed(built.document | {"claims": [built.document["claims"][0], rates]})
    own = built.turbine.pitch_rate_limit

    text = check_document(document).claims[1].text

    told = text.split("stays below the drive's limit of ")[1].split(" rad/s")[0]
    below = int(text.split("rad/s, and in ")[1].split(" stays below")[0])
    assert own - 1e-6 < float(told) <= own
    assert below == sum(cell["pitch_rate"] < float(told) for cell in rates["cells"])


@pytest.mark.parametrize("limit", ["15000.00001", "14999.99999"])
def test_a_limit_of_torque_is_told_as_it_is_stated(limit: str) -> None:
    """With more digits than other numbers: a cell at the limit itself is within it."""
    text = torque_words(limit)

    assert f"in 1 within the turbine's limit of {limit} N m/s; it steps" in text


def torque_words(limit: str) -> str:
    """Return the sentence about one cell of wind whose torque moves at the limit."""
    cell = {"pitch_rate": Number("0.1"), "torque_rate": Number(limit), "schedule_bend": Number("1")}
    model = {"pitch_rate_limit": Number("0.2"), "torque_rate_limit": Number(limit)}
    claim = {"loop": 0, "cells": [cell], "torque_step": Number("0")}
    rates = ActuatorRates(claim, {"model": model}, "here", "rates", None, None, "")
    law = SimpleNamespace(wind=[Fraction(5), Fraction(8)])
    rates.__dict__.update(subject=SimpleNamespace(law=law), bounds=[SimpleNamespace(fed=0)])
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
            bend = bound["schedule_bend"] * draw.choice([-1.0, 1.0])
            wind = float(later[1]) + law.wind_filter * (rate + step * bend)
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


DAMAGES: dict[str, Callable[[dict[str, float]], float]] = {
    "pitch_rate": lambda cell: cell["pitch_rate"] * 0.999,
    "signal_rate": lambda cell: cell["signal_rate"] * 0.9999,
    "torque_rate": lambda cell: cell["torque_rate"] * 0.9999,
    "schedule_bend": lambda cell: -1e-6,
}


def test_the_short_certificate_is_proved(short_rates: dict[str, Any]) -> None:
    """What the damages below begin from."""
    assert verdict_on_rates(short_rates) == PROVED


@pytest.mark.parametrize("name", DAMAGES)
@pytest.mark.parametrize("k", [0, pytest.param(2, marks=pytest.mark.slow)])
def test_each_number_of_a_cell_counts(short_rates: dict[str, Any], name: str, k: int) -> None:
    """A little less than what is needed is not proved."""
    changed = deepcopy(short_rates)
    cell = changed["claims"][1]["cells"][k]
    cell[name] = DAMAGES[name](cell)

    assert verdict_on_rates(changed) == UNDECIDED


@pytest.mark.slow
def test_what_is_fed_forward_counts(built: Any, rates: dict[str, Any]) -> None:
    """|v_s''| a little larger, and a step at the nodes a little smaller, in the whole loop."""
    loop = built.document["claims"][0]
    k = next(k for k, cell in enumerate(rates["cells"]) if cell["schedule_bend"] > 0)
    for place, value in (("schedule_bend", 1.001), ("torque_step", 0.9999)):
        claim = deepcopy(rates)
        owner = claim if place == "torque_step" else claim["cells"][k]
        owner[place] = round(owner[place] * value, 9)
        checked = check_document(resealed(built.document | {"claims": [loop, claim]})).claims[1]
        assert checked.verdict.name == UNDECIDED
        assert "torque" in checked.text


def test_the_step_at_a_node_is_that_of_the_law(built: Any, rates: dict[str, Any]) -> None:
    """The feed-forward just below and above each node, over all rates: the largest is the bound."""
    ahead, E = built.law.feedforward, built.law.effort_torque
    rho = [cell["wind_rate"] for cell in built.document["claims"][0]["cells"]]
    largest = 0.0
    for k in range(len(rho) - 1):
        rate = np.linspace(0, min(rho[k : k + 2]), 2001)
        sides = [
            np.clip(ahead.inertia[i] * rate, -ahead.effort_limit[i], ahead.effort_limit[i])
            for i in (k, k + 1)
        ]
        largest = max(largest, float(np.abs(sides[0] - sides[1]).max()))

    assert E * largest <= rates["torque_step"]
    assert E * largest > 0.999 * rates["torque_step"]


def test_steps_by_hand() -> None:
    """f = 2 held within 3, beside f = 1 held within 1: at s = 1.5 they are 3 and 1."""

    def step(f: list[int], g: list[int], rates: list[int]) -> Any:
        law: Any = SimpleNamespace(inertia=f, inertia_limit=g, effort_torque=10)
        return torque_step(law, [Fraction(rate) for rate in rates])

    assert step([2, 1], [3, 1], [5, 5]) == 20
    assert step([2, 1], [3, 1], [5, 1]) == 10
    assert step([2, 1], [3, 1], [0, 5]) == 0
    assert step([2, 1], [100, 100], [5, 7]) == 50
    assert step([-2, 1], [3, 1], [5, 5]) == 40
    # Apart between their limits alone: 2 and 4 at s = 2, both 4 at s = 4.
    assert step([1, 2], [4, 4], [9, 9]) == 20


def test_what_is_no_claim_is_refused(short_rates: dict[str, Any]) -> None:
    """A cell too few, a turbine without a stated torque rate."""
    few, bare = deepcopy(short_rates), deepcopy(short_rates)
    few["claims"][1]["cells"].pop()
    del bare["model"]["torque_rate_limit"]
    with pytest.raises(CertificateError, match="cells: a list of"):
        check_document(resealed(few))
    with pytest.raises(CertificateError, match="torque_rate_limit"):
        check_document(resealed(bare))


def test_a_loop_that_is_not_proved_carries_no_rates(short_rates: dict[str, Any]) -> None:
    """The loop's verdict comes first."""
    changed = deepcopy(short_rates)
    changed["claims"][0]["cells"][1]["decay_rate"] = 3.0

    assert verdict_on_rates(changed) == UNDECIDED


RATE, ACTUATORS = 1, 2
# Cells from 9 m/s on, where the torque is fed v_s', to beyond the last of them.
FROM, CELLS = 9.0, 6
Document = dict[str, Any]


def narrow(built: Any, wind_filter: float) -> Document:
    """Return the certificate of a few cells, with all claims that hold."""
    document = cells_from(built.document, FROM, CELLS)
    gains, loop = document["gains"], document["claims"][0]
    gains["wind_filter"] = wind_filter
    claims, left_out = loop_claims(document["model"], gains, loop)
    assert not left_out
    return dict(document | {"claims": claims})


@pytest.fixture(scope="module")
def slow(built: Any) -> Document:
    return narrow(built, 5.0)


def verdict_on_rates_in_the_class(document: Document) -> str:
    """Return the verdict on the claim about rates."""
    return check_document(resealed(document)).claims[ACTUATORS].verdict.name


def test_the_slow_filter_keeps_to_the_rate_that_is_stated(slow: Document) -> None:
    """(r + phi) / 5 s is below what the torque's rate limit leaves: no NOT for the class."""
    text = check_document(resealed(slow)).claims[ACTUATORS].text

    assert slow["claims"][ACTUATORS]["wind_rate"] == RATE
    assert verdict_on_rates_in_the_class(slow) == "PROVED"
    assert "as in every wind of the claim on the wind's rate" in text
    assert "NOT for every wind" not in text


def test_a_fast_filter_does_not_and_the_line_says_so(built: Any) -> None:
    """With 0.05 s v_s'' may reach metres per second cubed; what is stated holds up to less."""
    document = narrow(built, 0.05)
    checked = check_document(resealed(document)).claims[ACTUATORS]

    assert "wind_rate" not in document["claims"][ACTUATORS]
    assert checked.verdict.name == "PROVED"
    assert "m/s^3, NOT for every wind of the wind limits)" in checked.text


def test_a_fast_filter_that_is_said_to_keep_it_is_refused(built: Any) -> None:
    document = narrow(built, 0.05)
    document["claims"][ACTUATORS]["wind_rate"] = RATE

    assert verdict_on_rates_in_the_class(document) == "UNDECIDED"


@pytest.mark.parametrize(("share", "verdict"), [(1.0, "PROVED"), (0.999, "UNDECIDED")])
def test_the_bound_is_the_threshold(slow: Document, share: float, verdict: str) -> None:
    """A ``schedule_bend`` just at the class's own, and a little below."""
    changed = deepcopy(slow)
    ranges = [tube(one) for one in changed["claims"][RATE]["ranges"]]
    k = next(k for k, cell in enumerate(changed["claims"][ACTUATORS]["cells"]) if fed(changed, k))
    ends = [Fraction(str(v)) for v in changed["gains"]["wind"][k : k + 2]]
    bend = max(one.bend(ends[0], ends[1], Fraction(5)) for one in ranges)
    cell = changed["claims"][ACTUATORS]["cells"][k]
    assert 0 < bend < Fraction(str(cell["schedule_bend"]))
    cell["schedule_bend"] = float(bend) * share + (1e-12 if share == 1 else 0)

    assert verdict_on_rates_in_the_class(changed) == verdict


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
def test_only_an_earlier_claim_on_the_winds_rate_is_named(slow: Document, place: float) -> None:
    """Not the loop, not itself, nothing that is not there."""
    changed = deepcopy(slow)
    changed["claims"][ACTUATORS]["wind_rate"] = place
    with pytest.raises(CertificateError):
        check_document(resealed(changed))


def test_a_rate_that_is_not_proved_carries_nothing(slow: Document) -> None:
    changed = deepcopy(slow)
    one = changed["claims"][RATE]["ranges"][0]
    one["estimate_rate"] = [1.0 for _ in one["estimate_rate"]]

    assert verdict_on_rates_in_the_class(changed) == "UNDECIDED"
