"""The claim about the effort-sharing loop: it proves, and breaks wherever it is made false."""

from __future__ import annotations

import random
from bisect import bisect_right
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, Verdict, check, check_document
from takagi.certificates.checker.turbine.effort_sharing.corners import BOUNDS, RANGES
from takagi.certificates.claims.turbine.effort_sharing import (
    DEFAULT_UNCERTAINTY,
    effort_sharing_candidate,
    effort_sharing_claim,
)
from takagi.certificates.cross_check.comparison import cross_checked_document
from takagi.certificates.document.certificate_file import certificate_document, dumps
from takagi.models import Interval
from tests.certificates.kinds.claims import resealed

Document = dict[str, Any]


def verdict(document: Document) -> Verdict:
    return check_document(document).verdict


def outcome(document: Document) -> str:
    """Return the verdict on a forger's certificate, or "refused"."""
    try:
        return verdict(resealed(document)).name
    except CertificateError:
        return "refused"


def test_the_whole_certificate_is_proved(built: Any, tmp_path: Path) -> None:
    """The emitted file proves for every wind from cut-in to cut-out, read back from disk."""
    path = tmp_path / "certificate.json"
    path.write_text(dumps(built.document), encoding="utf-8")

    checked = check(path)

    assert checked.verdict is Verdict.PROVED, checked.claims[0].text
    assert "winds 3 to 25 m/s" in checked.claims[0].text
    assert len(checked.messages) == 2, "embedded copies alone were checked: it has to say so"


def test_the_short_certificate_is_proved(short: Document) -> None:
    """Six cells of the same numbers are a certificate of their own."""
    assert verdict(short) is Verdict.PROVED


def test_the_name_is_the_checkers_own(short: Document) -> None:
    """A forged name does not reach the reader: the claim is named by what was checked."""
    short["claims"][0]["name"] = "stable in every wind"
    short["claims"][0]["uncertainty"]["frozen_wake"] = False

    claim = check_document(resealed(short)).claims[0]

    assert claim.verdict is Verdict.PROVED
    assert (
        claim.name
        == f"effort-sharing loop, {claim.text.split(' m/s')[0][6:]} m/s, equilibrium wake"
    )


def test_a_wrong_power_coefficient_has_to_be_in_the_ranges(short: Document) -> None:
    """Claimed beside ranges that were enclosed for the table's own c_P it is not proved."""
    short["claims"][0]["uncertainty"]["power_coefficient"] = [0.999, 1.001]

    claim = check_document(resealed(short)).claims[0]

    assert claim.verdict is Verdict.UNDECIDED
    assert "leaves the stated range" in claim.text or "exceeds the stated bound" in claim.text


@pytest.mark.parametrize("range_", [[0.0, 1.0], [1.01, 1.02], [0.98, 0.99], [1.0]])
def test_power_coefficients_around_the_table_are_needed(
    range_: list[float], short: Document
) -> None:
    """The law's trim is the table's, so the interval has to hold 1."""
    short["claims"][0]["uncertainty"]["power_coefficient"] = range_

    assert outcome(short) == "refused"


def test_a_file_without_a_power_coefficient_speaks_of_the_table(short: Document) -> None:
    """It says the same as one that states the table's, and does not mention another."""
    stated = check_document(short).claims[0].text
    del short["claims"][0]["uncertainty"]["power_coefficient"]

    claim = check_document(resealed(short)).claims[0]

    assert claim.verdict is Verdict.PROVED
    assert claim.text == stated and "of the table's c_P" not in claim.text


@pytest.mark.slow
def test_one_per_cent_of_power_is_proved_and_two_are_not(built: Any) -> None:
    """From both sides: near rated wind 2 % of the torque is more than the set holds."""
    for wrong, expected in ((1, Verdict.PROVED), (2, Verdict.UNDECIDED)):
        around = Interval.of(f"0.{100 - wrong}", f"1.{wrong:02d}")
        uncertainty = replace(DEFAULT_UNCERTAINTY, power_coefficient=around)
        candidate = effort_sharing_candidate(built.turbine, built.law, uncertainty=uncertainty)
        sealed = certificate_document(
            model=built.document["model"],
            gains=built.document["gains"],
            claims=[effort_sharing_claim(candidate)],
            provenance={},
        )
        claim = check_document(sealed).claims[0]

        assert claim.verdict is expected
        if expected is Verdict.PROVED:
            assert "c_P 0.99 to 1.01 of the table's" in claim.text
            assert cross_checked_document(sealed).agrees


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every number, text and truth value."""
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from leaves(value[key], (*path, key))
    else:
        yield path


def holder(document: Document, path: tuple[Any, ...]) -> Any:
    found: Any = document
    for key in path[:-1]:
        found = found[key]
    return found


def changed(value: Any) -> Any:
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return value + "!"
    return value + 1e-7 if value else 1e-12


def test_any_change_with_the_old_hashes_is_refused(short: Document) -> None:
    """No number, text or truth value of model, gains or claims is outside the hashes."""
    parts = ("model", "gains", "claims")
    paths = [path for path in leaves(short) if path[0] in parts]
    coefficients = [path for path in paths if "coefficients" in path]
    others = [path for path in paths if "coefficients" not in path]
    rng = random.Random(1)
    for path in rng.sample(others, 150) + rng.sample(coefficients, 20):
        place = holder(short, path)
        before = place[path[-1]]
        place[path[-1]] = changed(before)
        with pytest.raises(CertificateError, match="hash differs"):
            check_document(short)
        place[path[-1]] = before
    assert verdict(short) is Verdict.PROVED


@pytest.mark.parametrize("k", [0, 3, 5])
@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("name", RANGES)
def test_a_smaller_range_is_not_proved(name: str, end: int, k: int, short: Document) -> None:
    """The stated ranges are the enclosures: a millionth less at either end is too little."""
    stated = short["claims"][0]["cells"][k][name]
    stated[end] = round(stated[end] + (1e-6 if end == 0 else -1e-6), 7)

    assert outcome(short) == "UNDECIDED"


@pytest.mark.parametrize("name", BOUNDS)
def test_a_smaller_size_is_not_proved(name: str, short: Document) -> None:
    """The stated sizes are the enclosures: a millionth less is too little."""
    cell = short["claims"][0]["cells"][2]
    cell[name] = round(cell[name] - 1e-6, 7)

    assert outcome(short) == "UNDECIDED"


@pytest.mark.parametrize("k", range(6))
def test_a_larger_class_is_not_proved(k: int, short: Document) -> None:
    """Every cell's wind error is close to the largest allowed one, and a smaller class holds.

    The rate is what was asked for; a cell may allow somewhat more of it.
    """
    cell = short["claims"][0]["cells"][k]
    error, rate = cell["wind_error"], cell["wind_rate"]
    cell["wind_error"] = 1.05 * error
    assert outcome(short) == "UNDECIDED"
    cell["wind_error"], cell["wind_rate"] = error, 2 * rate
    assert outcome(short) == "UNDECIDED"
    cell["wind_error"], cell["wind_rate"] = 0.5 * error, 0.5 * rate
    assert outcome(short) == "PROVED"


def false_claims() -> dict[str, Callable[[Document], None]]:
    """Return changes of one kind each that leave a well-formed, false or unwitnessed claim."""

    def at(*path: Any, to: Callable[[Any], Any]) -> Callable[[Document], None]:
        def change(document: Document) -> None:
            place = holder(document, path)
            place[path[-1]] = to(place[path[-1]])

        return change

    def claim(*path: Any, to: Callable[[Any], Any]) -> Callable[[Document], None]:
        return at("claims", 0, *path, to=to)

    def flipped(P: Any) -> Any:
        P[0][2] = P[2][0] = -P[0][2]
        return P

    def column(factor: float) -> Callable[[Any], Any]:
        return lambda values: [factor * value for value in values]

    def stronger_wake(document: Document) -> None:
        """Change gains and claim alike, which have to agree on it."""
        wakes = [document["gains"], *document["claims"][0]["cells"]]
        for one in wakes:
            one["effectiveness_limit"] = column(1.3)(one["effectiveness_limit"])

    def torque(rows: Any) -> Any:
        return [[1.02 * entry for entry in row] for row in rows]

    def knots(values: Any) -> Any:
        return [value + 0.002 if 0 < value < 0.1 else value for value in values]

    def pitch_ends_early(document: Document) -> None:
        document["model"]["pitch_max"] = document["gains"]["pitch_max"] = 0.01

    return {
        "moved pitch knots": at("model", "torque_surface", "pitch_knots", to=knots),
        "smaller largest pitch": pitch_ends_early,
        "P with a flipped sign": claim("P", to=flipped),
        "P not symmetric": claim("P", 0, 2, to=lambda p: p + 1),
        "P negative": claim("P", to=lambda P: [[-p for p in row] for row in P]),
        "P of a larger set": claim("P", to=lambda P: [[0.9 * p for p in row] for row in P]),
        "P of a smaller set": claim("P", to=lambda P: [[9 * p for p in row] for row in P]),
        "smaller speed peak": claim("peaks", "speed_error", to=lambda p: 0.99 * p),
        "smaller lag peak": claim("peaks", "effort_lag", to=lambda p: 0.99 * p),
        "negative peak": claim("peaks", "speed_error", to=lambda p: -p),
        "peak beyond the box": claim("peaks", "speed_error", to=lambda p: 2 * p),
        "box below the peaks": claim("box", "speed_error", to=lambda b: 0.8 * b),
        "box of the signal below": claim("box", "speed_signal", to=lambda b: 0.8 * b),
        "larger box": claim("box", "speed_error", to=lambda b: 1.2 * b),
        "larger lag box": claim("box", "effort_lag", to=lambda b: 1.2 * b),
        "larger wind share": claim("box", "wind_share", to=lambda b: 1.2 * b),
        "wind share below the class": claim("box", "wind_share", to=lambda b: 1e-3),
        "faster decay": claim("cells", 1, "decay_rate", to=lambda r: round(1.05 * r + 0.001, 5)),
        "negative decay": claim("cells", 1, "decay_rate", to=lambda r: -0.01),
        "faster common decay": claim("settling", "decay_rate", to=lambda r: round(3 * r, 6)),
        "common decay, P negative": claim(
            "settling", "P", to=lambda P: [[-p for p in row] for row in P]
        ),
        "common decay, P flipped": claim("settling", "P", to=flipped),
        "negative multiplier": claim("cells", 1, "multiplier", to=lambda r: -r),
        "zero multiplier": claim("cells", 1, "multiplier", to=lambda r: 0),
        "large multiplier": claim("cells", 1, "multiplier", to=lambda r: 10.0),
        "negative class": claim("cells", 1, "wind_error", to=lambda e: -e),
        "negative rate": claim("cells", 1, "wind_rate", to=lambda e: -e),
        "lighter rotor": claim("uncertainty", "inertia", to=lambda i: [0.8, 1.1]),
        "heavier rotor": claim("uncertainty", "inertia", to=lambda i: [0.9, 1.3]),
        "stronger frozen wake": stronger_wake,
        "higher gain": at("gains", "proportional", to=column(1.1)),
        "lower gain": at("gains", "proportional", to=column(0.9)),
        "other trim": at("gains", "trim_effort", to=lambda q: [e + 1e-3 for e in q]),
        "other speed": at("gains", "rotor_speed", to=column(1.01)),
        "other effectiveness": at("gains", "effectiveness", to=column(0.9)),
        "other rated torque": at("gains", "rated_torque", to=lambda t: 1.01 * t),
        "other effort torque": at("gains", "effort_torque", to=lambda t: 1.01 * t),
        "other overlap": at("gains", "overlap", to=lambda e: 2 * e),
        "integral held earlier": at("gains", "integral_limit", to=lambda x: 0.2 * x),
        "steeper surface": at("model", "torque_surface", "coefficients", to=torque),
        "heavier air": at("model", "torque_constant", to=lambda c: 1.01 * c),
        "larger rotor": at("model", "rotor_radius", to=lambda r: 1.01 * r),
        "other inertia": at("model", "rotor_inertia", to=lambda j: 1.02 * j),
        "other gear": at("model", "gear_ratio", to=lambda n: 1.02 * n),
        "faster pitch": at("model", "pitch_time_constant", to=lambda t: 0.9 * t),
        "pitch rate limit": at("model", "pitch_rate_limit", to=lambda r: 0.05 * r),
    }


@pytest.mark.parametrize("name", false_claims())
def test_a_false_claim_is_not_proved(name: str, short: Document) -> None:
    """Hashes recomputed, claim made false: UNDECIDED, with the reason in words."""
    false_claims()[name](short)

    checked = check_document(resealed(short))

    assert checked.verdict is Verdict.UNDECIDED
    assert checked.claims[0].text


@pytest.mark.parametrize("name", ["paper", "pdc", "", None, 1])
def test_a_law_whose_gain_file_has_another_program_is_refused(
    name: object, short: Document
) -> None:
    """The program of a gain file follows from the law's name: of ``paper`` it is another law."""
    short["gains"]["name"] = name
    with pytest.raises(CertificateError, match=r"gains\.name"):
        check_document(resealed(short))


@pytest.mark.parametrize("k", range(8))
def test_one_coefficient_under_the_loop_is_noticed(k: int, short: Document, built: Any) -> None:
    """Each B-spline coefficient that the cells lean on is checked: two percent are too much."""
    table, gains = short["model"]["torque_surface"], short["gains"]
    ratio = built.turbine.rotor_radius * gains["rotor_speed"][2] / gains["wind"][2]
    i = bisect_right(table["tip_speed_ratio_knots"], ratio) - 4
    j = bisect_right(table["pitch_knots"], gains["pitch_min"]) - 4
    table["coefficients"][i + k // 2][j + k % 2] *= 1.02

    assert outcome(short) == "UNDECIDED"


@pytest.mark.parametrize(
    "path",
    [
        ("gains", "wind", 2),
        ("gains", "integral_rate", 2),
        ("gains", "effectiveness_limit", 2),
        ("claims", 0, "cells", 3, "effectiveness_limit", 0),
        ("gains", "pitch_max"),
        ("model", "pitch_min"),
        ("claims", 0, "cells", 3, "integral_rate"),
        ("claims", 0, "cells", 3, "wind", 1),
        ("claims", 0, "cells", 3, "multiplier"),
    ],
)
def test_parts_that_do_not_belong_together_are_refused(
    path: tuple[Any, ...], short: Document
) -> None:
    """Cells tile the law's winds, with its integral rates, limits and seven decimals."""
    holder(short, path)[path[-1]] += 1.1e-9

    assert outcome(short) == "refused"


def test_cells_must_tile_the_winds(short: Document) -> None:
    """A cell less, a cell more, two cells swapped: refused."""
    for change in (
        lambda cells: cells[:-1],
        lambda cells: [*cells, cells[-1]],
        lambda cells: [cells[1], cells[0], *cells[2:]],
        lambda cells: [],
    ):
        damaged = deepcopy(short)
        damaged["claims"][0]["cells"] = change(damaged["claims"][0]["cells"])
        assert outcome(damaged) == "refused"
