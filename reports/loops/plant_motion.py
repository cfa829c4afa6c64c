"""The nonlinear plant under its law, from inside the proved ellipsoid: simulations, not proofs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.reports.loops.observed_path import ObservedPath, observed_flow, observed_steps

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.reports.loops.plant_loop import PlantLoop

# A start lies this far out in the ellipsoid, as a share of its level, or of the box without one.
INSIDE, SHARE = 0.98, 0.3
SAMPLES, STEPS = 301, 300
# The slowest pole has decayed to e^-7, a thousandth.
TIMES = 7.0
LONGEST = 1e3
# A motion is ended at this multiple of the box (or ellipsoid) size.
FAR = 20.0


@dataclass(frozen=True, slots=True, eq=False)
class PlantMotion:
    """One motion of the loop.

    Attributes
    ----------
    name : where it starts, in words.
    time : (k,) [s], or steps times the sample time.
    state : (k, n), deviations x - x* in SI units.
    input : (k, m), u itself.
    value : (k,) V / level; empty where there is no proved function or no level.
    whole : False if the motion diverged, or reached a state where the plant is undefined.
    acting : (k, 2), the commands of the two actuators of a blend; empty without one.
    estimate : (k, n) of the deviations, by a law with outputs; empty for one of all states.
    """

    name: str
    time: Floats
    state: Floats
    input: Floats
    value: Floats
    whole: bool = True
    acting: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    estimate: Floats = field(default_factory=lambda: np.zeros((0, 0)))


def plant_rate(plant: Plant) -> Callable[[Floats, Floats], Floats]:
    """Return (x, u) -> x' of the plant itself, disturbances at rest; x(t + T) in discrete time.

    Evaluated from the plant's equations in floating point, apart from any model of it; of a blended
    plant from those that were written, with its two actuators.
    """
    import sympy as sp

    from takagi.models.blending.blending import blending_of
    from takagi.models.blending.run_time import RunTimeBlending

    blending = blending_of(plant)
    if blending is not None:
        return RunTimeBlending(blending).rate()

    values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    values |= {v.symbol: sp.Rational(*v.rest.as_integer_ratio()) for v in plant.disturbances}
    symbols = [v.symbol for v in (*plant.states, *plant.inputs)]
    rows = [sp.sympify(row).subs(values) for row in plant.equations]
    right = sp.lambdify(symbols, rows, modules=["scipy", "numpy"])
    mass = None
    if plant.mass is not None:
        mass = sp.lambdify(symbols, plant.mass.subs(values).tolist(), modules=["scipy", "numpy"])

    def rate(x: Floats, u: Floats) -> Floats:
        point = (*map(float, x), *map(float, u))
        f = np.array(right(*point), dtype=np.float64)
        if mass is None:
            return f
        return np.asarray(np.linalg.solve(np.array(mass(*point), float), f), dtype=np.float64)

    return rate


def starts(loop: PlantLoop) -> list[tuple[str, Floats]]:
    """Return (words, deviation): for each state the point of the ellipsoid where it is largest.

    Without a proved ellipsoid each boxed state starts at a share of its box, all others at rest.
    """
    n = len(loop.names)
    if loop.bounded:
        P, level = loop.start_ellipsoid
        inverse = np.linalg.inv(P)
        size = np.sqrt(INSIDE * level)
        return [
            (f"{name} largest", size * inverse[j] / np.sqrt(inverse[j, j]))
            for j, name in enumerate(loop.names)
        ]
    reach = _box(loop)
    return [
        (f"{name} = {SHARE * reach[j]:.3g}", SHARE * reach[j] * np.eye(n)[j])
        for j, name in enumerate(loop.names)
    ]


def around(loop: PlantLoop, count: int) -> list[tuple[str, Floats]]:
    """Return ``count`` starts around the ellipse (or box) of a loop with two states."""
    shape: Floats = np.asarray(np.diag(SHARE * _box(loop)), dtype=np.float64)
    if loop.bounded:
        P, level = loop.start_ellipsoid
        root = np.linalg.cholesky(np.linalg.inv(P)) * np.sqrt(INSIDE * level)
        shape = np.asarray(root, dtype=np.float64)
    turns = 2 * np.pi * (np.arange(count) + 0.5) / count
    return [("around", shape @ np.array([np.cos(a), np.sin(a)])) for a in turns]


def motions(
    loop: PlantLoop,
    begin: Sequence[tuple[str, Floats]],
    *,
    duration: float | None = None,
    errors: Mapping[str, float] | None = None,
) -> tuple[PlantMotion, ...]:
    """Return the motions from the given deviations, all over the same time [s].

    Parameters
    ----------
    errors : blended actuator -> delta, the relative error of its effect on the plant.

    Raises
    ------
    ModelError : errors of a plant without a blend, or of no blended actuator.
    """
    rate = plant_rate(loop.plant)
    if errors:
        from takagi.models.blending.blending import blending_of
        from takagi.models.blending.run_time import RunTimeBlending

        blending = blending_of(loop.plant)
        if blending is None:
            raise ModelError(f"errors of {', '.join(errors)}: the plant has no blended actuators")
        rate = RunTimeBlending(blending, errors).rate()
    move = _iterated if loop.discrete else _integrated
    end = horizon(loop) if duration is None else duration
    return tuple(move(loop, rate, name, np.asarray(x0, float), end) for name, x0 in begin)


def horizon(loop: PlantLoop, *, longest: float = LONGEST) -> float:
    """Return the duration [s] in which the slowest pole at equilibrium decays to a thousandth.

    Parameters
    ----------
    longest : s, where that would take longer, in continuous time.
    """
    matrices, K = loop.at_rest()
    poles = np.linalg.eigvals(matrices.A if K is None else matrices.A - matrices.B @ K)
    if loop.observed is not None:
        poles = loop.observed.poles_at(loop.memberships(np.zeros(len(loop.names))))
    step = loop.model.sample_time
    rates = -np.real(poles) if step is None else -np.log(np.maximum(np.abs(poles), 1e-9)) / step
    moving = np.abs(rates)[np.abs(rates) > 1e-6]
    settled = TIMES / float(moving.min()) if moving.size else 10.0
    return min(settled, longest if step is None else STEPS * step)


def settling_time(motion: PlantMotion, share: float = 0.01) -> float:
    """Return when every state stays within a share of the largest deviation it has had [s].

    nan if it does not.
    """
    size = np.abs(motion.state)
    late = np.flatnonzero(np.any(size > share * size.max(axis=0), axis=1))
    if not motion.whole or (late.size and late[-1] == len(size) - 1):
        return float("nan")
    return float(motion.time[late[-1] + 1]) if late.size else 0.0


def _integrated(
    loop: PlantLoop, rate: Callable[[Floats, Floats], Floats], name: str, x0: Floats, end: float
) -> PlantMotion:
    from scipy.integrate import solve_ivp

    far = _far(loop, x0)
    if loop.observed is not None:
        times = np.linspace(0.0, end, SAMPLES)
        return _observed(loop, name, observed_flow(loop.observed, loop.state, rate, x0, times, far))

    def slope(_: float, x: Floats) -> Floats:
        return rate(loop.state + x, loop.command(x))

    def leaves(_: float, x: Floats) -> float:
        return float(np.min(far - np.abs(x)))

    leaves.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        slope, (0.0, end), x0, method="LSODA", rtol=1e-7, atol=1e-9,
        t_eval=np.linspace(0.0, end, SAMPLES), events=leaves,
    )  # fmt: skip
    return _motion(loop, name, found.t, found.y.T, whole=found.status == 0)


def _iterated(
    loop: PlantLoop, rate: Callable[[Floats, Floats], Floats], name: str, x0: Floats, end: float
) -> PlantMotion:
    step = loop.model.sample_time or 1.0
    far = _far(loop, x0)
    if loop.observed is not None:
        times = step * np.arange(max(int(np.ceil(end / step)), 1) + 1, dtype=np.float64)
        return _observed(
            loop, name, observed_steps(loop.observed, loop.state, rate, x0, times, far)
        )
    states = [x0]
    for _ in range(max(int(np.ceil(end / step)), 1)):
        following = rate(loop.state + states[-1], loop.command(states[-1])) - loop.state
        if not np.all(np.abs(following) <= far):
            return _run(loop, name, states, whole=False)
        states.append(following)
    return _run(loop, name, states, whole=True)


def _run(loop: PlantLoop, name: str, states: list[Floats], *, whole: bool) -> PlantMotion:
    time = (loop.model.sample_time or 1.0) * np.arange(len(states), dtype=np.float64)
    return _motion(loop, name, time, np.array(states), whole=whole)


def _observed(loop: PlantLoop, name: str, path: ObservedPath) -> PlantMotion:
    """Return the motion of a path; V is that of plant and estimate."""
    assert loop.observed is not None
    value = np.zeros(0)
    if loop.observed.P is not None and loop.bounded:
        z = loop.observed.coordinates(path.state, path.estimate)
        value = np.einsum("ki,ij,kj->k", z, loop.observed.P, z) / loop.ellipsoid[1]
    return PlantMotion(
        name, path.time, path.state, path.command, value, path.whole, estimate=path.estimate
    )


def _motion(loop: PlantLoop, name: str, time: Floats, state: Floats, *, whole: bool) -> PlantMotion:
    commands = np.array([loop.command(x) for x in state]).reshape(len(state), -1)
    value = np.zeros(0)
    if loop.bounded:
        P, level = loop.ellipsoid
        value = np.einsum("ki,ij,kj->k", state, P, state) / level
    acting = np.zeros((0, 2))
    if loop.blend is not None:
        acting = np.array([loop.blend.commands(loop.state + x) for x in state])
    return PlantMotion(name, time, state, commands, value, whole, acting)


def _box(loop: PlantLoop) -> Floats:
    """Return how far each state may go from rest [SI]; 1 where the box leaves it out."""
    sides = [loop.model.box.get(label) for label in loop.model.states]
    return np.array([1.0 if s is None else min(abs(float(e)) for e in s) or 1.0 for s in sides])


def _far(loop: PlantLoop, x0: Floats) -> Floats:
    """Return per state the deviation at which a motion is ended."""
    reach = np.maximum(_box(loop), np.linalg.norm(x0) / np.sqrt(len(x0)))
    if loop.bounded:
        P, level = loop.ellipsoid
        reach = np.maximum(reach, np.sqrt(level * np.diag(np.linalg.inv(P))))
    return np.asarray(FAR * reach, dtype=np.float64)
