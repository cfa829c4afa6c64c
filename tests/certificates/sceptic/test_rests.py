"""Rests that may be counted wrong: gains that turn back, slivers, ends of tables, a hidden bend."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import pytest

from takagi.certificates.checker import read_text
from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import ONE, UNIT, ZERO, Interval
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.equilibria.effort_sharing import effort_sharing_equilibria
from takagi.certificates.checker.turbine.equilibria.equilibrium_claim import equilibrium_reader
from takagi.certificates.checker.turbine.equilibria.one_integrator import OneIntegrator
from takagi.certificates.checker.turbine.equilibria.published import bends, published_equilibria
from takagi.certificates.checker.turbine.equilibria.two_integrators import TwoIntegrators
from takagi.certificates.checker.turbine.equilibria.zero_count import Piece, Span, count_zeros
from takagi.certificates.checker.turbine.published.inputs import PublishedLaw
from takagi.certificates.claims.turbine import published_law_data
from takagi.certificates.document import turbine_data
from takagi.lmi.turbine import EffortSettings, effort_gains
from takagi.models.laws import EffortSharingLaw, effort_schedule
from takagi.models.laws.published import PublishedLawName
from takagi.models.turbine import rotor_torque
from tests.certificates.conftest import Built
from tests.certificates.test_paper_certificate import TURBINE, make_law

Data = dict[str, Any]
WINDS = Fraction(15), Fraction("15.02")


@cache
def emitted(name: PublishedLawName) -> tuple[Data, Data]:
    return turbine_data(TURBINE, ()), published_law_data(make_law(name))


def forged(name: PublishedLawName, change: Callable[[Data], None]) -> tuple[Data, Data]:
    """Return model and gains as the checker reads them, the gains changed."""
    model, gains = emitted(name)
    gains = copy.deepcopy(gains)
    change(gains)
    read = read_text(json.dumps({"model": model, "gains": gains}), "loop")
    return read["model"], read["gains"]


def turning_back(gains: Data) -> None:
    """Gains of pitch that double just beyond the trim's pitch, so that u falls there as s grows."""
    gains["partial"]["k_integral"] = [1.5 * k for k in gains["partial"]["k_integral"]]
    gains["full"]["premises"]["b"] = [-0.95, -0.86]
    rules = gains["full"]["rules"]
    gains["full"]["k_integral"] = [-0.16 if rule[1] == 0 else -0.08 for rule in rules]
    gains["full"]["k_pitch"] = [-0.6] * len(rules)


def test_a_torque_command_that_falls_again_does_not_decide_where_the_rest_is() -> None:
    """The one rest has rated torque; beyond it u is below rated torque again, where f < 0."""
    model, gains = forged("paper", turning_back)
    law = PublishedLaw.read(gains)
    rest = OneIntegrator(Plant.read(model), law)
    corner = law.rated_torque + law.overlaps.torque / 2

    def look(s: str) -> tuple[int, int]:
        at = Fraction(s), Fraction(s)
        curve, excess = rest._curve(WINDS, at), rest._excess(WINDS, at)
        assert curve is not None and excess is not None
        value, command = excess.value, curve[1].value
        above = (command[0] >= corner * ONE) - (command[1] < corner * ONE)
        return (value[0] > 0) - (value[1] < 0), above

    # The rest lies between 0.35 and 0.37, with u above the corner; farther on u is below it.
    assert (look("0.35"), look("0.37")) == ((1, 1), (-1, 1))
    assert look("0.55") == (-1, -1)

    _, _, answer = equilibrium_reader(model, gains)
    assert answer(WINDS) in ("one", "one at the trim")


def test_a_set_point_below_the_smallest_speed_bends_the_reference() -> None:
    """min(lambda_max v/R, set-point) has a bend of its own; between bends the speed is a line."""
    gains = forged("paper", lambda g: g.update(speed_setpoint=0.5))[1]
    law = PublishedLaw.read(gains)
    plant = Plant.read(emitted_model())
    rest = OneIntegrator(plant, law)
    first, last = Fraction(1), Fraction(25)
    cuts = [first, *sorted(v for v in bends(plant, law) if first < v < last), last]

    assert law.setpoint < law.minimum_speed
    for low, high in zip(cuts, cuts[1:], strict=False):
        middle = rest.reference((low + high) / 2)
        assert middle == (rest.reference(low) + rest.reference(high)) / 2


def emitted_model() -> Data:
    return forged("paper", lambda _: None)[0]


def test_a_trim_beyond_the_coefficient_table_is_no_answer() -> None:
    """Premises are averages from the trim: where its tip-speed ratio has no table, none exists."""

    def fast_trim(gains: Data) -> None:
        gains["full"]["rotor_speed"] = [3 * speed for speed in gains["full"]["rotor_speed"]]

    _, _, answer = equilibrium_reader(*forged("paper", fast_trim))

    with pytest.raises(Refused, match="leaves the coefficient table"):
        answer(WINDS)


def test_a_ramp_that_ends_a_hair_above_the_reference_speed_asks_for_any_pitch() -> None:
    """f_1/(1 - f_1) has no bound, however small the speed error: large pitches are looked at."""

    def hair(gains: Data) -> None:
        coupling = gains["coupling"]
        coupling["speed_overlap"] = 0.1
        coupling["speed_ramp_start"] = round(gains["speed_setpoint"] - 0.1, 9)

    model, gains = forged("paper-two-integrators", hair)
    law = PublishedLaw.read(gains)
    sliver = Fraction(1, 10**25)
    over = replace(law.overlaps, start=law.setpoint - law.overlaps.width + sliver)
    rest = TwoIntegrators(Plant.read(model), replace(law, overlaps=over))

    found = rest._joined(WINDS, (Fraction(0), 2 * sliver))

    # At the largest pitch of the table the rotor brakes.
    assert found is not None
    assert found.value[0] < 0 < found.value[1]


def test_a_sign_of_other_winds_is_no_change_of_sign() -> None:
    """f is -1 left of 1/2 at some winds, not defined there at others, and may be 1 all beyond."""

    def left_by_some(_winds: Span, span: Span) -> Dual:
        if span[1] <= Fraction(1, 2):
            return Dual(-UNIT, ())
        if span[0] >= 1:
            return Dual(UNIT, (ZERO, ZERO))
        return Dual(Interval(-ONE, ONE), ())

    half = Fraction(1, 2)
    ends = [(Fraction(0), half), (half, Fraction(1)), (Fraction(1), Fraction(2))]
    found = count_zeros(left_by_some, (half, half * 2), [Piece(e) for e in ends], most_parts=16)

    assert found.least == 0
    assert found.exact is None


def test_states_beyond_the_reference_speed_of_some_winds_are_not_their_rests() -> None:
    """x at its upper limit needs e <= 0; over a cell the largest R omega*/v is not every wind's."""
    from takagi.certificates.document import effort_sharing_law_data

    # A share at which a rotor stalls at 22 m/s.
    schedule = effort_schedule(TURBINE, effectiveness_share=0.6)
    gains = effort_gains(TURBINE, schedule, EffortSettings(integral_share=0.3)).gains
    stalling = EffortSharingLaw.of(TURBINE, schedule, gains)
    data = {"model": turbine_data(TURBINE, []), "gains": effort_sharing_law_data(stalling)}
    read = read_text(json.dumps(data), "loop")
    plant, law = Plant.read(read["model"]), Law.read(read["gains"])
    k = next(i for i, wind in enumerate(law.wind) if wind >= 22)
    speed = [*law.speed]
    speed[k : k + 2] = Fraction("0.72"), Fraction(1)
    law = replace(law, speed=speed)
    ratios = [plant.radius * speed[i] / law.wind[i] for i in (k, k + 1)]

    def reach(**common: bool) -> list[Fraction]:
        winds = law.wind[k], law.wind[k + 1]
        return [
            stop for _, stop in effort_sharing_equilibria(plant, law, winds, **common).upper.blocks
        ]

    assert reach() == reach(common=False) == [max(ratios)]
    assert all(stop <= min(ratios) for stop in reach(common=True))


def test_pitch_held_at_the_very_end_of_the_table_is_looked_at(built: Built) -> None:
    """A largest pitch that is the table's end: the balance there is bracketed, not left out."""
    from takagi.certificates.checker.turbine.equilibria.effort_sharing import _Equilibrium
    from takagi.certificates.document import effort_sharing_law_data

    data = {"model": turbine_data(TURBINE, []), "gains": effort_sharing_law_data(built.law)}
    read = read_text(json.dumps(data), "loop")
    plant, law = Plant.read(read["model"]), Law.read(read["gains"])
    k = next(i for i, wind in enumerate(law.wind) if wind >= 22)
    # So much effort that pitch is at its limit with the integrator at its lower one.
    efforts = [effort + 10 for effort in law.effort]
    winds, x = (law.wind[k], law.wind[k + 1]), (Fraction(-1, 10), Fraction(-1, 10))
    end = plant.surface.y.breaks[-1]

    def balance(pitch_max: Fraction) -> Dual | None:
        held = replace(law, effort=efforts, pitch_max=pitch_max)
        return _Equilibrium(plant, held, winds).inside(winds, x)

    at_end, beyond = balance(end), balance(end + 1)

    assert at_end is not None
    assert at_end.value[0] < at_end.value[1] < 0
    assert beyond is None


def test_a_paper_law_whose_pitch_ends_with_the_table_is_not_answered() -> None:
    """Pitch may rest at its limit there, which the curves of both laws leave out."""
    model, gains = forged("paper", lambda _: None)
    plant, law = Plant.read(model), PublishedLaw.read(gains)

    with pytest.raises(Refused, match="largest pitch inside"):
        published_equilibria(plant, replace(law, pitch_max=plant.surface.y.breaks[-1]), WINDS)


def test_a_wake_may_move_all_between_the_rest_and_the_trim(built: Built) -> None:
    """A wake lowers f where x < 0: f > 0 there is no answer, only its slope, up to x = 0."""
    from takagi.certificates.document import effort_sharing_law_data

    data = {"model": turbine_data(TURBINE, []), "gains": effort_sharing_law_data(built.law)}
    read = read_text(json.dumps(data), "loop")
    plant, law = Plant.read(read["model"]), Law.read(read["gains"])
    k = next(i for i, wind in enumerate(law.wind) if wind >= 11.4)
    for x in (Fraction(-1, 20), Fraction(1, 20)):
        # U = q* - gamma x as before at this x, so that the rest is moved from the trim to there.
        efforts = [q + g * x for q, g in zip(law.effort, law.gamma, strict=True)]
        moved = replace(law, effort=efforts, integral_limit=Fraction(3, 5))

        found = effort_sharing_equilibria(plant, moved, (law.wind[k], law.wind[k + 1])).inside

        assert found.exact == 1
        ((low, high),) = found.blocks
        assert low <= min(x, Fraction(0)) < max(x, Fraction(0)) <= high


def test_a_rest_far_along_the_curve_is_not_left_out() -> None:
    """f_1 = 1e-8 at the set-point: pitch still balances the rotor, with a huge integral."""

    def hardly(gains: Data) -> None:
        gains["coupling"]["speed_ramp_start"] = round(gains["speed_setpoint"] - 5.8e-6, 9)

    _, _, answer = equilibrium_reader(*forged("paper", hardly))

    with pytest.raises(Refused, match="far beyond rated torque"):
        answer(WINDS)


def test_a_rotor_without_torque_below_the_reference_speed_is_not_left_out() -> None:
    """A blade that brakes at low tip-speed ratios: a slow rotor rests there with e < 0."""
    model, gains = forged("paper-two-integrators", lambda _: None)
    plant = Plant.read(model)
    _, _, answer = equilibrium_reader(model, gains)
    assert answer(WINDS) == "one off the trim"

    surface = plant.surface
    surface._rows[0] = [-abs(entry) - ONE // 10 for entry in surface._rows[0]]
    surface._nets.clear()

    with pytest.raises(Refused, match="below the reference speed"):
        published_equilibria(plant, PublishedLaw.read(gains), WINDS)


def test_two_integrators_rest_on_a_continuum_only_below_rated_torque() -> None:
    """Each pitch of it asks for a torque that passes; where f_1 only just reaches 1, no answer."""
    model, gains = forged(
        "paper-two-integrators",
        lambda g: g["coupling"].update(speed_ramp_start=round(g["speed_setpoint"] - 0.1001, 9)),
    )
    plant, law = Plant.read(model), PublishedLaw.read(gains)

    low, high = published_equilibria(plant, law, WINDS).continuum or (Fraction(0), Fraction(0))

    rated = law.rated_torque - law.overlaps.torque / 2
    for pitch in (float(low), float(high)):
        torque = float(rotor_torque(TURBINE, float(law.setpoint), pitch, 15.01))
        assert 0 < torque / TURBINE.gear_ratio < float(rated)
    bend = law.setpoint * plant.radius / law.optimal_ratio
    at_bend = replace(law.overlaps, start=law.setpoint - law.overlaps.width)
    with pytest.raises(Refused, match="reaches 1"):
        published_equilibria(plant, replace(law, overlaps=at_bend), (bend - Fraction(1, 100), bend))
