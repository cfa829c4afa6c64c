"""Runs whole collections of published problems, and prints their rows and counts as a table.

    python benchmarks/collections_of_plants.py --compleib FOLDER --sdplib FOLDER [--states 30]
    python benchmarks/collections_of_plants.py --compleib FOLDER --certify [--states 9]

FOLDER holds the data, which are not part of this repository: one .mat file a plant, with the
matrices A, B1, B, C1, D11 and D12 as COMPleib.m returns them; the .dat-s files of SDPLIB.  sdpa is
hidden: nothing here may need it.  Beside takagi at its default options stands the textbook LMI,
written in cvxpy and solved by clarabel, in the units of the data.

With --certify nothing is compared: each default design is certified, with nothing asked for but its
kind of bound, and counts where both checkers say PROVED within a thousandth of its own bound.

What counts as the optimum of a plant is the least norm of a stable closed loop, computed from
its gains by the Hamiltonian or the Gramian, that any of the methods reached.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from takagi.lmi import LMI, Condition, Constant, Term, Unknown

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


# Borchers (1999), table of optimal objective values, to the digits printed there.
OPTIMA = {
    "control1": "1.778463e+01",
    "control2": "8.300000e+00",
    "control3": "1.363327e+01",
    "control4": "1.979423e+01",
    "control5": "1.68836e+01",
    "control6": "3.73044e+01",
    "hinf1": "2.0326e+00",
    "hinf2": "1.0967e+01",
    "hinf3": "5.69e+01",
    "hinf4": "2.74764e+02",
    "hinf5": "3.63e+02",
    "hinf6": "4.490e+02",
    "hinf7": "3.91e+02",
    "hinf8": "1.16e+02",
    "hinf9": "2.3625e+02",
    "hinf10": "1.09e+02",
    "hinf11": "6.59e+01",
    "hinf12": "2e-1",
    "hinf13": "4.6e+01",
    "hinf14": "1.30e+01",
    "hinf15": "2.5e+01",
}


def read_sdpa(path: Path) -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]:
    """Return the cost c, (m,), and F of every block, (m + 1, n, n)."""
    lines = [
        line for line in path.read_text().splitlines() if line[:1] not in '"*' and line.strip()
    ]
    m = int(lines[0].split()[0])
    sizes = [abs(int(word)) for word in re.findall(r"-?\d+", lines[2])]
    cost = np.array([float(word) for word in re.split(r"[\s,{}()]+", lines[3]) if word])
    blocks = [np.zeros((m + 1, size, size)) for size in sizes]
    for line in lines[4:]:
        k, which, i, j, value = line.split()[:5]
        block, row, column = blocks[int(which) - 1], int(i) - 1, int(j) - 1
        block[int(k), row, column] = block[int(k), column, row] = float(value)
    return cost, blocks


def condition_of(
    name: str, cost: NDArray[np.float64], blocks: list[NDArray[np.float64]]
) -> Condition:
    """Return the problem as a condition on the unknown ``x``, one LMI a block."""
    m = len(cost)
    x = Unknown("x", 1, 1, count=m)
    lmis = []
    for number, F in enumerate(blocks, start=1):
        every = Term(unknown=x, left=F[1:], items=np.zeros(m, dtype=np.intp), members=np.arange(m))
        lmis.append(
            LMI(
                name=f"block {number}",
                blocks=(F.shape[1],),
                terms=(every,),
                constants=(Constant(value=-F[:1]),),
            )
        )
    return Condition(
        name=name, unknowns=(x,), lmis=tuple(lmis), objective={"x": cost[:, None, None]}
    )


Floats = NDArray[np.float64]
Peer = Callable[[dict[str, NDArray[np.float64]]], tuple[float, NDArray[np.float64]]]
LIMIT = 60.0
NEAR = 1e-3
# Below this share of what the output weighs, a least norm is zero: approached, never reached.
NOTHING = 1e-5


class Found(NamedTuple):
    """What a method claims, the norm of the loop with its gains, its words and seconds."""

    claimed: float
    true: float
    words: str
    seconds: float


def main() -> None:
    """Run what is there, and print."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--compleib", type=Path)
    parser.add_argument("--sdplib", type=Path)
    parser.add_argument("--certify", action="store_true", help="certify the default designs")
    parser.add_argument("--states", type=int, help="the most that a plant may have")
    asked = parser.parse_args()
    from takagi.lmi.solver import solve

    setattr(solve, "sdpa_is_installed", lambda: False)  # noqa: B010 (one attribute of a module)
    if asked.compleib and asked.certify:
        certified(asked.compleib, asked.states or 9)
    elif asked.compleib:
        plants(asked.compleib, asked.states or 30)
    if asked.sdplib:
        problems(asked.sdplib)


def plants(folder: Path, most: int) -> None:
    """Print a row for every plant and norm, then the counts."""
    counts: Counter[tuple[str, str]] = Counter()
    for name, plant in plants_in(folder, most):
        for norm, peers in (("H-infinity", (energy,)), ("H2", (gramian, dual))):
            mine = asked_of_takagi(plant, norm)
            others = [tried(peer, plant, norm) for peer in peers]
            verdict = judged(plant, mine, others)
            counts[norm, verdict] += 1
            cells = [f"{one.claimed:.6g} ({one.words})" for one in (mine, *others)]
            print(f"| {name} | {norm} | {' | '.join(cells)} | {verdict} |", flush=True)
    for (norm, verdict), count in sorted(counts.items()):
        print(f"| {norm} | {verdict} | {count} |")


def plants_in(folder: Path, most: int) -> Iterator[tuple[str, dict[str, Floats]]]:
    """Yield the plants of at most this many states, by name."""
    from scipy.io import loadmat

    for path in sorted(folder.glob("*.mat")):
        data = loadmat(path)
        plant = {
            k: np.atleast_2d(np.asarray(data[k], float))
            for k in ("A", "B1", "B", "C1", "D11", "D12")
        }
        if len(plant["A"]) <= most:
            yield path.stem, plant


def certified(folder: Path, most: int) -> None:
    """Print what the checkers say of every default design, then the counts."""
    from takagi.certificates import certify
    from takagi.certificates.cross_check.comparison import cross_checked_document
    from takagi.certificates.requests import H2Norm, L2Gain, Peak
    from takagi.lmi import h2_pdc, hinf_pdc, peak_pdc, time_limit
    from takagi.models import ModelError, TSModel

    kinds: dict[str, tuple[Callable[..., Any], Callable[..., Any], str]] = {
        "H-infinity": (hinf_pdc, L2Gain, "gain"),
        "H2": (h2_pdc, H2Norm, "norm"),
        "peak": (peak_pdc, Peak, "gain"),
    }
    counts: Counter[tuple[str, str]] = Counter()
    for name, plant in plants_in(folder, most):
        model = TSModel([plant["A"]], [plant["B"]], E=[plant["B1"]])
        output = (plant["C1"], plant["D12"], plant["D11"])
        for kind, (design, request, key) in kinds.items():
            try:
                with time_limit(LIMIT):
                    found = design(model, performance=output)
            except ModelError:
                continue
            if found.gains is None:
                continue
            answer = certify(model, found.gains, claims=[request(output=output)])
            above = answer.document["claims"][0][key] / found.gain - 1
            said = {row.second for row in cross_checked_document(answer.document).rows}
            verdict = "PROVED" if said == {"PROVED"} else "not proved"
            if verdict == "PROVED" and above > NEAR:
                verdict = "PROVED, but more"
            counts[kind, verdict] += 1
            print(f"| {name} | {kind} | {found.gain:.6g} | {above:+.2%} | {verdict} |", flush=True)
    for (kind, verdict), count in sorted(counts.items()):
        print(f"| {kind} | {verdict} | {count} |")


def judged(plant: dict[str, Floats], mine: Found, others: list[Found]) -> str:
    """Return how takagi did beside the best of the others."""
    if mine.words.startswith("refused"):
        return mine.words
    true = [one.true for one in (mine, *others) if np.isfinite(one.true)]
    best = min(true, default=np.inf)
    size = float(np.linalg.norm(plant["C1"], 2) * np.linalg.norm(plant["B1"], 2))
    if best <= NOTHING * size:
        shown = "shown" if mine.claimed <= NOTHING * size else mine.words
        return f"the least norm is zero: {shown}"
    good = abs(mine.claimed / best - 1) <= NEAR
    there = any(abs(one.claimed / best - 1) <= NEAR for one in others)
    if good:
        return "both" if there else "takagi alone"
    return "cvxpy alone" if there else "neither"


def asked_of_takagi(plant: dict[str, Floats], norm: str) -> Found:
    """Ask for gains at default options."""
    from takagi.lmi import h2_pdc, hinf_pdc, time_limit
    from takagi.models import ModelError, TSModel

    model = TSModel([plant["A"]], [plant["B"]], E=[plant["B1"]])
    design = hinf_pdc if norm == "H-infinity" else h2_pdc
    output = (plant["C1"], plant["D12"], plant["D11"])
    began = time.perf_counter()
    try:
        with time_limit(LIMIT):
            found = design(model, performance=output)
    except ModelError as error:
        return Found(np.nan, np.nan, f"refused: {error}"[:60], time.perf_counter() - began)
    spent = time.perf_counter() - began
    if found.gains is None or found.gain is None:
        return Found(np.nan, np.nan, found.status, spent)
    return Found(found.gain, true_norm(plant, found.gains[0], norm), found.status, spent)


def tried(peer: Peer, plant: dict[str, Floats], norm: str) -> Found:
    """Return what cvxpy and clarabel claim, and what the loop is worth."""
    import cvxpy as cp

    began = time.perf_counter()
    try:
        claimed, K = peer(plant)
    except (cp.SolverError, TypeError, np.linalg.LinAlgError) as error:
        return Found(np.nan, np.nan, type(error).__name__, time.perf_counter() - began)
    return Found(claimed, true_norm(plant, K, norm), "solved", time.perf_counter() - began)


def energy(plant: dict[str, Floats]) -> tuple[float, Floats]:
    """Pose the bounded real lemma as in the books."""
    import cvxpy as cp

    Q, M, G, Z = _unknowns(plant)
    gamma, E, D11 = cp.Variable(), plant["B1"], plant["D11"]
    w, z = gamma * np.eye(E.shape[1]), gamma * np.eye(len(D11))
    whole = cp.bmat([[-G - G.T, -E, -Z.T], [-E.T, w, -D11.T], [-Z, -D11, z]])
    return _least(gamma, [Q >> 0, whole >> 0], Q, M)


def gramian(plant: dict[str, Floats]) -> tuple[float, Floats]:
    """Pose the controllability Gramian's inequality."""
    import cvxpy as cp

    Q, M, G, Z = _unknowns(plant)
    W, E = cp.Variable((Z.shape[0], Z.shape[0]), symmetric=True), plant["B1"]
    claimed, K = _least(
        cp.trace(W), [Q >> 0, -G - G.T - E @ E.T >> 0, cp.bmat([[W, Z], [Z.T, Q]]) >> 0], Q, M
    )
    return float(np.sqrt(max(claimed, 0.0))), K


def dual(plant: dict[str, Floats]) -> tuple[float, Floats]:
    """Pose the observability Gramian's inequality, by its inverse."""
    import cvxpy as cp

    Q, M, G, Z = _unknowns(plant)
    E = plant["B1"]
    W = cp.Variable((E.shape[1], E.shape[1]), symmetric=True)
    loop = cp.bmat([[-G - G.T, -Z.T], [-Z, np.eye(Z.shape[0])]])
    claimed, K = _least(cp.trace(W), [Q >> 0, loop >> 0, cp.bmat([[W, E.T], [E, Q]]) >> 0], Q, M)
    return float(np.sqrt(max(claimed, 0.0))), K


def _unknowns(plant: dict[str, Floats]) -> tuple[Any, Any, Any, Any]:
    import cvxpy as cp

    A, B, C, D = (plant[k] for k in ("A", "B", "C1", "D12"))
    Q, M = cp.Variable(A.shape, symmetric=True), cp.Variable(B.shape[::-1])
    return Q, M, A @ Q - B @ M, C @ Q - D @ M


def _least(objective: Any, constraints: list[Any], Q: Any, M: Any) -> tuple[float, Floats]:
    import cvxpy as cp

    problem = cp.Problem(cp.Minimize(objective), constraints)
    problem.solve(solver=cp.CLARABEL, time_limit=LIMIT)
    return float(problem.value), np.asarray(M.value @ np.linalg.inv(Q.value))


def true_norm(plant: dict[str, Floats], K: Floats, norm: str) -> float:
    """Return the norm of the closed loop; inf where it is not stable."""
    from scipy.linalg import solve_continuous_lyapunov

    from tests.lmi.norms import hamiltonian_norm

    A, C = plant["A"] - plant["B"] @ K, plant["C1"] - plant["D12"] @ K
    if not np.isfinite(A).all() or np.linalg.eigvals(A).real.max() >= 0:
        return np.inf
    if norm == "H-infinity":
        try:
            return float(hamiltonian_norm(A, plant["B1"], C, plant["D11"]))
        except OverflowError:  # eigenvalues of the Hamiltonian that rounding keeps on the axis
            return np.inf
    if plant["D11"].any():
        return np.inf
    P = solve_continuous_lyapunov(A.T, -C.T @ C)
    return float(np.sqrt(max(np.trace(plant["B1"].T @ P @ plant["B1"]), 0.0)))


def problems(folder: Path) -> None:
    """Print a row for every problem of SDPLIB that is there."""
    from takagi.lmi import optimise, time_limit

    for name, text in OPTIMA.items():
        path = folder / f"{name}.dat-s"
        if not path.is_file():
            print(f"| {name} | {text} | the file is not there |")
            continue
        began = time.perf_counter()
        with time_limit(5 * LIMIT):
            found = optimise(condition_of(name, *read_sdpa(path)))
        spent = time.perf_counter() - began
        row = (name, text, f"{found.objective:.7g}", f"{found.lower_bound:.7g}", found.status)
        print(f"| {' | '.join(row)} | {spent:.1f} s |", flush=True)


if __name__ == "__main__":
    main()
