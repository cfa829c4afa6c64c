r"""The section [frozen_wake] of a turbine file: what pitch does before the wake has answered.

Two forms.  Published sensitivities, each with the trim pitch that it belongs to:

    wind, pitch, power_sensitivity    S(v) = dP/dbeta with the induction held [W/rad]

or, where nothing is published, a factor kappa that is stated over wind:

    wind, factor                      S(v) = kappa(v) omega_rated dT_r/dbeta(omega_rated, beta*, v)

with beta* the trim pitch and dT_r/dbeta the slope of the coefficient table, which is that of the
wake in equilibrium.  kappa is at least 1: held induction makes pitch act more.  Where the slope
vanishes, as it may at rated wind, no factor helps: the column begins above, and its first entry
holds below, with the square of wind.  ``source`` says where the columns were read, or why the
factor was chosen.
"""

from __future__ import annotations

from takagi.models.files.toml_document import Document
from takagi.models.turbine.data import FrozenWake, Turbine
from takagi.models.turbine.file_figures import FileFigure, column_at, text_at

_WIND = FileFigure("frozen_wake.wind", "wind", "m/s", 0.1, 60)
_PITCH = FileFigure("frozen_wake.pitch", "pitch", "rad", -1, 2)
_SENSITIVITY = FileFigure("frozen_wake.power_sensitivity", "power_sensitivity", "W/rad", -1e12, 0)
_FACTOR = FileFigure("frozen_wake.factor", "factor", "-", 1, 100)
WAKE = (_WIND, _PITCH, _SENSITIVITY, _FACTOR)
"""The columns that the section may have."""


def read_frozen_wake(document: Document, turbine: Turbine) -> FrozenWake:
    """Return the frozen-wake columns of a file, computed from the factor if one is stated.

    Parameters
    ----------
    turbine : the file's turbine; its own frozen wake is not read.

    Raises
    ------
    ModelError : both forms at once, a column that is missing, winds that do not increase, columns
        of different length; with a factor: a wind outside rated wind to cut-out, or one at which
        the table's torque does not fall with pitch.
    """
    given = document.data.get("frozen_wake", {})
    stated = isinstance(given, dict) and "factor" in given
    if stated and not {"pitch", "power_sensitivity"}.isdisjoint(given):
        raise document.error(
            "frozen_wake.factor",
            "is given beside published columns; keep pitch and power_sensitivity, or factor alone",
        )
    columns = {
        spec.attribute: column_at(document, spec)
        for spec in ((_WIND, _FACTOR) if stated else (_WIND, _PITCH, _SENSITIVITY))
    }
    _check(document, columns)
    source = text_at(document, "frozen_wake.source")
    if not stated:
        return FrozenWake(**columns, source=source)
    points = [
        _scaled(document, turbine, wind, factor)
        for wind, factor in zip(columns["wind"], columns["factor"], strict=True)
    ]
    pitch, sensitivity = zip(*points, strict=True)
    return FrozenWake(columns["wind"], pitch, sensitivity, source)


def _check(document: Document, columns: dict[str, tuple[float, ...]]) -> None:
    wind = columns["wind"]
    if any(after <= before for before, after in zip(wind, wind[1:], strict=False)):
        raise document.error("frozen_wake.wind", "must increase; sort the table by wind")
    for name, column in columns.items():
        if len(column) != len(wind):
            raise document.error(
                f"frozen_wake.{name}", f"has {len(column)} values, but wind has {len(wind)}"
            )


def _scaled(
    document: Document, turbine: Turbine, wind: float, factor: float
) -> tuple[float, float]:
    """Return (trim pitch [rad], kappa omega_rated dT_r/dbeta [W/rad]) at one wind."""
    from takagi.models.turbine.aerodynamics import rotor_torque_gradient
    from takagi.models.turbine.trim import rated_wind, trim

    first = rated_wind(turbine)
    if not first <= wind <= turbine.cut_out:
        raise document.error(
            "frozen_wake.wind",
            f"{wind:.6g} m/s was given; a factor is stated from rated wind, {first:.6g} m/s, to "
            f"cut-out, {turbine.cut_out:.6g} m/s; below rated the first one holds, with the "
            "square of wind",
        )
    pitch = trim(turbine, wind).pitch
    slope = float(rotor_torque_gradient(turbine, turbine.rated_rotor_speed, pitch, wind)[1])
    if slope >= 0:
        raise document.error(
            "frozen_wake.factor",
            f"at {wind:.6g} m/s the table's dT_r/dbeta is {slope:.6g} N m/rad, not negative, and "
            "no factor makes it so; leave this wind out",
        )
    return pitch, factor * turbine.rated_rotor_speed * slope
