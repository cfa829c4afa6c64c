"""A plant file and the law of its certificate, read and run without takagi.

Equations, parameters, units and mass matrix come from the TOML file by tomllib and sympy; premises,
gains, trim and the certified set from ``certificate.json``.  Inputs are cut at their ranges, as
actuators would cut them.  Everything is in SI; ``scale`` has one of the file's units in SI.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy as sp
from scipy.integrate import solve_ivp

Floats = npt.NDArray[np.float64]

# Named units in SI; in a file they stand with powers, and behind one "/".
UNITS = {
    **dict.fromkeys("- 1 m kg s A K mol rad N J V W F H Ohm Wb Pa".split(), 1.0),
    "um": 1e-6,
    "mm": 1e-3,
    "cm": 1e-2,
    "g": 1e-3,
    "L": 1e-3,
    "min": 60.0,
    "h": 3600.0,
    "deg": np.pi / 180,
    "rpm": np.pi / 30,
    "mH": 1e-3,
    "uF": 1e-6,
    "kJ": 1e3,
}
# Nearer to rest than this share of the range a deviation counts as this share in the premises:
# quotients such as sin(x)/x have their limits there.
NEAREST = 1e-6
# The share of the set's half-width that counts as rest.
SETTLED = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A run: times, states (n, samples) and the inputs (m, samples) that the plant gets, in SI."""

    time: Floats
    state: Floats
    input: Floats


@dataclass(frozen=True, slots=True, eq=False)
class TextbookLoop:
    """A plant, its law and the certified set {d' P d <= 1} of deviations d from rest.

    Attributes
    ----------
    rate : x' of the plant at (x, u).
    slopes : its Jacobians A (n, n) and B (n, m) at rest.
    command : of the certified law at x, before it is cut.
    ranges : (n + m, 2), of states and inputs; infinite where the file gives none.
    horizon : time in which exp(-alpha t), with the proved rate alpha, falls below 1e-4.
    """

    name: str
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    units: tuple[str, ...]
    scale: Floats
    ranges: Floats
    rest: Floats
    rate: Callable[[Floats, Floats], Floats]
    slopes: tuple[Floats, Floats]
    command: Callable[[Floats], Floats]
    gains: Floats
    P: Floats
    horizon: float

    @property
    def reach(self) -> Floats:
        """How far the set reaches in each state (n,)."""
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(self.P))), dtype=np.float64)

    @property
    def alone(self) -> Floats:
        """How far each state alone may be off rest in the set (n,)."""
        return np.asarray(1 / np.sqrt(np.diag(self.P)), dtype=np.float64)

    def boundary(self) -> list[Floats]:
        """Return states just inside the set's boundary: both ends of all its principal axes."""
        scale = np.diag(self.reach)
        sizes, axes = np.linalg.eigh(scale @ self.P @ scale)
        ends = [
            0.999 * scale @ axis / np.sqrt(size) for size, axis in zip(sizes, axes.T, strict=True)
        ]
        return [self.rest[: len(self.states)] + sign * end for end in ends for sign in (1, -1)]

    def level(self, motion: Motion) -> Floats:
        """Return d' P d along a motion."""
        d = motion.state - self.rest[: len(self.states), None]
        return np.asarray(np.einsum("it,ij,jt->t", d, self.P, d), dtype=np.float64)

    def settled(self, motion: Motion) -> float | None:
        """Return the time after which all states stay near rest; None where they do not."""
        d = motion.state - self.rest[: len(self.states), None]
        off = np.flatnonzero(np.any(np.abs(d) > SETTLED * self.reach[:, None], axis=0))
        if off.size and off[-1] + 1 >= motion.time.size:
            return None
        return float(motion.time[off[-1] + 1]) if off.size else 0.0

    def run(
        self,
        start: Floats,
        command: Callable[[Floats], Floats] | None = None,
        samples: int = 2001,
    ) -> Motion:
        """Return the motion from a state, until ``horizon`` or until it is far away."""
        law = command or self.command
        n = len(self.states)
        low, high = self.ranges[n:].T

        def cut(x: Floats) -> Floats:
            return np.clip(law(x), low, high)

        def far(_: float, x: Floats) -> float:
            return float(100 - np.abs((x - self.rest[:n]) / self.reach).max())

        far.terminal = True  # type: ignore[attr-defined]
        found = solve_ivp(
            lambda _, x: self.rate(x, cut(x)),
            (0.0, self.horizon),
            start,
            method="LSODA",
            t_eval=np.linspace(0.0, self.horizon, samples),
            events=far,
            rtol=1e-7,
            atol=1e-9 * self.reach,
        )
        applied = np.array([cut(x) for x in found.y.T]).T
        return Motion(found.t, found.y, applied)


def in_si(unit: str) -> float:
    """Return what one of a unit is in SI, such as 1e-3/3600 of "L/(mol h)"; KeyError if unknown."""
    above, _, below = unit.partition("/")
    value = 1.0
    for part, sign in ((above, 1), (below.strip("()"), -1)):
        for factor in part.split():
            name, _, power = factor.partition("^")
            value *= UNITS[name] ** (sign * int(power or 1))
    return value


def textbook_loop(file: Path, certificate: Mapping[str, Any]) -> TextbookLoop:
    """Return the loop of a plant file and the content of its ``certificate.json``."""
    text = tomllib.loads(file.read_text(encoding="utf-8"))
    states, inputs = text["states"], text["inputs"]
    entries = [*states.values(), *inputs.values()]
    units = tuple(entry.get("unit", "-") for entry in entries)
    scale = np.array([in_si(unit) for unit in units])
    ranges = np.array([entry.get("range", (-np.inf, np.inf)) for entry in entries], dtype=float)
    law = certificate["gains"]
    rest = np.array([*law["trim"]["state"], *law["trim"]["input"]])
    rate, slopes = _dynamics(text, rest)
    claims = {claim["kind"]: claim for claim in certificate["claims"]}
    limits, decay = claims["input-limits"], claims["decay"]
    n = len(states)
    gains = np.array(law["K"], dtype=np.float64)
    return TextbookLoop(
        name=text["name"],
        states=tuple(states),
        inputs=tuple(inputs),
        units=tuple(_told_unit(entry) for entry in entries),
        scale=scale,
        ranges=ranges * scale[:, None],
        rest=rest,
        rate=rate,
        slopes=slopes,
        command=_command(text, law, rest, (ranges * scale[:, None])[:n], gains),
        gains=gains,
        P=np.array(limits["P"], dtype=np.float64) / limits["level"],
        horizon=float(10 / decay["decay_rate"]),
    )


def _told_unit(entry: Mapping[str, Any]) -> str:
    """Return the unit, of a file without units that behind the comma of the description."""
    words = str(entry.get("description", ""))
    return str(entry.get("unit") or (words.rpartition(", ")[2] if ", " in words else "-"))


def _read(text: str, names: Mapping[str, sp.Expr]) -> sp.Expr:
    return sp.sympify(text.replace("^", "**"), locals={"abs": sp.Abs, **names})


def _parameters(text: Mapping[str, Any]) -> dict[str, sp.Expr]:
    """Return every parameter in SI; those that are expressions of others may stand in any order."""
    found: dict[str, sp.Expr] = {}
    open_: dict[str, str] = {}
    for name, entry in text.get("parameters", {}).items():
        whole = entry if isinstance(entry, dict) else {"value": entry}
        value = whole["value"]
        if isinstance(value, str):
            open_[name] = value
        else:
            found[name] = sp.Float(value * in_si(whole.get("unit", "-")), 20)
    names = {name: sp.Symbol(name) for name in (*found, *open_)}
    for _ in range(len(open_)):
        for name, value in open_.items():
            found[name] = _read(value, names).subs(found)
    return found


def _dynamics(
    text: Mapping[str, Any], rest: Floats
) -> tuple[Callable[[Floats, Floats], Floats], tuple[Floats, Floats]]:
    states, inputs = list(text["states"]), list(text["inputs"])
    names = {name: sp.Symbol(name, real=True) for name in (*states, *inputs)}
    known = {**names, **_parameters(text)}
    f = sp.Matrix([_read(text["equations"][name], known) for name in states])
    mass = sp.eye(len(states))
    for row, entries in text.get("mass", {}).items():
        for k, column in enumerate(states):
            mass[states.index(row), k] = _read(str(entries.get(column, 0)), known)
    x, u = [names[s] for s in states], [names[s] for s in inputs]
    M = sp.lambdify([*x, *u], mass)
    right = sp.lambdify([*x, *u], list(f))
    # f vanishes at rest, so that the slopes of M do not count there.
    slopes = sp.lambdify([*x, *u], f.jacobian([*x, *u]))
    whole = np.linalg.solve(
        np.array(M(*rest), dtype=np.float64), np.array(slopes(*rest), dtype=np.float64)
    )

    def rate(state: Floats, command: Floats) -> Floats:
        value = np.array(right(*state, *command), dtype=np.float64)
        if not text.get("mass"):
            return value
        inertia = np.array(M(*state, *command), dtype=np.float64)
        return np.asarray(np.linalg.solve(inertia, value), dtype=np.float64)

    n = len(states)
    return rate, (whole[:, :n], whole[:, n:])


def _command(
    text: Mapping[str, Any],
    law: Mapping[str, Any],
    rest: Floats,
    ranges: Floats,
    gains: Floats,
) -> Callable[[Floats], Floats]:
    """Return u* - sum of h_i K_i (x - x*), h_i as the gain file's formulas say."""
    n = len(text["states"])
    deviations = [label.partition(" [")[0] for label in law["state_names"]]
    names = {name: sp.Symbol(name, real=True) for name in deviations}
    settled = {
        f"{name}_rest": sp.Float(value, 17)
        for name, value in zip((*text["states"], *text["inputs"]), rest, strict=True)
    }
    known = {**_parameters(text), **settled, **names}
    premises = [_read(premise["expression"], known) for premise in law["premises"]]
    evaluate = sp.lambdify([names[name] for name in deviations], premises)
    lower = np.array([premise["lower"] for premise in law["premises"]])
    upper = np.array([premise["upper"] for premise in law["premises"]])
    corners = np.array(law["rules"], dtype=bool).reshape(-1, len(premises))
    widths = ranges[:, 1] - ranges[:, 0]
    nearest = NEAREST * np.where(np.isfinite(widths), widths, 1.0)
    scheduled = len(gains) > 1 and bool(np.any(gains != gains[0]))

    def command(state: Floats) -> Floats:
        d = state - rest[:n]
        if not scheduled:
            return np.asarray(rest[n:] - gains[0] @ d, dtype=np.float64)
        apart = np.where(np.abs(d) < nearest, nearest, d)
        z = np.clip(np.array(evaluate(*apart), dtype=np.float64), lower, upper)
        share = (z - lower) / (upper - lower)
        weights = np.where(corners, share, 1 - share).prod(axis=1)
        return np.asarray(rest[n:] - np.einsum("r,rmn,n->m", weights, gains, d))

    return command
