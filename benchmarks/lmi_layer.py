"""Measures the LMI layer against its peers, and writes the tables of docs/benchmarks.md.

    python benchmarks/lmi_layer.py [--only PART ...]      parts: posing rate vertices wide ratios

Every row is measured in this run, one after another, on one thread; compare the ratios, not the
times.  Peers get the same question, and their answers are compared with ours in the table.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("RAYON_NUM_THREADS", "1")

import numpy as np  # noqa: E402  the threads are counted when numpy is loaded
from measure import PAGE, placed, reduced, seconds, table  # noqa: E402
from numpy.typing import NDArray  # noqa: E402
from problems import (  # noqa: E402
    disturbed_rules,
    energy_gain_condition,
    least_trace_condition,
    scattered_rules,
    stable_vertices,
)

Floats = NDArray[np.float64]
Timed = tuple[float, float]
Works = list[tuple[Callable[[], Any], ...]]
LIMIT = 120.0
EFFORT = 1e4


def main() -> None:
    """Measure the parts that are asked for, and put their tables in the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS))
    parser.add_argument("--child", nargs=2, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.child:
        print(json.dumps(CHILDREN[asked.child[0]](json.loads(asked.child[1]))))
        return
    warnings.simplefilter("ignore")
    for part in asked.only:
        print(f"{part} ...", flush=True)
        found = PARTS[part]()
        print(f"{found}\n", flush=True)
        if part in ON_PAGE:
            text = placed(
                PAGE.read_text(encoding="utf-8"), f"layer {part}", reduced(found, *ON_PAGE[part])
            )
            PAGE.write_text(text, encoding="utf-8")


def best(work: Callable[[], Timed], repeats: int = 5) -> Timed:
    """Return the run with the least time."""
    return min((work() for _ in range(repeats)), key=lambda found: found[0])


def peer(work: Callable[[], Timed], repeats: int) -> Timed | str:
    """Return the best run, or why there is none."""
    try:
        return best(work, repeats)
    except ImportError as error:
        return f"{error.name} is not installed"


# ------------------------------------------------------------------ pose and solve


def posing() -> str:
    """Return the table of one solve: posed and solved, the solver alone, other libraries."""
    from peers import cvxpy_compensation, cvxpy_lyapunov, picos_compensation, picos_lyapunov

    from takagi.lmi import common_lyapunov, common_lyapunov_condition, pdc, pdc_condition
    from takagi.models import TSModel

    rows = []
    A = stable_vertices(64, 6)
    w = 2.0 * float(np.linalg.norm(A, 2, axis=(1, 2)).max())
    rows.append(
        _posing_row(
            "common Lyapunov, n = 6, 64 vertices",
            lambda: common_lyapunov_condition(A, weight=w),
            {},
            lambda: cvxpy_lyapunov(A, w),
            lambda: picos_lyapunov(A, w),
            lambda: common_lyapunov(A),
        )
    )
    for rules, n, m in ((16, 4, 2), (16, 6, 2)):
        V, B = scattered_rules(rules, n, m)
        model = TSModel(V, B)
        size = pdc_condition(model, decay_rate=0.1).lmis[2].weight
        rows.append(
            _posing_row(
                f"PDC, n = {n}, m = {m}, {rules} rules, all pairs",
                partial(pdc_condition, model, decay_rate=0.1),
                {"nu": EFFORT},
                partial(cvxpy_compensation, V, B, 0.1, size, EFFORT),
                partial(picos_compensation, V, B, 0.1, size, EFFORT),
                partial(pdc, model, decay_rate=0.1),
            )
        )
    heads = (
        "one question, largest margin",
        "takagi: pose, solve, check",
        "raw clarabel",
        "ratio",
        "takagi, by rounds",
        "cvxpy + clarabel",
        "slower by",
        "PICOS + CVXOPT",
        "slower by",
        "same answer",
        "whole call",
    )
    return table(heads, rows)


def _posing_row(
    name: str,
    pose: Callable[[], Any],
    limits: dict[str, float],
    cvxpy: Callable[[], Timed],
    picos: Callable[[], Timed],
    whole: Callable[[], object],
) -> tuple[str, ...]:
    from takagi.lmi.decision.decide import decide
    from takagi.lmi.decision.rounds import decide_by_rounds

    def ours() -> Timed:
        began = time.perf_counter()
        outcome = decide(pose(), rows=limits)
        return time.perf_counter() - began, outcome.margin

    def called() -> Timed:
        began = time.perf_counter()
        whole()
        return time.perf_counter() - began, 0.0

    def few() -> Timed:
        began = time.perf_counter()
        outcome = decide_by_rounds(pose(), rows=limits)
        return time.perf_counter() - began, outcome.margin

    mine, rounds = best(ours, 9), best(few, 9)
    raw = best(lambda: _raw_margin(pose(), limits), 9)
    print(f"  {name}: {mine[0]:.4f} s, raw {raw[0]:.4f} s", flush=True)
    first, second = peer(cvxpy, 3), peer(picos, 1)
    others = [found for found in (raw, first, second) if not isinstance(found, str)]
    same = all(abs(found[1] - mine[1]) <= 1e-6 + 1e-3 * abs(mine[1]) for found in others)
    return (
        name,
        seconds(mine[0]),
        seconds(raw[0]),
        f"{mine[0] / raw[0]:.2f}",
        seconds(rounds[0]),
        *_beside(first, mine),
        *_beside(second, mine),
        "yes" if same else "no",
        seconds(best(called, 3)[0]),
    )


def _beside(found: Timed | str, mine: Timed) -> tuple[str, str]:
    if isinstance(found, str):
        return found, "-"
    return seconds(found[0]), f"{found[0] / mine[0]:.1f}"


def _raw_margin(condition: Any, limits: dict[str, float]) -> Timed:
    """Solve the cone data, assembled beforehand, by a bare clarabel call: the floor."""
    from takagi.lmi.cone.cone_program import SolverRow, assemble, cone_program

    data = assemble(condition)
    t = np.eye(len(data.objective) + 1)[-1]
    rows = [SolverRow(t, 1.0)]
    rows += [SolverRow(np.eye(len(t))[data.offsets[name]], bound) for name, bound in limits.items()]
    program = cone_program(data, -t, tuple(rows))
    spent, y = _raw(program)
    return spent, float(y[-1])


def _raw(program: Any) -> tuple[float, Floats]:
    """Return the time from cone data to numbers of a bare clarabel call, and the numbers."""
    import clarabel
    import scipy.sparse as sp

    A, size = sp.csc_matrix(program.A), len(program.q)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.presolve_enable = False
    settings.chordal_decomposition_enable = False
    settings.time_limit = LIMIT
    cones = [clarabel.NonnegativeConeT(program.linear)] if program.linear else []
    for cone in program.cones:
        cones += [clarabel.PSDTriangleConeT(cone.size)] * cone.items
    began = time.perf_counter()
    none = sp.csc_matrix((size, size))
    solution = clarabel.DefaultSolver(none, program.q, A, program.b, cones, settings).solve()
    spent = time.perf_counter() - began
    return spent, np.array(solution.x)


# ------------------------------------------------------------------ the largest decay rate


def rate() -> str:
    """Return the table of the largest decay rate, n = 6, 8 rules, to 1e-6 relative."""
    from peers import cvxpy_rate, cvxpy_rate_by_parameter

    from takagi.lmi import max_decay_rate

    rows = []
    for seed in (1, 2, 3):
        A = stable_vertices(8, 6, seed)

        def ours(A: Floats = A) -> Timed:
            began = time.perf_counter()
            answer = max_decay_rate(A)
            assert answer.decay_rate is not None
            return time.perf_counter() - began, answer.decay_rate

        mine = best(ours)
        high = 2.0 * mine[1]
        anew = peer(partial(cvxpy_rate, A, 0.0, high, 1e-6), 3)
        once = peer(partial(cvxpy_rate_by_parameter, A, 0.0, high, 1e-6), 3)
        others = [found for found in (anew, once) if not isinstance(found, str)]
        apart = max((abs(found[1] / mine[1] - 1) for found in others), default=float("nan"))
        rows.append(
            (
                f"seed {seed}",
                seconds(mine[0]),
                *_beside(anew, mine),
                *_beside(once, mine),
                f"{apart:.0e}",
            )
        )
    heads = (
        "n = 6, 8 rules",
        "takagi",
        "cvxpy, recompiled",
        "slower by",
        "cvxpy, DPP",
        "slower by",
        "rates apart",
    )
    return table(heads, rows)


# ------------------------------------------------------------------ many vertices


def vertices() -> str:
    """Return the table of many vertices, each in a process of its own for its peak memory."""
    rows = []
    for count, n, question in (
        (1024, 8, "margin"),
        (1024, 8, "trace"),
        (5000, 6, "margin"),
        (5000, 6, "trace"),
        (100_000, 6, "margin"),
    ):
        given = {"count": count, "n": n, "question": question}
        mine = _child("rounds", given)
        print(f"  {count} vertices, n = {n}, {question}: {mine['seconds']:.3f} s", flush=True)
        raw = None if count > 50_000 else _child("at_once", given)
        within = raw is not None and raw["seconds"] < LIMIT
        rows.append(
            (
                f"{count:,} vertices of {n} x {n}, {question}".replace(",", " ", 1),
                seconds(mine["seconds"]),
                f"{mine['peak']:.2f} GiB",
                "-" if raw is None else seconds(raw["seconds"]) + ("" if within else " (stopped)"),
                "-" if raw is None else f"{raw['peak']:.2f} GiB",
                "-" if raw is None else f"{raw['seconds'] / mine['seconds']:.0f}",
                str(mine["status"]),
            )
        )
    heads = (
        "common Lyapunov function",
        "takagi",
        "peak memory",
        "raw clarabel, all at once",
        "peak memory",
        "slower by",
        "answer",
    )
    return table(heads, rows)


def _child(name: str, given: dict[str, Any]) -> dict[str, Any]:
    command = [sys.executable, __file__, "--child", name, json.dumps(given)]
    ran = subprocess.run(command, check=True, capture_output=True, text=True)
    found: dict[str, Any] = json.loads(ran.stdout.splitlines()[-1])
    return found


def _peak() -> float:
    """Return the most memory that this process has held [GiB]."""
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def rounds(given: dict[str, Any]) -> dict[str, Any]:
    """Answer as a user would ask."""
    from takagi.lmi import common_lyapunov
    from takagi.lmi.decision.rounds import optimise_by_rounds

    A = stable_vertices(given["count"], given["n"])
    common_lyapunov(A[:2])
    began = time.perf_counter()
    status: str
    if given["question"] == "margin":
        status = common_lyapunov(A).status
    else:
        outcome = optimise_by_rounds(least_trace_condition(A))
        status = f"{outcome.status}, trace {outcome.objective:.4f}"
    return {"seconds": time.perf_counter() - began, "peak": _peak(), "status": status}


def at_once(given: dict[str, Any]) -> dict[str, Any]:
    """Hand all vertices to the solver at once."""
    from takagi.lmi import common_lyapunov_condition
    from takagi.lmi.cone.cone_program import assemble, cone_program

    A = stable_vertices(given["count"], given["n"])
    if given["question"] == "margin":
        spent, margin = _raw_margin(common_lyapunov_condition(A), {})
        return {"seconds": spent, "peak": _peak(), "status": f"margin {margin:.3g}"}
    data = assemble(least_trace_condition(A))
    spent, y = _raw(cone_program(data, data.objective, (), margin=0.0))
    return {"seconds": spent, "peak": _peak(), "status": f"trace {data.objective @ y:.4f}"}


# ------------------------------------------------------------------ wide LMIs


def wide() -> str:
    """Return the table of H-infinity compensation: 36 LMIs of width 21 and of width 26."""
    from takagi.lmi.cone.cone_program import assemble, cone_program
    from takagi.lmi.solver.installed_solvers import sdpa_is_installed, with_sdpa
    from takagi.lmi.solver.solve import attempts

    rows = []
    for n, m, q, p in ((10, 2, 5, 6), (10, 2, 5, 11)):
        condition = energy_gain_condition(disturbed_rules(8, n, m, q, p))
        data = assemble(condition)
        program = cone_program(data, data.objective, (), margin=0.0)
        began = time.perf_counter()
        first = next(attempts(program))
        mine = time.perf_counter() - began, float(data.objective @ first.y)
        print(f"  width {n + q + p}: {first.solver}, {mine[0]:.2f} s", flush=True)
        raw, y = _raw(program)
        beside = "sdpa-python is not installed", "-"
        values = [float(data.objective @ y)]
        if sdpa_is_installed():
            began = time.perf_counter()
            other = with_sdpa(program)
            spent = time.perf_counter() - began
            values.append(float(data.objective @ other.y))
            beside = seconds(spent), f"{spent / mine[0]:.2f}"
        apart = max(abs(value / mine[1] - 1) for value in values)
        rows.append(
            (
                f"36 of width {n + q + p}",
                seconds(mine[0]),
                first.solver,
                seconds(raw),
                f"{raw / mine[0]:.2f}",
                *beside,
                f"{apart:.0e}",
            )
        )
    heads = (
        "H-infinity PDC, LMIs",
        "takagi",
        "chosen",
        "raw clarabel",
        "slower by",
        "sdpa-python",
        "slower by",
        "least gains apart",
    )
    return table(heads, rows)


# ------------------------------------------------------------------ processor time of whole calls

SEEDS = (1, 2, 3)
# States, inputs, rules; how far rules are scattered about the first.
GAINS = ((2, 1, 2), (4, 2, 4), (8, 3, 4))
NORMS = ((2, 1, 4), (4, 2, 4), (8, 2, 4), (12, 2, 2))
SCATTER = 0.05


def ratios() -> str:
    """Return the table of whole calls over bare clarabel and over cvxpy, in processor time.

    Every number is the median of three random problems, each of three runs; "a no" is of rules
    without gains, over the no of ``pdc``.
    """
    from peers import cvxpy_compensation, cvxpy_energy_gain, cvxpy_lyapunov, cvxpy_variance

    from takagi.lmi import (
        common_lyapunov,
        common_lyapunov_condition,
        h2_pdc,
        h2_pdc_condition,
        hinf_pdc,
        hinf_pdc_condition,
        pdc,
        pdc_condition,
    )
    from takagi.models import TSModel

    rows = []
    works: Works
    for count in (4, 1024):
        sets = [stable_vertices(count, 4, seed) for seed in SEEDS]
        works = [
            (
                partial(common_lyapunov, A),
                partial(_raw_margin, common_lyapunov_condition(A), {}),
                partial(cvxpy_lyapunov, A, 2.0 * float(np.linalg.norm(A, 2, axis=(1, 2)).max())),
            )
            for A in sets
        ]
        rows.append(_ratio_row(f"common P, n = 4, {count} vertices", works))
    for n, m, rules in GAINS:
        works = []
        for seed in SEEDS:
            A, B = scattered_rules(rules, n, m, seed, SCATTER)
            condition = pdc_condition(TSModel(A, B))
            size = condition.lmis[2].weight
            raw = partial(_raw_margin, condition, {"nu": EFFORT})
            other = partial(cvxpy_compensation, A, B, 0.0, size, EFFORT)
            works.append((partial(pdc, TSModel(A, B)), raw, other))
        rows.append(_ratio_row(f"PDC, n = {n}, m = {m}, {rules} rules", works))
    for n, m, rules in NORMS:
        plants = [
            disturbed_rules(rules, n, m, 2, m + min(n, 3), seed, spread=SCATTER) for seed in SEEDS
        ]
        models = [TSModel(p.A, p.B, C=p.C, D=p.D, E=p.E) for p in plants]
        for name, design, pose, textbook in (
            ("H-infinity", hinf_pdc, hinf_pdc_condition, cvxpy_energy_gain),
            ("H2", h2_pdc, h2_pdc_condition, cvxpy_variance),
        ):
            works = [
                (partial(design, model), partial(_raw_least, pose(model)), partial(textbook, plant))
                for model, plant in zip(models, plants, strict=True)
            ]
            rows.append(_ratio_row(f"{name}, n = {n}, m = {m}, {rules} rules", works))
    without = [_without_gains(seed) for seed in SEEDS]
    for name, design in (("H-infinity", hinf_pdc), ("H2", h2_pdc)):
        spent = [(_processor(partial(design, m)), _processor(partial(pdc, m))) for m in without]
        ratio = float(np.median([a / b for a, b in spent]))
        mine = float(np.median([a for a, _ in spent]))
        rows.append((f"{name}, a no", seconds(mine), "-", "-", f"{ratio:.1f}"))
    heads = ("whole call", "takagi", "over raw clarabel", "over cvxpy", "over the no of pdc")
    return table(heads, rows)


def _ratio_row(name: str, works: Works) -> tuple[str, ...]:
    spent = np.array([[_processor(work) for work in three] for three in works])
    over = np.nanmedian(spent[:, :1] / spent[:, 1:], axis=0)
    print(f"  {name}: {over[0]:.2f} of raw, {over[1]:.2f} of cvxpy", flush=True)
    mine = float(np.median(spent[:, 0]))
    return (name, seconds(mine), f"{over[0]:.2f}", f"{over[1]:.2f}", "-")


def _processor(work: Callable[[], Any], repeats: int = 3) -> float:
    """Return the median processor time of some runs [s], after a first; nan if one fails."""
    import cvxpy as cp

    spent = []
    for _ in range(repeats + 1):
        began = time.process_time()
        try:
            work()
        except cp.SolverError:
            return float("nan")
        spent.append(time.process_time() - began)
    return float(np.median(spent[1:]))


def _raw_least(condition: Any) -> Timed:
    """Solve the least objective by a bare clarabel call, in the plant's own coordinates."""
    from takagi.lmi.cone.cone_program import assemble, cone_program

    data = assemble(condition)
    spent, y = _raw(cone_program(data, data.objective, (), margin=0.0))
    return spent, float(data.objective @ y)


def _without_gains(seed: int) -> Any:
    """Return random rules, n = 2, m = 1, r = 4, that all pairs show no gains for."""
    from takagi.lmi import pdc
    from takagi.models import TSModel

    random = np.random.default_rng(seed)
    while True:
        A, B = random.normal(size=(4, 2, 2)), random.normal(size=(4, 2, 1))
        model = TSModel(A, B, E=np.ones((2, 1)), C=np.eye(3)[:, :2], D=np.eye(3)[:, 2:])
        if pdc(model).status == "infeasible":
            return model


PARTS: dict[str, Callable[[], str]] = {
    "posing": posing,
    "rate": rate,
    "vertices": vertices,
    "wide": wide,
    "ratios": ratios,
}
# Columns of the tables that the page shows, and words of their rows.
ON_PAGE = {
    "posing": ((0, 1, 2, 5, 7, 10), ("",)),
    "rate": ((0, 1, 2, 4), ("seed 1",)),
    "vertices": ((0, 1, 2, 3, 4), ("margin",)),
    "ratios": ((0, 1, 2, 3), ("common P", "PDC", ", n = 4, m", ", n = 12")),
}
CHILDREN: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
    "rounds": rounds,
    "at_once": at_once,
}


if __name__ == "__main__":
    main()
