"""The claim about the effort-sharing loop: it is proved, and each of its checks by itself."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import Verdict, check, check_document
from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.corners import (
    BOUNDS,
    RANGES,
    Corners,
    Stated,
)
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.claims.turbine.effort_sharing import (
    DEFAULT_UNCERTAINTY,
    effort_sharing_candidate,
    effort_sharing_claim,
)
from takagi.certificates.cross_check.comparison import cross_checked_document
from takagi.certificates.document.certificate_file import dumps
from takagi.lmi.analysis.invariant_ellipsoid import largest_scale
from takagi.models import Interval
from takagi.models.laws.effort_sharing.law import loop_vertices
from takagi.models.ramps import effort_ramp
from takagi.models.turbine.data import rotor_torque
from tests.certificates.kinds.claims import as_read, resealed

Document = dict[str, Any]


def test_the_whole_certificate_is_proved(built: Any, tmp_path: Path) -> None:
    """The emitted file proves for every wind from cut-in to cut-out, read back from disk."""
    path = tmp_path / "certificate.json"
    path.write_text(dumps(built.document), encoding="utf-8")

    checked = check(path)

    assert checked.verdict is Verdict.PROVED, checked.claims[0].text
    assert "winds 3 to 25 m/s" in checked.claims[0].text
    assert len(checked.messages) == 2, "embedded copies alone were checked: it has to say so"


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
        sealed = resealed(built.document | {"claims": [effort_sharing_claim(candidate)]})
        claim = check_document(sealed).claims[0]

        assert claim.verdict is expected
        if expected is Verdict.PROVED:
            assert "c_P 0.99 to 1.01 of the table's" in claim.text
            assert cross_checked_document(sealed).agrees


def subject(document: dict[str, Any]) -> Subject:
    read = as_read(document)
    return Subject.read(read["claims"][0], read["model"], read["gains"], "claim")


def loop(document: dict[str, Any], k: int, rate: str | None = None, **changes: Any) -> Loop:
    known = subject(document)
    stated = document["claims"][0]["cells"][k]["wind_rate"] if rate is None else rate
    law = replace(
        known.law, **{name: changes[name] for name in changes if hasattr(known.law, name)}
    )
    box = replace(
        known.box, **{name: changes[name] for name in changes if hasattr(known.box, name)}
    )
    return Loop(replace(known, law=law, box=box), k, Fraction(str(stated)))


def decided(cell: dict[str, Any], P: Any, error: float, rate: float, alpha: float) -> str:
    exact = {name: [Fraction(str(v)) for v in cell[name]] for name in RANGES}
    sizes = {name: Fraction(str(cell[name])) for name in BOUNDS}
    names = ("wind_error", "wind_rate", "multiplier", "decay_rate")
    for name, value in zip(names, (error, rate, alpha, 0), strict=True):
        sizes[name] = Fraction(str(round(value, 6)))
    sizes["integral_rate"] = Fraction(str(cell["integral_rate"]))
    matrix = Matrix.of([[Fraction(str(entry)) for entry in row] for row in P])
    return first_failure(Corners(Stated(exact, sizes, "cell")).obligations(matrix))


@pytest.mark.parametrize(("binding", "coupling"), [(0, 0.0), (1, -500.0)])
def test_both_signs_of_the_lag_disturbance_are_checked(
    built: Any, binding: int, coupling: float
) -> None:
    """A wind error that one sign of w_zeta allows and the other does not is refused.

    A larger w_zeta is stated; which sign is the worse one depends on how P couples speed and lag.
    """
    P, found = built.candidate.P.copy(), 0
    P[0, 1] = P[1, 0] = coupling
    for k, given in enumerate(built.candidate.cells):
        cell = replace(given, lag_disturbance=Fraction("0.003"))
        v = loop_vertices(cell)
        scales = [
            largest_scale(P, v.A[s::2], v.fixed[s::2], v.per_wind_error[s::2], limit=50)
            for s in (0, 1)
        ]
        (tight, _), (loose, alpha) = scales[binding], scales[1 - binding]
        if tight == 0 or loose < 1.02 * tight:
            continue
        found += 1
        stated = built.document["claims"][0]["cells"][k] | {"lag_disturbance": 0.003}
        error, rate = (tight + loose) / 2, stated["wind_rate"]
        assert "invariance" in decided(stated, P.tolist(), error, rate, alpha)
        if found == 3:
            break
    assert found


@pytest.mark.parametrize("wrong", [0, 0.02], ids=["table's c_P", "c_P 2 % off"])
def test_the_residual_bound_covers_the_torque_that_the_tables_leave(
    built: Any, wrong: float
) -> None:
    """Sampled between the nodes of every cell, by the float model of the plant."""
    power = (1 - Fraction(str(wrong)), 1 + Fraction(str(wrong)))
    known = subject(built.document)
    turbine, table = built.turbine, built.law.schedule
    close = 0
    for k in range(len(table.wind) - 1):
        v = np.linspace(table.wind[k], table.wind[k + 1], 41)
        speed, q, b = (
            np.interp(v, table.wind, column)
            for column in (table.rotor_speed, table.trim_effort, table.effectiveness)
        )
        pitch = turbine.pitch_min + effort_ramp(q, table.overlap) / b
        torque = built.law.rated_torque - built.law.effort_torque * effort_ramp(-q, table.overlap)
        rotor = rotor_torque(turbine, speed, pitch, v)
        left = [float(s) * rotor - turbine.gear_ratio * torque for s in power]
        sampled = float(np.abs(left).max() / turbine.inertia)
        bound = Loop(known, k, Fraction(0)).residual(power) / ONE
        assert sampled <= bound
        close += sampled > 0.2 * bound
    # A bound five times too small would have been noticed in these cells.
    assert close > 20


def test_a_set_that_may_demand_negative_torque_is_refused(built: Any) -> None:
    """A wider speed signal reaches below zero torque where little is in reserve: at low wind."""
    box = subject(built.document).box
    wide = 2 * box.speed_signal

    assert not first_failure(loop(built.document, 0).limits())
    assert "negative torque" in first_failure(loop(built.document, 0, speed_signal=wide).limits())
