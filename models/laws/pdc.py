"""The law u = -sum_i h_i K_i x, and its form with references and an observer.

Parallel distributed compensation as a law to be run, of the states or of an estimate of them.

    u = u* - sum_i h_i(z) K_i (x - x*)

Observer-based output feedback puts s in the place of x - x*,

    u = u* - sum_i h_i K_i s,
    s' = sum_i h_i (A_i s + B_i (u - u*) + L_i (y - y* - C_i s - D_i (u - u*)));

in discrete time s(t + T) replaces s'.  The weights h are those of the plant, if they depend on
measured outputs only, or the weights at the estimate.

A law with references and measured outputs: integrals, and an observer with constant matrices.

    u = u* - K_x s - K_xi xi,     s' = A s + B (u - u*) + L (y - y* - C s),     xi' = h(y) - r

s estimates the deviations of the plant's own states.  For callers that know an observer of all
states (``takagi.models.laws.pdc.OutputFeedback``) the estimate has a row for every state, 0 for the
integrals, which the law has itself and which stand behind the outputs in what it knows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats, frozen
from takagi.models.equilibrium_line import ConstantObserver
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel
from takagi.models.ts.vertex_arrays import finite_array

if TYPE_CHECKING:
    from takagi.models.blending.blending import RunTimeBlending


@dataclass(frozen=True, eq=False)
class PdcLaw:
    """u = u* - sum_i h_i(z) K_i (x - x*); premises z, memberships h and rules are a model's.

    Attributes
    ----------
    model : in deviations from the equilibrium; its premises are evaluated at run time.
    gains : K (r, m, n); one for all rules may be given as (m, n).
    state_rest, input_rest : x* (n,) and u* (m,), SI.
    name : word for tables and legends.

    Raises
    ------
    ModelError : gains or rest values that do not fit the model.
    """

    model: TSModel
    gains: Floats
    state_rest: Floats
    input_rest: Floats
    name: str = "pdc"

    def __post_init__(self) -> None:
        r, n, m = self.model.B.shape
        object.__setattr__(self, "gains", _gains(self.gains, (r, m, n)))
        for field_name, size in (("state_rest", n), ("input_rest", m)):
            value = frozen(self, field_name)
            if value.shape != (size,) or not np.all(np.isfinite(value)):
                raise ModelError(
                    f"{field_name} has shape {value.shape}; ({size},) is needed, all finite"
                )

    @property
    def sample_time(self) -> float | None:
        """T in s of a law in discrete time; None for continuous time."""
        return self.model.sample_time

    @cached_property
    def blend(self) -> RunTimeBlending | None:
        """The blend of two actuators behind the effort that is commanded; None without one."""
        form = None if self.model.derivation is None else self.model.derivation.form
        if form is None:
            return None
        from takagi.models.blending.blending import RunTimeBlending, blending_of

        blending = blending_of(form.plant)
        return None if blending is None else RunTimeBlending(blending)

    @property
    def is_scheduled(self) -> bool:
        """Whether the gains differ from each other; if not, the law needs no premises."""
        return bool(np.any(self.gains != self.gains[0]))

    def memberships(self, state: ArrayLike, **signals: float) -> Floats:
        """Return h (r,) at a state (n,) in SI.

        Outside its range a premise is held at the nearer end. There the law still gives a command,
        but nothing is proved.

        ``signals`` : inputs and disturbances that premises depend on, by name, as deviations from
        the equilibrium; 0 for those that are not given, but for the share of a blend, which
        follows from the effort in the state.

        Raises
        ------
        ModelError : a state of another length, or a signal that the model does not have.
        """
        x = np.asarray(state, dtype=np.float64)
        if x.shape != self.state_rest.shape:
            raise ModelError(
                f"the state has shape {x.shape}; ({len(self.state_rest)},) is needed: "
                + ", ".join(self.model.states)
            )
        if not self.model.premises:
            return np.full(len(self.model.rules), 1.0 / len(self.model.rules))
        other_signals = {
            _name(label): 0.0 for label in (*self.model.inputs, *self.model.disturbances)
        }
        if self.blend is not None:
            other_signals |= self.blend.signals(x)
        for key, value in signals.items():
            if key not in other_signals:
                raise ModelError(
                    f"signal {key} was given; the model has {', '.join(other_signals) or 'none'}"
                )
            other_signals[key] = float(value)
        deviation = zip(map(_name, self.model.states), x - self.state_rest, strict=True)
        point = other_signals | {key: float(value) for key, value in deviation}
        return self.model.memberships(self.model.premise_values(**point), clip=True)

    def command(self, state: ArrayLike, **signals: float) -> Floats:
        """Return u (m,) at a state (n,), both in SI; see ``memberships``."""
        x = np.asarray(state, dtype=np.float64)
        if self.is_scheduled:
            K = np.tensordot(self.memberships(x, **signals), self.gains, axes=1)
        else:
            K = self.gains[0]
        return np.asarray(self.input_rest - K @ (x - self.state_rest), dtype=np.float64)

    def sent(self, state: ArrayLike, **signals: float) -> Floats:
        """Return the command (m,), held within the ranges of the inputs that have one; SI.

        A proof about the law only covers states in which no command is limited.
        """
        free = np.array([-np.inf, np.inf])
        deviations = np.array([
            [float(end) for end in self.model.box.get(label, free)] for label in self.model.inputs
        ])  # fmt: skip
        low, high = self.input_rest + deviations.reshape(-1, 2).T
        return np.clip(self.command(state, **signals), low, high)


def _gains(gains: ArrayLike, shape: tuple[int, int, int]) -> Floats:
    K = finite_array("K", gains)
    if K.shape == shape[1:]:
        K = np.broadcast_to(K, shape).copy()
    if K.shape != shape:
        raise ModelError(
            f"gains have shape {K.shape}; {shape[0]} rules, {shape[1]} inputs and {shape[2]} "
            f"states need {shape}, or {shape[1:]} for one gain in all rules"
        )
    K.flags.writeable = False
    return K


def _name(label: str) -> str:
    return label.split(" [")[0]


@dataclass(frozen=True, eq=False)
class OutputFeedback:
    """The law of the module.

    Attributes
    ----------
    feedback : K with model, premises and rests; it is evaluated at the estimate.
    L : (r, n, p); (n, p) gives all rules the same L.
    rows : indices of the p measured outputs among the outputs of the model.
    at_estimate : whether the weights are evaluated at the estimate.

    Raises
    ------
    ModelError : gains that do not fit, an output that the model does not have.
    """

    feedback: PdcLaw
    L: Floats
    rows: tuple[int, ...]
    at_estimate: bool
    integrals: ClassVar[tuple[int, ...]] = ()

    def __post_init__(self) -> None:
        p = self.model.C.shape[1]
        if not self.rows or any(not 0 <= k < p for k in self.rows):
            raise ModelError(f"rows = {self.rows}: places of the model's {p} outputs are needed")
        r, n = self.model.A.shape[:2]
        L = finite_array("L", self.L)
        shape = (r, n, len(self.rows))
        if L.shape in (shape[1:], (1, *shape[1:])):
            L = np.broadcast_to(L, shape).copy()
        if L.shape != shape:
            raise ModelError(f"L has shape {L.shape}; {shape} or {shape[1:]} is needed")
        L.flags.writeable = False
        object.__setattr__(self, "L", L)

    @property
    def model(self) -> TSModel:
        return self.feedback.model

    @property
    def sample_time(self) -> float | None:
        """T in s of a law in discrete time; None for continuous time."""
        return self.model.sample_time

    @property
    def states(self) -> tuple[int, ...]:
        """Places of the states that are estimated: all."""
        return tuple(range(len(self.model.states)))

    @cached_property
    def _seen(self) -> dict[int, tuple[int, float]]:
        return seen_directly(self.model, self.rows)

    def memberships(self, estimate: ArrayLike, measured: ArrayLike) -> Floats:
        """Return h (r,) for s (n,) and y - y* (p,)."""
        point = np.array(estimate, dtype=np.float64)
        if not self.at_estimate:
            for state, (k, factor) in self._seen.items():
                point[state] = np.asarray(measured)[k] / factor
        return self.feedback.memberships(self.feedback.state_rest + point)

    def command(self, estimate: ArrayLike, measured: ArrayLike) -> Floats:
        """Return u (m,) for s (n,) and y - y* (p,), SI; see the module."""
        s = np.asarray(estimate, dtype=np.float64)
        K = np.tensordot(self.memberships(s, measured), self.feedback.gains, axes=1)
        return np.asarray(self.feedback.input_rest - K @ s, dtype=np.float64)

    def following(self, estimate: ArrayLike, measured: ArrayLike, sent: ArrayLike) -> Floats:
        """Return s' (s(t + T) in discrete time), (n,).

        Parameters
        ----------
        estimate, measured : s (n,) and y - y* (p,).
        sent : u (m,), the command that the plant gets.
        """
        s, y = (np.asarray(v, dtype=np.float64) for v in (estimate, measured))
        u = np.asarray(sent, dtype=np.float64) - self.feedback.input_rest
        A, B, C, D, L = self._mixed(self.memberships(s, y))
        return np.asarray(A @ s + B @ u + L @ (y - C @ s - D @ u), dtype=np.float64)

    def linear(self, h: Floats) -> tuple[Floats, Floats, Floats]:
        """Return F, L, K of s' = F s + L (y - y*), u - u* = -K s with the weights h (r,)."""
        A, B, C, D, L = self._mixed(h)
        K = np.tensordot(h, self.feedback.gains, axes=1)
        return A - B @ K - L @ (C - D @ K), L, K

    def _mixed(self, h: Floats) -> list[Floats]:
        """Return A, B, C, D and L with the weights h."""
        model, rows = self.model, list(self.rows)
        stacks = (model.A, model.B, model.C[:, rows], model.D[:, rows], self.L)
        return [np.tensordot(h, stack, axes=1) for stack in stacks]


def seen_directly(model: TSModel, rows: Sequence[int]) -> dict[int, tuple[int, float]]:
    """Return state -> (measured output, factor) for each output that is a factor times one state.

    ``rows`` : indices of the measured outputs among the outputs of the model.
    """
    direct = {}
    for k, row in enumerate(rows):
        C, D = model.C[:, row], model.D[:, row]
        nonzero = np.flatnonzero(np.any(C != 0, axis=0))
        if len(nonzero) == 1 and np.all(C == C[0]) and not np.any(D):
            state = int(nonzero[0])
            direct[state] = (k, float(C[0, state]))
    return direct


@dataclass(frozen=True, eq=False)
class ReferenceFeedback:
    """The law of the module.

    Attributes
    ----------
    feedback : K with model and rests; the columns of own states are those of the estimate.
    observer : its matrices.
    rows : indices of the measured outputs among the outputs of the model.
    states : places of the states that are estimated.
    """

    feedback: PdcLaw
    observer: ConstantObserver
    rows: tuple[int, ...]
    states: tuple[int, ...]
    at_estimate: ClassVar[bool] = False

    @property
    def model(self) -> TSModel:
        return self.feedback.model

    @property
    def sample_time(self) -> float | None:
        """None: the law is of continuous time."""
        return self.model.sample_time

    @property
    def integrals(self) -> list[int]:
        """Places of the states that the law has itself."""
        return [k for k in range(len(self.model.states)) if k not in self.states]

    @property
    def L(self) -> Floats:
        """(1, n, p), with rows of 0 for the integrals."""
        gains = np.zeros((1, len(self.model.states), len(self.rows)))
        gains[0, list(self.states)] = self.observer.L
        return gains

    def command(self, estimate: ArrayLike, measured: ArrayLike) -> Floats:
        """Return u (m,) for the estimate (n,) and what is known: y - y* (p,), then xi."""
        z = np.array(estimate, dtype=np.float64)
        z[self.integrals] = np.asarray(measured)[len(self.rows) :]
        return np.asarray(self.feedback.input_rest - self.feedback.gains[0] @ z, dtype=np.float64)

    def following(self, estimate: ArrayLike, measured: ArrayLike, sent: ArrayLike) -> Floats:
        """Return the rate of the estimate (n,); ``sent`` is u (m,) as the plant gets it."""
        observer, rates = self.observer, np.zeros(len(self.model.states))
        s = np.asarray(estimate, dtype=np.float64)[list(self.states)]
        u = np.asarray(sent, dtype=np.float64) - self.feedback.input_rest
        gap = np.asarray(measured, dtype=np.float64)[: len(self.rows)] - observer.C @ s
        rates[list(self.states)] = observer.A @ s + observer.B @ u + observer.L @ gap
        return rates

    def linear(self, h: Floats) -> tuple[Floats, Floats, Floats]:
        """Return F, G, K of z' = F z + G (y - y*), u - u* = -K z, z = (xi, s) as the states."""
        observer, K, n = self.observer, self.feedback.gains[0], len(self.model.states)
        states = list(self.states)
        A, C = (np.tensordot(h, stack, axes=1) for stack in (self.model.A, self.model.C))
        # What the integrals follow, by y.
        slopes = A[self.integrals][:, states] @ np.linalg.pinv(C[list(self.rows)][:, states])
        F, G = np.zeros((n, n)), np.zeros((n, len(self.rows)))
        F[states] = -observer.B @ K
        F[np.ix_(states, states)] += observer.A - observer.L @ observer.C
        G[states], G[self.integrals] = observer.L, slopes
        return F, G, K
