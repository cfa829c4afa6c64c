"""The law of a gain file on the nonlinear plant, with the observer of the same file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from takagi.certificates.checker.kernel.reader import member, number, numbers, read_json
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.design.given.turbine_law import law_from_gains
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.speed_filter import SpeedFilter
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.derating import derated
from takagi.models.turbine.wind_observer import WindObserver
from takagi.reports.simulation.laws import ChosenLaws


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
                f"law {name!r} was requested with the law of {path}; only baseline can be "
                "simulated with it, because another law has to be designed: simulate that in "
                "its own run"
            )
    law = law_from_gains(path, turbine)
    held = law.rated_torque if isinstance(law, EffortSharingLaw) else law.coupling.rated_torque
    if beside and held != turbine.rated_torque:
        raise ModelError(
            f"{path}: the law is de-rated to {held:.6g} N m and baseline has no de-rated form; "
            "leave --law baseline out"
        )
    document = read_json(Path(path))
    observer = _observer(turbine, member(document, "observer", str(path)), path)
    laws = {law.name: law, **{name: BaselineLaw(turbine) for name in beside}}
    return _as_held(turbine, held), ChosenLaws(
        laws, observer, _speed_filter(document, law.name, path)
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
