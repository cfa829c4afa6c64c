"""What the running loop's claim states, and its limits: each from both sides of its formula."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import read_text
from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import Interval, point
from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.checker.turbine.running_loop.cell import Cell, factors
from takagi.certificates.checker.turbine.running_loop.equations import FACTORS, rounded_form, rows
from takagi.certificates.checker.turbine.running_loop.inputs import (
    Machine,
    Sides,
    other_than_the_controller,
)
from takagi.certificates.checker.turbine.running_loop.limits import command_rates, limits
from takagi.certificates.checker.turbine.running_loop.running_claim import StatedCell, inside_box
from takagi.certificates.checker.words.running_loop import measured
from tests.certificates.kinds.claims import Data
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import Change, entry


@cache
def stored() -> Data:
    return dict(json.loads(next(recorded("running-loop"))[1]))


def changed(change: Change) -> Data:
    found = deepcopy(stored())
    claim = found["claims"][0]
    claim["cells"], claim["winds"] = claim["cells"][3:], claim["winds"][3:]
    change(found)
    return found


def read(document: Data) -> Any:
    return read_text(json.dumps(document), "document")


CLAIM = ("claims", 0)
SEEN, FILTERS, FAMILY = ((*CLAIM, k) for k in ("observer", "measurement", "uncertainty"))


def machine(document: Data) -> Machine:
    data = read(document)
    return Machine.read(data["claims"][0], data["model"], data["gains"], "claim")


def without_inertia(document: Data) -> None:
    model = document["model"]
    model["generator_inertia"] = 1
    model["rotor_inertia"] = -(model["gear_ratio"] ** 2)


@pytest.mark.parametrize(
    "change",
    [
        entry(*SEEN, "l1", value=0),
        entry(*SEEN, "l1", value=-1),
        entry(*SEEN, "l2", value=0),
        entry(*SEEN, "wind_limits", value=[0, 30]),
        entry(*SEEN, "wind_limits", value=[-1, 30]),
        entry(*SEEN, "wind_limits", value=[30, 3]),
        entry(*SEEN, "wind_limits", value=[8, 8]),
        entry(*FILTERS, "speed_filter", value=0),
        entry(*FILTERS, "torsion_filter", "frequency", value=0),
        entry(*FILTERS, "torsion_filter", "passed", value=-0.001),
        entry(*FILTERS, "torsion_filter", "passed", value=1.001),
        entry(*FAMILY, "inertia", value=[0, 1]),
        entry(*FAMILY, "inertia", value=[1.1, 0.9]),
        entry(*FAMILY, "wake_length", value=[0, 80]),
        entry(*FAMILY, "wake_length", value=[80, 40]),
        entry("gains", "wind_filter", value=0),
        entry("model", "torque_rate_limit", value=0),
        entry("model", "rotor_inertia", value=-(10**9)),
        without_inertia,
    ],
)
def test_a_machine_that_cannot_be_is_refused(change: Change) -> None:
    document = changed(change)
    with pytest.raises(CertificateError):
        machine(document)


def test_ends_that_a_machine_may_have() -> None:
    """A share of 0 and of 1, and a range of one number."""
    for passed in (0, 1):
        found = machine(changed(entry(*FILTERS, "torsion_filter", "passed", value=passed)))
        assert found.stop is not None and found.stop[1] == passed
    found = machine(changed(entry(*FAMILY, "inertia", value=[1, 1])))
    assert found.inertia == (Fraction(1), Fraction(1))


def test_the_observer_divides_by_a_float() -> None:
    """J = 10^16 + 9 * 0.1, whose nearest float is 10^16."""
    document = changed(entry("model", "rotor_inertia", value=10**16))
    document["model"] |= {"gear_ratio": 3, "generator_inertia": 0.1}
    assert machine(document).observer_inertia == 1 + Fraction(9, 10**17)


@pytest.mark.parametrize("name", Sides.__dataclass_fields__)
@pytest.mark.parametrize("value", [0, -1])
def test_every_side_is_positive(name: str, value: int) -> None:
    document = read(changed(entry(*CLAIM, "cells", 0, "sides", name, value=value)))
    with pytest.raises(CertificateError, match="every side must be positive"):
        Sides.read(document["claims"][0]["cells"][0], "cell")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (entry("wind", value=[15, 15]), "must increase"),
        (entry("wind", value=[16, 15]), "must increase"),
        (lambda cell: cell["P"].pop(), "10 rows of 10 numbers"),
        (lambda cell: [row.pop() for row in cell["P"]], "10 rows of 10 numbers"),
        (entry("multipliers", value=[[1]]), "by the names of the factors"),
        (entry("multipliers", value=[{"nothing": 1}]), "by the names of the factors"),
        (entry("multipliers", value=[]), "multipliers"),
    ],
)
def test_a_cell_that_does_not_fit_is_refused(change: Change, words: str) -> None:
    document = changed(lambda whole: change(whole["claims"][0]["cells"][0]))
    with pytest.raises(CertificateError, match=words):
        StatedCell.read(read(document)["claims"][0]["cells"][0], 10, "cell")


def test_a_cell_may_have_a_multiplier_of_each_factor() -> None:
    row = dict.fromkeys(sorted(FACTORS), 1)
    change = entry(*CLAIM, "cells", 0, "multipliers", value=[row])
    found = StatedCell.read(read(changed(change))["claims"][0]["cells"][0], 10, "cell")
    assert found.multipliers == [row]


def test_the_sentence_names_a_band_stop_that_is_there() -> None:
    found = machine(changed(lambda whole: None))
    assert "behind a band-stop at" in measured(found)
    assert "band-stop" not in measured(replace(found, stop=None))


def test_numbers_are_compared_as_numbers_with_the_controller() -> None:
    """1 and 1.0 are one number, in lists and objects too."""
    document = changed(lambda whole: None)
    claim, own = document["claims"][0], document["controller"]
    for part in (claim, own):
        part["observer"]["l1"], part["observer"]["wind_limits"] = 1, [3, 25]
        part["measurement"]["torsion_filter"] = {"frequency": 10, "passed": 0}
    own["observer"] |= {"l1": 1.0, "wind_limits": [3.0, 25.0]}
    own["measurement"]["torsion_filter"] = {"frequency": 10.0, "passed": 0.0}

    def other() -> str:
        data = read(document)
        return other_than_the_controller(data["claims"][0], data, "claim")

    assert other() == ""
    for path, value in (
        (("observer", "l1"), 1.5),
        # In Python True == 1; in a gain file it is no number.
        (("observer", "l1"), True),
        (("observer", "wind_limits"), [3, 25.5]),
        (("observer", "wind_limits"), "none"),
        (("measurement", "torsion_filter"), {"frequency": 10, "passed": 0.5}),
        (("measurement", "torsion_filter"), None),
    ):
        kept = own[path[0]][path[1]]
        own[path[0]][path[1]] = value
        assert other() == f"{path[0]}.{path[1]} is not the controller's"
        own[path[0]][path[1]] = kept
    own["observer"] = [2]
    assert other() == "observer.l1 is not the controller's"
    document["controller"] = None
    assert other() == ""
    document["controller"] = "none"
    assert other() == "observer.l1 is not the controller's"


def test_rounding_takes_its_share_from_the_diagonal_alone() -> None:
    """Of 64 bits nothing is rounded; two units are taken from each entry of the diagonal."""
    big = 2**63 + 12345
    for away, definite in ((3, True), (2, False)):
        for sign in (-1, 1):
            other = sign * (big - away)
            form = rounded_form([[big, other], [other, big]])
            assert form.is_positive_definite is definite


F = Fraction
HAIR = F(1, 10**12)
CELLS = range(4)


def cell_of(k: int) -> Cell:
    data = read_text(next(recorded("running-loop"))[1], "document")
    claim, stated = data["claims"][0], data["claims"][0]["cells"][k]
    machine = Machine.read(claim, data["model"], data["gains"], "claim")
    low, high = (F(str(end)) for end in stated["wind"])
    sides = Sides.read(stated, "cell")
    return Cell(Plant.read(data["model"]), Law.read(data["gains"]), machine, (low, high), sides)


def largest(column: Any, cell: Cell) -> Fraction:
    nodes = cell.law.wind
    found: list[Fraction] = [
        abs((column[j + 1] - column[j]) / (nodes[j + 1] - nodes[j])) for j in cell.near
    ]
    return max(found)


@pytest.mark.parametrize("k", CELLS)
def test_rates_of_the_commands_by_their_formula(k: int) -> None:
    """The module's text, written out once more, for columns that differ from node to node."""
    cell = cell_of(k)
    _ = cell.ramp_share, cell.shed
    cell.near = [*range(cell.near[0], cell.near[0] + 4)]
    tilted: dict[str, Any] = {
        name: [(j + 2) * value for j, value in enumerate(getattr(cell.law, name))]
        for name in ("nu", "speed")
    }
    cell.law = replace(cell.law, **tilted)
    law, sides, machine = cell.law, cell.sides, cell.machine
    rho = (sides.estimate + sides.schedule) / machine.wind_filter
    w, q, b = (largest(c, cell) for c in (law.speed, law.effort, law.effectiveness))
    bend = largest(law.gamma, cell)
    nu = max(law.nu[j] for j in cell.near)
    gamma, least = cell.over(law.gamma, cell.reach)[1], cell.over(law.effectiveness, cell.reach)[0]
    moved = q * rho + bend * rho * (sides.signal + cell.rest_integral)
    moved += gamma * (sides.measured_rate + w * rho + nu * (sides.measured + w * sides.schedule))
    torque = law.effort_torque * share(-cell.efforts[0], law.overlap) * moved
    most, part = psi(cell.efforts[1], law.overlap), share(cell.efforts[1], law.overlap)
    pitch = (part * moved + most * b * rho / least) / least

    assert command_rates(cell) == (torque, pitch)


def at(cell: Cell, **parts: Any) -> str:
    kept = {name: getattr(cell, name) for name in ("law", "machine", "plant", "sides")}
    for place, value in parts.items():
        owner, _, name = place.partition("__")
        setattr(cell, owner, replace(getattr(cell, owner), **{name: value}))
    try:
        return first_failure(limits(cell))
    finally:
        for name, value in kept.items():
            setattr(cell, name, value)


@pytest.mark.parametrize("k", CELLS)
def test_each_limit_counts_from_its_own_threshold(k: int) -> None:
    """Exactly at a limit nothing is beyond it; a hair less of it is too little."""
    cell = cell_of(k)
    law, sides = cell.law, cell.sides
    _ = cell.pitches, cell.ramp_share, cell.shed  # of the honest numbers, once for all
    assert first_failure(limits(cell)) == ""
    torque, pitch = command_rates(cell)
    rated = law.effort_torque * psi(-cell.efforts[0], law.overlap)
    for place, least, words in (
        ("law__rated_torque", rated, "negative torque"),
        ("law__integral_limit", sides.integral + cell.rest_integral, "the integral"),
        ("machine__torque_rate", torque, "torque may reach"),
        ("plant__rate_limit", pitch, "pitch may reach"),
    ):
        assert at(cell, **{place: least}) == "", place
        assert at(cell, **{place: least - HAIR}).startswith(words), place


@pytest.mark.parametrize("k", CELLS)
def test_pitch_keeps_its_upper_limit(k: int) -> None:
    """What the law asks for, and where the pitch itself may be."""
    cell = cell_of(k)
    law = cell.law
    least = cell.over(law.effectiveness, cell.reach)[0]
    asked = psi(cell.efforts[1], law.overlap) / least + law.pitch_min
    _ = cell.ramp_share, cell.shed
    cell.__dict__["pitches"] = Interval(0, 0)
    assert at(cell, law__pitch_max=asked) == ""
    assert at(cell, law__pitch_max=asked - HAIR).startswith("pitch beyond its limit")
    high = point(asked + 1)
    cell.__dict__["pitches"] = Interval(0, high.low)
    assert at(cell, law__pitch_max=asked + 1) == ""
    cell.__dict__["pitches"] = Interval(0, high.low + 1)
    assert at(cell, law__pitch_max=asked + 1).startswith("pitch beyond its limit")


def built(cell: Cell | None = None, **changed: Any) -> str:
    cell = cell or cell_of(3)
    parts = {name: getattr(cell, name) for name in ("plant", "law", "machine", "winds", "sides")}
    try:
        Cell(**(parts | changed))
    except Refused as reason:
        return str(reason)
    return ""


def test_winds_of_a_cell_lie_in_one_interval() -> None:
    cell = cell_of(3)
    nodes, (low, high), words = cell.law.wind, cell.winds, "winds that are not inside one interval"
    next_node = nodes[cell.k + 1]
    assert nodes[cell.k] <= low < high <= next_node
    assert built(winds=(low, next_node)) == built(winds=(nodes[cell.k], high)) == ""
    assert built(winds=(nodes[-2], nodes[-1])) == ""
    assert not built(winds=(nodes[0], nodes[1])).startswith(words)
    for winds in (
        *((low, next_node + HAIR), (nodes[cell.k] - HAIR, high), (low, low), (high, low)),
        *((nodes[0] - 1, nodes[0]), (nodes[-1], nodes[-1] + 1)),
    ):
        assert built(winds=winds).startswith(words), winds


def test_the_estimate_stays_off_its_limits() -> None:
    cell = cell_of(3)
    low, high = (cell.winds[0] - cell.sides.estimate, cell.winds[1] + cell.sides.estimate)

    def held(least: Fraction, most: Fraction) -> str:
        return built(machine=replace(cell.machine, wind_limits=(least, most)))

    assert held(low - HAIR, high + HAIR) == ""
    for ends in (
        (low, high + 1),
        (low - 1, high),
        (low + HAIR, high + 1),
        (low - 1, high - HAIR),
    ):
        assert held(*ends) == "the wind estimate may reach its limit"


def test_the_schedule_stays_above_zero() -> None:
    cell = cell_of(3)
    for schedule, words in (
        (cell.winds[0] - HAIR, ""),
        (cell.winds[0], "the schedule wind may reach zero"),
        (cell.winds[0] + 1, "the schedule wind may reach zero"),
    ):
        assert built(sides=replace(cell.sides, schedule=schedule)) == words


def test_a_law_needs_effectiveness() -> None:
    """Rounded to three places, so that less than half of the last is none."""
    law = cell_of(3).law
    for value in (F(0), F(1, 10**5), F(-1)):
        flat = replace(law, effectiveness=[value] * len(law.wind))
        assert built(law=flat) == "an assumed pitch effectiveness below 0.0005"


@pytest.mark.parametrize("k", CELLS)
def test_the_rest_lies_within_the_efforts_of_the_set(k: int) -> None:
    """|r| / G is compared with the side; G is nearly the same over both."""
    cell = cell_of(k)
    for part, words in ((2, ""), (F(1, 2), "no rest is known to lie near the trim")):
        sides = replace(cell.sides, effort=part * cell.rest)
        assert built(cell, sides=sides) == words


def test_tables_are_read_between_their_nodes() -> None:
    """w = v^2 at the nodes: in the first interval and in the last, at a node, and over all."""
    cell = cell_of(3)
    nodes = cell.law.wind
    squares = [wind**2 for wind in nodes]
    for j in (0, 1, len(nodes) - 3, len(nodes) - 2):
        a, b = nodes[j], nodes[j + 1]
        for part in (F(0), F(1, 3), F(1)):
            wind = a + part * (b - a)
            assert cell.at(squares, wind) == a**2 + part * (b**2 - a**2)
    away = [(wind - nodes[5]) ** 2 for wind in nodes]
    assert cell.over(away, (nodes[3], nodes[9])) == (F(0), (nodes[9] - nodes[5]) ** 2)
    assert cell.over(away, (nodes[5], nodes[9])) == (F(0), (nodes[9] - nodes[5]) ** 2)
    assert cell.over(away, (nodes[0], nodes[5])) == (F(0), (nodes[0] - nodes[5]) ** 2)
    inner = (nodes[4] + nodes[5]) / 2, (nodes[5] + nodes[6]) / 2
    assert cell.over(away, inner)[0] == 0


def test_intervals_near_a_set_are_those_that_it_meets() -> None:
    cell = cell_of(3)
    nodes, (low, high) = cell.law.wind, cell.winds
    far = replace(cell.sides, schedule=low - HAIR)
    for sides in (cell.sides, far):
        other = Cell(cell.plant, cell.law, cell.machine, cell.winds, sides)
        reach = (max(low - sides.schedule, nodes[0]), min(high + sides.schedule, nodes[-1]))
        met = [j for j in range(len(nodes) - 1) if nodes[j] < reach[1] and nodes[j + 1] > reach[0]]
        assert (other.reach, other.near) == (reach, met)
    assert other.near == [*range(len(nodes) - 1)]
    most = cell.law.wind[-1] - high
    for estimate, free in ((most, True), (most + HAIR, False)):
        machine = replace(cell.machine, wind_limits=(F(1, 1000), F(999)))
        sides = replace(cell.sides, estimate=estimate)
        other = Cell(cell.plant, cell.law, machine, cell.winds, sides)
        assert other.estimate_is_free is free
    first = replace(cell.sides, estimate=low - nodes[0])
    wide = [wind if wind < nodes[-1] else F(999) for wind in nodes]
    other = Cell(
        cell.plant, replace(cell.law, wind=wide), replace(cell.machine, wind_limits=(F(1), F(999))),
        cell.winds, first,
    )  # fmt: skip
    assert other.estimate_is_free


def test_pitch_follows_from_its_lower_limit() -> None:
    cell = cell_of(3)
    before = cell.pitch(cell.psi(cell.efforts))
    cell.plant = replace(cell.plant, pitch_min=cell.plant.pitch_min + F(1, 50))
    after, moved = cell.pitch(cell.psi(cell.efforts)), point(F(1, 50))
    assert after.low - before.low in (moved.low, moved.high)
    assert after.high - before.high in (moved.low, moved.high)


def test_efforts_that_end_where_the_ramp_begins() -> None:
    """At -eps and below it no pitch moves: the gain is that of torque alone."""
    cell = cell_of(3)
    eps = cell.law.overlap
    found = cell.effort_gain({-eps - 1, -eps}, cell.pitch_gain)
    assert found == point(cell.effort_unit)


LARGE = F(10**6)


def boxed(cell: Cell, **sides: Fraction) -> str:
    """Return which side the unit ball of all ten states leaves; a side that is not given is far."""
    all_sides = {name: LARGE for name in Sides.__dataclass_fields__} | {"schedule": F(2)} | sides
    span = factors(cell)
    cell.sides = Sides(**all_sides)
    unit = [[F(int(i == j)) for j in range(10)] for i in range(10)]
    return first_failure(inside_box(cell, span, unit))


@pytest.mark.parametrize("name", ["speed", "measured", "pitch", "schedule", "estimate", "integral"])
def test_a_state_s_side_is_left_where_it_is_reached(name: str) -> None:
    assert boxed(cell_of(3)) == ""
    assert boxed(cell_of(3), **{name: 1 + HAIR}) == ""
    assert boxed(cell_of(3), **{name: F(1)}) == f"the set leaves its box in {name}"


def test_the_sides_of_sums_by_their_formula() -> None:
    """Of factors from a range: the middle's row, and the rest taken from the bound."""
    cell = cell_of(3)
    span = factors(cell)
    half = {name: (high - low) / 2 for name, (low, high) in span.items()}
    mid = {name: (high + low) / 2 for name, (low, high) in span.items()}
    w, q, gamma = ("speed slope", "effort slope", "gamma")
    away = half[w] * 2
    # signal = m - x - w s; effort = q s + gamma signal; both in (x, s, m).
    signal2 = 2 + mid[w] ** 2
    effort2 = 2 * mid[gamma] ** 2 + (mid[q] - mid[gamma] * mid[w]) ** 2
    c, passed = cell.machine.corner, (cell.machine.stop or (F(0), F(1)))[1]
    rate2 = 2 * c**2 + 8 * (1 - passed) ** 2 * c**2
    spread = half[q] * 2 + half[gamma] * LARGE + mid[gamma] * away
    for name, square, less in (
        ("signal", signal2, away),
        ("effort", effort2, spread),
        ("measured_rate", rate2, F(0)),
    ):
        root = F(round(float(square) ** 0.5 * 10**9), 10**9)
        words = f"the set leaves its box in {name.replace('_', ' ')}"
        assert boxed(cell_of(3), **{name: root + less + F(1, 10**6)}) == ""
        assert boxed(cell_of(3), **{name: root + less - F(1, 10**6)}) == words
        # A bound below zero is left, however large its square.
        assert boxed(cell_of(3), **{name: less - 3 * root}) == words
    assert rows(cell, span).keys() == set(Sides.__dataclass_fields__)


def test_the_observed_stiffness_is_that_of_the_larger_error() -> None:
    cell = cell_of(3)
    small, large = F(1, 1000), F(1, 20)
    cell.sides = replace(cell.sides, speed=small, measured=small)
    least = factors(cell)["observed stiffness"]
    for speed, seen in ((small, large), (large, small)):
        cell.sides = replace(cell.sides, speed=speed, measured=seen)
        found = factors(cell)["observed stiffness"]
        assert found[0] < least[0] or least[1] < found[1]


@pytest.mark.parametrize(("i", "j", "entry"), [(9, 9, 0), (0, 1, 1), (1, 0, 1)])
def test_a_shape_that_is_not_definite_has_no_set(i: int, j: int, entry: int) -> None:
    """Nor one that is definite by the lower triangle alone, or by the upper one."""
    cell = cell_of(3)
    unit = [[F(int(k == n)) for n in range(10)] for k in range(10)]
    unit[i][j] = F(entry)
    failure = first_failure(inside_box(cell, factors(cell), unit))
    assert failure == "P is not symmetric positive definite"
