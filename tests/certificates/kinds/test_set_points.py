"""The claim ``set-points``: at every constant wind and set-point the loop settles.

Theorem: the module of the kind.  The second way is the law on the rotor, integrated from the edges
of the sets; its speed at rest is the lower one of lambda_opt v / R and the set-point.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.controller.effort_sharing_program import effort_sharing_program
from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.effort_sharing.set_points import Cell, CellLoop, covers
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.checker.turbine.turbine_claim import AT_RATED
from takagi.certificates.checker.words.figure import Figure
from takagi.certificates.claims.turbine.set_points_claim import set_points_claim
from takagi.certificates.document.certificate_file import dumps, effort_sharing_law_data
from takagi.models import nrel5mw
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw, SetpointInputs
from takagi.models.laws.effort_sharing.schedule import speed_effort
from takagi.models.laws.protocol import Measurement
from takagi.models.turbine.data import rotor_torque
from tests.certificates.kinds.claims import Data
from tests.certificates.recorded.answers import recorded

# rad/s and the share of rated torque: a small range, of one box an interval at most winds.
LOWEST_SPEED, LOWEST_TORQUE = 1.22, 0.97
FIRST_WIND, CELLS = 10.8, 8  # m/s


@dataclass(frozen=True)
class Subject:
    law: EffortSharingLaw
    members: dict[str, Any]
    claim: dict[str, Any]

    def outcome(self, change: Callable[[dict[str, Any], dict[str, Any]], object]) -> Outcome:
        claim, members = deepcopy(self.claim), deepcopy(self.members)
        change(claim, members["gains"])
        data = read_text(dumps({**members, "claims": [claim]}), "test")
        return replay(data["claims"][0], data, None, [], "claims[0]")


@pytest.fixture(scope="module")
def subject(built: Any) -> Subject:
    turbine, law = built.turbine, excerpt(built.law)
    inputs = SetpointInputs(
        LOWEST_SPEED,
        round(LOWEST_TORQUE * turbine.rated_torque, 3),
        turbine.generator_efficiency * turbine.gear_ratio,
        speed_effort(turbine, law.schedule, LOWEST_SPEED),
    )
    law = replace(law, setpoints=inputs)
    members = {"model": built.document["model"], "gains": effort_sharing_law_data(law)}
    return Subject(law, members, set_points_claim(turbine, law, **members))


def excerpt(law: EffortSharingLaw) -> EffortSharingLaw:
    first = int(np.searchsorted(law.schedule.wind, FIRST_WIND))
    nodes, cells = slice(first, first + CELLS + 1), slice(first, first + CELLS)
    columns = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")
    schedule = replace(law.schedule, **{n: getattr(law.schedule, n)[nodes] for n in columns})
    gains = replace(
        law.gains,
        proportional=law.gains.proportional[nodes],
        integral_rate=law.gains.integral_rate[cells],
    )
    return replace(law, schedule=schedule, gains=gains)


def unchanged(claim: dict[str, Any], gains: dict[str, Any]) -> None:
    pass


def test_the_loop_is_proved_at_all_set_points(subject: Subject, built: Any) -> None:
    outcome = subject.outcome(unchanged)
    assert outcome.verdict is Verdict.PROVED, outcome.failure
    claim = outcome.in_words()
    figures = {f.name: f.value for f in claim.figures if isinstance(f, Figure)}
    rated = built.turbine.rated_power
    # Power is efficiency times torque times generator speed, so its share is that of both.
    share = LOWEST_SPEED / built.turbine.rated_rotor_speed * LOWEST_TORQUE
    assert float(figures["lowest power set-point"] or 0) == pytest.approx(share * rated, rel=1e-6)
    assert "constant set-points" in claim.assumes
    assert AT_RATED not in claim.assumes


def test_motions_from_the_edges_of_the_sets_settle_at_the_set_point(
    subject: Subject, built: Any
) -> None:
    """y'Py falls at least as fast as is stated, on the rotor itself."""
    turbine, rng = built.turbine, np.random.default_rng(5)
    for cell in subject.claim["cells"]:
        v, reduction, torque = (rng.uniform(*cell[n]) for n in ("wind", "reduction", "torque"))
        reference = float(np.interp(v, subject.law.schedule.wind, subject.law.schedule.rotor_speed))
        # Where the set-point is not below the reference, any higher one gives the same.
        speed = reference + reduction
        power = turbine.generator_efficiency * turbine.gear_ratio * torque * speed
        if speed < LOWEST_SPEED:
            continue
        law = subject.law.at_setpoints(speed=speed, power=power)

        def rate(_: float, z: Any, law: EffortSharingLaw = law, v: float = v) -> list[float]:
            seen = Measurement(z[0], z[1], v)
            state = [z[2], v]
            command = law.command(state, seen)
            balance = rotor_torque(turbine, z[0], z[1], v) - turbine.gear_ratio * command.torque
            drive = (command.pitch - z[1]) / turbine.pitch_time_constant
            return [float(balance) / turbine.inertia, drive, law.state_rate(state, seen)[0]]

        rest = solve_ivp(
            rate, (0, 4000), [speed, law.schedule.pitch(v, turbine), 0.0], "LSODA", rtol=1e-10,
            atol=1e-12,
        ).y[:, -1]  # fmt: skip
        assert rest[0] == pytest.approx(speed, abs=1e-6)
        P, rho = np.array(cell["P"]), cell["decay_rate"]
        direction = rng.normal(size=3)
        direction[1] = abs(direction[1])
        y = direction / np.sqrt(direction @ P @ direction)
        times = np.linspace(0, min(1 / rho, 60.0), 9)
        path = solve_ivp(
            rate, (0, times[-1]), rest + y, "LSODA", t_eval=times, rtol=1e-10, atol=1e-12
        ).y.T - rest  # fmt: skip
        levels = np.einsum("ti,ij,tj->t", path, P, path)
        assert np.all(levels <= np.exp(-2 * rho * times) + 1e-4), (v, speed, torque)


def test_other_claims_of_such_a_law_assume_rated_set_points(subject: Subject, built: Any) -> None:
    """Their theorems are about the law at its rated set-points, and each says so."""
    gains = {**built.document["gains"], "setpoints": subject.members["gains"]["setpoints"]}
    gains["setpoints"] = {**gains["setpoints"], "speed_effort": [0] * len(gains["wind"])}
    for members, expected in ((gains, True), (built.document["gains"], False)):
        document = {**built.document, "gains": members}
        data = read_text(dumps(document), "test")
        outcome = replay(data["claims"][0], data, None, [], "claims[0]")
        assert outcome.verdict is Verdict.PROVED
        assert (AT_RATED in outcome.in_words().assumes) is expected


def test_a_law_without_set_points_takes_none(built: Any) -> None:
    with pytest.raises(ModelError, match="set-point"):
        built.law.at_setpoints(speed=1.2, power=4e6)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_boxes_that_a_region_is_cut_into_cover_it(data: st.DataObject) -> None:
    """And without any one of them they do not."""
    boxes = [((Fraction(0), Fraction(1)),) * 3]
    for _ in range(data.draw(st.integers(1, 8))):
        box = boxes.pop(data.draw(st.integers(0, len(boxes) - 1)))
        side = data.draw(st.integers(0, 2))
        low, high = box[side]
        cut = low + (high - low) * data.draw(st.fractions(Fraction(1, 8), Fraction(7, 8)))
        boxes += [(*box[:side], half, *box[side + 1 :]) for half in ((low, cut), (cut, high))]  # type: ignore[misc]
    region = ((Fraction(0), Fraction(1)),) * 3
    assert covers(boxes, region)
    left_out = data.draw(st.integers(0, len(boxes) - 1))
    assert not covers([box for k, box in enumerate(boxes) if k != left_out], region)


PROVED = next(text for answer, text in recorded("set-points") if answer[0] == ["PROVED"])
RATED_TORQUE = 43093.55


def test_nested_boxes_are_answered_at_once() -> None:
    """Cut along their faces, the region would fall into a hundred thousand parts."""
    spans = [(Fraction(k, 60), 1 - Fraction(k, 60)) for k in range(29, 0, -1)]
    unit = Fraction(0), Fraction(1)
    assert not covers([*((span,) * 3 for span in spans), (unit,) * 3], (unit,) * 3)


def test_the_bracket_of_the_torque_balance_holds_it() -> None:
    """With columns that all rise or fall over the wind, unlike those of the recorded law."""
    rng, turbine = np.random.default_rng(2), nrel5mw()
    data = read_text(PROVED, "test")
    plant, law = Plant.read(data["model"]), Law.read(data["gains"])
    assert law.setpoints is not None
    slanted = replace(
        law, speed=[Fraction(n, 100) for n in (121, 124, 122, 127)],
        effectiveness=[Fraction(n, 100) for n in (50, 60, 45, 58)],
        gamma=[gain * Fraction(n, 10) for gain, n in zip(law.gamma, (10, 7, 12, 9), strict=True)],
    )  # fmt: skip
    efforts = replace(law.setpoints, speed_effort=[Fraction(n, 10) for n in (-2, 3, -1, 1)])
    nodes, columns = (
        np.array(law.wind, dtype=float),
        (slanted.speed, law.effort, slanted.effectiveness, efforts.speed_effort, slanted.gamma),
    )
    for raw in data["claims"][0]["cells"]:
        cell = Cell.read(raw, "cell")
        loop = CellLoop(plant, slanted, efforts, cell)
        for shift in cell.shifts:
            bracket = [end / ONE for end in loop.excess(shift)]
            for _ in range(20):
                v, r, torque = (
                    rng.choice([*s, rng.uniform(*s)]) for s in np.array(cell.box, dtype=float)
                )
                speed, rest, b, s, gamma = (
                    np.interp(v, nodes, np.array(c, dtype=float)) for c in columns
                )
                E, eps = float(law.effort_torque), float(law.overlap)
                U = rest + s * r + (RATED_TORQUE - torque) / E + float(shift)
                shed = U if U > eps else max(U + eps, 0.0) ** 2 / (4 * eps)
                balance = rotor_torque(turbine, speed + r, shed / b, v)
                balance -= turbine.gear_ratio * (torque - E * (shed - U))
                excess = float(balance) / turbine.inertia
                assert bracket[0] - 1e-9 <= excess <= bracket[1] + 1e-9
                for signal in float(cell.bounds[1]) * np.array([-1, 1]):
                    effort = U + gamma * signal
                    share = min(max((effort + eps) / (2 * eps), 0.0), 1.0)
                    for (low, high), value in (
                        (loop.reached, effort),
                        (loop.share, share),
                        (loop.signal_gain, share * gamma / b),
                    ):
                        assert float(low) - 1e-9 <= value <= float(high) + 1e-9


def test_each_input_of_the_program_lies_in_a_cell() -> None:
    document = json.loads(PROVED)
    gains, cells = document["gains"], document["claims"][0]["cells"]
    steps = {s["set"]: s["formula"] for s in effort_sharing_program(gains)["steps"]}
    names: Data = {"limit": lambda x, a, b: min(max(x, a), b), "line": np.interp, "min": min}
    names |= {"last": lambda row: row[-1], **gains, **gains["setpoints"]}
    for speed in (-1e9, 0.0, 1.22, 1.25, gains["rotor_speed"][-1], 1e9):
        for power in (-1e12, 0.0, 4.6e6, 4.8e6, 5e6, 1e12):
            for v in np.linspace(gains["wind"][0], gains["wind"][-1], 7):
                names |= {"speed_setpoint": speed, "power_setpoint": power, "v_s": v}
                for name in ("speed_most", "torque_setpoint", "reduction"):
                    names[name] = eval(steps[name], {"__builtins__": {}}, names)
                point = {"wind": v, "reduction": names["reduction"],
                         "torque": names["torque_setpoint"]}  # fmt: skip
                assert any(
                    all(c[n][0] - 1e-12 <= x <= c[n][1] + 1e-12 for n, x in point.items())
                    for c in cells
                )
