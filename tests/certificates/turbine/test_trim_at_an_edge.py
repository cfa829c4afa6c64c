"""``turbine-crossing``: a trim at the edge of the c_Q table, where c_Q has slopes to one side only.

The table of the recorded certificate at 8 m/s is cut at the trim's tip-speed ratio: the same
surface up to there, and the same matrix, so the claim would hold in every other respect.
"""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import fmpq
from scipy.interpolate import BSpline

from takagi.certificates.checker.arithmetic import spline_point
from takagi.certificates.checker.kernel import refusal
from takagi.certificates.checker.turbine.effort_sharing import inputs as plants
from takagi.certificates.checker.turbine.linear_loop import trim
from takagi.certificates.checker.turbine.running_loop import inputs as machines
from takagi.certificates.cross_check.kernel import reading
from takagi.certificates.cross_check.turbine import numbers, surface
from takagi.certificates.cross_check.turbine.linear import linear_rates
from takagi.certificates.cross_check.turbine.running import machine as second
from tests.certificates.turbine.crossing_documents import BOTH, Data, as_read, stored_documents
from tests.certificates.turbine.running_documents import verdicts

F = Fraction


@pytest.fixture(scope="module")
def stored() -> Data:
    """Return the certificate at 8 m/s with a reference speed of few digits there."""
    document = stored_documents()[0]
    law = document["gains"]
    k = max(i for i, v in enumerate(law["wind"]) if v < 8)
    low, high = law["wind"][k : k + 2]
    speed = law["rotor_speed"]
    speed[k] = round(speed[k], 6)
    speed[k + 1] = round(speed[k] + 0.1213175 * (high - low), 12)
    # Far more than the bound of the slightly other law.
    document["claims"][0]["probability"] = 0.9
    return document


@pytest.fixture
def document(stored: Data) -> Data:
    return deepcopy(stored)


def ratio(document: Data) -> Fraction:
    """Return R omega* / v at 8 m/s."""
    law, v = document["gains"], F(8)
    nodes, speed = ([F(str(n)) for n in law[name]] for name in ("wind", "rotor_speed"))
    k = max(i for i, node in enumerate(nodes) if node < v)
    slope = (speed[k + 1] - speed[k]) / (nodes[k + 1] - nodes[k])
    return F(str(document["model"]["rotor_radius"])) * (speed[k] + slope * (v - nodes[k])) / v


def cut_at(document: Data, end: float) -> None:
    """Leave the table up to one tip-speed ratio, where its knots become the last ones."""
    table = document["model"]["torque_surface"]
    knots, rows = table["tip_speed_ratio_knots"], table["coefficients"]
    whole: Any = BSpline(knots, np.array(rows), 3)
    # Three more knots there: a fourth one, and the spline's coefficients up to it, end it.
    finer: Any = whole.insert_knot(end, m=3)
    count = int((finer.t < end).sum())
    table["tip_speed_ratio_knots"] = [*finer.t[:count].tolist(), *[end] * 4]
    table["coefficients"] = finer.c[:count].tolist()


def test_a_tip_speed_ratio_at_the_edge_is_undecided(document: Data) -> None:
    """A table that ends 0.001 beyond it is enough; one that ends at it is not."""
    end = ratio(document)
    assert F(repr(float(end))) == end
    assert verdicts(document) == BOTH
    for away, expected in ((0.001, BOTH), (0.0, ("UNDECIDED", "UNDECIDED"))):
        changed = deepcopy(document)
        cut_at(changed, round(float(end) + away, 14))
        assert verdicts(changed) == expected


def test_pitch_that_the_law_holds_may_be_at_the_edge(document: Data) -> None:
    """At 8 m/s the law asks for the lower limit, 0, whatever its signals: no slope acts."""
    table = document["model"]["torque_surface"]
    whole: Any = BSpline(table["pitch_knots"], np.array(table["coefficients"]).T, 3)
    first = table["pitch_knots"].index(0.0)
    finer: Any = whole.insert_knot(0.0, m=3)
    table["pitch_knots"] = finer.t[first:].tolist()
    table["coefficients"] = finer.c[first : len(finer.t) - 4].T.tolist()
    assert verdicts(document) == BOTH


@pytest.mark.parametrize("end", [0, -1])
def test_a_pitch_at_the_edge_is_refused(document: Data, end: int) -> None:
    """At 15 m/s, with the first or the last pitch of the table moved to the trim's."""
    read = as_read(document)
    claim, v = read["claims"][0], "15"
    plant, law = plants.Plant.read(read["model"]), plants.Law.read(read["gains"])
    machine = machines.Machine.read(claim, read["model"], read["gains"], "claim")
    table = spline_point.ExactSurface.read(read["model"])
    given = reading.loads(json.dumps(document))
    rotor = numbers.Rotor(given["model"], given["gains"])
    seen = second.Machine(given["claims"][0], given["model"], given["gains"])

    pitch = linear_rates.LinearRates(rotor, seen, given["claims"][0], fmpq(int(v))).pitch
    knots = list(table.y_knots)
    knots[end] = F(int(pitch.p), int(pitch.q))
    rotor.surface.y.breaks[end] = pitch

    with pytest.raises(refusal.Refused, match="at the edge of the coefficient table"):
        trim.trim_at(plant, law, machine, replace(table, y_knots=knots), F(v))
    with pytest.raises(surface.Outside, match="a pitch at the table's edge"):
        linear_rates.LinearRates(rotor, seen, given["claims"][0], fmpq(int(v)))
