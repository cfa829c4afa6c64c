"""No DISPROVED where 20,000 blends decay with the function that the design or the family has."""

from __future__ import annotations

import csv
from importlib import import_module
from itertools import combinations, product
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.certificates import Verdict, certify
from takagi.lmi import pdc
from takagi.models import Premise, TSModel
from tests.certificates.kinds.claims import resealed, verdicts

pytestmark = pytest.mark.numeric

Floats = NDArray[np.float64]
family: Any = import_module("known_blends")
ladder: Any = import_module("kim_lee_ladder")

LADDER = Path(ladder.FIGURES) / "kim-lee-ladder.csv"
RELAXATIONS = tuple(ladder.RELAXATIONS)
BLENDS = 20_000


def frontier() -> dict[str, float]:
    with LADDER.open(encoding="utf-8", newline="") as file:
        return {row["relaxation"]: float(row["largest_b"]) for row in csv.DictReader(file)}


def grid(model: TSModel) -> Floats:
    if model.premises:
        side = np.linspace(0.0, 1.0, int(np.ceil(BLENDS ** (1 / len(model.rules[0])))))
        w = np.array(list(product(side, repeat=len(model.rules[0]))))
        columns = [np.where(np.array(c), w, 1 - w).prod(axis=1) for c in model.rules]
        return np.stack(columns, axis=1)
    r, parts = len(model.A), 1
    while prod(parts + k for k in range(1, r)) < BLENDS * prod(range(1, r)):
        parts += 1
    bars = np.array(list(combinations(range(parts + r - 1), r - 1)))
    ends = np.full((len(bars), 1), parts + r - 1)
    return np.diff(np.hstack([0 * ends - 1, bars, ends]), axis=1) / parts - 1 / parts


def loops(model: TSModel, K: Floats) -> Floats:
    h = grid(model)
    A, B, gains = (np.tensordot(h, stack, axes=1) for stack in (model.A, model.B, K))
    return np.asarray(A - B @ gains)


def falls(G: Floats, P: Floats, rate: float, step: float | None) -> bool:
    """Return whether x'Px falls at the rate [1/s] along every G."""
    L = np.linalg.cholesky(P)
    inside = np.linalg.solve(L, (G.transpose(0, 2, 1) @ L))
    if step is None:
        both = inside + inside.transpose(0, 2, 1) + 2 * rate * np.eye(len(P))
    else:
        both = inside @ inside.transpose(0, 2, 1) - np.exp(-2 * rate * step) * np.eye(len(P))
    return bool(np.linalg.eigvalsh(both)[:, -1].max() < 0)


def on_the_ladder(name: str) -> None:
    """One per cent inside the frontier, at rates that V has on the grid and at rates beyond."""
    b = frontier()[name]
    model = ladder.model(b - 0.01 * abs(b))
    K, P = pdc(model, relaxation=name).require()
    G = loops(model, K)
    slowest = -float(np.linalg.eigvals(G).real.max())
    assert len(G) >= BLENDS and falls(G, P, 0.0, None)

    assert certify(model, K, decay_rate=0.0).verdict is Verdict.PROVED
    seen = []
    for share in (0.5, 0.9, 0.999, 1.001, 1.5):
        verdict = certify(model, K, decay_rate=share * slowest).verdict
        seen.append(verdict)
        assert verdict is not Verdict.DISPROVED or not falls(G, P, share * slowest, None)
    assert seen[-1] is Verdict.DISPROVED and Verdict.PROVED not in seen[-2:]


@pytest.mark.parametrize("name", ["kim-lee"])
def test_the_ladder(name: str) -> None:
    """Kim and Lee (2000), a = 2: one of the relaxations; the others below."""
    on_the_ladder(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in RELAXATIONS if name != "kim-lee"])
def test_all_of_the_ladder(name: str) -> None:
    on_the_ladder(name)


def test_from_cheap_to_rich() -> None:
    """The example of docs/lmi.md, b = 2: Liu and Zhang's gains, as "auto" takes them there."""
    model = ladder.model(2.0)
    K, P = pdc(model, relaxation="liu-zhang").require()

    assert falls(loops(model, K), P, 0.0, None)
    assert certify(model, K, decay_rate=0.0).verdict is Verdict.PROVED


def scattered(seed: int, hair: float, premises: bool = False) -> tuple[TSModel, Floats, Floats]:
    """Return a model, gains and P; the fastest change of V is a hair below 0, or the blend above.

    With hair > 0 V = x'Px falls along the whole grid, |x|^2 in other states; with hair < 0 one
    blend of the grid has an eigenvalue to the right.
    """
    rng = np.random.default_rng(seed)
    r = 4 if premises else int(rng.integers(2, 4))
    A, B, K = (rng.normal(size=(r, *shape)) for shape in ((2, 2), (2, 1), (1, 2)))
    named_ = [Premise("p", 0, 1), Premise("q", 0, 1)] if premises else []
    G = loops(TSModel(A, B, premises=named_), K)
    if hair > 0:
        worst = np.linalg.eigvalsh(G + G.transpose(0, 2, 1))[:, -1].max() / 2
    else:
        worst = np.linalg.eigvals(G).real.max()
    T = np.array([[1.0, float(rng.integers(-3, 4))], [0.0, 1.0]])
    back = np.linalg.inv(T)
    moved = T @ (A - (worst + hair) * np.eye(2)) @ back
    model = TSModel(np.round(moved, 9), np.round(T @ B, 9), premises=named_)
    return model, np.round(K @ back, 9), back.T @ back


def on_scattered_rules(seeds: range) -> None:
    """What decays on the grid is PROVED, what does not is DISPROVED, a hair to either side."""
    for seed in seeds:
        for hair in (1e-3, -1e-3):
            model, K, P = scattered(seed, hair, premises=seed % 5 == 0)
            verdict = certify(model, K, decay_rate=0.0).verdict
            if hair > 0:
                assert falls(loops(model, K), P, 0.0, None)
                assert verdict is Verdict.PROVED
            else:
                assert verdict is Verdict.DISPROVED


def test_scattered_rules() -> None:
    """Two or three rules, or two premises, every matrix by chance."""
    on_scattered_rules(range(4))


@pytest.mark.slow
def test_many_scattered_rules(reduced: bool) -> None:
    on_scattered_rules(range(4, 14 if reduced else 204))


def on_known_sums(seeds: range) -> None:
    """Sums of ``known_blends``: the grid never contradicts the truth, nor the verdict either."""
    for seed in seeds:
        rng = np.random.default_rng([seed, 17])
        problem = (family.opposed_rules, family.sampled_rules)[seed % 2](rng)
        model = TSModel(problem.A, problem.B, sample_time=problem.step)
        G = loops(model, problem.K)
        size = np.abs(np.linalg.eigvals(G)) if problem.step else np.linalg.eigvals(G).real
        beyond = bool(size.max() > (1 if problem.step else -problem.rate) + 1e-9)
        verdict = certify(model, problem.K, decay_rate=problem.rate).verdict
        assert not (beyond and problem.truth)
        assert verdict is not (Verdict.PROVED if beyond else Verdict.DISPROVED) or (
            not beyond and not problem.truth
        )


def test_known_sums() -> None:
    """Quadratic forms on the simplex, at their limit or a hair beside it."""
    on_known_sums(range(6))


@pytest.mark.slow
def test_many_known_sums(reduced: bool) -> None:
    on_known_sums(range(6, 26 if reduced else 306))


def test_blends_of_another_loop_exclude_nothing() -> None:
    """The evidence of one loop beside the matrices of a faster one: neither checker takes it."""
    model, K, _ = scattered(1, -1e-3)
    document = dict(certify(model, K, decay_rate=0.0).document)
    faster = document["model"] | {"A": (np.array(document["model"]["A"]) - 9 * np.eye(2)).tolist()}
    moved = resealed(document | {"model": faster})

    assert verdicts(document)[-1] == "DISPROVED"
    assert verdicts(moved)[-1] != "DISPROVED"
