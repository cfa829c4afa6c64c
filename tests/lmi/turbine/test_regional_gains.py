"""Regional gains: what the LMIs promise, looked at on the ellipsoid and on the nonlinear plant."""

from __future__ import annotations

import re
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from takagi.lmi.turbine.region_request import Requirement, region_request
from takagi.lmi.turbine.regional import RegionalGains, RegionGains, region_gains, regional_gains
from takagi.models import Floats, ModelError, nrel5mw
from takagi.models.turbine.trim import trim
from tests.paper_models import regional_models

TURBINE = nrel5mw()


@cache
def design() -> RegionalGains:
    """The default requirements."""
    partial, full = regional_models()
    return regional_gains(TURBINE, partial_model=partial, full_model=full)


def parts() -> tuple[RegionGains, RegionGains]:
    return design().partial, design().full


def boundary(P: Floats, count: int) -> Floats:
    x = np.random.default_rng(5).normal(size=(count, len(P)))
    scale = np.sqrt(np.einsum("ki,ij,kj->k", x, P, x))
    return np.asarray(x / scale[:, None])


def blends(count: int, rules: int) -> Floats:
    return np.vstack([np.eye(rules), np.random.default_rng(6).dirichlet(np.ones(rules), count)])


@pytest.mark.parametrize("which", [0, 1])
def test_every_blend_decays_at_the_rate_asked(which: int) -> None:
    """He(P (A - B K)) + 2 alpha P <= 0 for A and K blended by the same h: recomputed from P."""
    part = parts()[which]
    assert part.P is not None
    for h in blends(40, len(part.gains)):
        A = np.tensordot(h, part.model.A, 1) - part.model.B[0] @ np.tensordot(h, part.gains, 1)
        worst = np.linalg.eigvals(np.linalg.solve(part.P, part.P @ A + A.T @ part.P)).real.max()
        assert worst <= -2 * part.requirement.decay_rate


@pytest.mark.parametrize("which", [0, 1])
def test_published_signs(which: int) -> None:
    """k_x < 0 on speed (too fast: more torque, more pitch) and k_I = -K_I < 0 on every rule."""
    k_x, k_I = parts()[which].require()

    assert np.all(k_x[:, 0] < 0) and np.all(k_I < 0)
    np.testing.assert_array_equal(parts()[which].gains[:, 0, -1], -k_I)


@pytest.mark.parametrize("which", [0, 1])
def test_operating_set_lies_in_the_ellipsoid_and_that_in_the_box(which: int) -> None:
    """The stated errors have V <= 1, and V <= 1 stays where the model is exact."""
    part = parts()[which]
    asked, P = part.requirement, part.P
    assert P is not None
    signs = [(1, 1), (1, -1)]
    corners = [[a * asked.speed_error, b * asked.pitch_error, 0.0] for a, b in signs]
    for corner in corners:
        x = np.array(corner if len(P) == 3 else [corner[0], 0.0])
        assert x @ P @ x <= 1
    widths = np.sqrt(np.diag(np.linalg.inv(P)))
    for name, width in zip(part.model.states, widths, strict=True):
        if name in part.model.box:
            assert width <= float(part.model.box[name][1])


def test_torque_stays_within_its_limits_on_the_ellipsoid() -> None:
    """T* + dT lies in 0..T_max at every wind of the region, for every blend of gains."""
    part = design().partial
    assert part.P is not None
    x, h = boundary(part.P, 400), blends(50, 4)
    deviation = np.abs(np.einsum("bi,iun,kn->bk", h, part.gains, x)).max()
    torques = [trim(TURBINE, v).torque for v in np.linspace(4.1, 11.45, 99)]

    assert deviation <= min(torques) and max(torques) + deviation <= TURBINE.maximum_torque
    (limit, largest) = part.bounds["torque within its limits"]
    assert deviation <= largest * (1 + 1e-9) and largest <= limit


def test_demanded_pitch_rate_stays_within_its_limit_on_the_ellipsoid() -> None:
    """|beta_ref - beta|/tau <= 8 deg/s and beta* + d_ref >= smallest pitch, every blend."""
    part = design().full
    assert part.P is not None
    x, h = boundary(part.P, 400), blends(50, 8)
    command = -np.einsum("bi,iun,kn->bk", h, part.gains, x)
    rate = np.abs(command - x[:, 1]).max() / TURBINE.pitch_time_constant
    lowest = trim(TURBINE, 11.951).pitch

    assert rate <= TURBINE.pitch_rate_limit
    assert lowest - np.abs(command).max() >= TURBINE.pitch_min


def test_least_demand_agrees_with_cvxpy() -> None:
    cp: Any = import_module("cvxpy")
    part = design().full
    (_, ours) = part.bounds["pitch reference above the smallest pitch"]
    task = region_request(TURBINE, part.model, part.requirement, None)
    s, u = task.scales, task.unit
    A, B = part.model.A * s / s[:, None], part.model.B[0] * u / s[:, None]
    Q, mu = cp.Variable((3, 3), symmetric=True), cp.Variable((1, 1))
    M = [cp.Variable((1, 3)) for _ in A]
    limit = task.bounds[1].limit / u
    drive = np.array([[0.0, s[1] / u, 0.0]])
    constraints = [Q >> 1e-6 * np.eye(3), Q[0, 0] <= (task.box[0] / s[0]) ** 2]
    constraints.append(Q[1, 1] <= (task.box[1] / s[1]) ** 2)
    for sign in (1.0, -1.0):
        x = np.array([[part.requirement.speed_error, sign * part.requirement.pitch_error, 0]]) / s
        constraints.append(cp.bmat([[np.ones((1, 1)), x], [x.T, Q]]) >> 0)
    for A_i, M_i in zip(A, M, strict=True):
        G = A_i @ Q - B @ M_i
        constraints.append(G + G.T + 2 * part.requirement.decay_rate * Q << 0)
        constraints.append(cp.bmat([[mu, M_i], [M_i.T, Q]]) >> 0)
        rate = M_i + drive @ Q
        constraints.append(cp.bmat([[np.full((1, 1), limit**2), rate], [rate.T, Q]]) >> 0)
    problem = cp.Problem(cp.Minimize(mu[0, 0]), constraints)
    problem.solve(solver="CLARABEL")

    assert float(np.sqrt(problem.value)) * u == pytest.approx(ours, rel=0.02)


def test_infeasible_names_region_winds_and_cures() -> None:
    _, full = regional_models()
    asked = Requirement(decay_rate=0.15, speed_error=0.02, pitch_error=0.005)
    answer = region_gains(TURBINE, full, asked)
    found = re.search(r"lower the decay rate to ([\d.]+) 1/s", answer.diagnosis)

    assert answer.status == "infeasible" and answer.k_x is None
    assert "full load, 11.95 to 25 m/s" in answer.diagnosis
    assert "decay of rule" in answer.diagnosis
    assert found is not None
    slower = Requirement(float(found.group(1)) * 0.99, asked.speed_error, asked.pitch_error)
    assert region_gains(TURBINE, full, slower).found
    with pytest.raises(ModelError, match="no gains were found"):
        answer.require()


def test_misuse_is_explained() -> None:
    partial, _ = regional_models()
    with pytest.raises(ModelError, match="the model is exact up to"):
        region_gains(TURBINE, partial, Requirement(decay_rate=0.1, speed_error=0.2))
    with pytest.raises(ModelError, match="must exceed 0"):
        Requirement(decay_rate=0.0, speed_error=0.02)
