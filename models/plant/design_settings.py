"""The requirements on a design for a plant, from the section ``[design]`` of its file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal, TypeAlias, get_args

from takagi.models.errors import ModelError, did_you_mean

Choice: TypeAlias = Literal["fewest-rules", "least-conservative"]
Rest: TypeAlias = Literal["given", "solve inputs"]
Effort: TypeAlias = Literal["small", "moderate", "large"]
Norm: TypeAlias = Literal["hinf", "h2", "peak"]
SafeStart: TypeAlias = Literal["ellipsoid", "polynomial"]
Objective: TypeAlias = Literal["hinf", "h2", "peak", "decay", "effort"]
CHOICES, RESTS, EFFORTS = get_args(Choice), get_args(Rest), get_args(Effort)
SAFE_STARTS = get_args(SafeStart)
NORMS: tuple[Norm, ...] = get_args(Norm)
OBJECTIVES: tuple[Objective, ...] = get_args(Objective)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantSettings:
    """The requirements on model and gains; SI units.

    Attributes
    ----------
    choice : of premises: ``"fewest-rules"`` or ``"least-conservative"``.
    rest : ``"given"`` takes the rest values of the plant, ``"solve inputs"`` solves for those of
        the inputs.
    decay_rate : alpha [1/s] with V' <= -2 alpha V; ``"max"`` for nine tenths of the largest, which
        needs bounded gains or limited inputs; None for a moderate one
        (``takagi.certificates.design.plant.wishes``).
    relaxation : of the double sum, as ``takagi.lmi.pdc`` names it; None takes all pairs of rules,
        and richer ones where these have no gains.
    input_limit : input -> largest deviation from its rest; one that is not named takes the range
        of the input, if it has one.
    initial : state -> half-width of the box of initial deviations that the limits shall cover;
        a state that is not named starts at rest.  Without any, the ellipsoid in which all limits
        hold is made as large as possible.
    gain_bound : on the spectral norm of every gain, in the units of the model.
    damping : least damping ratio of the poles at the vertices, below 1; continuous time.
    fastest : largest size of those poles [1/s]; continuous time.
    effort : how hard the law may use the inputs.  ``"small"``: at most half of
        the range of every input, and a slower loop; ``"large"``: a faster loop at the price of a
        smaller set or larger gains; ``"moderate"`` for neither.  In numbers:
        ``takagi.certificates.design.plant.wishes``.
    sample_time : T [s] of a law that runs every T seconds and holds its command on a plant in
        continuous time; None for a law that runs all the time.
    noise : disturbance -> root of the intensity (two-sided spectral density) of the white noise
        that it is, in its unit times sqrt(s); a disturbance without a range.
    horizon : T [s] within which the probability of leaving a set is to be bounded under the noise;
        None without noise.
    objective : what is made best beside all that is asked: a norm from disturbances to performance
        (``"hinf"`` energy gain, ``"h2"`` response to white noise, ``"peak"`` peak to peak), the
        ``"decay"`` rate, or the ``"effort"``, the share of the inputs' limits that is used from
        the initial box; None for none.
    performance : names of the outputs, states and inputs that a norm is about; () takes the outputs
        of the plant, else its states over their ranges.
    disturbances : names of those that a norm is about, the others at rest; () takes all.
    norm_below : the norm that is enough, in the units of the plant's file, as
        ``takagi.certificates.design.plant.norm_wish`` writes them; None for the least.
    safe_start : ``"polynomial"`` also asks for a proved set {V <= c} of a polynomial V, for a plant
        and a law that are polynomials in the states; ``"ellipsoid"`` for those of x'Px alone.
    feedback : names of the measured outputs that a static law has, or a controller of a given
        order; () for a law of all states, or with an observer.
    order : the number of that controller's states; 0 for a static law.

    Raises
    ------
    ModelError : an unknown word, a number out of its range, or wishes that contradict each other.
    """

    choice: Choice = "fewest-rules"
    rest: Rest = "given"
    decay_rate: float | Literal["max"] | None = None
    relaxation: str | None = None
    input_limit: Mapping[str, float] = field(default_factory=dict)
    initial: Mapping[str, float] = field(default_factory=dict)
    gain_bound: float | None = None
    damping: float | None = None
    fastest: float | None = None
    effort: Effort = "moderate"
    sample_time: float | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    horizon: float | None = None
    objective: Objective | None = None
    performance: tuple[str, ...] = ()
    disturbances: tuple[str, ...] = ()
    norm_below: float | None = None
    feedback: tuple[str, ...] = ()
    safe_start: SafeStart = "ellipsoid"
    order: int = 0

    def __post_init__(self) -> None:
        _word("choice", self.choice, CHOICES)
        _word("rest", self.rest, RESTS)
        _word("effort", self.effort, EFFORTS)
        _word("safe_start", self.safe_start, SAFE_STARTS)
        for name in ("gain_bound", "damping", "fastest", "sample_time", "horizon", "norm_below"):
            value = getattr(self, name)
            if value is not None:
                _positive(name, value)
        for name in ("input_limit", "initial", "noise"):
            values = dict(getattr(self, name))
            for key, value in values.items():
                _positive(f"{name} of {key}", value)
            object.__setattr__(self, name, MappingProxyType(values))
        if self.noise and self.horizon is None:
            raise ModelError("horizon is missing: noise was given, and no time for its effect")
        if self.horizon is not None and not self.noise:
            raise ModelError("noise is missing: horizon was given, and no white noise")
        if self.damping is not None and self.damping >= 1:
            raise ModelError(f"damping = {self.damping:g} was given; a ratio below 1 is needed")
        object.__setattr__(self, "feedback", tuple(self.feedback))
        self._check_objective()
        rate = self.decay_rate
        if rate is None or rate == "max":
            return
        if isinstance(rate, str) or isinstance(rate, bool) or not math.isfinite(rate) or rate < 0:
            raise ModelError(
                f'decay_rate = {rate!r} was given; a number >= 0 in 1/s is needed, or "max"'
            )

    def _check_objective(self) -> None:
        """Raise ModelError for an objective that contradicts another wish, or lacks one."""
        if self.objective is not None:
            _word("objective", self.objective, OBJECTIVES)
        if self.objective not in NORMS:
            for name in ("norm_below", "performance", "disturbances"):
                if getattr(self, name):
                    raise ModelError(
                        f"{name} was given, which is about a norm, but objective is "
                        f"{self.objective or 'not given'}; give objective hinf, h2 or peak, or "
                        f"leave {name} out"
                    )
        for name in ("performance", "disturbances"):
            names = tuple(getattr(self, name))
            twice = next((key for key in names if names.count(key) > 1), None)
            if twice is not None:
                raise ModelError(f"{name} has {twice} twice; leave one out")
            object.__setattr__(self, name, names)
        if self.objective == "decay" and self.decay_rate not in (None, "max"):
            raise ModelError(
                "objective decay asks for the largest rate, and decay_rate (or settle) for a given "
                "one; leave one out"
            )
        if self.objective not in (None, "decay") and self.decay_rate == "max":
            raise ModelError(
                f"objective {self.objective} and decay_rate max both ask for the best; give a rate "
                "in numbers beside the objective, or leave one out"
            )

    @property
    def without_objective(self) -> PlantSettings:
        """The other wishes alone."""
        return replace(self, objective=None, performance=(), disturbances=(), norm_below=None)

    def require_names(
        self,
        *,
        states: tuple[str, ...],
        inputs: tuple[str, ...],
        disturbances: tuple[str, ...] = (),
        outputs: tuple[str, ...] | None = None,
    ) -> None:
        """Raise ModelError for a name of a wish that the plant does not have.

        ``outputs`` : None where performance was tested before.
        """
        seen = self.performance if outputs is not None else ()
        shown = tuple(dict.fromkeys((*(outputs or ()), *states, *inputs)))
        for field_name, names_given, names, kind in (
            ("input_limit", self.input_limit, inputs, "input"),
            ("initial", self.initial, states, "state"),
            ("noise", self.noise, disturbances, "disturbance"),
            ("performance", seen, shown, "output, state or input"),
            ("disturbances", self.disturbances, disturbances, "disturbance"),
        ):
            for name in names_given:
                if name not in names:
                    listed = ", ".join(names) or "none"
                    raise ModelError(
                        f"{field_name} of {name}: there is no {kind} of that name"
                        f"{did_you_mean(name, names)}; the plant has {listed}"
                    )


def settling_rate(seconds: float) -> float:
    """Return the rate [1/s] at which exp(-rate t) is 2 % after the time."""
    return math.log(50) / seconds


def _word(name: str, value: str, words: tuple[str, ...]) -> None:
    if value not in words:
        raise ModelError(
            f"{name} = {value!r} was given{did_you_mean(value, words)}; "
            f"{' or '.join(words)} is needed"
        )


def _positive(name: str, value: float) -> None:
    if isinstance(value, bool) or not (math.isfinite(value) and value > 0):
        raise ModelError(f"{name} = {value!r} was given; a positive number is needed")
