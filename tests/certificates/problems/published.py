"""Published LMIs and conic problems as files of other programs, each with what is known of it.

``python -m tests.certificates.problems.published`` prints the table of docs/verify.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations_with_replacement, product
from math import sqrt
from pathlib import Path
from typing import Any

import cvxpy as cp
import numpy as np
import scipy.io
from numpy.typing import ArrayLike, NDArray

from takagi.lmi import save_cvxpy
from tests.lmi.known_models import masses_and_spring, oscillators, planar_pair
from tests.lmi.norms import third_order

Floats = NDArray[np.float64]
FEASIBLE, INFEASIBLE, UNBOUNDED, OPEN = "feasible", "no solution", "no bound", "undecided"


@dataclass(frozen=True)
class Lmi:
    """Minimise cost'x, with every S_k(x) = F_k0 + sum_i x_i F_ki semidefinite."""

    cost: Floats
    blocks: tuple[Floats, ...]


def affine(cost: ArrayLike, *functions: Callable[[Floats], ArrayLike]) -> Lmi:
    c = np.asarray(cost, dtype=np.float64)
    blocks = []
    for function in functions:
        constant = np.asarray(function(np.zeros(len(c))), dtype=np.float64)
        slopes = [np.asarray(function(unit)) - constant for unit in np.eye(len(c))]
        blocks.append(np.array([constant, *slopes], dtype=np.float64))
    return Lmi(c, tuple(blocks))


# ------------------------------------------------------------------ the four formats


def write_sdpa(lmi: Lmi, path: Path) -> None:
    sizes = [block.shape[1] for block in lmi.blocks]
    head = [f"{len(lmi.cost)}", f"{len(sizes)}", " ".join(map(str, sizes))]
    head.append(" ".join(map(repr, lmi.cost.tolist())))
    rows = [
        f"{i} {k} {r + 1} {s + 1} {float(-F[r, s] if i == 0 else F[r, s])!r}"
        for k, block in enumerate(lmi.blocks, start=1)
        for i, F in enumerate(block)
        for r, s in zip(*np.nonzero(np.triu(F)), strict=True)
    ]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")


def write_cbf(lmi: Lmi, path: Path) -> None:
    m, entries = len(lmi.cost), list(_lower(lmi))
    linear = [f"{i} {c!r}" for i, c in enumerate(lmi.cost.tolist()) if c]
    H = [f"{k} {i - 1} {r} {s} {v!r}" for k, i, r, s, v in entries if i]
    D = [f"{k} {r} {s} {v!r}" for k, i, r, s, v in entries if not i]
    lines = ["VER", "3", "OBJSENSE", "MIN", "VAR", f"{m} 1", f"F {m}", "PSDCON"]
    lines += [f"{len(lmi.blocks)}", *(f"{block.shape[1]}" for block in lmi.blocks)]
    for name, rows in (("OBJACOORD", linear), ("HCOORD", H), ("DCOORD", D)):
        lines += [name, f"{len(rows)}", *rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _lower(lmi: Lmi) -> Iterator[tuple[int, int, int, int, float]]:
    for k, block in enumerate(lmi.blocks):
        for i, F in enumerate(block):
            for r, s in zip(*np.nonzero(np.tril(F)), strict=True):
                yield k, i, int(r), int(s), float(F[r, s])


def write_sedumi(lmi: Lmi, path: Path) -> None:
    c = np.concatenate([block[0].ravel() for block in lmi.blocks])
    A = [-np.concatenate([block[i].ravel() for block in lmi.blocks])
         for i in range(1, len(lmi.cost) + 1)]  # fmt: skip
    sizes = [float(block.shape[1]) for block in lmi.blocks]
    scipy.io.savemat(path, {"A": np.array(A), "b": -lmi.cost, "c": c, "K": {"s": sizes}})


def write_cvxpy(lmi: Lmi, path: Path) -> None:
    x = cp.Variable(len(lmi.cost))
    constraints = [
        block[0] + sum(x[i] * block[i + 1] for i in range(len(lmi.cost))) >> 0
        for block in lmi.blocks
    ]
    save_cvxpy(cp.Problem(cp.Minimize(lmi.cost @ x), constraints), path)


WRITERS = {
    ".dat-s": write_sdpa, ".cbf": write_cbf, ".mat": write_sedumi, ".npz": write_cvxpy,
}  # fmt: skip


@dataclass(frozen=True)
class Published:
    """A problem of the literature as a file, what is known of it, and by how much that may be off.

    The file is that of ``lmi``, or what ``write`` writes; its name's ending chooses the reader.
    """

    name: str
    source: str
    known: str | float
    lmi: Callable[[], Lmi] | None = None
    digits: float = 0.0
    text: str = ""
    write: Callable[[Path], None] | None = None

    def written(self, folder: Path) -> Path:
        path = folder / self.name
        if self.write is not None:
            self.write(path)
        elif self.lmi is not None:
            WRITERS[path.suffix](self.lmi(), path)
        return path


# ------------------------------------------------------------------ manuals of solvers


def symmetric(*lower: float) -> Floats:
    size = round(sqrt(2 * len(lower)))
    matrix = np.zeros((size, size))
    matrix[np.tril_indices(size)] = lower
    return np.asarray(matrix + matrix.T - np.diag(np.diag(matrix)))


def from_lists(cost: ArrayLike, *blocks: Sequence[Floats]) -> Lmi:
    """Return the LMI of SDPA's matrices F_0, ..., F_m by blocks; F_0 is subtracted."""
    return Lmi(np.asarray(cost, dtype=np.float64),
               tuple(np.array([-F[0], *F[1:]]) for F in blocks))  # fmt: skip


def sdpa_one() -> Lmi:
    matrices = [(-11, 0, 23), (10, 4, 0), (0, 0, -8), (0, -8, -2)]
    return from_lists([48, -8, 20], [symmetric(*entries) for entries in matrices])


def sdpa_two() -> Lmi:
    """The data as in QICS's documentation, with the optimal x that is printed there."""
    first = [(-1.4, -3.2, -28), (0.5, 5.2, -5.3), (1.7, 7.0, -9.3), (6.3, -7.5, -3.3)]
    first += [(-2.4, -2.5, -2.9), (-6.5, -5.4, -6.6)]
    second = [(15, -12, 16, 2.1, -3.8, 15), (7.8, -2.4, 4.2, 6.0, 6.5, 2.1)]
    second += [(-1.9, -0.9, -0.8, -1.3, -2.1, 4.0), (0.2, 8.8, 3.4, 5.4, -0.4, 7.5)]
    second += [(3.4, -3.2, 3.0, -4.5, -4.8, 3.6), (6.7, -7.2, 7.3, -3.6, -3.0, -1.4)]
    third = [(1.8, -4.0), (-4.5, -3.5), (-0.2, -3.7), (-3.3, -4.0), (4.8, 9.7), (6.1, -1.5)]
    blocks = [[symmetric(*entries) for entries in block] for block in (first, second)]
    return from_lists([1.1, -10, 6.6, 19, 4.1], *blocks, [np.diag(d) for d in third])


def csdp_guide() -> Lmi:
    first = [symmetric(2, 1, 2), symmetric(3, 1, 3), np.zeros((2, 2))]
    second = [symmetric(3, 0, 2, 1, 0, 3), np.zeros((3, 3)), symmetric(3, 0, 4, 1, 0, 5)]
    return from_lists([1, 2], first, second, [np.diag(d) for d in ((0, 0), (1, 0), (0, 1))])


def mosek_sdo1(path: Path) -> None:
    """A matrix variable, a second-order cone and two equations, as the format has them."""
    ones = "\n".join(f"1 0 {i} {j} 1" for i in range(3) for j in range(i + 1))
    path.write_text(
        "VER\n3\nOBJSENSE\nMIN\nPSDVAR\n1\n3\nVAR\n3 1\nQ 3\nCON\n2 1\nL= 2\n"
        "OBJFCOORD\n5\n0 0 0 2\n0 1 0 1\n0 1 1 2\n0 2 1 1\n0 2 2 2\nOBJACOORD\n1\n0 1\n"
        f"FCOORD\n9\n0 0 0 0 1\n0 0 1 1 1\n0 0 2 2 1\n{ones}\n"
        "ACOORD\n3\n0 0 1\n1 1 1\n1 2 1\nBCOORD\n2\n0 -1\n1 -0.5\n",
        encoding="utf-8",
    )


def cvxopt_socp(path: Path) -> None:
    x = cp.Variable(3)
    first = np.array([[-13.0, 3, 5], [-12, 12, -6]]) @ x - np.array([3.0, 2])
    second = np.array([[-3.0, 6, 2], [1, 9, 2], [-1, -19, 3]]) @ x + np.array([0.0, 3, -42])
    constraints = [
        cp.SOC(np.array([-12.0, -6, 5]) @ x - 12, first),
        cp.SOC(np.array([-3.0, 6, -10]) @ x + 27, second),
    ]
    save_cvxpy(cp.Problem(cp.Minimize(-2 * x[0] + x[1] + 5 * x[2]), constraints), path)


def mincx() -> Lmi:
    """Minimise trace X with [A'X + XA + Q, XB; B'X, -I] negative semidefinite."""
    A = np.array([[-1.0, -2, 1], [3, 2, 1], [1, -2, -1]])
    B, Q = np.array([[1.0], [0], [1]]), symmetric(1, -1, -3, 0, -12, -36)

    def inequality(x: Floats) -> Floats:
        X = symmetric(*x)
        return -np.block([[A.T @ X + X @ A + Q, X @ B], [B.T @ X, -np.eye(1)]])

    return affine([1, 0, 1, 0, 0, 1], inequality)


# ------------------------------------------------------------------ theorems


def jansson(epsilon: float, delta: float, path: Path) -> None:
    """Maximise y_1 + epsilon y_2 with [-y_2, (1 + y_1)/2, -y_3; ., delta, -y_4; ., ., delta]."""
    C = [0, 0.5, 0, 0.5, delta, 0, 0, 0, delta]
    A = [[0, -0.5, 0, -0.5, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 0, 0, 0, 0]]
    A += [[0, 0, 1, 0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 0, 1, 0, 1, 0]]
    data = {"A": np.array(A, dtype=float), "b": [1, epsilon, 0, 0], "c": C, "K": {"s": 3.0}}
    scipy.io.savemat(path, data)


# x in the cone of second order with x_1 + x_3 / 2 = 0 and x_2 = 1, and its dual.
CONE_ROWS = np.array([[1, 0, 0.5], [0, 1, 0]])


def ben_tal(path: Path) -> None:
    x = cp.Variable(3)
    constraints = [CONE_ROWS @ x == np.array([0, 1]), cp.SOC(x[0], x[1:])]
    save_cvxpy(cp.Problem(cp.Minimize(0), constraints), path)


def ben_tal_dual(path: Path) -> None:
    scipy.io.savemat(path, {"A": CONE_ROWS, "b": [0, 1], "c": [0, 0, 0], "K": {"q": 3.0}})


def theta_of_pentagon() -> Lmi:
    """Minimise t with t I - J + sum of y_e E_e over the edges semidefinite."""

    def slack(x: Floats) -> Floats:
        M = x[0] * np.eye(5) - np.ones((5, 5))
        for k in range(5):
            M[k, (k + 1) % 5] += x[1 + k]
            M[(k + 1) % 5, k] += x[1 + k]
        return np.asarray(M)

    return affine([1, 0, 0, 0, 0, 0], slack)


def cut_of_pentagon(path: Path) -> None:
    X = cp.Variable((5, 5), symmetric=True)
    cut = sum((1 - X[k, (k + 1) % 5]) / 2 for k in range(5))
    save_cvxpy(cp.Problem(cp.Maximize(cut), [X >> 0, cp.diag(X) == 1]), path)


def correlation(sign: float) -> Lmi:
    """Correlations -0.2 <= a <= -0.1 and 0.4 <= b <= 0.5; the third is least, or largest."""
    return affine(
        [0, 0, sign],
        lambda x: symmetric(1, x[0], 1, x[2], x[1], 1),
        lambda x: np.diag([x[0] + 0.2, -0.1 - x[0], x[1] - 0.4, 0.5 - x[1]]),
    )


def common_function(vertices: Floats, rate: float = 0.0) -> Lmi:
    """P - I and -(A_i'P + P A_i) - rate P semidefinite; the zero objective asks for a point."""
    n = vertices.shape[1]

    def decay(A: Floats) -> Callable[[Floats], Floats]:
        return lambda x: -(A.T @ symmetric(*x) + symmetric(*x) @ A) - rate * symmetric(*x)

    above = [lambda x: symmetric(*x) - np.eye(n)]
    return affine(np.zeros(n * (n + 1) // 2), *above, *map(decay, vertices))


GEVP = np.array([[[-1, 2], [1, -3]], [[-0.8, 1.5], [1.3, -2.7]], [[-1.4, 0.9], [0.7, -2]]])


def energy_gain(A: Floats, B: Floats, C: Floats) -> Lmi:
    """Minimise gamma with the bounded-real inequality at every vertex, and P semidefinite."""
    n, q, p = A.shape[-1], B.shape[-1], C.shape[-2]

    def bounded_real(a: Floats, b: Floats) -> Callable[[Floats], Floats]:
        def inequality(x: Floats) -> Floats:
            P, gamma = symmetric(*x[1:]), x[0]
            lower = [[C, np.zeros((p, q)), -gamma * np.eye(p)]]
            upper = [[a.T @ P + P @ a, P @ b, C.T], [b.T @ P, -gamma * np.eye(q), np.zeros((q, p))]]
            return -np.block(upper + lower)

        return inequality

    blocks = [bounded_real(a, b) for a, b in zip(A, B, strict=True)]
    cost = np.eye(1, 1 + n * (n + 1) // 2)[0]
    return affine(cost, lambda x: symmetric(*x[1:]), *blocks)


def masses() -> Lmi:
    model = masses_and_spring()
    return energy_gain(model.A, model.E, model.C[0])


def robust_trace() -> Lmi:
    """Minimise the larger trace; A_i'P_j + P_j A_i averaged over ij and ji is at most -I."""
    A = np.array([[[-1, 2], [0, -1.1]], [[-1, 1.1], [0, -2]]])

    def sums(i: int, j: int) -> Callable[[Floats], Floats]:
        def inequality(x: Floats) -> Floats:
            P = symmetric(*x[1:4]), symmetric(*x[4:])
            total = sum(A[a].T @ P[b] + P[b] @ A[a] for a, b in ((i, j), (j, i)))
            return np.asarray(-total - 2 * np.eye(2))

        return inequality

    traces = [lambda x: [[x[0] - x[1] - x[3]]], lambda x: [[x[0] - x[4] - x[6]]]]
    return affine([1, 0, 0, 0, 0, 0, 0], *traces, sums(0, 0), sums(0, 1), sums(1, 1))


# ------------------------------------------------------------------ sums of squares

Polynomial = dict[tuple[int, int], float]
ROBINSON: Polynomial = {(6, 0): 1, (0, 6): 1, (4, 2): -1, (2, 4): -1, (4, 0): -1, (0, 4): -1}
ROBINSON |= {(2, 0): -1, (0, 2): -1, (2, 2): 3, (0, 0): 1}
CAMEL: Polynomial = {(2, 0): 4, (4, 0): -2.1, (6, 0): 1 / 3, (1, 1): 1, (0, 2): -4, (0, 4): 4}
MOTZKIN: Polynomial = {(4, 2): 1, (2, 4): 1, (2, 2): -3, (0, 0): 1}
PARRILO: Polynomial = {(4, 0): 2, (3, 1): 2, (2, 2): -1, (0, 4): 5}


def squares(polynomial: Polynomial, basis: Sequence[tuple[int, int]], *, bounded: bool) -> Lmi:
    """Return the Gram matrices of p, or those of p - t for the largest t.

    Of the entries with the same product of monomials all but the first are unknown.
    """
    places: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for i, j in combinations_with_replacement(range(len(basis)), 2):
        (a, b), (c, d) = basis[i], basis[j]
        places.setdefault((a + c, b + d), []).append((i, j))
    unknown = [pair for pairs in places.values() for pair in pairs[1:]]

    def gram(x: Floats) -> Floats:
        G, values = np.zeros((len(basis), len(basis))), dict(zip(unknown, x[1:], strict=True))
        for degrees, (first, *others) in places.items():
            left = polynomial.get(degrees, 0.0) - (x[0] if degrees == (0, 0) else 0.0)
            for pair in others:
                G[pair] = values[pair]
                left -= values[pair] * (1 if pair[0] == pair[1] else 2)
            G[first] = left / (1 if first[0] == first[1] else 2)
        return np.asarray(np.triu(G) + np.triu(G, 1).T)

    cost = np.zeros(1 + len(unknown))
    if bounded:
        cost[0] = -1
        return affine(cost, gram)
    lmi = affine(cost, gram)
    return Lmi(cost[1:], tuple(np.delete(block, 1, axis=0) for block in lmi.blocks))


CUBES = [(a, b) for a in range(4) for b in range(4 - a)]
# Half of the polygon of the exponents of the camel's back.
HALF_OF_CAMEL = [(a, b) for a, b in CUBES if 2 * a + 3 * b <= 6]


def robinson(path: Path) -> None:
    """The largest t for which p - t is z'Xz, in the polynomials z that may stand in squares.

    The terms of degree six, (x^2 - y^2)^2 (x^2 + y^2), vanish for x = y and x = -y, and so do those
    of degree three of every square in the sum.
    """
    z: list[Polynomial] = [{monomial: 1.0} for monomial in CUBES if sum(monomial) < 3]
    z += [{(3, 0): 1, (1, 2): -1}, {(0, 3): 1, (2, 1): -1}]
    X, t = cp.Variable((len(z), len(z)), symmetric=True), cp.Variable()
    coefficients: dict[tuple[int, int], Any] = {(0, 0): t}
    for i, j in product(range(len(z)), repeat=2):
        for (a, b), u in z[i].items():
            for (c, d), v in z[j].items():
                at = a + c, b + d
                coefficients[at] = coefficients.get(at, 0) + u * v * X[i, j]
    constraints = [value == ROBINSON.get(at, 0.0) for at, value in coefficients.items()]
    save_cvxpy(cp.Problem(cp.Maximize(t), [X >> 0, *constraints]), path)


# ------------------------------------------------------------------ without an exact answer


def gap() -> Lmi:
    """x_1 = 0 is forced, and the optimum 0; the dual has the optimum -1."""
    return affine([1, 0], lambda x: symmetric(0, x[0], x[1], 0, 0, x[0] + 1))


def touching() -> Lmi:
    """[[x, 1], [1, 0]]: no solution, and points as near to one as is liked."""
    return affine([0], lambda x: symmetric(x[0], 1, 0))


def parabola() -> Lmi:
    """x_2^2 <= x_1: x_2 has no bound, and no ray raises it."""
    return affine([0, -1], lambda x: symmetric(x[0], x[1], 1))


def hyperbola() -> Lmi:
    """x_1 x_2 >= 1: the infimum 0 of x_1 is not attained."""
    return affine([1, 0], lambda x: symmetric(x[0], 1, x[1]))


SDPA = "SDPA user's manual 6.2, section 4"
JANSSON = "Jansson, Chaykin and Keil (2007), example"
# Name, source, and both sides of a threshold, each with the ending of its file.
THRESHOLDS: tuple[tuple[str, str, Callable[[float], Lmi], dict[str, float]], ...] = (
    ("dayawansa-martin", "Dayawansa and Martin (1999): a < 3 + √8",
     lambda a: common_function(planar_pair(a)), {".dat-s": 5.828, ".cbf": 5.829}),
    ("shorten-narendra", "Shorten and Narendra (2002): λ < 4 + 4√2",
     lambda a: common_function(oscillators(a)), {".mat": 9.656, ".npz": 9.657}),
    ("gevp", "MathWorks, gevp: V' ≤ -0.122 V",
     lambda a: common_function(GEVP, a), {".cbf": 0.122, ".dat-s": 0.123}),
)  # fmt: skip


def _sides() -> Iterator[Published]:
    for name, source, lmi, sides in THRESHOLDS:
        for (ending, value), known in zip(sides.items(), (FEASIBLE, INFEASIBLE), strict=True):
            yield Published(f"{name}-{value}{ending}", source, known, partial(lmi, value))


PUBLISHED: tuple[Published, ...] = (
    Published("sdpa-1.dat-s", f"{SDPA}, example 1", -41.9, sdpa_one),
    Published("sdpa-2.dat-s", f"{SDPA}, example 2", 32.06269, sdpa_two, 1e-5),
    Published("csdp.dat-s", "CSDP user's guide, Borchers", 2.75, csdp_guide),
    Published("sdo1.cbf", "MOSEK, sdo1", 0.7057105,
              digits=5e-8, write=mosek_sdo1),
    Published("socp.npz", "CVXOPT user's guide, solvers.socp", -38.34637,
              digits=5e-6, write=cvxopt_socp),
    Published("mincx.cbf", "MathWorks, mincx, asked for five digits", -18.7167, mincx, 2e-4),
    Published("robust4.mat", "YALMIP, test_robust_4", -1.8203, robust_trace, 5e-5),
    Published("theta-pentagon.dat-s", "Lovász (1979)", sqrt(5), theta_of_pentagon, text="√5"),
    Published("cut-pentagon.npz", "Goemans and Williamson (1995)", -(25 + 5 * sqrt(5)) / 8,
              write=cut_of_pentagon, text="-(25 + 5√5)/8"),
    Published("correlation-least.mat", "Wikipedia, semidefinite programming", 0.978,
              lambda: correlation(1), 5e-4),
    Published("correlation-largest.dat-s", "Wikipedia, semidefinite programming", -0.872,
              lambda: correlation(-1), 5e-4),
    Published("robinson.npz", "Gatermann and Parrilo (2004), example 5.4", 3825 / 4096,
              write=robinson, text="3825/4096"),
    Published("camel.cbf", "Parrilo and Sturmfels (2003), six-hump camel", 1.0316285,
              lambda: squares(CAMEL, HALF_OF_CAMEL, bounded=True), 1e-7),
    Published("parrilo.dat-s", "Parrilo (2000), example 3.5", FEASIBLE,
              lambda: squares(PARRILO, [(2, 0), (0, 2), (1, 1)], bounded=False)),
    Published("motzkin.cbf", "Motzkin (1967)", INFEASIBLE,
              lambda: squares(MOTZKIN, CUBES, bounded=False)),
    Published("third-order.dat-s", "python-control, sysnorm_test", 4.276759162964244,
              lambda: energy_gain(*(M[None] if k < 2 else M for k, M in enumerate(third_order()))),
              1e-9),
    Published("mass-spring.mat", "ROLMIP manual, table 2", -2.8429, masses, 5e-5),
    *_sides(),
    Published("jansson.mat", f"{JANSSON} with ε = 2e-4, δ = 1e-4", -0.5,
              write=lambda path: jansson(2e-4, 1e-4, path)),
    Published("jansson-rising.mat", f"{JANSSON} with ε = -0.01, δ = 0.1", UNBOUNDED,
              write=lambda path: jansson(-0.01, 0.1, path)),
    Published("jansson-none.mat", f"{JANSSON} with ε = 0.1, δ = -0.1", INFEASIBLE,
              write=lambda path: jansson(0.1, -0.1, path)),
    Published("jansson-gap.mat", f"{JANSSON} with ε = δ = 0: a gap", OPEN,
              write=lambda path: jansson(0, 0, path)),
    Published("ben-tal.npz", "Ben-Tal and Nemirovski (2001), 2.4.2", INFEASIBLE,
              write=ben_tal),
    Published("ben-tal-dual.mat", "the dual of the same", UNBOUNDED, write=ben_tal_dual),
    Published("gap.dat-s", "Vandenberghe and Boyd (1996), section 3", OPEN, gap),
    Published("touching.dat-s", "weakly infeasible: Ramana (1997)", OPEN, touching),
    Published("parabola.cbf", "no bound, and no ray", OPEN, parabola),
    Published("hyperbola.dat-s", "an infimum that is not attained", 0.0, hyperbola),
)  # fmt: skip


def table() -> str:
    rows = ["| problem | source | known |", "|---|---|---|"]
    for problem in PUBLISHED:
        known = problem.text or (
            problem.known if isinstance(problem.known, str) else f"{problem.known:.10g}"
        )
        rows.append(f"| {problem.name} | {problem.source} | {known} |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
