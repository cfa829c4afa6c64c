"""Parallel distributed compensation as a law to be run: u = u* - sum_i h_i(z) K_i (x - x*)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel
from takagi.models.ts.vertex_arrays import finite_array

if TYPE_CHECKING:
    from takagi.models.blending.run_time import RunTimeBlending


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
        for what, size in (("state_rest", n), ("input_rest", m)):
            value = np.array(getattr(self, what), dtype=np.float64)
            if value.shape != (size,) or not np.all(np.isfinite(value)):
                raise ModelError(f"{what} has shape {value.shape}; ({size},) is needed, all finite")
            value.flags.writeable = False
            object.__setattr__(self, what, value)

    @property
    def sample_time(self) -> float | None:
        """T in s of a law in discrete time; None for continuous time."""
        return self.model.sample_time

    @cached_property
    def blend(self) -> RunTimeBlending | None:
        """The blend of two actuators behind the effort that is commanded; None without one."""
        form = None if self.model.derivation is None else self.model.derivation.form
        if form is None or form.plant is None:
            return None
        from takagi.models.blending.blending import blending_of
        from takagi.models.blending.run_time import RunTimeBlending

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

        Parameters
        ----------
        signals : inputs and disturbances that premises depend on, by name, as deviations from
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
        others = {_name(label): 0.0 for label in (*self.model.inputs, *self.model.disturbances)}
        if self.blend is not None:
            others |= self.blend.signals(x)
        for key, value in signals.items():
            if key not in others:
                raise ModelError(
                    f"signal {key} was given; the model has {', '.join(others) or 'none'}"
                )
            others[key] = float(value)
        deviation = zip(map(_name, self.model.states), x - self.state_rest, strict=True)
        point = others | {key: float(value) for key, value in deviation}
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


def _gains(given: ArrayLike, shape: tuple[int, int, int]) -> Floats:
    K = finite_array("K", given)
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
