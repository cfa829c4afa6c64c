"""What is asked of a region of attraction, checked on entry, in one set of coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import corners_of, number, positive_vector, sample_time_of
from takagi.lmi.condition.term import Array
from takagi.lmi.gains.requirements.limits import limits_of
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError, did_you_mean

MEASURES = ("volume", "trace")


def state_box_of(
    model: object, state_box: ArrayLike | None, n: int, input_limit: Array | None
) -> Array | None:
    """Return (n,) half-widths, inf for none: those given, within the model's own box.

    Raises
    ------
    ModelError : shapes, numbers, a model whose domain is not a box, a box of the model without 0
        inside, or with the range of an input that no limit keeps.
    """
    if getattr(model, "domain", None) is not None:
        raise ModelError(
            "the model equals its plant on a band or a union of cells only, and no box inside it "
            "is known; derive the model on a box (sector_model without domain)"
        )
    limits = limits_of(n, 1, state_box=state_box)
    model_box = np.full(n, np.inf)
    inputs = tuple(getattr(model, "inputs", ()))
    for variable, (lower, upper) in getattr(model, "box", {}).items():
        half = min(-float(lower), float(upper))
        if variable in getattr(model, "states", ()):
            if half <= 0:
                raise ModelError(
                    f"the model's box of {variable} is {float(lower):g} ... {float(upper):g}; an "
                    "ellipsoid about 0 needs 0 inside it"
                )
            model_box[model.states.index(variable)] = half  # type: ignore[attr-defined]
        elif variable in inputs and (
            input_limit is None or input_limit[inputs.index(variable)] > half
        ):
            raise ModelError(
                f"the model equals its plant only for |{variable}| <= {half:g}; give an "
                "input_limit within that"
            )
    box = model_box if limits.states is None else np.minimum(model_box, limits.states)
    return box if np.isfinite(box).any() else None


def measure_of(measure: str | ArrayLike, n: int) -> str | Array:
    """Return "volume", "trace" or points, (k, n); half-widths (n,) become corners of the box.

    Raises
    ------
    ModelError : an unknown name, a shape, entries that are not finite, points that are all 0.
    """
    if isinstance(measure, str):
        if measure not in MEASURES:
            raise ModelError(
                f"measure {measure!r} is not known; there are volume, trace, or points (k, {n})"
                + did_you_mean(measure, list(MEASURES))
            )
        return measure
    try:
        points = np.asarray(measure, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(f"measure cannot be read as points ({error}); give (k, {n})") from error
    if points.ndim == 1:
        box = positive_vector("measure", points, n)
        limits = limits_of(n, 1, initial_box=box)
        assert limits.initial is not None
        return limits.initial
    if points.ndim != 2 or points.shape[1] != n or not np.isfinite(points).all():
        raise ModelError(
            f"measure has shape {points.shape}; points (k, {n}), half-widths ({n},), or a name "
            "are needed, all finite"
        )
    if not points.any():
        raise ModelError("the points of the measure are all 0, so any multiple of them is in")
    return points


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class AttractionRequest:
    """What is asked, in one set of coordinates.

    A, B : (r, n, n), (r, n, m); m = 0 without inputs.
    gains : K, (r, m, n) or (1, m, n); None where they are sought.
    sought : whether gains are sought; without gains and not sought, u = 0.
    input_limit : (m,) or None.
    saturation : None, |u| <= limit everywhere; or "polytope".
    overdrive : |v_k| <= overdrive input_limit_k for the command v of gains that are sought.
    state_box : (n,), inf for none; or None.
    decay_rate, saturated_decay_rate : alpha in 1/s where no input saturates, and where one does.
    step : sample time in s or None.
    relaxation : name; measure : "volume", "trace" or points (k, n).
    units : (n,), in which the trace is measured.
    corners : as in ``DoubleSum``.
    """

    A: Array
    B: Array
    gains: Array | None
    sought: bool
    input_limit: Array | None
    saturation: str | None
    overdrive: float
    state_box: Array | None
    decay_rate: float
    saturated_decay_rate: float
    step: float | None
    relaxation: str
    measure: str | Array
    units: Array
    corners: Indices | None

    @property
    def slowest(self) -> float:
        """Return the alpha that holds in the whole ellipsoid."""
        return self.decay_rate if self.saturation is None else self.saturated_decay_rate

    def scaled(self, s: Array, tau: Array) -> AttractionRequest:
        """Return the task in x = s xhat, u = tau uhat."""
        return replace(
            self,
            A=self.A * s / s[:, None],
            B=self.B * tau / s[:, None],
            gains=None if self.gains is None else self.gains * s / tau[:, None],
            input_limit=None if self.input_limit is None else self.input_limit / tau,
            state_box=None if self.state_box is None else self.state_box / s,
            units=self.units / s,
            measure=self.measure if isinstance(self.measure, str) else self.measure / s,
        )


def attraction_request(
    model: object,
    A: Array,
    B: Array,
    gains: Array | None,
    *,
    state_box: ArrayLike | None,
    input_limit: ArrayLike | None,
    saturation: str | None,
    overdrive: float,
    decay_rate: float,
    saturated_decay_rate: float,
    relaxation: str,
    measure: str | ArrayLike,
    sample_time: float | None,
) -> AttractionRequest:
    """Return the task in the model's own coordinates, for gains that are known.

    Parameters and errors are those of ``attraction_ellipsoid``.
    """
    relaxation_named(relaxation)
    n, m = B.shape[1:]
    if saturation not in (None, "polytope"):
        raise ModelError(f'saturation {saturation!r} is not known; there are None and "polytope"')
    limit = None if input_limit is None else positive_vector("input_limit", input_limit, m)
    if saturation is not None and limit is None:
        raise ModelError(f"saturation {saturation!r} needs input_limit, where the inputs saturate")
    step = sample_time_of(model, sample_time)
    fast = float(number("decay_rate", decay_rate, at_least=0.0))
    slow = float(number("saturated_decay_rate", saturated_decay_rate, at_least=0.0))
    if slow > fast:
        raise ModelError(
            f"saturated_decay_rate is {slow:g}, decay_rate only {fast:g} 1/s; saturation slows a "
            "loop down, so ask for no more where an input saturates"
        )
    # Without inputs u = 0, which every box of the inputs holds.
    input_bound = np.zeros(len(getattr(model, "inputs", ()))) if m == 0 else limit
    box = state_box_of(model, state_box, n, input_bound)
    return AttractionRequest(
        A=A,
        B=B,
        gains=gains,
        sought=False,
        input_limit=limit,
        saturation=saturation,
        overdrive=float(number("overdrive", overdrive, at_least=1.0)),
        state_box=box,
        decay_rate=fast,
        saturated_decay_rate=slow,
        step=step,
        relaxation=relaxation,
        measure=measure_of(measure, n),
        units=np.ones(n) if box is None else np.where(np.isfinite(box), box, 1.0),
        corners=corners_of(model),
    )
