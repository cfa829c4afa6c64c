"""The loop of a plant and its design as numbers, and which of its claims are proved.

For a law with outputs, plant and estimate are one loop.  Its certificate's function is
V = z'Pz, with z = (x, e) or (xhat, e) and e = x - xhat.  The state alone never leaves the
projection of {V <= c}; it may start where V <= c for the estimate as the law starts it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.checker.kernel.result import Checked, Verdict
from takagi.certificates.checker.words.figure import Figure
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.arrays import Complex, Floats
from takagi.models.blending.blending import RunTimeBlending, blending_of
from takagi.models.errors import ModelError
from takagi.models.laws.pdc import OutputFeedback, ReferenceFeedback, seen_directly
from takagi.models.plant.plant import Plant
from takagi.models.ts.model import Matrices, TSModel
from takagi.reports.page.text import name_of


@dataclass(frozen=True, slots=True, eq=False)
class ObservedMotion:
    """A law with an observer, and the proved function of plant and estimate.

    Attributes
    ----------
    law : the law.
    outputs : (x, u) -> y of the measured outputs, SI.
    resting : y* (p,).
    P : (2n, 2n) of the proved V; None where none is proved.
    level : c of the proved set.
    """

    law: OutputFeedback | ReferenceFeedback
    outputs: Callable[[Floats, Floats], Floats]
    resting: Floats
    P: Floats | None
    level: float | None

    def seen(self, state: Floats, command: Floats) -> Floats:
        """Return y - y* at x (n,) and u (m,)."""
        return np.asarray(self.outputs(state, command) - self.resting, dtype=np.float64)

    def start(self, deviation: Floats) -> Floats:
        """Return the estimate (n,) of x - x* at the first sample: measured states, else 0."""
        estimate = np.zeros(len(deviation))
        for state in self.measured_states():
            estimate[state] = deviation[state]
        return estimate

    def command(self, state: Floats, estimate: Floats) -> Floats:
        """Return u (m,) at x (n,), for outputs without an input in the premises."""
        rest = self.law.feedback.input_rest
        return self.law.command(estimate, self.seen(state, rest))

    def following(self, state: Floats, estimate: Floats, command: Floats) -> Floats:
        """Return the rate of the estimate; in discrete time the next estimate."""
        return self.law.following(estimate, self.seen(state, command), command)

    def coordinates(self, deviation: Floats, estimate: Floats) -> Floats:
        """Return z (k, 2n) of x - x* and its estimate, (k, n) each."""
        first = estimate if self.law.at_estimate else deviation
        return np.concatenate([first, deviation - estimate], axis=-1)

    def measured_states(self) -> list[int]:
        """Return the places of the states that an output shows by themselves."""
        directly_measured = seen_directly(self.law.model, self.law.rows)
        return [state for state, (_, factor) in directly_measured.items() if factor == 1.0]

    def shapes(self) -> tuple[Floats, Floats] | None:
        """Return the (n, n) matrices of the set, projected, and of its starts; None without one.

        {x'Sx <= c} is where x may start, {x'Rx <= c} what x never leaves.
        """
        if self.P is None:
            return None
        n = len(self.P) // 2
        identity = np.eye(n)
        state = np.hstack([identity, identity if self.law.at_estimate else np.zeros((n, n))])
        projection = np.linalg.inv(state @ np.linalg.inv(self.P) @ state.T)
        selection = np.zeros((n, n))
        selection[self.measured_states(), self.measured_states()] = 1.0
        N = np.vstack([selection if self.law.at_estimate else identity, identity - selection])
        return np.asarray((projection + projection.T) / 2), np.asarray(N.T @ self.P @ N)

    def largest_commands(self) -> Floats | None:
        """Return (m,): the largest |u - u*| of any gain on the set; None without one."""
        if self.P is None or self.level is None:
            return None
        K = self.law.feedback.gains
        rows = np.concatenate([K, 0.0 * K if self.law.at_estimate else -K], axis=2)
        squares = np.einsum("imn,nk,imk->im", rows, np.linalg.inv(self.P), rows)
        return np.asarray(np.sqrt(self.level * squares.max(axis=0)), dtype=np.float64)

    def poles_at(self, h: Floats) -> Complex:
        """Return the poles of plant and observer with constant weights h (r,): both parts."""
        model, rows = self.law.model, list(self.law.rows)
        if not isinstance(self.law, OutputFeedback):
            A, B, K = self.joint(h)
            return np.linalg.eigvals(A - B @ K).astype(np.complex128)
        A, B, C, K, L = (
            np.tensordot(h, stack, axes=1)
            for stack in (model.A, model.B, model.C[:, rows], self.law.feedback.gains, self.law.L)
        )
        spectra = [np.linalg.eigvals(A - B @ K), np.linalg.eigvals(A - L @ C)]
        return np.concatenate(spectra).astype(np.complex128)

    def joint(self, h: Floats) -> tuple[Floats, Floats, Floats]:
        """Return A, B, G of (x, s), with u - u* = -G (x, s) broken where the plant gets it.

        The observer goes on with the command that it asks for, which is a part of A.  Integrals
        are states of the law alone.
        """
        F, L, K = self.law.linear(h)
        model, rows = self.law.model, list(self.law.rows)
        A, B, C = (np.tensordot(h, stack, axes=1) for stack in (model.A, model.B, model.C))
        D = np.tensordot(h, model.D, axes=1)[rows]
        states = list(self.law.states)
        n, m = len(states), B.shape[1]
        joint_A = np.block(
            [[A[np.ix_(states, states)], np.zeros((n, len(F)))], [L @ C[rows][:, states], F]]
        )
        return joint_A, np.vstack([B[states], L @ D]), np.hstack([np.zeros((m, n)), K])


def observed_motion(design: PlantDesign) -> ObservedMotion | None:
    """Return the observer of a design with its proved function; None for a law of all states."""
    law = design.output_law
    if law is None:
        return None
    measured, integrals = measured_outputs(design.plant), list(law.integrals)

    def outputs(x: Floats, u: Floats) -> Floats:
        # The law has the integrals itself.
        return np.concatenate([measured(x, u), x[integrals]])

    resting = outputs(law.feedback.state_rest, law.feedback.input_rest)
    return ObservedMotion(law, outputs, resting, *_proved(design, "observed-loop", "level"))


def measured_outputs(plant: Plant) -> Callable[[Floats, Floats], Floats]:
    """Return (x, u) -> y of what is measured, from the plant's own expressions."""
    import sympy as sp

    from takagi.models.ranges.float_value import float_function

    assert plant.measured is not None  # only such a law has an observer
    values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    symbols = [v.symbol for v in (*plant.states, *plant.inputs)]
    expressions = {y.name: y.expression for y in plant.outputs}
    rows = [sp.sympify(expressions[name]).subs(values) for name in plant.measured]
    evaluate = float_function(symbols, rows)

    def outputs(x: Floats, u: Floats) -> Floats:
        return np.array(evaluate(*map(float, x), *map(float, u)), dtype=np.float64)

    return outputs


@dataclass(frozen=True, slots=True, eq=False)
class PolynomialRegion:
    """The proved set {V <= level} of a polynomial V in the states' deviations, SI.

    ``starts`` : (n,) how far each state may start to either side with the others at rest.
    """

    V: Callable[[Floats], Floats]
    level: float
    starts: tuple[float, ...]


def _region(design: PlantDesign, model: TSModel) -> PolynomialRegion | None:
    from takagi.lmi.sums_of_squares.polynomial import StatePolynomial

    claims = zip(design.document["claims"], design.checked.claims, strict=False)
    for claim, checked in claims:
        if claim["kind"] == "attraction-region" and checked.verdict is Verdict.PROVED:
            V = StatePolynomial.of(claim["function"], [name_of(label) for label in model.states])
            starts = tuple(
                float(figure.value or 0) for figure in checked.figures if isinstance(figure, Figure)
            )
            return PolynomialRegion(V, float(Fraction(str(claim["level"]))), starts)
    return None


@dataclass(frozen=True, eq=False)
class PlantLoop:
    """The plant with u = u* - sum_i h_i K_i (x - x*), or without control if there are no gains.

    Attributes
    ----------
    gains : K (r, m, n) as emitted; None for an analysis.
    state, input : x* (n,) and u* (m,), where the plant rests.
    P : (n, n), of V = (x - x*)' P (x - x*): of the proved set in which inputs stay within their
        limits, else of a proved invariant ellipsoid, else of the proved decay; None where none is
        proved.
    level : c of the set {V <= c}: as proved, else the largest that stays inside the box, computed
        in floating point; None without P; inf where no state has a bound.
    level_proved : whether the certificate proves that the set lies in the box and is invariant.
    decay_rate, decay_P : alpha [1/s] and the P of the proved decay, V' <= -2 alpha V; None if none.
    observed : of a law with outputs: its observer, and the proved function of plant and estimate.
        P then is that of the projection of the set on the states, and decay_P is None.
    starting_P : of a law with outputs: {x'Sx <= level} is where the state may start.
    region : the proved region of attraction of a polynomial; None without one.
    """

    plant: Plant
    model: TSModel
    gains: Floats | None
    state: Floats
    input: Floats
    P: Floats | None = None
    level: float | None = None
    level_proved: bool = False
    decay_rate: float | None = None
    decay_P: Floats | None = None
    observed: ObservedMotion | None = None
    starting_P: Floats | None = None
    region: PolynomialRegion | None = None

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the model's states without units, e.g. ``"angle"``."""
        return tuple(name_of(label) for label in self.model.states)

    @property
    def bounded(self) -> bool:
        """Whether there is an ellipsoid of finite size."""
        return self.P is not None and self.level is not None and bool(np.isfinite(self.level))

    @property
    def ellipsoid(self) -> tuple[Floats, float]:
        """Return (P, level); only where ``bounded``."""
        assert self.P is not None and self.level is not None
        return self.P, self.level

    @property
    def start_ellipsoid(self) -> tuple[Floats, float]:
        """Return (S, level): where the state may start; only where ``bounded``."""
        P, level = self.ellipsoid
        return (P if self.starting_P is None else self.starting_P), level

    @property
    def discrete(self) -> bool:
        return self.model.sample_time is not None

    @cached_property
    def _others(self) -> dict[str, float]:
        labels = (*self.model.inputs, *self.model.disturbances)
        return {name_of(label): 0.0 for label in labels}

    @cached_property
    def blend(self) -> RunTimeBlending | None:
        """The blend of two actuators in the plant, as it runs; None without one."""
        blending = blending_of(self.plant)
        return None if blending is None else RunTimeBlending(blending)

    def premise_values(
        self, deviation: Floats, signals: Mapping[str, float] | None = None
    ) -> Floats:
        """Return z at x = x* + deviation, inputs and disturbances at rest, the share as it is.

        Parameters
        ----------
        signals : deviations of disturbances that are not at rest, by their names in the model.
        """
        if not self.model.premises:
            return np.zeros(0)
        point = dict(zip(self.names, map(float, deviation), strict=True))
        shares = {} if self.blend is None else self.blend.signals(self.state + deviation)
        return self.model.premise_values(**(self._others | shares | dict(signals or {})), **point)

    def memberships(self, deviation: Floats, signals: Mapping[str, float] | None = None) -> Floats:
        """Return h (r,); outside the box premises stay at their nearer bound, as at run time."""
        if not self.model.premises:
            return np.full(len(self.model.rules), 1 / len(self.model.rules))
        low, width, upper = self._corners
        share = np.clip((self.premise_values(deviation, signals) - low) / width, 0.0, 1.0)
        return np.asarray(np.where(upper, share, 1.0 - share).prod(axis=1), dtype=np.float64)

    @cached_property
    def _corners(self) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Lower ends, widths (1 for a constant premise), and which rules take the upper end.

        A motion asks for memberships some thousand times, one state at a time.
        """
        members = self.model.premises
        low = np.array([float(p.lower) for p in members])
        width = np.array([float(p.upper - p.lower) for p in members])
        # A constant premise has weight 1, also if its value is rounded.
        constant = width == 0
        low, width = np.where(constant, -np.inf, low), np.where(constant, 1.0, width)
        return low, width, (np.array(self.model.rules) == 1) | constant

    @cached_property
    def _has_one_gain(self) -> bool:
        return self.gains is not None and bool(np.all(self.gains == self.gains[0]))

    def command(self, deviation: Floats, signals: Mapping[str, float] | None = None) -> Floats:
        """Return u (m,) of the law at x = x* + deviation, before it is cut at any range."""
        if self.gains is None:
            return self.input
        if self._has_one_gain:
            return np.asarray(self.input - self.gains[0] @ deviation, dtype=np.float64)
        r, m, n = self.gains.shape
        blended = self.memberships(deviation, signals) @ self.gains.reshape(r, m * n)
        return np.asarray(self.input - blended.reshape(m, n) @ deviation, dtype=np.float64)

    def at_rest(self) -> tuple[Matrices, Floats | None]:
        """Return (A, B, ...) and K where the plant rests: the loop linearised there.

        For x' = A(z(x)) x + B(z(x)) u the derivative at 0 is A(z(0)), B(z(0)).
        """
        h = self.memberships(np.zeros(len(self.names)))
        stacks = (self.model.A, self.model.B, self.model.C, self.model.D, self.model.E)
        matrices = Matrices(*(np.tensordot(h, stack, axes=1) for stack in stacks))
        K = None if self.gains is None else np.tensordot(h, self.gains, axes=1)
        return matrices, K


@lru_cache(maxsize=4)
def plant_loop(design: PlantDesign) -> PlantLoop:
    """Return the loop of a design, with the function that its certificate proves.

    Raises
    ------
    ModelError : the gains do not fit the model.
    """
    plant, model = design.plant, design.model
    gains = None if design.gains is None else np.asarray(design.gains, dtype=np.float64)
    r, n, m = model.B.shape
    if gains is not None and gains.shape != (r, m, n):
        raise ModelError(
            f"gains have shape {gains.shape}; {r} rules, {m} inputs and {n} states need "
            f"({r}, {m}, {n})"
        )
    loop = PlantLoop(plant, model, gains, *_trim(design))
    observed = observed_motion(design)
    if observed is not None:
        P, S = observed.shapes() or (None, None)
        _, rate = _proved(design, "observed-loop", "decay_rate")
        loop = replace(loop, P=P, level=observed.level, level_proved=P is not None)
        return replace(loop, decay_rate=rate, observed=observed, starting_P=S)
    decay_P, rate = _proved(design, "decay", "decay_rate")
    # A limit that was asked for may be tighter than the range of an input in the model's box.
    P, level = _proved(design, "input-limits", "level")
    if P is None:
        P, level = _proved(design, "invariant-ellipsoid", "level")
    level_proved = level is not None
    if P is None and decay_P is not None:
        P, level = decay_P, _level(model, gains, decay_P)
    return replace(
        loop,
        P=P,
        level=level,
        level_proved=level_proved,
        decay_rate=rate,
        decay_P=decay_P,
        region=_region(design, model),
    )


def _trim(design: PlantDesign) -> tuple[Floats, Floats]:
    """Return (x*, u*): of the emitted law, else the rest values of the plant."""
    plant = design.plant
    trim: Any = (design.document.get("gains") or {}).get("trim") or {}
    state = trim.get("state", [v.rest for v in plant.states])
    inputs = trim.get("input", [v.rest for v in plant.inputs])
    return np.array([_float(x) for x in state]), np.array([_float(u) for u in inputs])


def _proved(design: PlantDesign, kind: str, figure: str) -> tuple[Floats | None, float | None]:
    """Return P and a figure of the first claim of a kind that is proved; (None, None) if none."""
    claim = next(iter(proved_claims(design.document, design.checked, kind)), None)
    if claim is None:
        return None, None
    return claimed_matrix(claim), _float(claim[figure])


def claimed_matrix(claim: Mapping[str, Any]) -> Floats:
    """Return the P of a claim."""
    return np.array([[_float(entry) for entry in row] for row in claim["P"]])


def _float(number: object) -> float:
    """Return a number of a certificate, which may be written as a fraction."""
    return float(Fraction(str(number)))


def _level(model: TSModel, gains: Floats | None, P: Floats) -> float:
    """Return min over |a'x| <= b of b^2 / (a' P^-1 a): sides of states, and of inputs by K_i."""
    inverse = np.linalg.inv(P)
    levels = [np.inf]
    for label, ends in model.box.items():
        b = min(abs(float(ends[0])), abs(float(ends[1])))
        if label in model.states:
            rows = np.eye(len(P))[[model.states.index(label)]]
        elif gains is not None and label in model.inputs:
            rows = gains[:, model.inputs.index(label), :]
        else:
            continue
        levels += [b**2 / float(a @ inverse @ a) for a in rows if np.any(a)]
    return float(min(levels))


def largest_commands(loop: PlantLoop) -> list[tuple[str, float]]:
    """Return (input, largest |u - u*| of any rule on the ellipsoid): sqrt(c K_i P^-1 K_i').

    In floating point; empty where there is no bounded ellipsoid.
    """
    if loop.gains is None or not loop.bounded:
        return []
    if loop.observed is not None:
        bounds = loop.observed.largest_commands()
        assert bounds is not None  # the set is bounded
        return [(name, float(bound)) for name, bound in zip(loop.model.inputs, bounds, strict=True)]
    P, level = loop.ellipsoid
    inverse = np.linalg.inv(P)
    sizes = np.sqrt(level * np.einsum("imn,nk,imk->im", loop.gains, inverse, loop.gains))
    bounds = sizes.max(axis=0)
    return [(name, float(bound)) for name, bound in zip(loop.model.inputs, bounds, strict=True)]


EMBEDDINGS = {"sector-embedding", "secant-embedding"}


def proved_claims(
    document: Mapping[str, Any], checked: Checked, kind: str | None = None
) -> list[Mapping[str, Any]]:
    """Return the claims that are proved, of one kind if one is given, as the file states them."""
    pairs = zip(document.get("claims", []), checked.claims, strict=False)
    proved = [stated for stated, result in pairs if result.verdict is Verdict.PROVED]
    return [stated for stated in proved if kind in (None, stated.get("kind"))]


def proved_kinds(design: PlantDesign) -> set[str]:
    """Return the kinds of the claims that are proved."""
    return {str(claim.get("kind")) for claim in proved_claims(design.document, design.checked)}


def embedded(design: PlantDesign) -> bool:
    """Return whether it is proved, by the checker, that the model is the plant on its box."""
    return bool(EMBEDDINGS & proved_kinds(design))
