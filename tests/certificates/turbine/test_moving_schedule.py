"""What a moving schedule leaves of the pitch lead where the lower pitch limit cuts it."""

from __future__ import annotations

from fractions import Fraction
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop

OVERLAP = Fraction(1)


def moving(efforts: tuple[str, str], effort: str, b: tuple[str, str], gamma: str = "0") -> Loop:
    """Return a cell from wind 0 to 1 m/s that moves at 1 m/s^2, with the lag's own time as lead."""
    low, high = (Fraction(value) for value in efforts)
    law: Any = SimpleNamespace(
        wind=[Fraction(0), Fraction(1)],
        effort=[Fraction(0), Fraction(effort)],
        gamma=[Fraction(1), 1 + Fraction(gamma)],
        effectiveness=[Fraction(value) for value in b],
        overlap=OVERLAP,
        effort_torque=Fraction(1),
        lead=Fraction(2),
    )
    plant: Any = SimpleNamespace(lag=Fraction(2), rate_limit=Fraction(1), gear_per_inertia=1)
    box: Any = SimpleNamespace(speed_signal=Fraction(1), effort_lag=Fraction(1))
    law.slope = partial(Law.slope, law)
    subject: Any = SimpleNamespace(
        plant=plant,
        law=law,
        box=box,
        uncertainty=SimpleNamespace(kappa=(Fraction(1),) * 2, power=(Fraction(1),) * 2),
    )
    found = Loop(subject, 0, Fraction(1))
    found.efforts = low, high
    return found


def largest(efforts: tuple[str, str], A: float, c: float) -> float:
    """Return max(0, sup A F(s) - c psi(s)) over efforts s by a fine grid, from F and psi."""
    low, high = (float(value) for value in efforts)
    s = np.union1d(np.linspace(low, high, 100_001), np.clip([-1, 1], low, high))
    F = np.clip((s + 1) / 2, 0, 1)
    psi = np.where(s >= 1, s, np.where(s <= -1, 0, (s + 1) ** 2 / 4))
    return max(0.0, float(np.max(A * F - c * psi)))


@pytest.mark.parametrize(
    ("efforts", "effort", "b", "gamma", "A", "c"),
    [
        # c = 1/tau - |b'/b|, A = |q'| + |gamma'| * signal
        (("-2", "3"), "0.25", ("1", "2"), "0", 0.25, -0.5),
        (("-2", "0.5"), "0.25", ("1", "2"), "0", 0.25, -0.5),
        (("-2", "3"), "0.25", ("1", "1.5"), "0", 0.25, 0.0),
        (("2", "3"), "3", ("1", "1"), "0", 3.0, 0.5),
        (("1", "3"), "-3", ("1", "1"), "0", 3.0, 0.5),
        (("7", "8"), "3", ("1", "1"), "0", 3.0, 0.5),
        (("-2", "5"), "0.3", ("1", "1"), "0.3", 0.6, 0.5),
        (("-2", "-0.5"), "0.3", ("1", "1"), "-0.3", 0.6, 0.5),
        (("-2", "5"), "2", ("1", "1"), "0", 2.0, 0.5),
        (("0.5", "5"), "0.9", ("1", "1"), "0", 0.9, 0.5),
        (("0.5", "5"), "0.2", ("1", "1"), "0", 0.2, 0.5),
        (("-3", "-2"), "2", ("1", "1"), "0", 2.0, 0.5),
    ],
    ids=[
        *("no c left", "no c left, inside the ramp", "c is zero"),
        *("beyond the ramp", "from the ramp's end", "beyond what counts"),
        *("greatest inside the ramp", "greatest at the upper effort", "greatest at full pitch"),
        *("greatest at the lower effort", "nothing is left", "no pitch at all"),
    ],
)
def test_what_the_cut_lead_leaves(
    efforts: tuple[str, str], effort: str, b: tuple[str, str], gamma: str, A: float, c: float
) -> None:
    """The bound is the supremum, in every branch: never below it, and not above."""
    found = float(moving(efforts, effort, b, gamma).lag_disturbance())

    assert found == pytest.approx(largest(efforts, A, c), rel=1e-8, abs=1e-8)
