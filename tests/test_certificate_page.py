"""README and pages promise no more than the recorded default certificate proves."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import Verdict, check
from takagi.certificates.checker.kernel.reader import number, read_json
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range

ROOT = Path(__file__).resolve().parents[1]
STORED = ROOT / "docs" / "figures" / "nrel5mw-certificate.json"
PAGE = (ROOT / "docs" / "certificate.md").read_text(encoding="utf-8")
RPM = Fraction("9.54929658551372")
# How far a page may stay below what is proved: two digits of a number that begins with 1.
NEAR = Fraction(9, 10)


@pytest.fixture(scope="module")
def stored() -> Any:
    return read_json(STORED)


def column(stored: Any, name: str) -> list[Fraction]:
    return [number(cell, name, "cell") for cell in stored["claims"][0]["cells"]]


def at(stored: Any, name: str, wind: Fraction) -> Fraction:
    """Return the number of the cell of a wind; of two at a node the upper's, as the theorem says."""
    cells = stored["claims"][0]["cells"]
    nodes = [Fraction(str(node)) for node in stored["gains"]["wind"]]
    k = next(k for k in reversed(range(len(cells))) if nodes[k] <= wind)
    return number(cells[k], name, "cell")


def ranges(stored: Any) -> list[Range]:
    return [Range.read(one, "range") for one in stored["claims"][1]["ranges"]]


def row(title: str) -> tuple[list[Fraction], list[Fraction]]:
    """Return winds and numbers of the row of a table of the page whose title begins so."""
    lines = PAGE.splitlines()
    k = next(k for k, line in enumerate(lines) if line.startswith(f"| {title}"))
    head = next(i for i in range(k, 0, -1) if lines[i].startswith("| wind"))
    first, second = (
        [Fraction(cell.strip()) for cell in lines[i].strip("|").split("|")[1:]] for i in (head, k)
    )
    return first, second


def test_the_stored_certificate_is_proved() -> None:
    found = check(STORED, model=ROOT / "models" / "data" / "nrel5mw.toml")

    assert found.verdict is Verdict.PROVED
    assert [claim["kind"] for claim in read_json(STORED)["claims"]] == [
        "coherent-loop",
        "wind-rate",
        "bumpless",
        "running-loop",
    ]
    assert "wind filter of 12 s" in found.claims[1].text
    drive = ("pitch not below its lower limit", "no lag of torque", "drive of first order")
    assumed = [
        (*drive, "v_s within the law's tables", "no states of wake", "continuous time"),
        ("what the claim of that assumes",),
        ("what the claim about these assumes",),
        (*drive, "schedule wind within the law's tables", "where the law commands", "rigid"),
    ]
    for claim, words in zip(found.claims, assumed, strict=True):
        assert [one for one in words if one not in claim.text] == [], claim.name


def test_the_pages_say_at_which_winds_the_running_loop_is_proved(stored: Any) -> None:
    claim = next(claim for claim in stored["claims"] if claim["kind"] == "running-loop")
    assert [[Fraction(end) for end in row] for row in claim["winds"]] == [[3, 25]]
    for name in ("docs/certificate.md", "docs/running-loop.md", "README.md"):
        page = " ".join((ROOT / name).read_text(encoding="utf-8").split())
        assert "at every constant wind from 3 to 25 m/s" in page, name
        if name != "README.md":
            assert f"in {len(claim['cells'])} cells" in page, name
            assert f"{claim['decay_rate']} 1/s" in page, name


@pytest.mark.parametrize(
    ("title", "name"), [("δ: wind off", "wind_error"), ("ρ: schedule wind", "wind_rate")]
)
def test_the_table_of_the_wind_class_is_not_above_it(stored: Any, title: str, name: str) -> None:
    winds, numbers = row(title)
    for wind, told in zip(winds, numbers, strict=True):
        proved = at(stored, name, wind)
        assert NEAR * proved <= told <= proved, (float(wind), float(told), float(proved))


def test_the_table_of_the_winds_rate_is_not_above_it(stored: Any) -> None:
    winds, numbers = row("r: wind moves")
    for wind, told in zip(winds, numbers, strict=True):
        first = ranges(stored)[0]
        proved = first.at(first.estimate, wind)
        assert NEAR * proved <= told <= proved, (float(wind), float(told), float(proved))


def overspeed(stored: Any) -> Fraction:
    rated = number(stored["model"], "rated_rotor_speed", "model")
    fastest = max(Fraction(str(speed)) for speed in stored["gains"]["rotor_speed"])
    peak = number(stored["claims"][0]["peaks"], "speed_error", "peaks")
    return 100 * ((fastest + peak) / rated - 1)


def from_wind(stored: Any, name: str, wind: str) -> Fraction:
    cells = stored["claims"][0]["cells"]
    high = [number(cell, name, "") for cell in cells if Fraction(str(cell["wind"][1])) > 13]
    assert wind == "13"
    return min(high)


def peak(name: str) -> Callable[[Any], Fraction]:
    return lambda stored: number(stored["claims"][0]["peaks"], name, "peaks")


def torque(stored: Any) -> Fraction:
    return max(number(cell, "torque_rate", "") for cell in stored["claims"][2]["cells"]) / 1000


# Page, sentence with the number, what is proved, and whether it is a bound from above.
# ruff: noqa: E501
SENTENCES: list[tuple[str, str, Callable[[Any], Fraction], bool]] = [
    ("README.md", r"([\d.]+) to [\d.]+ m/s of wind error", lambda s: min(column(s, "wind_error")), False),
    ("README.md", r"[\d.]+ to ([\d.]+) m/s of wind error", lambda s: max(column(s, "wind_error")), False),
    ("README.md", r"([\d.]+) to [\d.]+ m/s²\. Turbulence", lambda s: min(ranges(s)[0].estimate), False),
    ("README.md", r"to ([\d.]+) m/s²\. Turbulence", lambda s: max(ranges(s)[0].estimate), False),
    ("README.md", r"most ([\d.]+) % above rated for", overspeed, True),
    ("docs/certificate.md", r"speed within ([\d.]+) rad/s", peak("speed_error"), True),
    ("docs/certificate.md", r"rad/s \(([\d.]+) rpm\)", lambda s: RPM * peak("speed_error")(s), True),
    ("docs/certificate.md", r"has not delivered yet within ([\d.]+) rad/s²", peak("effort_lag"), True),
    ("docs/certificate.md", r"the integrator within ([\d.]+) rad/s", peak("integral"), True),
    ("docs/certificate.md", r"rotor speed at most ([\d.]+) % above", overspeed, True),
    ("docs/certificate.md", r"at ([\d.]+) 1/s in one quadratic function", lambda s: number(s["claims"][0]["settling"], "decay_rate", ""), False),
    ("docs/certificate.md", r"at ([\d.]+) 1/s at 3 m/s", lambda s: at(s, "decay_rate", Fraction(3)), False),
    ("docs/certificate.md", r"([\d.]+) at rated wind and", lambda s: min(at(s, "decay_rate", w) for w in (Fraction("11.4"), Fraction("11.5"))), False),
    ("docs/certificate.md", r"and ([\d.]+) at 25 m/s", lambda s: at(s, "decay_rate", Fraction(25)), False),
    ("docs/certificate.md", r"known wind that moves at ([\d.]+) to", lambda s: min(ranges(s)[0].estimate), False),
    ("docs/certificate.md", r"known wind that moves at [\d.]+ to ([\d.]+) m/s²", lambda s: max(ranges(s)[0].estimate), False),
    ("docs/certificate.md", r"From 13 m/s on δ is at least ([\d.]+) m/s", lambda s: from_wind(s, "wind_error", "13"), False),
    ("docs/certificate.md", r"stay above ([\d.]+) m/s, an estimate", lambda s: ranges(s)[1].wind[0], True),
    ("docs/certificate.md", r"an estimate that moves at up to ([\d.]+) m/s²", lambda s: min(ranges(s)[1].estimate), False),
    ("docs/certificate.md", r"may be off by\s+([\d.]+) m/s", lambda s: ranges(s)[1].error, False),
    ("docs/certificate.md", r"torque asked for at most at ([\d.]+) kN m/s", torque, True),
    ("docs/cli.md", r"wind within ([\d.]+) to", lambda s: min(column(s, "wind_error")), False),
    ("docs/cli.md", r"wind within [\d.]+ to ([\d.]+) m/s", lambda s: max(column(s, "wind_error")), False),
    ("docs/cli.md", r"rpm, ([\d.]+) % above the rated", overspeed, True),
    ("docs/cli.md", r"settling [^;]*? decay rate >= ([\d.]+) 1/s", lambda s: number(s["claims"][0]["settling"], "decay_rate", ""), False),
]  # fmt: skip


@pytest.mark.parametrize(
    ("page", "sentence", "of", "above"), SENTENCES, ids=[f"{p}-{s}" for p, s, *_ in SENTENCES]
)
def test_a_sentence_promises_no_more_than_is_proved(
    stored: Any, page: str, sentence: str, of: Callable[[Any], Fraction], above: bool
) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    found = {Fraction(told) for told in re.findall(sentence, re.sub(r"\s+", " ", text))}
    proved = of(stored)

    assert len(found) == 1
    told = found.pop()
    if above:
        assert proved <= told <= proved / NEAR
    else:
        assert NEAR * proved <= told <= proved
