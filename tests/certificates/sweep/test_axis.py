"""Axes as they are written: values, units, and one clear message for each mistake."""

from __future__ import annotations

import pytest

from takagi.certificates.sweep.points import AxisKind
from takagi.certificates.sweep.sweep import Axis, parse_axes
from takagi.models import ModelError

KINDS = (
    AxisKind("speed-overlap", "rad/s"),
    AxisKind("torque-overlap", "N m"),
    AxisKind("share", "-", highest=0.5),
)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("speed-overlap=0.02:0.2:3", (0.02, 0.11, 0.2)),
        ("speed-overlap=1:2:4", (1.0, 1.33333333, 1.66666667, 2.0)),
        ("speed-overlap=0.05", (0.05,)),
        ("speed-overlap= .05 , 1e-1 ", (0.05, 0.1)),
        ("torque-overlap=0.5kNm:5kN m:2", (500.0, 5000.0)),
        ("torque-overlap=500 N m,5kNm", (500.0, 5000.0)),
        ("speed-overlap=3deg/s", (0.0523598775598,)),
        ("share=0.5", (0.5,)),
    ],
)
def test_values(text: str, values: tuple[float, ...]) -> None:
    """Ranges, lists and units give short decimals in SI."""
    (axis,) = parse_axes([text], KINDS)
    assert axis.values == values
    assert axis == Axis(text.partition("=")[0], axis.unit, values)


@pytest.mark.parametrize(
    ("texts", "parts"),
    [
        (["sped-overlap=1"], ["'sped-overlap'", "did you mean 'speed-overlap'", "share [-]"]),
        (["wind=1:2:3"], ["'wind' cannot be swept", "speed-overlap [rad/s], torque-overlap [N m]"]),
        (["share=0.1", "share=0.2"], ["share was given before"]),
        (["share"], ["--over share: write share=LOW:HIGH:COUNT"]),
        (["share=0.1:0.2"], ["write share=LOW:HIGH:COUNT"]),
        (["share=0.1:0.2:1"], ["whole number from 2 to 100000"]),
        (["share=0.1:0.2:2.5"], ["'2.5'", "whole number"]),
        (["share=0.2:0.1:3"], ["0.2 is followed by", "must increase"]),
        (["share=0.1:0.1:3"], ["must increase"]),
        (["share=0.2,0.1"], ["0.2 is followed by 0.1", "must increase"]),
        (["share=0.1,x"], ["'x' is not a number"]),
        (["share=nan"], ["'nan' is not a number"]),
        (["share=1e999"], ["is not a number"]),
        (["share=0.1:0.6:3"], ["0.6", "above 0 and at most 0.5"]),
        (["share=0"], ["above 0"]),
        (["torque-overlap=0.1rad/s"], ["'rad/s' does not fit", "'kN m'"]),
        (["torque-overlap=5lbf"], ["'lbf' is not known"]),
        (["share=0.1:0.2:100001"], ["100001"]),
        (["share=0.1:0.2:400", "speed-overlap=1:2:400"], ["160000 points", "100000"]),
    ],
)
def test_mistakes(texts: list[str], parts: list[str]) -> None:
    """Each mistake names what was given, and what is needed."""
    with pytest.raises(ModelError) as raised:
        parse_axes(texts, KINDS)
    for part in parts:
        assert part in str(raised.value)
