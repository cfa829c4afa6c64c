"""What a claim about the running loop states: numbers without a meaning are refused, by both."""

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
from takagi.certificates.checker.turbine.running_loop.equations import FACTORS, rounded_form
from takagi.certificates.checker.turbine.running_loop.inputs import (
    Machine,
    Sides,
    other_than_the_controller,
)
from takagi.certificates.checker.turbine.running_loop.running_claim import StatedCell
from takagi.certificates.checker.words.running_loop import measured
from tests.certificates.kinds.claims import Data
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import Change, entry


@cache
def stored() -> Data:
    return dict(json.loads(next(recorded("running-loop"))[1]))


def changed(change: Change) -> Data:
    """Return the document with one cell, the last, and with the change."""
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
