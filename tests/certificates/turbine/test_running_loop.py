"""The running loop's candidate: the nonlinear loop, written anew here, does what it says."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.certificates.claims.turbine.running_loop import (
    Machine,
    Running,
    Signals,
    combined,
    decay_form,
    inequality_failure,
    loop_subject,
    running_candidate,
)
from takagi.lmi.turbine import effort_gains
from takagi.models import Turbine, nrel5mw
from takagi.models.laws import EffortSharingLaw, effort_schedule
from takagi.models.turbine import rotor_torque

L1, L2, CORNER, FILTER = 1.7942, 48.8767, 4.0, 12.0
F = Fraction


def machine() -> Machine:
    return Machine(F("1.7942"), F("48.8767"), (F("1.5"), F("37.5")), F(4), F(12), (F(40), F(80)))


@pytest.fixture(scope="module")
def nrel() -> Turbine:
    return nrel5mw()


@pytest.fixture(scope="module")
def subject(nrel: Turbine) -> Any:
    schedule = effort_schedule(nrel, effectiveness_share=1.0)
    gains = effort_gains(nrel, schedule).gains
    law = EffortSharingLaw.of(nrel, schedule, gains, wind_filter=FILTER)
    sides = (F("0.03"), F("0.01"), F("0.03"), F("0.01"))
    return loop_subject(nrel, law, sides, (F("0.9"), F("1.1")))


def cell(subject: Any, wind: Fraction) -> tuple[int, tuple[Fraction, Fraction]]:
    nodes = subject.law.wind
    k = max(i for i in range(len(nodes) - 1) if nodes[i] <= wind)
    return k, (wind, min(wind + F(1, 50), nodes[k + 1]))


def test_uncertain_factor_of_one_state() -> None:
    # x' = a x with a in [-3, -1] falls at 1 and not at more.
    signals = Signals(1)
    rate = signals.times("a", (F(-3), F(-1)), signals.state(0))
    held = decay_form(signals, [rate], [[F(1)]], [F(1)], F("0.9"))
    assert held[0][0] * held[1][1] > held[0][1] ** 2 and held[0][0] > 0
    fast = decay_form(signals, [rate], [[F(1)]], [F(1)], F("1.1"))
    assert fast[0][0] * fast[1][1] < fast[0][1] ** 2
    assert combined((2, {0: F(1)}), (1, {0: F(1), 1: F(3)})) == {0: F(3), 1: F(3)}


@pytest.mark.parametrize("wind", ["5", "8", "12.1", "15", "22"])
def test_function_falls_along_the_nonlinear_loop(subject: Any, nrel: Turbine, wind: str) -> None:
    k, winds = cell(subject, F(wind))
    found, why = running_candidate(subject, machine(), k, winds, decay=F(1, 500))
    assert found is not None, why
    loop = Running(subject, machine(), k, winds, found.sides)
    assert inequality_failure(loop, found) == ""
    P = np.array(found.P, dtype=float)
    rng, root = np.random.default_rng(3), np.linalg.inv(np.linalg.cholesky(P)).T
    v = float(sum(winds) / 2)
    for _ in range(300):
        direction = rng.normal(size=8)
        xi = root @ (direction / np.linalg.norm(direction)) * rng.uniform(0.2, 0.99)
        rate = nonlinear(subject, nrel, loop, v, xi, rng)
        if rate is not None:
            assert 2 * xi @ P @ rate < -2 * float(found.decay) * (xi @ P @ xi) * 0.999


def test_changed_function_fails(subject: Any) -> None:
    k, winds = cell(subject, F(8))
    found, why = running_candidate(subject, machine(), k, winds)
    assert found is not None, why
    loop = Running(subject, machine(), k, winds, found.sides)
    wider = [[value * F("0.5") for value in row] for row in found.P]
    object.__setattr__(found, "P", wider)
    assert "leaves its box" in inequality_failure(loop, found)
    unstable = Running(
        subject, Machine(F("1.7942"), F(5000), (F("1.5"), F("37.5")), F(4), F(12), (F(40), F(80))),
        k, winds, found.sides,
    )  # fmt: skip
    object.__setattr__(found, "P", [[value * 2 for value in row] for row in wider])
    assert inequality_failure(unstable, found) == "the decay inequality fails"


def nonlinear(subject: Any, nrel: Turbine, loop: Running, v: float, xi: Any, rng: Any) -> Any:
    """Return the states' rates from the law's formulas; None where pitch is below its limit."""
    law, plant = subject.law, subject.plant
    nodes = np.array(law.wind, dtype=float)
    column = {name: np.array(getattr(law, name), dtype=float)
              for name in ("speed", "effort", "effectiveness", "gamma", "limit")}  # fmt: skip
    J, eps, E, b0 = nrel.inertia, float(law.overlap), float(law.effort_torque), float(loop.b0)

    def psi(s: float) -> float:
        return 0.0 if s <= -eps else s if s >= eps else (s + eps) ** 2 / (4 * eps)

    def at(name: str, w: float) -> float:
        return float(np.interp(w, nodes, column[name]))

    def torque(speed: float, pitch: float, wind: float) -> float:
        return float(rotor_torque(nrel, speed, pitch, wind)) / J

    def balance(x: float) -> tuple[float, float]:
        U = at("effort", v) - at("gamma", v) * x
        beta = float(law.pitch_min) + psi(U) / at("effectiveness", v)
        held = float(law.rated_torque) - E * psi(-U)
        return torque(at("speed", v), beta, v) - nrel.gear_ratio * held / J, beta

    low, high = -0.02, 0.02
    assert balance(low)[0] * balance(high)[0] < 0
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (low, middle) if balance(middle)[0] * balance(high)[0] > 0 else (middle, high)
        if balance(low)[0] * balance(high)[0] > 0:
            break
    x_rest, beta_rest = (low + high) / 2, balance((low + high) / 2)[1]
    e, p, x, s, m, o, z, eta = xi
    beta, vs, seen = beta_rest + p / b0, v + s, min(max(v + z, nodes[0]), nodes[-1])
    if beta < float(law.pitch_min) or not nodes[0] <= vs <= nodes[-1]:
        return None
    star = at("speed", v)
    i = min(max(int(np.searchsorted(nodes, vs, side="right")) - 1, 0), len(nodes) - 2)
    slope = {name: (values[i + 1] - values[i]) / (nodes[i + 1] - nodes[i])
             for name, values in column.items()}  # fmt: skip
    error = star + m - at("speed", vs)
    signal = error - x_rest - x
    U, rate = at("effort", vs) + at("gamma", vs) * signal, (seen - vs) / FILTER
    bound = float(law.inertia_limit[i])
    taken = min(max(float(law.inertia[i]) * rate, -bound), bound)
    held = float(law.rated_torque) - E * (psi(-U) + taken)
    held = min(max(held, 0.0), float(law.rated_torque))
    F1, b = min(max((U + eps) / (2 * eps), 0), 1), at("effectiveness", vs)
    moved = F1 * (slope["effort"] + slope["gamma"] * signal)
    moved -= psi(U) * slope["effectiveness"] / b
    asked = float(law.pitch_min) + (psi(U) + float(law.lead) * rate * moved) / b
    asked = max(asked, float(law.pitch_min))
    moving = (asked - beta) / float(plant.lag)
    moving = min(max(moving, -float(plant.rate_limit)), float(plant.rate_limit))
    late = rng.uniform(0, 1) * float(loop.factors["late pitch gain"][1])
    kappa, length = 1 / rng.uniform(0.9, 1.1), rng.uniform(40, 80)
    aero, load = torque(star + e, beta, v), nrel.gear_ratio * held / J
    return np.array([
        kappa * (aero - late * (p - eta) - load),
        b0 * moving,
        -float(law.nu[i]) * error,
        rate,
        CORNER * (e - m),
        torque(star + m, beta, v + z) - load + L1 * (m - o),
        L2 * (m - o),
        (p - eta) * v / length,
    ])  # fmt: skip
