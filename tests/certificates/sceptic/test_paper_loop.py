"""The checker's brackets of the paper's loop hold what the law itself does, wherever it is looked.

Boxes are drawn over the whole range of winds, on the ramp in speed, at the rounded corner of the
torque and at the limits of pitch, and held against the law and the plant in floats.
"""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.certificates.checker import read_text
from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.turbine.published.inputs import STATES, Overlaps, PublishedLaw
from takagi.certificates.checker.turbine.published.loop import Ends, Loop
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.checker.words import published as words
from takagi.certificates.document.certificate_file import (
    published_law_data,
    turbine_data,
)
from takagi.models import nrel5mw
from takagi.models.laws.published import law as model
from takagi.models.laws.published.regional_schedule import coupling_filter, regional_schedule
from takagi.models.ramps import Shape
from tests.certificates.kinds.claims import sealed
from tests.certificates.recorded.inputs import read_law
from tests.paper_models import loop_rate, regional_models

Floats = NDArray[np.float64]
TURBINE = nrel5mw()
SHAPES: tuple[Shape, Shape] = ("smooth", "linear")
# Some boxes leave the coefficient table.
BOXES, FEWEST, POINTS = 24, 18, 10


@cache
def law_of(shape: Shape) -> model.PublishedLaw:
    partial = regional_schedule(
        TURBINE,
        regional_models()[0],
        k_x=np.repeat([-60_000.0, -95_000.0], 2)[:, None],
        k_I=np.repeat([-12_000.0, -6_000.0], 2),
    )
    full = regional_schedule(
        TURBINE,
        regional_models()[1],
        k_x=np.repeat([[-0.2, -0.3], [-0.4, -0.5], [-0.6, -0.2], [-0.1, -0.7]], 2, 0),
        k_I=np.repeat([-0.05, -0.09, -0.07, -0.12], 2),
    )
    return model.published_law(
        TURBINE,
        partial=partial,
        full=full,
        coupling=coupling_filter(TURBINE, shape=shape, speed_overlap=0.125),
    )


@cache
def read_of(shape: Shape) -> tuple[Plant, PublishedLaw]:
    from json import dumps

    document = sealed(turbine_data(TURBINE, ()), published_law_data(law_of(shape)), {})
    data = read_text(dumps(document), "certificate")
    # A drive of any speed, so that boxes far from rest are not refused for the limit of its rate.
    plant = replace(Plant.read(data["model"]), rate_limit=Fraction(1000))
    return plant, PublishedLaw.read(data["gains"])


def drawn(rng: np.random.Generator, law: PublishedLaw, asked: float) -> Ends:
    """Return a short span of winds, and a box near where the regions meet or anywhere.

    The integral is such that the torque command lies about its corners and limits; it is ``asked``
    times as large.
    """
    near_rated = rng.random() < 0.5
    v = rng.uniform(10.5, 12.5) if near_rated else rng.uniform(4.0, 24.0)
    reference = min(float(law.setpoint), float(law.optimal_ratio) * v / TURBINE.rotor_radius)
    pitch = max(0.0, rng.uniform(-0.02, 0.06) if v < 13 else rng.uniform(0.05, 0.4))
    torque = float(law.rated_torque) + rng.uniform(-3000, 3000) if v > 11 else rng.uniform(0, 4e4)
    first = [reference + rng.uniform(-0.06, 0.06), pitch, -torque / 9000]
    first[-1] *= asked
    last = [a + rng.uniform(-1, 1) * 0.002 * max(abs(a), 0.1) for a in first]
    last[1] = max(last[1], 0.0)
    size = 10 ** rng.uniform(-2, 0)
    widths = [size * width for width in (0.02, 0.01, 0.2)]

    def exact(values: list[float]) -> list[Fraction]:
        return [Fraction(round(value * 10**6), 10**6) for value in values]

    start, stop = exact([v, v + rng.uniform(0.001, 0.05)])
    return Ends((start, stop), (exact(first), exact(last)), exact(widths))


def points(rng: np.random.Generator, ends: Ends, wind: float, lowest: float) -> Floats:
    v1, v2 = (float(v) for v in ends.wind)
    first, last = (np.array([float(x) for x in z]) for z in ends.states)
    centre = first + (wind - v1) / (v2 - v1) * (last - first)
    shares = np.clip(rng.uniform(-1.4, 1.4, (POINTS, len(centre))), -1, 1)
    found = centre + shares * np.array([float(r) for r in ends.widths])
    found[:, 1] = np.maximum(found[:, 1], lowest)
    return np.asarray(found)


def bracket(pair: tuple[int, int]) -> tuple[float, float]:
    return pair[0] / ONE, pair[1] / ONE


def outside(value: float, low: float, high: float) -> float:
    """Return by how much a float leaves its bracket, with room for the secants' own rounding."""
    return max(low - value, value - high) - 1e-6 * (1 + abs(value))


def violations(shape: Shape, seed: int, asked: float = 1.0) -> tuple[list[Any], int]:
    rng = np.random.default_rng(seed)
    law, (plant, read) = law_of(shape), read_of(shape)
    found: list[Any] = []
    looked = 0
    for _ in range(BOXES):
        ends = drawn(rng, read, asked)
        overlaps: Overlaps = read.overlaps
        try:
            loop = Loop(plant, read, overlaps, ends, "states")
            values = [bracket(rate.value) for rate in loop.rates()]
            choices = [loop.rates(*choice) for choice in loop.choices()]
        except Refused:
            continue
        looked += 1
        wind = float(rng.uniform(float(ends.wind[0]), float(ends.wind[1])))
        states = points(rng, ends, wind, float(read.pitch_min))
        rates = np.array([loop_rate(law, wind, z) for z in states])
        for i, (low, high) in enumerate(values):
            found += [(ends, "value", i) for f in rates[:, i] if outside(f, low, high) > 0]
        widths = np.array([float(r) for r in ends.widths])
        for (a, fa), (b, fb) in zip(
            zip(states, rates, strict=True), zip(states[1:], rates[1:], strict=False), strict=False
        ):
            step = (a - b) / widths
            for i in range(STATES):
                spans = [
                    [sorted(s * y for s in bracket(slope))
                     for slope, y in zip(rows[i].slopes, step, strict=True)]
                    for rows in choices
                ]  # fmt: skip
                low = min(sum(span[0] for span in row) for row in spans)
                high = max(sum(span[1] for span in row) for row in spans)
                if outside(fa[i] - fb[i], low, high) > 0:
                    found.append((ends, "slope", i, fa[i] - fb[i], low, high))
    return found, looked


@pytest.mark.parametrize("asked", [1.0, 40.0], ids=["about the limits", "beyond the upper one"])
@pytest.mark.parametrize("shape", SHAPES)
def test_law_and_its_differences_lie_in_the_brackets(shape: Shape, asked: float) -> None:
    """The pitch that is asked for may lie beyond its upper limit, of which the integral learns."""
    found, looked = violations(shape, seed=11, asked=asked)

    assert found == []
    assert looked >= FEWEST


def test_brackets_are_not_so_wide_that_anything_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the two weights of full load exchanged points leave."""
    weights = vars(Loop)["full_weights"].func
    monkeypatch.setattr(Loop, "full_weights", property(lambda self: weights(self)[::-1]))

    assert violations(SHAPES[0], seed=11)[0]


@pytest.mark.parametrize("shape", SHAPES)
def test_the_ramp_over_speed_has_its_values_and_slopes(shape: Shape) -> None:
    """Speeds below, on and above the ramp and across both corners: its quotients, and no more."""
    plant, law = read_of(shape)
    start, width = float(law.overlaps.start), float(law.overlaps.width)

    def ramp(speed: Floats) -> Floats:
        s = np.clip((speed - start) / width, 0, 1)
        return np.asarray(s if shape == "linear" else s * s * (3 - 2 * s))

    for low, high in [(-9, -1), (-3, 4), (2, 7), (6, 8), (-2, 12), (7, 13), (10, 12), (11, 15)]:
        middle = Fraction(round((start + (low + high) / 20 * width) * 10**6), 10**6)
        half = Fraction(round((high - low) / 20 * width * 10**6), 10**6)
        states = [middle, Fraction(0), *[Fraction(0)] * (STATES - 2)]
        widths = [half, *[Fraction(1, 1000)] * (STATES - 1)]
        wind = (Fraction(12), Fraction("12.01"))
        share = Loop(plant, law, law.overlaps, Ends(wind, (states, states), widths), "states").share
        omega = np.linspace(float(middle - half), float(middle + half), 60)
        values, slopes = ramp(omega), np.diff(ramp(omega)) / np.diff(omega)
        for found, exact in ((share.value, values), (share.slopes[0], slopes * float(half))):
            least, most = bracket(found)
            assert least <= exact.min() + 1e-9 and exact.max() - 1e-9 <= most


DECIMALS = st.integers(1, 10**13).map(lambda k: Fraction(k, 10**12))


@given(st.lists(DECIMALS, min_size=4, max_size=6, unique=True), DECIMALS)
def test_windows_of_one_width_are_not_moved(starts: list[Fraction], width: Fraction) -> None:
    """A rounded lower end would move the window, and its upper end out of what is proved."""
    ordered = sorted(starts)
    said = words.winds_words([(low, low + width) for low in ordered])
    shown, listed = said.split(" m/s wide from ")

    assert Fraction(shown.removeprefix("in windows ")) <= width
    named = [Fraction(number) for number in re.findall(r"[\d.]+(?:e[+-]?\d+)?", listed)]
    runs = "in steps of" in listed
    assert runs or named == ordered


def test_steps_between_windows_are_not_rounded() -> None:
    step = Fraction("0.1000000001")
    said = words.winds_words([(3 + k * step, 3 + k * step + Fraction(1, 50)) for k in range(5)])

    assert said == "in windows 0.02 m/s wide from 3 to 3.4000000004 in steps of 0.1000000001"


def test_overlaps_are_named_as_they_are() -> None:
    overlaps = Overlaps(Fraction(1), Fraction("0.1000000001"), Fraction("2000.0004"))

    assert "0.1000000001 rad/s" in words._words(overlaps)
    assert "2000.0004 N m" in words._words(overlaps)


def test_winds_that_are_left_out_are_told() -> None:
    data = read_law("paper")
    claim = {**data["claims"][0], "cells": [], "winds": [[Number("5"), Number("6")]]}

    def said(unproved: list[dict[str, list[Number]]]) -> str:
        stated = {**claim, "unproved": unproved}
        return replay(stated, data, None, [], "here").in_words().text

    ends = "not proved: 5 to 6 m/s, where no stated cell holds"
    assert said([]).endswith(ends)
    unproved = [{"wind": [Number("3"), Number("4")]}]
    assert said(unproved).endswith(f"{ends}; looked at but not claimed: 3 to 4 m/s")


@pytest.mark.parametrize("side", [1, -1])
def test_the_width_of_the_set_is_added_to_how_far_its_centre_is(side: int) -> None:
    """Pitch of the tables is zero here: 1.5 degrees off and 0.4 wide is near, 0.6 wide is not."""
    law = PublishedLaw.read(read_law("paper")["gains"])
    partial, full = (
        replace(region, pitch=[Fraction(0)] * len(region.pitch))
        for region in (law.partial, law.full)
    )
    flat, degree = replace(law, partial=partial, full=full), Fraction(1745, 100000)

    def near(width: Fraction) -> bool:
        z = [Fraction(1), side * degree * Fraction(3, 2), Fraction(0)]
        ends = Ends((Fraction(8), Fraction(9)), (z, z), [Fraction(0), width, Fraction(0)])
        return words._near_trim_pitch(flat, ends)

    assert near(degree * Fraction(2, 5))
    assert not near(degree * Fraction(3, 5))
