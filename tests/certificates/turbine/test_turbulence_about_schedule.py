"""The nonlinear loop about the schedule wind, of ``benchmarks/turbulence_exit_nonlinear.py``."""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov

from tests.certificates.recorded.answers import recorded

about: Any = import_module("turbulence_exit_about_schedule")
linear: Any = import_module("turbulence_exit_loop")
HORIZON, EACH = 600.0, 0.2


@pytest.fixture(scope="module")
def law(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return the law of the recorded certificate."""
    document = json.loads(next(recorded("running-loop"))[1])
    claim, path = document["claims"][0], Path(tmp_path_factory.mktemp("law")) / "gains.json"
    parts = {name: claim[name] for name in ("observer", "measurement")}
    path.write_text(json.dumps({"law": document["gains"]} | parts), encoding="utf-8")
    return linear.Law.read(path)


@pytest.mark.parametrize("wind", [12.7, 15.2, 18.2, 21.2])
def test_the_modes_are_those_of_the_loop_about_the_present_wind(law: Any, wind: float) -> None:
    """Two derivations of one linear loop, in different coordinates, have the same eigenvalues.

    The loop about the present wind has one state more, the wake's lag behind the wind; without its
    effect it is a mode by itself.
    """
    loop = about.Loop(law, wind)
    here = np.append(np.linalg.eigvals(loop.slope(np.zeros(about.N))), -wind / linear.WAKE_LENGTH)
    there = np.linalg.eigvals(linear.linear_loop(law, wind, loop.wind, (1, 1, 1, 1, 0)))

    assert np.sort_complex(here) == pytest.approx(np.sort_complex(there), abs=2e-3)


def test_nothing_moves_at_the_trim_of_another_schedule_wind(law: Any) -> None:
    """Only the wind returns to its mean; the tables' residual is left in the speeds."""
    loop = about.Loop(law, 18.0)
    z = np.zeros((about.N, 1))
    z[about.Y] = -3.0
    rates = loop.rates(z)[:, 0]

    assert rates[about.R] == pytest.approx(3 * loop.wind.stiffness)
    rates[about.R] = 0
    assert np.abs(rates).max() < 1e-3


def test_the_wind_leaves_its_reach_as_seldom_as_stated() -> None:
    """4000 exact runs from rest: below the bound, and above a third of it."""
    tau, wind = 12.0, linear.Wind.of_class_b(15.0)
    reach = about.Reach.of(15.0, tau, HORIZON, EACH)
    A = np.array([[0, 1, 0], [-wind.stiffness, -wind.damping, 0], [0, 1, -1 / tau]])
    S = np.array([[0.0], [wind.noise], [0.0]])
    spread, flow = solve_continuous_lyapunov(A, -S @ S.T), expm(A)
    left, vectors = np.linalg.eigh(spread - flow @ spread @ flow.T)
    root = vectors * np.sqrt(np.maximum(left, 0))
    random, z = np.random.default_rng(5), np.zeros((3, 4000))
    largest = np.zeros((3, 4000))
    for _ in range(round(HORIZON)):
        z = flow @ z + root @ random.standard_normal(z.shape)
        largest = np.maximum(largest, np.abs([z[0], z[2], z[0] - z[2]]))
    sides = np.array([[reach.wind], [reach.lag], [reach.schedule]])
    shares = (largest > sides).mean(axis=1)

    assert reach.probability == pytest.approx(3 * EACH)
    assert (shares < EACH).all() and (shares > EACH / 3).all()
