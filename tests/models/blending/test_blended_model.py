"""The model of a blended plant is the plant with its two actuators, wherever it is."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.models import Floats, ModelError, Plant, TSModel
from takagi.models.blending.blending import RunTimeBlending, blending_of
from takagi.models.blending.substitution import blended_model
from takagi.models.files.library import data_folder
from takagi.models.laws.pdc import PdcLaw
from tests.models import library_plants
from tests.models.blending.plants import ROOM, plant_of

# Rests where cooling alone acts, against a load of 1.
LOADED = ROOM.replace("range = [-3, 3]", "range = [-3, 3], rest = -1").replace(
    '"a*x - 2', '"1 + a*x - 2'
)
ROOMS = {"handing over": (ROOM, 0.0, 0.0), "cooled": (LOADED, -1.0, 1.0)}


@cache
def made(text: str) -> tuple[Plant, TSModel]:
    with TemporaryDirectory() as folder:
        plant = plant_of(Path(folder), text)
    return plant, blended_model(plant)


def by_hand(
    x: float, effort: float, errors: tuple[float, float], rest: float = 0.0, load: float = 0.0
) -> float:
    """x' of the room from its equation, psi written by max, actuators wrong about their rest."""

    def psi(s: float) -> float:
        return max(s - 0.5, 0.0) + min(max(s + 0.5, 0.0), 1.0) ** 2 / 2

    cooling, heating = psi(-effort) / 2, psi(effort) / (2 + x)
    cooling0, heating0 = psi(-rest) / 2, psi(rest) / 2
    cooling = cooling0 + (1 + errors[0]) * (cooling - cooling0)
    heating = heating0 + (1 + errors[1]) * (heating - heating0)
    return load + 0.5 * x - 2 * cooling + (2 + x) * heating


@pytest.mark.parametrize("name", ROOMS)
@given(
    x=st.floats(-1, 1),
    effort=st.floats(-3, 3),
    low=st.floats(-0.1, 0.1),
    high=st.floats(-0.2, 0.2),
)
def test_the_model_equals_the_two_actuators(
    name: str, x: float, effort: float, low: float, high: float
) -> None:
    """sum h_i (A_i x + B_i u) is x' by hand, with weights >= 0 that sum to one."""
    text, rest, load = ROOMS[name]
    plant, model = made(text)
    blending = blending_of(plant)
    assert blending is not None
    state = np.array([x, effort])
    known = RunTimeBlending(blending).signals(state)
    signals = {**known, "cooling_error": low, "heating_error": high}
    moved = {"effort": effort} if rest == 0 else {"delta_effort": effort - rest}
    point = {"x": x, **moved, "effort_rate": 0.0, **signals}
    values = model.premise_values(**point)
    h = model.memberships(values)
    now = model.blend(values)

    assert h.min() >= 0
    assert h.sum() == pytest.approx(1, abs=1e-12)
    wanted = by_hand(x, effort, (low, high), rest, load)
    assert (now.A @ (state - np.array([0.0, rest])))[0] == pytest.approx(wanted, abs=1e-10)
    np.testing.assert_allclose(now.B, np.array([[0.0], [1.0]]), atol=1e-12)


@given(
    x=st.floats(-1, 1), effort=st.floats(-3, 3), low=st.floats(-0.5, 0.5), high=st.floats(-0.5, 0.5)
)
def test_the_running_plant_is_the_one_by_hand(
    x: float, effort: float, low: float, high: float
) -> None:
    plant, _ = made(ROOM)
    blending = blending_of(plant)
    assert blending is not None
    errors = {"cooling": low, "heating": high}
    rate = RunTimeBlending(blending, errors).disturbed_rate(())

    found = rate(np.array([x, effort]), np.array([7.0]), np.zeros(0))
    assert found == pytest.approx([by_hand(x, effort, (low, high)), 7.0], abs=1e-12)


def test_the_share_cancels_where_both_act_alike(tmp_path: Path) -> None:
    """Actuators that do as told, with the plant's own effectiveness: x' = a x + U, one rule."""
    plant = plant_of(tmp_path, a=", error = 0.1 -> ", b=", error = 0.2 -> ")
    model = blended_model(plant)

    assert len(model.rules) == 1
    np.testing.assert_allclose(model.A[0], np.array([[0.5, 1.0], [0.0, 0.0]]))


def test_a_wrong_effectiveness_in_the_law_stays_in_the_model(tmp_path: Path) -> None:
    """The law says 2 where the plant has 2 + x: x' = a x - psi(-U) + (2 + x)/2 psi(U)."""
    plant = plant_of(
        tmp_path, a=", error = 0.1 -> ", b=", error = 0.2 -> ", c='ness = "2 + x" -> ness = "2"'
    )
    model = blended_model(plant)
    blending = blending_of(plant)
    assert blending is not None
    for x, effort in ((0.7, 2.0), (-0.9, 1.0), (0.3, -2.0), (0.5, 0.0)):
        state = np.array([x, effort])
        known = RunTimeBlending(blending).signals(state)
        now = model.blend(model.premise_values(x=x, effort=effort, effort_rate=0.0, **known))
        low, high = (max(s - 0.5, 0) + min(max(s + 0.5, 0), 1) ** 2 / 2 for s in (-effort, effort))
        wanted = 0.5 * x - low + (2 + x) / 2 * high
        assert (now.A @ state)[0] == pytest.approx(wanted, abs=1e-10)


def test_a_law_that_is_scheduled_by_the_share_follows_the_effort(tmp_path: Path) -> None:
    """Gains 1 and 3 at the ends of the share: the command is that of the blend of both."""
    plant = plant_of(tmp_path)
    model = blended_model(plant)
    shares = [rule[0] for rule in model.rules]
    gains = np.array([[[0.0, 1.0 + 2.0 * corner]] for corner in shares])
    law = PdcLaw(model, gains, np.zeros(2), np.zeros(1))
    assert model.premises[0].name == "high_share"
    low, high = (float(end) for end in (model.premises[0].lower, model.premises[0].upper))

    for effort in (-3.0, -0.2, 1e-13, 0.4, 3.0):
        share = (max(effort - 0.5, 0) + min(max(effort + 0.5, 0), 1) ** 2 / 2 - 0.125) / effort
        share = 0.5 if abs(effort) < 1e-6 else share
        weight = (share - low) / (high - low)
        command = law.command(np.array([0.0, effort]))
        assert command[0] == pytest.approx(-(1 + 2 * weight) * effort, abs=1e-9)


def test_an_error_of_no_actuator_is_refused(tmp_path: Path) -> None:
    plant = plant_of(tmp_path)
    blending = blending_of(plant)
    assert blending is not None

    with pytest.raises(ModelError, match="error of fan: the blended actuators are cooling and"):
        RunTimeBlending(blending, {"fan": 0.1})


def psi(s: float, e: float) -> float:
    return max(s - e, 0.0) + min(max(s + e, 0.0), 2 * e) ** 2 / (4 * e)


def split_range(x: Floats, wrong: Floats) -> list[float]:
    """Energy balances of tank and jacket; cooling 0.1 kg/s and heating 0 at rest."""
    T, Tj, _, U = x
    cooling, heating = psi(-U, 1e4) / (4e3 * (Tj - 290)), psi(U, 1e4) / (4e3 * (380 - Tj))
    cooling, heating = 0.1 + (1 + wrong[0]) * (cooling - 0.1), (1 + wrong[1]) * heating
    reaction = 2e4 * np.exp(7000 / 350 - 7000 / T)
    return [
        (2e3 * (Tj - T) + reaction) / 4e6,
        (2e3 * (T - Tj) - 4e3 * cooling * (Tj - 290) + 4e3 * heating * (380 - Tj)) / 8e5,
        T - 350,
        0.0,
    ]


def boost_throttle(x: Floats, wrong: Floats) -> list[float]:
    """Filling through the throttle, charger with a lag; 5 kPa/s each at rest."""
    pm, d, _, U = x
    at = 1 - 5e3 / (20 * 17e3), 5e3 / (20 * 80e3)
    throttle, boost = 1 - psi(-U, 2e4) / (20 * 17e3), psi(U, 2e4) / (20 * 80e3)
    throttle = at[0] + (1 + wrong[0]) * (throttle - at[0])
    boost = at[1] + (1 + wrong[1]) * (boost - at[1])
    filling = 20 * throttle * d - 4 * pm
    return [filling, (100.5e3 + 80e3 * boost - pm - d) / 0.5 - filling, pm - 83.75e3, 0.0]


FIELDS: dict[str, Callable[[Floats, Floats], list[float]]] = {
    "split_range": split_range,
    "boost_throttle": boost_throttle,
}


@pytest.mark.parametrize("name", FIELDS)
@settings(max_examples=15)
@given(shares=st.lists(st.floats(0, 1), min_size=6, max_size=6))
def test_model_and_running_plant_equal_the_equations(name: str, shares: list[float]) -> None:
    plant, model = library_plants.plant_of(name), library_plants.library_model(name)
    blending = blending_of(plant)
    assert blending is not None
    sides = [v.range for v in plant.states]
    x = np.array([
        float(side.lower) + share * float(side.width)
        for side, share in zip(sides, shares, strict=False)
        if side is not None
    ])  # fmt: skip
    wrong = 0.2 * np.array(shares[4:]) - 0.1
    names = [a.name for a in blending.actuators]
    errors = dict(zip(names, wrong, strict=True))
    running = RunTimeBlending(blending, errors)
    wanted = FIELDS[name](x, wrong)
    size = 1e-9 * np.abs(wanted).max() + 1e-12

    rate = running.disturbed_rate(())(x, np.zeros(1), np.zeros(0))
    np.testing.assert_allclose(rate, wanted, rtol=1e-9, atol=size)
    rest = np.array([float(v.rest) for v in plant.states])
    labels = [label.split(" [")[0] for label in model.states]
    point = dict(zip(labels, x - rest, strict=True)) | running.signals(x)
    point |= {f"{one}_error": error for one, error in errors.items()}
    values = model.premise_values(**point, effort_rate=0.0)
    h = model.memberships(values, clip=True)
    assert h.min() >= 0 and h.sum() == pytest.approx(1, abs=1e-12)
    moved = model.blend(values, clip=True).A @ (x - rest)
    np.testing.assert_allclose(moved, wanted, rtol=1e-9, atol=1e-9 * np.abs(x - rest).max())


@pytest.mark.parametrize("name", FIELDS)
def test_it_rests_where_the_file_says(name: str) -> None:
    plant = library_plants.plant_of(name)
    rest = np.array([float(v.rest) for v in plant.states])

    np.testing.assert_allclose(FIELDS[name](rest, np.zeros(2)), 0, atol=1e-9)


@pytest.mark.parametrize(("name", "rules"), [("split_range", 16), ("boost_throttle", 16)])
def test_number_of_rules(name: str, rules: int) -> None:
    assert len(library_plants.library_model(name).rules) == rules


BAD = {
    "no overlap": (
        "overlap = 0.5 -> overlap = 0",
        r"blending.effort.overlap'.*the share of the actuators would jump.*give a positive one",
    ),
    "a hole": (
        "overlap = 0.5 -> overlap = -0.5",
        r"blending.effort.overlap'.*between -0.5 and 0.5 no actuator would act: a hole",
    ),
    "no overlap at all": ("overlap = 0.5, -> ", r"blending.effort.overlap': is missing"),
    "no direction": ("direction = -1, -> ", r"blending.low.direction': is missing; add it"),
    "a direction that is none": ("direction = -1 -> direction = 2", r"blending.low.direction'"),
    "the wrong direction": (
        "direction = -1 -> direction = 1",
        r"blending.low.input': cooling acts by going down from its rest, 0, .*end of its range",
    ),
    "no such input": (
        'input = "heating" -> input = "heatin"',
        r"blending.high.input': heatin is no input \(did you mean 'heating'\?\)",
    ),
    "one input for both": (
        'input = "heating" -> input = "cooling"',
        r"blending.high': cooling is the low actuator already",
    ),
    "an actuator that does nothing": (
        " + (2 + x)*heating -> ",
        r"blending.high.input': no equation contains heating: where it should act, nothing does",
    ),
    "an effectiveness that vanishes": (
        '"2 + x", error -> "0.5 + x", error',
        r"blending.high.effectiveness': x \+ 1/2 is -0.5 at x = -1; there heating moves nothing",
    ),
    "an effectiveness that just vanishes": (
        '"2 + x", error -> "1 + x", error',
        r"blending.high.effectiveness': x \+ 1 is 0 at x = -1",
    ),
    "an effectiveness without a box": (
        "x = { range = [-1, 1] } -> x = {}",
        r"blending.high.effectiveness': it depends on x, which has no range",
    ),
    "an effectiveness of the effort": (
        '"2 + x", error -> "2 + effort", error',
        r"blending.high.effectiveness'.*'effort' is not known",
    ),
    "an effectiveness of an actuator": (
        '"2 + x", error -> "2 + cooling", error',
        r"blending.high.effectiveness': cooling stands in it; states, signals and parameters may",
    ),
    "beyond the limits of an actuator": (
        "heating = { range = [0, 3] } -> heating = { range = [0, 2.9] }",
        r"blending.effort.range': at its upper end heating would have to go 3 from where it idles "
        r"at x = -1, and its range leaves 2.9.*up to 2.9 on that",
    ),
    "an effort to one side": (
        "range = [-3, 3], overlap -> range = [0, 3], overlap",
        r"blending.effort.range'.*below 0 the low actuator acts, above 0 the high one",
    ),
    "an error of the whole": (
        "error = 0.2 -> error = 1",
        r"blending.high.error': 1 was given; a share from 0 up to but not 1",
    ),
    "a name that is taken": (
        "a = { value = 0.5 } -> a = { value = 0.5 }\nshare = { value = 1 }",
        r"share is used more than once",
    ),
    "discrete time": ('units = "unchecked" -> sample_time = 1', r"discrete time"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_blend_is_refused_with_place_and_cure(name: str, tmp_path: Path) -> None:
    change, words = BAD[name]

    with pytest.raises(ModelError, match=words):
        plant_of(tmp_path, a=change)


def test_what_just_fits_is_read(tmp_path: Path) -> None:
    """The other side of two thresholds: 3 at x = -1, and an effectiveness of 1/100 there."""
    assert plant_of(tmp_path).blending is not None
    weak = plant_of(
        tmp_path,
        a='"2 + x", error -> "1.01 + x", error',
        b="heating = { range = [0, 3] } -> heating = {}",
    )
    assert weak.blending is not None


def test_units_of_the_effectiveness_have_to_fit(tmp_path: Path) -> None:
    """Effort in W, heating in kg/s: W per kg/s is needed, not K kg."""
    text = (data_folder() / "split_range.toml").read_text(encoding="utf-8")

    words = (
        r"blending.high.effectiveness': it has the unit kg K; times the input's kg/s that is not"
    )
    with pytest.raises(ModelError, match=words):
        plant_of(tmp_path, text, a='"cp*(Thot - Tj)" -> "m*(Thot - Tj)"')
