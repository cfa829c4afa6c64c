"""The plant of a structured design, with the disturbance and the output of the objective."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import input_stack, sample_time_of, symmetric, vertex_stack
from takagi.lmi.gains.cost.condition import initial_factor
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant, Performance, plant_of
from takagi.lmi.gains.structured.sums import Objective
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError


def plant_for(
    model: Controlled,
    objective: Objective,
    *,
    Q: ArrayLike | None,
    R: ArrayLike | None,
    deviations: ArrayLike,
    performance: Performance | None,
    sample_time: float | None,
) -> tuple[DisturbedPlant, Floats]:
    """Return the plant, and L of the covariance L L' of x(0).

    For "cost" the output is z = [F x; G u] with Q = F' F, R = G' G, so that |z|^2 is the cost's
    integrand.

    Raises
    ------
    ModelError : an argument that the objective needs is missing, or one that it does not use is
        given; otherwise as ``lqr_pdc`` and ``hinf_pdc``.
    """
    _check_given(objective, {"Q": Q, "R": R}, performance)
    A = vertex_stack(model).astype(np.float64)
    n = A.shape[1]
    if objective == "hinf":
        return plant_of(model, performance, sample_time), np.eye(n)
    B = input_stack(model, A).astype(np.float64)
    r, _, m = B.shape
    C, D12 = np.zeros((r, 1, n)), np.zeros((r, 1, m))
    if objective == "cost":
        assert Q is not None and R is not None  # _check_given has checked this
        F = _root(symmetric("Q", Q, n, definite=False))
        G = _root(symmetric("R", R, m, definite=True))
        C = np.broadcast_to(np.concatenate([F, np.zeros((m, n))]), (r, len(F) + m, n))
        D12 = np.broadcast_to(np.concatenate([np.zeros((len(F), m)), G]), (r, len(F) + m, m))
    plant = DisturbedPlant(
        A=A,
        B=B,
        E=np.zeros((r, n, 1)),
        C=C,
        D12=D12,
        D11=np.zeros((r, C.shape[1], 1)),
        sample_time=sample_time_of(model, sample_time),
        premises=tuple(getattr(model, "premises", ())),
        rules=tuple(getattr(model, "rules", ())),
    )
    return plant, np.asarray(initial_factor(deviations, n), dtype=np.float64)


def _check_given(objective: Objective, weights: Mapping[str, object], performance: object) -> None:
    for name, value in weights.items():
        if objective == "cost" and value is None:
            raise ModelError(f'objective is "cost", but there is no {name}; give Q and R')
        if objective != "cost" and value is not None:
            raise ModelError(f'{name} was given, but objective is "{objective}"; leave it out')
    if objective != "hinf" and performance is not None:
        raise ModelError(f'performance was given, but objective is "{objective}"; leave it out')


def _root(weight: Floats) -> Floats:
    """Return F with F' F = weight; directions of eigenvalue 0 have no row."""
    values, vectors = np.linalg.eigh(weight)
    keep = values > 1e-14 * max(values[-1], 1e-300)
    if not keep.any():
        return np.zeros((1, len(weight)))
    return np.asarray(np.sqrt(values[keep])[:, None] * vectors[:, keep].T)
