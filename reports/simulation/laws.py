"""The laws to choose from: with gains found now, or the law of a gain file, with its observer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, get_args

from takagi.certificates.checker.kernel.reader import member, number, numbers, read_json
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.design.given.turbine_law import law_from_gains
from takagi.certificates.design.turbine.effort_sharing_gains import (
    wind_by_wind_law,
    wind_observer_design,
)
from takagi.certificates.design.turbine.published_law import designed_law, regional_design
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.protocol import Law
from takagi.models.laws.published.law import switched_law
from takagi.models.laws.published.regional_schedule import Variant
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import Observer
from takagi.models.simulation.turbine_plant import SpeedFilter
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import derated
from takagi.models.turbine.wind_observer import WindObserver
from takagi.reports.output import read_words

# The law's name, and what a reader of its numbers should know.
LAW_NAMES: Mapping[str, str] = read_words("simulation/words.toml")["laws"]
# Set-points beyond their ends by this share are these ends, written with few digits.
ROUNDED = 1e-6
DEFAULT_LAWS = ("coherent", "paper", "baseline")


def default_laws(turbine: Turbine) -> tuple[str, ...]:
    """Return ``DEFAULT_LAWS``, without the reference's own where the turbine has none."""
    return DEFAULT_LAWS if turbine.baseline is not None else DEFAULT_LAWS[:-1]


@dataclass(frozen=True, slots=True, eq=False)
class ChosenLaws:
    """Laws by name, and the observer in their loops (None where no law uses an estimate).

    Attributes
    ----------
    speed_filters : law's name -> what is done to the measured speed before the law reads it; a law
        that is not named has nothing of the kind outside itself.
    """

    laws: Mapping[str, Law]
    observer: Observer | None
    speed_filters: Mapping[str, SpeedFilter] = field(default_factory=dict)


def chosen_laws(
    turbine: Turbine,
    names: Sequence[str],
    *,
    coupling_filter: str | None = None,
    settings: DesignSettings | None = None,
) -> ChosenLaws:
    """Return the named laws, in the order given, a name given twice once; nothing is proved.

    Parameters
    ----------
    names : from ``LAW_NAMES``.
    coupling_filter : "saturated" or "sector", of Schulte's law; None takes the first.
    settings : of a design; None takes the turbine's defaults.

    Raises
    ------
    ModelError : no or an unknown name, a filter that is unknown or that no law has, or gains that
        cannot be found.
    """
    asked_for = require_law_names(names)
    variant = _require_variant(coupling_filter, asked_for)
    if asked_for == ("baseline",):
        return ChosenLaws({"baseline": BaselineLaw(turbine)}, None)
    # Imported here: the reference's own controller needs no solver.
    from takagi.certificates.design.turbine.result import speed_filter

    settings = settings or default_settings(turbine)
    laws = {name: _law(name, turbine, settings, variant) for name in asked_for}
    measured = speed_filter(settings)
    filters = dict.fromkeys(("coherent", "paper", "switched"), measured) if measured else {}
    return ChosenLaws(laws, studied_observer(turbine), filters)


@lru_cache(maxsize=1)
def studied_observer(turbine: Turbine) -> Any:
    """Return what all laws share that read an estimate of the wind."""
    return wind_observer_design(turbine, default_settings(turbine)).observer


@lru_cache(maxsize=1)
def _regional(turbine: Turbine) -> Any:
    """Return what Schulte's laws share, whatever their overlaps."""
    return regional_design(turbine)


def _require_variant(given: str | None, names: Sequence[str]) -> Variant:
    if given is None:
        return "saturated"
    if "paper" not in names:
        raise ModelError(
            f"coupling filter {given!r} was given, which is an option of Schulte's law alone; ask "
            "for that law too, or leave the filter out"
        )
    for variant in get_args(Variant):
        if given == variant:
            return variant  # type: ignore[no-any-return]
    raise ModelError(
        f"coupling filter {given!r} was given; choose one of {', '.join(get_args(Variant))}"
        f"{did_you_mean(given, get_args(Variant))}"
    )


def require_law_names(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names without repetitions; ModelError for none or an unknown one."""
    if not names:
        raise ModelError(f"no law was given; choose from {', '.join(LAW_NAMES)}")
    for name in names:
        if name not in LAW_NAMES:
            raise ModelError(
                f"law {name!r} is not known{did_you_mean(name, LAW_NAMES)}; choose from "
                f"{', '.join(LAW_NAMES)}"
            )
    return tuple(dict.fromkeys(names))


def _law(name: str, turbine: Turbine, settings: DesignSettings, variant: Variant) -> Law:
    if name == "baseline":
        return BaselineLaw(turbine)
    if name == "coherent":
        return wind_by_wind_law(turbine, settings)[1]
    # The emitted law: what is certified and what is simulated read the same gains.
    law = designed_law(turbine, replace(settings, law="paper"), _regional(turbine), variant)
    return switched_law(law) if name == "switched" else law


def filed_laws(
    turbine: Turbine, path: Path, beside: Sequence[str] = ()
) -> tuple[Turbine, ChosenLaws]:
    """Return the law of a gain file, and the reference's own controller if it is requested.

    If the law is de-rated at rated speed, the turbine is returned de-rated too, so that its numbers
    are relative to the reduced torque.

    Parameters
    ----------
    turbine : the turbine for which the gains were designed.
    path : the gain file, as `takagi design` writes it.
    beside : empty, or "baseline".

    Raises
    ------
    CertificateError : a file that is no turbine's gain file, or has no observer.
    ModelError : another law beside it, which would have to be designed anew; or the reference's
        own beside a de-rated one, since it has no de-rated form.
    """
    for name in beside:
        if name != "baseline":
            raise ModelError(
                f"law {name!r} was requested with the law of {path}; only reference can be "
                "simulated with it, because another law has to be designed: simulate that in "
                "its own run"
            )
    law = law_from_gains(path, turbine)
    held = law.rated_torque if isinstance(law, EffortSharingLaw) else law.coupling.rated_torque
    if beside and held != turbine.rated_torque:
        raise ModelError(
            f"{path}: the law is de-rated to {held:.6g} N m and the reference controller has no "
            "de-rated form; leave --law reference out"
        )
    document = read_json(Path(path))
    observer = _observer(turbine, member(document, "observer", str(path)), path)
    laws = {law.name: law, **{name: BaselineLaw(turbine) for name in beside}}
    return _as_held(turbine, held), ChosenLaws(
        laws, observer, _speed_filter(document, law.name, path)
    )


def with_setpoints(
    turbine: Turbine, chosen: ChosenLaws | None, setpoints: Mapping[str, float]
) -> tuple[Turbine, ChosenLaws]:
    """Return a filed law at these set-points from the start on, and the turbine as de-rated.

    Parameters
    ----------
    chosen : as ``filed_laws`` returns it; None without a file.
    setpoints : "speed" of the rotor [rad/s], electrical "power" [W]; the rated one unless given.

    Raises
    ------
    ModelError : no law that takes set-points, or one outside the range that the law is proved for.
    """
    law = None if chosen is None else chosen.laws.get("coherent")
    if chosen is None or not isinstance(law, EffortSharingLaw) or law.setpoints is None:
        raise ModelError(
            "option --setpoint: no law here takes set-points at run time; design one with "
            "`takagi design MODEL --lowest-speed-setpoint SPEED --lowest-torque-setpoint TORQUE "
            "--out DIR`, and simulate DIR"
        )
    if "baseline" in chosen.laws:
        raise ModelError(
            "option --setpoint: the reference controller takes no set-points; leave --law "
            "reference out"
        )
    inputs, rated = law.setpoints, float(law.schedule.rotor_speed[-1])
    factor = inputs.power_per_torque
    ranges = {
        "speed": (inputs.lowest_speed, rated, "rad/s"),
        "power": (
            factor * inputs.lowest_speed * inputs.lowest_torque,
            factor * rated * law.rated_torque,
            "W",
        ),
    }
    for name, value in setpoints.items():
        low, high, unit = ranges[name]
        if not low * (1 - ROUNDED) <= value <= high * (1 + ROUNDED):
            raise ModelError(
                f"option --setpoint {name}: {value:.6g} {unit} was given; the law takes "
                f"{low:.6g} to {high:.6g} {unit}"
            )
    asked = {name: high for name, (_, high, _) in ranges.items()} | dict(setpoints)
    at_setpoints = law.at_setpoints(speed=asked["speed"], power=asked["power"])
    assert at_setpoints.operation is not None
    return _as_held(turbine, at_setpoints.operation.torque), replace(
        chosen, laws={"coherent": at_setpoints}
    )


def _observer(turbine: Turbine, stated: Any, path: Path) -> WindObserver:
    """Return the file's observer; files without limits of the wind have those of the turbine."""
    where = f"{path}: observer"
    l1, l2 = (float(number(stated, name, where)) for name in ("l1", "l2"))
    if "wind_limits" not in stated:
        return WindObserver(turbine, l1, l2)
    low, high = (float(one) for one in numbers(stated, "wind_limits", where, 2))
    return WindObserver(turbine, l1, l2, (low, high))


def _speed_filter(document: Any, law: str, path: Path) -> dict[str, SpeedFilter]:
    """Return law -> the file's filter of the measured speed; files without one have no entry."""
    if "measurement" not in document:
        return {}
    where = f"{path}: measurement"
    stated = member(document, "measurement", str(path))
    corner, stop, passed = float(number(stated, "speed_filter", where)), 0.0, 1.0
    if "torsion_filter" in stated:
        band_stop, inside = member(stated, "torsion_filter", where), f"{where}.torsion_filter"
        stop = float(number(band_stop, "frequency", inside))
        passed = float(number(band_stop, "passed", inside))
        if not stop > 0:
            raise CertificateError(
                f"{inside}.frequency is {stop:g} rad/s; it must be above 0, or the member must not "
                "be there"
            )
    if not corner > 0:
        raise CertificateError(
            f"{where}.speed_filter is {corner:g} rad/s; it must be above 0, or the "
            "member must not be there"
        )
    return {law: SpeedFilter(corner, stop, passed)}


def _as_held(turbine: Turbine, torque: float) -> Turbine:
    try:
        return derated(turbine, torque)
    except ModelError:
        # With a lower speed too: a run starts at the trim of rated speed, which it has not.
        return turbine
