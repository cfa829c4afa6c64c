"""Blends that cannot work are refused where the file says them, with what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from takagi.models import ModelError
from takagi.models.files.library import data_folder
from tests.models.blending.plants import plant_of

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
