r"""How probable it is that turbulence drives the rotor beyond an overspeed, by wind and by law.

    python benchmarks/turbulence_exit.py GAINS.json [--simulate] [--ranges] [--certify FOLDER]

GAINS.json is the gain file of ``takagi design nrel5mw``.  Everything here is FLOATING POINT, NOT
PROVED, and about the loop linearised at one wind.  ``--certify`` writes certificates of the kind
``exit-probability`` for some winds; they are about every blend of the stated vertices, not about
the turbine.  ``--simulate`` compares with 10,000 runs where the bound is one half;
``--ranges`` has one function for a range of winds, of the nominal loop.

The loop is that of ``turbulence_exit_loop``.
"""

from __future__ import annotations

import argparse
from importlib import import_module
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_continuous_lyapunov
from turbulence_exit_loop import (
    STATES,
    TURBINE,
    E,
    Law,
    R,
    Wind,
    deviation,
    linear_loop,
    room,
    system,
)

from takagi.lmi.analysis.disturbance.exit_exponent import (
    ExitFunction,
    NoisyVertices,
)

Floats = NDArray[np.float64]
WINDS = (5.0, 8.0, 10.0, 11.0, 11.4, 11.6, 12.0, 13.0, 15.0, 18.0, 20.0, 23.0)
FILTERS, OVERSPEEDS, HORIZON = (12.0, 5.0, 1.0), (0.10, 0.15, 0.20, 0.30), 600.0
RATES = (0.01, 0.02, 0.04, 0.08)  # a [1/s]
SPACING, FASTEST = 1.0, 6.0  # of nodes of P(v) [m/s]; of |r| on the set, over its rms
RANGES = ((15.0, 1.0), (15.0, 2.0))
SOUGHT, MIDDLE = (0.15, 0.30), 0.20  # overspeeds that functions are sought for; others: scaled
UNCERTAIN_WINDS = (8.0, 11.0, 12.0, 13.0, 15.0, 18.0, 23.0)
# Filter [s], wind [m/s], overspeed of the certificates.
CERTIFIED = ((12.0, 12.0, 0.30), (12.0, 15.0, 0.30), (1.0, 12.0, 0.15), (1.0, 15.0, 0.15))
MARGIN = 1e-8  # so that rounded numbers still hold
UNITS = ("rad/s", "rad", "rad/s", "m/s", "rad/s", "rad/s", "m/s", "rad", "m/s", "m/s", "m/s^2")


class Search:
    """The LMIs of ``exit_exponent`` for one system, compiled once."""

    def __init__(self, system: NoisyVertices) -> None:
        cp: Any = import_module("cvxpy")
        mean = system.A.mean(axis=0)
        X = solve_continuous_lyapunov(mean, -system.S[0] @ system.S[0].T)
        T = np.linalg.cholesky(X + 1e-9 * np.diag(X.diagonal() + 1e-6))
        T /= np.abs(system.rows @ T).max()
        one, self.back = system.in_states(np.asarray(T, dtype=np.float64)), np.linalg.inv(T)
        n, self.solver = len(T), cp.CLARABEL
        self.P = cp.Variable((n, n), symmetric=True)
        self.c, self.kappa = cp.Variable(nonneg=True), cp.Variable(nonneg=True)
        self.rate, self.by_level, self.price = (cp.Parameter(nonneg=True) for _ in range(3))
        h = one.rows
        conditions = [self.P - h.T @ h >> MARGIN * np.eye(n)]
        corner = -cp.reshape(self.kappa, (1, 1), order="C")
        for A, S in zip(one.A, one.S, strict=True):
            side = self.P @ S
            top = self.P @ A + A.T @ self.P + self.rate * self.P + MARGIN * np.eye(n)
            conditions.append(cp.bmat([[top, side], [side.T, corner]]) << 0)
        conditions.append(cp.trace(one.S[0].T @ self.P @ one.S[0]) <= self.c)
        aim = self.by_level * self.c + self.price * self.kappa
        self.problem = cp.Problem(cp.Minimize(aim), conditions)

    def at(self, rate: float, price: float) -> ExitFunction | None:
        """Return the function that maximises (1 - c/a) - 2 price kappa at the rate a [1/s]."""
        self.rate.value, self.by_level.value, self.price.value = rate, 1 / rate, 2 * price
        try:
            self.problem.solve(solver=self.solver)
        except Exception as error:  # cvxpy's own class is imported late with it
            if type(error).__name__ != "SolverError":
                raise
            return None
        if self.P.value is None or self.kappa.value <= 0:
            return None
        P = self.back.T @ (self.P.value + self.P.value.T) @ self.back / 2
        return ExitFunction(P, 1 / (2 * self.kappa.value), rate, np.zeros(0), float(self.c.value))

    def best(self, rate: float, guess: float) -> ExitFunction | None:
        """Return the function with the largest exponent at the rate, by Dinkelbach's method."""
        price, best = max(guess, 0.05), None
        for _ in range(6):
            one = self.at(rate, price)
            if one is None:
                break
            best = one if best is None or one.exponent > best.exponent else best
            if abs(one.exponent - price) <= 0.02 * price or price < 0.05:
                break
            price = one.exponent if one.exponent > 0 else price / 5
        return best


def found(
    law: Law, v: float, overspeed: float, *, uncertain: bool, rate: float | None = None
) -> ExitFunction | None:
    """Return about the function with the least bound at one wind; None where there is none.

    Parameters
    ----------
    rate : a [1/s]; None tries RATES.
    """
    search = Search(system(law, v, overspeed, uncertain=uncertain))
    guess, best = 0.1 * (room(law, v, overspeed) / deviation(law, v)) ** 2, None
    for a in RATES if rate is None else (rate,):
        one = search.best(a, guess)
        if one is not None and (best is None or one.logarithm(HORIZON) < best.logarithm(HORIZON)):
            best, guess = one, max(one.exponent, guess / 10)
    return best


Functions = dict[float, ExitFunction]


def functions(law: Law, v: float, *, uncertain: bool, rates: Functions | None = None) -> Functions:
    """Return overspeed -> function for those of SOUGHT that have one."""
    rows = {
        x: found(law, v, x, uncertain=uncertain, rate=rates[x].rate if rates else None)
        for x in (rates or SOUGHT)
    }
    return {x: one for x, one in rows.items() if one is not None}


class RangeSearch(Search):
    """One function for U - w <= v <= U + w: P, or P(v) linear between nodes, nominal loop.

    P(v) adds dP/dv r to the drift.  That is affine in r, which the set bounds by FASTEST of its
    rms, and the rest is affine in P(v) for each of the three loops of a segment.
    """

    def __init__(self, law: Law, mean: float, width: float, *, moving: bool) -> None:
        cp: Any = import_module("cvxpy")
        wind, self.solver = Wind.of_class_b(mean), cp.CLARABEL
        nodes = np.linspace(mean - width, mean + width, 1 + round(2 * width / SPACING))
        middle = system(law, mean, MIDDLE, uncertain=False)
        A, S = middle.A[0], middle.S[0]
        X = solve_continuous_lyapunov(A, -S @ S.T)
        T = np.linalg.cholesky(X + 1e-9 * np.diag(X.diagonal() + 1e-6))
        speed = np.eye(len(A))[[E]] / min(room(law, v, MIDDLE) for v in nodes)
        rate = np.eye(len(A))[[R]] / (FASTEST * wind.rate)
        T /= np.abs(speed @ T).max()
        S = np.linalg.solve(T, S)
        n, count = len(A), len(nodes) if moving else 1
        P = [cp.Variable((n, n), symmetric=True) for _ in range(count)]
        self.c, self.kappa = cp.Variable(nonneg=True), cp.Variable(nonneg=True)
        self.rate, self.by_level, self.price = (cp.Parameter(nonneg=True) for _ in range(3))
        corner = -cp.reshape(self.kappa, (1, 1), order="C")
        conditions = [
            one - T.T @ h.T @ h @ T >> 0
            for one in P
            for h in ((speed, rate) if moving else (speed,))
        ]
        conditions += [cp.trace(S.T @ one @ S) <= self.c for one in P]
        for j, (low, high) in enumerate(pairwise(nodes)):
            ends = (P[j], P[j + 1]) if moving else (P[0], P[0])
            turn = (ends[1] - ends[0]) * (FASTEST * wind.rate / (high - low))
            for v in np.linspace(low + 1e-6, high - 1e-6, 3):
                At = np.linalg.solve(T, linear_loop(law, float(v), wind) @ T)
                for one, sign in product(ends if moving else ends[:1], (1, -1) if moving else (0,)):
                    top = one @ At + At.T @ one + self.rate * one + sign * turn
                    side = one @ S
                    conditions.append(cp.bmat([[top, side], [side.T, corner]]) << 0)
        aim = self.by_level * self.c + self.price * self.kappa
        self.problem = cp.Problem(cp.Minimize(aim), conditions)
        self.P, self.back = P[0], np.linalg.inv(T)


def of_range(law: Law, mean: float, width: float, *, moving: bool) -> str:
    """Return ten-minute bounds for all overspeeds, as far as the wind stays in the range."""
    search = RangeSearch(law, mean, width, moving=moving)
    best: ExitFunction | None = None
    for a in RATES[1:3]:
        one = search.best(a, 10.0 if best is None else best.exponent)
        if one is not None and (best is None or one.logarithm(HORIZON) < best.logarithm(HORIZON)):
            best = one
    return shown({} if best is None else {MIDDLE: best}, law, mean)


def for_room(one: ExitFunction, ratio: float) -> ExitFunction:
    """Return the function for a set that is ``ratio`` times as large: P / ratio^2."""
    square = ratio**2
    return ExitFunction(
        one.P / square, one.factor * square, one.rate, one.multipliers, one.level / square
    )


def shown(known: Functions, law: Law, v: float) -> str:
    """Return the bounds for all overspeeds in ten minutes, as powers of ten; 1 for no bound."""
    told = []
    for x in OVERSPEEDS:
        logs = [
            for_room(one, room(law, v, x) / room(law, v, own)).logarithm(HORIZON) / np.log(10)
            for own, one in known.items()
        ]
        least = min(logs, default=0.0)
        told.append("1" if least >= 0 else f"10^{least:.1f}")
    return " | ".join(told)


def simulated(law: Law, v: float, runs: int = 10_000, step: float = 0.1) -> str:
    """Return bound and share of runs of the nominal loop, for the set whose bound is one half."""
    one = found(law, v, MIDDLE, uncertain=False)
    assert one is not None
    ratios = np.linspace(0.2, 2, 2000)
    bounds = np.array([for_room(one, ratio).logarithm(HORIZON) for ratio in ratios])
    set_ = for_room(one, float(ratios[np.argmin(np.abs(bounds - np.log(0.5)))]))
    loop = system(law, v, MIDDLE, uncertain=False)
    A, S = loop.A[0], loop.S[0]
    spread, flow = solve_continuous_lyapunov(A, -S @ S.T), expm(A * step)
    values, vectors = np.linalg.eigh(spread - flow @ spread @ flow.T)
    root = vectors * np.sqrt(np.maximum(values, 0))
    random = np.random.default_rng(1)
    x, left = np.zeros((len(A), runs)), np.zeros(runs, dtype=bool)
    for _ in range(round(HORIZON / step)):
        x = flow @ x + root @ random.standard_normal(x.shape)
        left |= (x * (set_.P @ x)).sum(axis=0) >= 1
    bound = np.exp(set_.logarithm(HORIZON))
    return f"{v:g} m/s: bound {bound:.2f}, V reached 1 in {left.mean():.3f} of {runs} runs"


def certified(law: Law, v: float, overspeed: float, folder: Path) -> str:
    """Write a certificate about every blend of the uncertain vertices; return what is proved."""
    from takagi.certificates import certify
    from takagi.certificates.requests import ExitProbability
    from takagi.models import TSModel

    nominal = found(law, v, overspeed, uncertain=False)
    one = found(law, v, overspeed, uncertain=True, rate=None if nominal is None else nominal.rate)
    if one is None:
        return f"{v:g} m/s: no function was found"
    noise = np.zeros((len(STATES), 1))
    noise[R] = float(f"{Wind.of_class_b(v).noise:.6g}")
    A = system(law, v, overspeed, uncertain=True).A
    model = TSModel(
        [[[float(f"{entry:.9g}") for entry in row] for row in vertex] for vertex in A],
        E=noise,
        states=[f"{name} [{unit}]" for name, unit in zip(STATES, UNITS, strict=True)],
        disturbances=["turbulence [m/s^2]"],
        name=f"NREL 5-MW, linear loop at {v:g} m/s",
    )
    limit = float(f"{room(law, v, overspeed):.6g}")
    asked = ExitProbability(
        noise=[1.0], horizon=HORIZON, state_limits={"e": limit}, P=one.P, rate=one.rate
    )
    answer = certify(model, claims=[asked])
    answer.save(folder / f"exit-{law.filter:g}s-{v:g}.json")
    claim = answer.document["claims"][0]
    return (
        f"{v:g} m/s, {100 * overspeed:g} %: {answer.verdict.name}, "
        f"p = {claim['probability']:g} of every blend of {len(A)} vertices"
    )


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("gains", type=Path)
    reader.add_argument("--certify", type=Path, metavar="FOLDER")
    reader.add_argument("--simulate", action="store_true")
    reader.add_argument("--ranges", action="store_true")
    given = reader.parse_args()
    if given.certify is not None:
        given.certify.mkdir(parents=True, exist_ok=True)
        for tau, v, overspeed in CERTIFIED:
            law = Law.read(given.gains, tau)
            print(f"filter {tau:g} s, {certified(law, v, overspeed, given.certify)}", flush=True)
        return
    if given.simulate:
        for v in (12.0, 15.0, 20.0):
            print(simulated(Law.read(given.gains), v), flush=True)
        return
    if given.ranges:
        for tau, (mean, width) in product((12.0,), RANGES):
            for moving in (False, True):
                told = of_range(Law.read(given.gains, tau), mean, width, moving=moving)
                kind = "P(v)" if moving else "one P"
                print(f"| {tau:g} | {mean:g} ± {width:g} | {kind} | {told} |", flush=True)
        return
    print("FLOATING POINT, NOT PROVED: p for ten minutes at overspeeds of 10, 15, 20, 30 %")
    for tau in FILTERS:
        law = Law.read(given.gains, tau)
        for v in WINDS:
            spread = 100 * deviation(law, v) / TURBINE.rated_rotor_speed
            nominal = functions(law, v, uncertain=False)
            told = f"| {tau:g} | {v:g} | {spread:.2f} | {shown(nominal, law, v)} |"
            if nominal and v in UNCERTAIN_WINDS:
                told += f" {shown(functions(law, v, uncertain=True, rates=nominal), law, v)} |"
            print(told, flush=True)


if __name__ == "__main__":
    main()
