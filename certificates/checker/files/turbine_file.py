r"""Ties the plant of a certificate to the turbine file it is said to come from.

A hash shows that a file is the one that was recorded; it does not show that the certificate's
numbers are the file's.  Here they are computed again from the TOML file and its coefficient table:

    every figure, converted to SI         to 1e-12 of itself
    torque constant 1/2 rho pi R^3        to 1e-12 of itself
    the knots of the spline c_Q           those of the not-a-knot spline of the table, to 1e-12
    lambda c_Q(lambda, beta) = c_P        at every entry of the table, to 1e-9
    the law's frozen-wake limit           at every wind node, to its last decimal; between them not
                                          more than 5 % below the file's at one of its winds
    the law's rated torque                to 1e-12 of itself; a lower one is reported

With the knots that belong to the table's entries there is one spline through these (Schoenberg and
Whitney); with more knots it may have other values between them.

Numbers are read as the decimals that are written; pi is a rational with 50 digits.

Source: de Boor (1978), A Practical Guide to Splines, ch. IV (not-a-knot) and XIII (uniqueness).

The frozen wake of a turbine file that states a factor kappa: dP/dbeta at each of its winds v.

    beta* = the largest pitch with k v^2 c_Q(lambda, beta*) = n_g T_rated
    dP/dbeta = kappa omega_rated k v^2 dc_Q/dbeta(lambda, beta*)

    lambda = omega_rated R / v,   k = 1/2 rho pi R^3

The root is searched from the top of the pitch range downwards. The enclosure of c_Q proves that no
piece above it contains a root, so it is the largest one.

A file without the section has the frozen wake of momentum theory, u = v (1 - k_a a(c_T)) held:

    dP/dbeta = omega_rated (T_beta + T_v v k_a a' c_T,beta / u_v)
    u_v      = 1 - k_a a + k_a a' lambda c_T,lambda
    T_beta   = k v^2 dc_Q/dbeta,   T_v = k v (2 c_Q - lambda dc_Q/dlambda)

at the multiples of 1/2 m/s at which a pitch balances rated torque, and at cut-out. k_a is the
file's wake.induction, or 1.3; a = (1 - sqrt(1 - c_T)) / 2, beyond c_T = 8/9 its tangent; c_T is
linear between the entries of its table and held at the edges, its slopes are differences over
+-1/4 in lambda and +-1/50 rad in beta.
"""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from math import isqrt
from pathlib import Path
from typing import Any, NamedTuple

from takagi.certificates.checker.arithmetic.interval import ONE, Interval, enclose, point
from takagi.certificates.checker.arithmetic.spline import Spline
from takagi.certificates.checker.files.model_content import (
    OtherModel,
    file_content,
    inside_folder,
    read_toml,
)
from takagi.certificates.checker.kernel.reader import (
    increasing,
    matrix,
    member,
    number,
    numbers,
)
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused

PI = Fraction("3.14159265358979323846264338327950288419716939937511")
FACTORS = {
    "-": Fraction(1),
    "m": Fraction(1),
    "s": Fraction(1),
    "kg m^2": Fraction(1),
    "kg/m^3": Fraction(1),
    "m/s": Fraction(1),
    "N m": Fraction(1),
    "N m/s": Fraction(1),
    "kN m": Fraction(1000),
    "rad": Fraction(1),
    "rad/s": Fraction(1),
    "deg": PI / 180,
    "deg/s": PI / 180,
    "rpm": PI / 30,
    "W/rad": Fraction(1),
    "MW/rad": Fraction(10**6),
}
FIGURES = {
    "rotor_radius": ("rotor", "radius"),
    "rotor_inertia": ("rotor", "inertia"),
    "generator_inertia": ("generator", "inertia"),
    "gear_ratio": ("drivetrain", "gear_ratio"),
    "rated_rotor_speed": ("rotor", "rated_speed"),
    "pitch_time_constant": ("pitch", "time_constant"),
    "pitch_rate_limit": ("pitch", "rate_limit"),
    "pitch_min": ("pitch", "minimum"),
    "pitch_max": ("pitch", "maximum"),
}
# Quantities that only some claims need: compared if the certificate states them.
MORE_FIGURES = {"torque_rate_limit": ("generator", "torque_rate_limit")}
RELATIVE = Fraction(1, 10**12)
TABLE_TOLERANCE = Fraction(1, 10**9)
LIMIT_TOLERANCE = Fraction(1, 10**6)
# The law's table is linear between its winds, and a bend of the file's column may lie there.
WAKE_SHORTFALL = Fraction(1, 20)
EDGE = Fraction(1, 10**20)
LARGEST_EXPONENT, MOST_DIGITS = 40, 100


def compare_turbine(model: Any, gains: Any, path: Path) -> str:
    """Compare plant and frozen-wake limit with a turbine file; return messages for the reader.

    Raises
    ------
    CertificateError : the file cannot be read.
    OtherModel : a number of the certificate is not the file's.
    """
    file = read_toml(path, _decimal, what="turbine file")
    try:
        return _compare(model, gains, file, path)
    except (ValueError, ArithmeticError) as error:
        if isinstance(error, CertificateError):
            raise
        # A wind, an inertia or a speed of zero, columns that do not fit.
        raise OtherModel(f"{path}: not the certificate's turbine: {error}") from error


def _compare(model: Any, gains: Any, file: dict[str, Any], path: Path) -> str:
    stated = {key: field for key, field in MORE_FIGURES.items() if key in model}
    for key, (section, name) in (FIGURES | stated).items():
        _same(number(model, key, "model"), _figure(file, section, name, path), key, path)
    radius = _figure(file, "rotor", "radius", path)
    density = _figure(file, "rotor", "air_density", path)
    constant = number(model, "torque_constant", "model")
    _same(constant, density * PI * radius**3 / 2, "torque_constant", path)
    rated = _figure(file, "generator", "rated_torque", path)
    derated = _derated(number(gains, "rated_torque", "gains"), rated, path)
    spline = _compare_surface(model, file, path)
    if isinstance(gains, dict) and "effectiveness_limit" in gains:
        winds, slopes = _frozen_wake(model, rated, spline, file, path)
        if len(winds) != len(slopes):
            raise CertificateError(f"{path}: frozen_wake columns of different length")
        _compare_limit(model, gains, winds, slopes, path)
    return derated


def _derated(law_torque: Fraction, rated: Fraction, path: Path) -> str:
    """Return a message if the law's rated torque is below the file's; refuse one above it."""
    if not 0 < law_torque < (1 - RELATIVE) * rated:
        _same(law_torque, rated, "rated_torque", path)
        return ""
    return (
        f"de-rated: the law holds torque at {float(law_torque):.12g} N m, "
        f"{float(100 * law_torque / rated):.4g} % of the rated torque in {path.name}"
    )


def _decimal(written: str) -> Fraction:
    """Return a decimal exactly; ``Fraction`` alone would expand 1e999999999."""
    number = Decimal(written)
    if not number.is_finite() or (number and abs(number.adjusted()) > LARGEST_EXPONENT):
        raise ValueError(f"a number beyond 1e{LARGEST_EXPONENT}: {written[:40]}")
    digits, exponent = len(number.as_tuple().digits), number.as_tuple().exponent
    if digits > MOST_DIGITS or not isinstance(exponent, int) or abs(exponent) > MOST_DIGITS:
        raise ValueError(f"a number of more than {MOST_DIGITS} digits: {written[:40]}")
    return Fraction(number)


def _figure(file: dict[str, Any], section: str, name: str, path: Path) -> Fraction:
    """Return one quantity in SI units, exact except for pi."""
    entry = file.get(section, {}).get(name) if isinstance(file.get(section), dict) else None
    if not isinstance(entry, dict):
        raise OtherModel(f"{path}: {section}.{name} is missing")
    return _si(entry.get("value"), entry.get("unit"), f"{path}: {section}.{name}")


def _si(value: Any, unit: Any, where: str) -> Fraction:
    if isinstance(value, bool) or not isinstance(value, (int, Fraction)):
        raise CertificateError(f"{where}: a number is needed")
    if abs(value) > 10**LARGEST_EXPONENT:
        raise CertificateError(f"{where}: numbers go to 1e{LARGEST_EXPONENT}")
    if not isinstance(unit, str) or unit not in FACTORS:
        raise CertificateError(f"{where}: unit {unit!a} is not one the checker converts")
    return Fraction(value) * FACTORS[unit]


def _same(stated: Fraction, written: Fraction, quantity: str, path: Path) -> None:
    if abs(stated - written) > RELATIVE * abs(written):
        raise OtherModel(
            f"{path}: {quantity} is {float(written):.12g} there, {float(stated):.12g} in the "
            "certificate"
        )


def _compare_surface(model: Any, file: dict[str, Any], path: Path) -> Spline:
    """Compare lambda c_Q of the certificate's spline with every entry of the c_P table."""
    surface, where = member(model, "torque_surface", "model"), "model.torque_surface"
    spline = Spline(
        numbers(surface, "tip_speed_ratio_knots", where),
        numbers(surface, "pitch_knots", where),
        matrix(surface, "coefficients", where),
    )
    section = file.get("coefficients")
    table = section.get("power") if isinstance(section, dict) else None
    if not isinstance(table, str) or Path(table).name != table:
        raise CertificateError(f"{path}: coefficients.power must name a table beside the file")
    table_path = path.with_name(table)
    pitches, rows = _entries(inside_folder(path, table))
    points = {"tip-speed ratio": list(rows), "pitch": pitches}
    for (name, table_points), axis in zip(points.items(), (spline.x, spline.y), strict=True):
        if not _are_not_a_knot(axis.breaks, table_points):
            raise OtherModel(
                f"{table_path}: its entries in {name} are not those of the certificate's spline, "
                "which has other knots"
            )
    for ratio, row in rows.items():
        for pitch, power in zip(pitches, row, strict=True):
            try:
                low, high = spline.bounds(
                    point(_held(ratio, spline.x.breaks)), point(_held(pitch, spline.y.breaks))
                )
            except Refused as error:
                raise OtherModel(f"{table_path}: {error}") from error
            slack = TABLE_TOLERANCE * ONE
            if not low * ratio - slack <= power * ONE <= high * ratio + slack:
                raise OtherModel(
                    f"{table_path}: c_P at tip-speed ratio {float(ratio):g}, pitch "
                    f"{float(pitch):.6g} rad is {float(power):.9g} there, "
                    f"{float(Fraction(low, ONE) * ratio):.9g} in the certificate"
                )
    return spline


def _are_not_a_knot(breaks: list[Fraction], points: list[Fraction]) -> bool:
    """Return whether a clamped cubic spline with these breaks is the one through the points.

    It has a break at every point but the second and the last but one.
    """
    expected_breaks = [points[0], *points[2:-2], points[-1]]
    return (
        len(points) >= 4
        and len(breaks) == len(expected_breaks)
        and all(abs(a - b) <= RELATIVE for a, b in zip(breaks, expected_breaks, strict=True))
    )


def _held(value: Fraction, breaks: list[Fraction]) -> Fraction:
    """Return a value at the table's edge moved inside by 1e-20, because the knots are rounded."""
    low, high = breaks[0], breaks[-1]
    if abs(value - low) <= RELATIVE:
        return low + EDGE
    return high - EDGE if abs(value - high) <= RELATIVE else value


def _entries(path: Path) -> tuple[list[Fraction], dict[Fraction, list[Fraction]]]:
    """Return the pitches [rad] of a coefficient table, and by tip-speed ratio the row of c_P."""
    try:
        lines = file_content(path, what="table").decode("utf-8-sig").splitlines()
        rows = [line.split(",") for line in lines if line and not line.startswith("#")]
        angles = [_decimal(cell) * FACTORS["deg"] for cell in rows[0][1:]]
        power_rows: dict[Fraction, list[Fraction]] = {}
        for row in rows[1:]:
            if len(row) != len(angles) + 1:
                raise CertificateError(f"{path}: rows of different length")
            power_rows[_decimal(row[0])] = [_decimal(cell) for cell in row[1:]]
        for points in (angles, list(power_rows)):
            increasing(points, f"{path}: tip-speed ratios and pitches")
    except (ValueError, IndexError, ArithmeticError) as error:
        if isinstance(error, CertificateError):
            raise
        raise CertificateError(f"{path}: not a coefficient table: {error}") from error
    if len(power_rows) < len(rows) - 1 or not angles or not power_rows:
        raise CertificateError(f"{path}: not a coefficient table: a tip-speed ratio stands twice")
    return angles, power_rows


def _frozen_wake(
    model: Any, rated: Fraction, spline: Spline, file: dict[str, Any], path: Path
) -> tuple[list[Fraction], list[Fraction]]:
    """Return winds and dP/dbeta [W/rad]: published, by the factor, or of momentum theory."""
    if "frozen_wake" not in file:
        return momentum_slopes(model, rated, spline, file, path)
    section = file["frozen_wake"]
    if not isinstance(section, dict) or "factor" not in section:
        return _column(file, "wind", path), _column(file, "power_sensitivity", path)
    if "power_sensitivity" in section:
        raise CertificateError(f"{path}: frozen_wake states a factor beside published columns")
    stated = _column(file, "wind", path), _column(file, "factor", path)
    if len(stated[0]) != len(stated[1]):
        raise CertificateError(f"{path}: frozen_wake columns of different length")
    return stated[0], scaled_slopes(model, rated, spline, stated, path)


def _compare_limit(
    model: Any, gains: Any, winds: list[Fraction], slopes: list[Fraction], path: Path
) -> None:
    """Compare the law's limit of pitch effectiveness with the file's frozen wake.

    -dP/dbeta / (omega_rated J), linear between its winds; below the first it falls with v^2.
    """
    gear = number(model, "gear_ratio", "model")
    inertia = number(model, "rotor_inertia", "model")
    inertia += gear**2 * number(model, "generator_inertia", "model")
    scale = number(model, "rated_rotor_speed", "model") * inertia
    wind, limits = (numbers(gains, name, "gains") for name in ("wind", "effectiveness_limit"))
    pairs = list(zip(wind, limits, strict=True))
    # The columns' own winds between those of the law, at which the law's limit is a line.
    pairs += [(v, _between(v, wind, limits)) for v in winds if wind[0] < v < wind[-1]]
    for k, (v, stated) in enumerate(pairs):
        share = min(Fraction(1), v / winds[0]) ** 2
        expected = -_between(v, winds, slopes) * share / scale
        at_node, short = k < len(wind), expected - stated
        if abs(short) > LIMIT_TOLERANCE if at_node else short > WAKE_SHORTFALL * expected:
            raise OtherModel(
                f"{path}: the frozen wake's pitch effectiveness at {float(v):g} m/s is "
                f"{float(expected):.7g} there, {float(stated):.7g} in the gains"
            )


def _column(file: dict[str, Any], name: str, path: Path) -> list[Fraction]:
    section = file.get("frozen_wake")
    entry = section.get(name) if isinstance(section, dict) else None
    values = entry.get("values") if isinstance(entry, dict) else None
    if not isinstance(entry, dict) or not isinstance(values, list) or not values:
        raise OtherModel(f"{path}: frozen_wake.{name} is missing")
    return [_si(value, entry.get("unit"), f"{path}: frozen_wake.{name}") for value in values]


def _between(v: Fraction, winds: list[Fraction], values: list[Fraction]) -> Fraction:
    """Return the piecewise linear value, constant beyond both ends."""
    if v <= winds[0]:
        return values[0]
    for k in range(len(winds) - 1):
        if v <= winds[k + 1]:
            share = (v - winds[k]) / (winds[k + 1] - winds[k])
            return values[k] + share * (values[k + 1] - values[k])
    return values[-1]


# Width at which the bisection for the trim pitch ends, in rad: far below any stated decimal.
NARROW = Fraction(1, 2**44)


def scaled_slopes(
    model: Any,
    rated_torque: Fraction,
    spline: Spline,
    stated: tuple[list[Fraction], list[Fraction]],
    path: Path,
) -> list[Fraction]:
    """Return dP/dbeta [W/rad] at each wind of (winds, factors).

    Raises
    ------
    CertificateError : a wind at which no pitch balances rated torque, or outside the table.
    """
    slopes = []
    for wind, factor in zip(*stated, strict=True):
        try:
            rotor = _Trim.at(model, rated_torque, spline, wind)
        except (Refused, ZeroDivisionError) as error:
            raise CertificateError(
                f"{path}: frozen_wake.factor at {float(wind):g} m/s: {error}"
            ) from error
        slopes.append(factor * rotor.speed * rotor.by_pitch)
    return slopes


class _Trim(NamedTuple):
    """A wind at which pitch holds rated torque: lambda, pitch, dT/dbeta and dT/dv."""

    speed: Fraction
    ratio: Fraction
    pitch: Fraction
    by_pitch: Fraction
    by_wind: Fraction

    @classmethod
    def at(cls, model: Any, rated_torque: Fraction, spline: Spline, wind: Fraction) -> _Trim:
        """Return the trim; ``Refused`` where no pitch holds rated torque."""
        radius, speed, constant, gear, low, pitch_max = (
            number(model, key, "model")
            for key in ("rotor_radius", "rated_rotor_speed", "torque_constant", "gear_ratio",
                        "pitch_min", "pitch_max")
        )  # fmt: skip
        # The table's last knot is rounded in fixed point, so the range stays slightly inside.
        high = min(pitch_max, spline.y.breaks[-1] - EDGE)
        ratio = speed * radius / wind
        needed = gear * rated_torque / (constant * wind**2)
        pitch = _largest_root(spline, point(ratio), needed, low, high)

        def middle(dx: int, dy: int) -> Fraction:
            return Fraction(sum(spline.bounds(point(ratio), pitch, dx, dy)), 2 * ONE)

        by_wind = 2 * middle(0, 0) - ratio * middle(1, 0)
        angle = Fraction(pitch.low + pitch.high, 2 * ONE)
        k = constant * wind
        return cls(speed, ratio, angle, k * wind * middle(0, 1), k * by_wind)


INDUCTION = Fraction("1.3")
WIND_STEP, RATIO_STEP, PITCH_STEP = Fraction(1, 2), Fraction(1, 4), Fraction(1, 50)
ROOT_DIGITS, LARGEST_WIND = 10**20, Fraction(60)


def momentum_slopes(
    model: Any, rated: Fraction, spline: Spline, file: dict[str, Any], path: Path
) -> tuple[list[Fraction], list[Fraction]]:
    """Return the winds and dP/dbeta [W/rad] of momentum theory, for a file that states none.

    Raises
    ------
    CertificateError : a table or figure that is missing; no pitch holds rated torque at any wind.
    """
    last, ka = _figure(file, "operation", "cut_out", path), INDUCTION
    if last > LARGEST_WIND:
        raise CertificateError(f"{path}: operation.cut_out goes to {float(LARGEST_WIND):g} m/s")
    if "wake" in file:
        ka = _figure(file, "wake", "induction", path)
    section = file.get("coefficients")
    angles, rows = _entries(
        inside_folder(path, section.get("thrust") if isinstance(section, dict) else None)
    )

    def thrust(ratio: Fraction, pitch: Fraction) -> Fraction:
        along = [_between(pitch, angles, row) for row in rows.values()]
        return _between(ratio, list(rows), along)

    slopes: dict[Fraction, Fraction] = {}
    wind = last
    while wind > 0:
        try:
            at = _Trim.at(model, rated, spline, wind)
        except Refused:
            break  # Below rated wind, or beyond the table's largest tip-speed ratio.
        x, y, h, d = at.ratio, at.pitch, RATIO_STEP, PITCH_STEP
        a, slope = _induction(thrust(x, y))
        by_ratio = (thrust(x + h, y) - thrust(x - h, y)) / (2 * h)
        by_pitch = (thrust(x, y + d) - thrust(x, y - d)) / (2 * d)
        flow = 1 - ka * a + ka * slope * x * by_ratio
        if flow <= 0:
            raise CertificateError(f"{path}: no frozen wake by momentum theory at {float(wind):g}")
        slopes[wind] = at.speed * (at.by_pitch + at.by_wind * wind * ka * slope * by_pitch / flow)
        wind = (-(-wind // WIND_STEP) - 1) * WIND_STEP
    if not slopes:
        raise CertificateError(f"{path}: no pitch holds rated torque at cut-out")
    winds = sorted(slopes)
    return winds, [slopes[v] for v in winds]


def _induction(thrust: Fraction) -> tuple[Fraction, Fraction]:
    """Return a(c_T) and its slope; the root to twenty digits."""
    if thrust > Fraction(8, 9):
        return Fraction(1, 3) + Fraction(3, 4) * (thrust - Fraction(8, 9)), Fraction(3, 4)
    root = Fraction(isqrt(int((1 - thrust) * ROOT_DIGITS**2)), ROOT_DIGITS)
    return (1 - root) / 2, 1 / (4 * root)


def _largest_root(
    spline: Spline, ratio: Interval, needed: Fraction, low: Fraction, high: Fraction
) -> Interval:
    """Return a short bracket of the largest pitch at which c_Q is not certainly below needed."""
    if not _below(spline, ratio, point(high), needed):
        raise Refused("the largest pitch still leaves too much torque")
    # Pieces to examine, the highest last; a piece that may contain a root is halved.
    waiting = [(low, high)]
    while waiting:
        low_pitch, high_pitch = waiting.pop()
        if _below(spline, ratio, enclose(low_pitch, high_pitch), needed):
            continue
        if high_pitch - low_pitch <= NARROW:
            return enclose(low_pitch, high_pitch)
        middle = (low_pitch + high_pitch) / 2
        waiting += [(low_pitch, middle), (middle, high_pitch)]
    raise Refused("no pitch gives rated torque there; a factor is stated from rated wind on")


def _below(spline: Spline, ratio: Interval, pitch: Interval, needed: Fraction) -> bool:
    """Return whether c_Q is certainly below ``needed`` on the piece."""
    return spline.bounds(ratio, pitch)[1] * needed.denominator < needed.numerator * ONE
