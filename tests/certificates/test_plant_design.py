"""Designs of plants: gains that are moderate and short, claims that were asked, honest noes."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

from takagi.certificates import Verdict
from takagi.certificates.design.design import NoDesign
from takagi.certificates.design.plant.design import certify_plant, design_plant
from takagi.certificates.design.plant.gain_task import rounded_gains
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.plant.wishes import reach_rates
from takagi.models import Interval, ModelError, Plant, TSModel, Variable, load_model
from takagi.models.files.library import built_in_kinds
from takagi.models.plant.design_settings import PlantSettings
from takagi.reports.loops.plant_loop import largest_commands, plant_loop

X, V, U = sp.symbols("x v u", real=True)


def cubic(*, range_of_u: tuple[int, int] | None = None) -> Plant:
    """x' = x + x^3 + u on |x| <= 1: vertices 1 and 2."""
    side = None if range_of_u is None else Interval.of(*range_of_u)
    return Plant(
        equations=(X + X**3 + U,),
        states=(Variable(X, "-", Interval.of(-1, 1)),),
        inputs=(Variable(U, "-", side),),
        name="cubic",
    )


def done(found: PlantDesign | NoDesign) -> PlantDesign:
    assert isinstance(found, PlantDesign)
    return found


QUICK = ("truck_trailer", "mass_spring_damper")
PLANTS = sorted(name for name, kind in built_in_kinds().items() if kind == "plant")


@pytest.mark.numeric
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in PLANTS]
)
def test_library_plants_are_proved_with_nothing_asked(name: str) -> None:
    """Every claim, the first of them about the plant's own equations."""
    plant = load_model(name)
    assert isinstance(plant, Plant)

    found = done(design_plant(plant))

    assert found.verdict is Verdict.PROVED
    # References are followed by differences of two motions, which are those of slopes.
    form = "secant" if plant.references else "sector"
    assert found.document["claims"][0]["kind"] == f"{form}-embedding"
    law = found.law if plant.measured is None else found.output_law
    assert (law is not None) == (found.design is not None) == bool(plant.inputs)


def test_gains_in_file_law_and_design_are_the_same_numbers() -> None:
    """The emitted decimals are what is proved and what is run."""
    found = done(design_plant(cubic()))

    assert found.gains is not None and found.law is not None
    assert np.array_equal(found.gains, found.law.gains)
    written = np.array(found.document["gains"]["K"])
    assert np.array_equal(np.broadcast_to(written, found.gains.shape), found.gains)


def test_a_rate_that_is_asked_for_is_proved() -> None:
    found = done(design_plant(cubic(), PlantSettings(decay_rate=3.0)))
    (claim,) = (c for c in found.document["claims"] if c["kind"] == "decay")

    assert found.verdict is Verdict.PROVED and claim["decay_rate"] >= 3.0
    assert found.gains is not None and found.gains.max() >= 5.0


def test_limits_that_gains_break_are_not_proved_away() -> None:
    """Given gains and |u| <= 1: the claim is made on a smaller set, |K x| <= 1 with K = 4."""
    found = certify_plant(cubic(), np.array([[4.0]]), PlantSettings(input_limit={"u": 1.0}))
    (claim,) = (c for c in found.document["claims"] if c["kind"] == "input-limits")
    reach = np.sqrt(claim["level"] / claim["P"][0][0])

    assert found.verdict is Verdict.PROVED and 4.0 * reach <= 1.0


@pytest.mark.parametrize("wish", [{"decay_rate": "max"}, {"damping": 0.7}, {"fastest": 9.0}])
def test_wishes_with_limited_inputs_take_starts_of_their_own(wish: dict[str, Any]) -> None:
    """|u| <= 3 and no starts: a part of the box is taken, and a note names it."""
    found = done(design_plant(cubic(range_of_u=(-3, 3)), PlantSettings(**wish)))

    assert found.verdict is Verdict.PROVED
    assert any("no initial states were given" in note for note in found.notes)


def test_wishes_name_the_one_range_that_is_missing() -> None:
    """The speed v has neither range nor start, so nothing bounds where the limits are kept."""
    plant = Plant(
        equations=(V, -X - X**3 + U),
        states=(Variable(X, "-", Interval.of(-1, 1)), Variable(V)),
        inputs=(Variable(U, "-", Interval.of(-2, 2)),),
    )

    with pytest.raises(ModelError, match=r"state v has neither .* initial = \{ v = half-width \}"):
        design_plant(plant, PlantSettings(damping=0.7))


def test_starts_may_name_some_states_alone() -> None:
    plant = Plant(
        equations=(V, X + U),
        states=(Variable(X, "-", Interval.of(-1, 1)), Variable(V, "-", Interval.of(-1, 1))),
        inputs=(Variable(U, "-", Interval.of(-2, 2)),),
    )

    found = done(design_plant(plant, PlantSettings(initial={"x": 0.5}, decay_rate=0.2)))
    (claim,) = (c for c in found.document["claims"] if c["kind"] == "input-limits")

    assert found.verdict is Verdict.PROVED and claim["P"][0][0] * 0.25 <= claim["level"]


@pytest.mark.slow
def test_a_fast_pole_does_not_make_the_default_fast() -> None:
    """A motor with a pole of 1.5e6 1/s: its ranges say 3 rad at 60 rad/s, so some 20 1/s.

    Control Tutorials for MATLAB and Simulink, Motor Position, J, b, K, R, L as printed there.
    """
    theta, omega, i, volt = sp.symbols("theta omega i volt", real=True)
    J, b, K, R, L = map(Fraction, ("3.2284e-6", "3.5077e-6", "0.0274", "4", "2.75e-6"))
    limits = ((theta, 3), (omega, 60), (i, 5), (volt, 12))
    *states, volts = (Variable(name, "-", Interval.of(-top, top)) for name, top in limits)
    torque, loss = (sp.Rational(v.numerator, v.denominator) for v in (K / J, b / J))
    current = [sp.Rational(v.numerator, v.denominator) for v in (1 / L, R / L, K / L)]
    plant = Plant(
        equations=(
            omega,
            torque * i - loss * omega,
            current[0] * volt - current[1] * i - current[2] * omega,
        ),
        states=tuple(states),
        inputs=(volts,),
    )

    found = done(design_plant(plant))
    (claim,) = (c for c in found.document["claims"] if c["kind"] == "invariant-ellipsoid")
    alone = np.sqrt(claim["level"] / np.diag(np.array(claim["P"], dtype=float)))

    assert found.verdict is Verdict.PROVED and np.all(alone >= 0.6 * np.array([3, 60, 5]))
    assert found.design is not None and 5 <= found.design.decay_rate <= 40


def test_states_without_a_range_do_not_make_integrators_absurdly_slow() -> None:
    """x'' = sin(theta), theta'' = u, |theta| <= 1/2, |u| <= 1: theta is at its end after 1 s.

    The largest set alone has a law that takes days, with x up to 10^7.
    """
    x, v, theta, omega = sp.symbols("x v theta omega", real=True)
    plant = Plant(
        equations=(v, sp.sin(theta), omega, U),
        states=(
            Variable(x, "-"),
            Variable(v, "-"),
            Variable(theta, "-", Interval.of("-0.5", "0.5")),
            Variable(omega, "-"),
        ),
        inputs=(Variable(U, "-", Interval.of(-1, 1)),),
    )

    found = done(design_plant(plant))

    assert found.verdict is Verdict.PROVED
    assert found.design is not None and 0.05 <= found.design.decay_rate <= 2
    assert any("follow from 1 s" in n and "x, v, omega have none" in n for n in found.notes)


def test_the_time_in_which_inputs_reach_the_ends() -> None:
    """x'' = u with |u| <= 2 is at 9 after 3 s; a state that no input moves has no such time."""
    A, B = [[[0, 1], [0, 0]]], [[[0], [1]]]
    limit = np.array([2.0])

    rates, time = reach_rates(TSModel(A, B), np.array([9.0, np.inf]), limit)
    assert time == pytest.approx(3, rel=0.01)
    assert rates[-1] == pytest.approx(2 / 3, rel=0.02) and len(rates) == 7
    assert reach_rates(TSModel([[[0]]], [[[0]]]), np.array([1.0]), limit) == ([], np.inf)


@pytest.mark.slow
def test_an_equation_that_the_checker_does_not_see_through_is_told_how_to_write() -> None:
    """sin(theta + asin(y/2)) - y/2 vanishes with theta, by a rule that no checker has.

    Written as the note says, by the addition theorem, it is proved.
    """

    def plant(rate: sp.Expr) -> Plant:
        states = (
            Variable(Y, "-", Interval.of(-1, 1)),
            Variable(THETA, "-", Interval.of("-0.5", "0.5")),
        )
        inputs = (Variable(U, "-", Interval.of(-5, 5)),)
        return Plant(equations=(rate, U), states=states, inputs=inputs)

    Y, THETA = sp.symbols("y theta", real=True)
    whole = done(design_plant(plant(sp.sin(THETA + sp.asin(Y / 2)) - Y / 2)))
    parts = sp.sin(THETA) * sp.sqrt(1 - Y**2 / 4) + sp.cos(THETA) * Y / 2 - Y / 2
    written = done(design_plant(plant(parts)))

    assert whole.verdict is Verdict.UNDECIDED and "write the equation" in whole.notes[0]
    assert written.verdict is Verdict.PROVED
    assert not any("write the equation" in note for note in written.notes)


def test_trim_is_part_of_the_law() -> None:
    """x' = 2 - x + x^3 + u about x* = 1/2 rests with u* = -13/8: so does the emitted law."""
    plant = Plant(
        equations=(2 - X + X**3 + U,),
        states=(Variable(X, "-", Interval.of(0, 1), Fraction(1, 2)),),
        inputs=(Variable(U, "-", None, Fraction(-13, 8)),),
        name="trimmed",
    )

    found = done(design_plant(plant))

    assert found.verdict is Verdict.PROVED and found.law is not None
    assert found.document["gains"]["trim"] == {"state": [0.5], "input": [-1.625]}
    assert found.law.command(np.array([0.5])) == pytest.approx([-1.625])


def test_gains_are_rounded_to_digits_of_the_largest_over_the_rules() -> None:
    """Four digits of 1234.5 leave whole numbers, for every rule alike."""
    K = np.array([[[1234.567, 0.0]], [[-12.3456, 0.0]]])

    assert rounded_gains(K, 4).tolist() == [[[1235.0, 0.0]], [[-12.0, 0.0]]]


def test_the_same_design_twice_is_the_same_certificate() -> None:
    """No time, no place: the bytes are those of the numbers."""
    first, second = (done(design_plant(cubic())) for _ in range(2))

    assert first.document == second.document


def effort_of(plant: Plant, **asked: Any) -> dict[str, PlantDesign]:
    return {
        effort: done(design_plant(plant, PlantSettings(effort=effort, **asked)))
        for effort in ("small", "moderate", "large")
    }


def largest_gain(found: PlantDesign) -> float:
    assert found.gains is not None
    return float(np.abs(found.gains).max())


def test_a_small_effort_claims_half_of_the_input_s_range() -> None:
    """|u| <= 3: half of it is used, and the gains rise with the effort."""
    found = effort_of(cubic(range_of_u=(-3, 3)))
    (claim,) = (c for c in found["small"].document["claims"] if c["kind"] == "input-limits")

    assert [one.verdict for one in found.values()] == [Verdict.PROVED] * 3
    assert claim["input_limits"] == [1.5]
    assert largest_gain(found["small"]) < largest_gain(found["moderate"])
    assert largest_gain(found["moderate"]) <= largest_gain(found["large"])
    ((_, most),) = largest_commands(plant_loop(found["small"]))
    assert 0.99 * 1.5 < most <= 1.5 * (1 + 1e-9), (
        "the set that is told holds the limit that is told"
    )


def test_the_set_that_is_told_keeps_a_limit_narrower_than_the_range() -> None:
    """x' = x + u, u = -2 x: |u| <= 1/2 for |x| <= 1/4 alone, though the box reaches 1."""
    plant = Plant(
        equations=(X + U,),
        states=(Variable(X, "-", Interval.of(-1, 1)),),
        inputs=(Variable(U, "-"),),
    )
    found = done(design_plant(plant, PlantSettings(input_limit={"u": 0.5})))
    P, level = plant_loop(found).ellipsoid
    assert np.sqrt(level / P[0, 0]) * largest_gain(found) <= 0.5 * (1 + 1e-9)


def test_without_limits_a_small_effort_takes_smaller_gains_at_the_rate() -> None:
    """A rate that is asked for is kept; a large effort says that it changes nothing."""
    found = effort_of(cubic(), decay_rate=1.0)

    assert [one.verdict for one in found.values()] == [Verdict.PROVED] * 3
    assert largest_gain(found["small"]) < largest_gain(found["moderate"])
    assert any("changes nothing" in note for note in found["large"].notes)


def test_the_largest_rate_asks_for_one_number_and_proposes_it() -> None:
    """The proposal, taken, is proved at the first try."""
    with pytest.raises(ModelError, match="one number is missing: give gain_bound") as told:
        design_plant(cubic(), PlantSettings(decay_rate="max"))
    proposed = float(str(told.value).split("for instance ")[1].split(",")[0])

    assert done(design_plant(cubic(), PlantSettings(decay_rate="max", gain_bound=proposed))).proved
