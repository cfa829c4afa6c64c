"""Disturbed plants of several rules that the tests share, and what is done with their gains."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from takagi.lmi import Design
from takagi.models import Floats, TSModel
from tests.lmi.norms import sampled


def two_rules(sample_time: float | None = None) -> TSModel:
    """A stiff and an unstable oscillator, pushed where they are steered; z = (x1, 0.1 u)."""
    A = np.array([[[0.0, 1.0], [-0.5, -0.1]], [[0.0, 1.0], [0.5, -0.1]]])
    B, C, D = np.array([[0.0], [1.0]]), [[1.0, 0.0], [0.0, 0.0]], [[0.0], [0.1]]
    if sample_time is None:
        return TSModel(A, B, E=B, C=C, D=D)
    pairs = [sampled(vertex, B, sample_time) for vertex in A]
    Ad, Bd = [a for a, _ in pairs], [b for _, b in pairs]
    return TSModel(Ad, Bd, E=Bd, C=C, D=D, sample_time=sample_time)


def three_rules(sample_time: float | None = None) -> TSModel:
    """Three rules of three states, every matrix scattered; two disturbances, two outputs."""
    rng = np.random.default_rng(11)
    A = rng.standard_normal((3, 3)) + 0.3 * rng.standard_normal((3, 3, 3))
    B = rng.standard_normal((3, 2)) + 0.1 * rng.standard_normal((3, 3, 2))
    E, C = rng.standard_normal((3, 3, 2)), rng.standard_normal((3, 2, 3))
    D = 0.5 * rng.standard_normal((3, 2, 2))
    if sample_time is None:
        return TSModel(A, B, E=E, C=C, D=D)
    held = [sampled(a, np.hstack([b, e]), sample_time) for a, b, e in zip(A, B, E, strict=True)]
    Ad, Bd = np.array([a for a, _ in held]), np.array([b for _, b in held])
    return TSModel(Ad, Bd[:, :, :2], E=Bd[:, :, 2:], C=C, D=D, sample_time=sample_time)


def loop(model: TSModel, gains: Floats, h: Floats) -> tuple[Floats, Floats, Floats]:
    A, B, C, D, E, K = (
        np.tensordot(h, part, 1) for part in (model.A, model.B, model.C, model.D, model.E, gains)
    )
    return A - B @ K, E, C - D @ K


def blends(rules: int, count: int, seed: int = 0) -> Iterator[Floats]:
    yield from np.eye(rules)
    yield from np.random.default_rng(seed).dirichlet(np.ones(rules), count)


def gain_of(design: Design) -> float:
    assert design.status == "candidate", design.answer.diagnosis
    assert design.gain is not None
    return design.gain
