"""Numbers of the coherent loop: enclosures in one wind cell, corner matrices, and its claims."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.certificate import check_document
from takagi.certificates.checker.kernel.reader import Number, matrix
from takagi.certificates.checker.turbine import coherent, coherent_corners, coherent_residual
from takagi.certificates.checker.turbine.coherent_corners import Corners, Stated, bounds_row
from takagi.certificates.checker.turbine.coherent_inputs import Settling, Subject
from takagi.certificates.checker.turbine.coherent_loop import Loop
from takagi.certificates.checker.turbine.coherent_moving import Moving
from tests.certificates.pinned.turbine.inputs import CELLS, Document, as_read, document
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


@cache
def read(cell: str) -> Document:
    """Return a recorded certificate as the checker reads it."""
    return as_read(document(cell))


def subject(cell: str) -> Subject:
    """Return what the recorded claim is about."""
    data = read(cell)
    return Subject.read(data["claims"][0], data["model"], data["gains"], "claims[0]")


def stated(cell: str) -> Stated:
    return Stated.read(read(cell)["claims"][0]["cells"][0], "cell")


def other(about: Subject, part: str, **changes: Any) -> Subject:
    """Return the subject with other numbers in one of its parts."""
    return replace(about, **{part: replace(getattr(about, part), **changes)})


# ------------------------------------------------------------------ enclosures


def moving(at: Moving) -> Named:
    """Yield what a moving schedule wind does."""
    yield "efforts", (at.low, at.high, at.least_b, at.lead)
    yield "ranges", (at.wind, at.b, at.c, at.radius)
    yield "asked", at.asked
    yield "led", at.led()
    yield "lag rates", at.lag_rates()
    yield "slopes", (at.effectiveness_slope(), at.reference_slope())
    yield "cut", at._cut()
    yield "lag disturbance", at.lag_disturbance()
    yield "least torque", at.least_torque()
    yield "largest pitch", said(at.largest_pitch)


def loop(at: Loop) -> Named:
    """Yield the coefficients of the loop in a cell."""
    yield "reached", at.reached
    yield "pieces", list(at._pieces())
    yield "limits", at.limits_failure()
    yield from (*at.ranges(), *at.sizes())


def in_cell(cell: str) -> Named:
    about, rate = subject(cell), stated(cell).sizes["wind_rate"]
    at = Loop(about, 0, rate)
    yield from moving(at)
    yield from loop(at)
    ranges, sizes = stated(cell).ranges, stated(cell).sizes
    yield "failures", (at.range_failure(ranges), at.size_failure(sizes))
    for name, found in at.ranges():
        low, high = F(found.low, ONE), F(found.high, ONE)
        tried = ((low, high), (low + F(1, ONE), high), (low, high - F(1, ONE)))
        yield f"{name} at its ends", [at.range_failure({**ranges, name: list(e)}) for e in tried]
    for name, size in at.sizes():
        ends = (size, size - F(1, ONE))
        yield f"{name} at its end", [at.size_failure({**sizes, name: end}) for end in ends]


def variants(cell: str) -> Iterator[tuple[str, Subject, Fraction]]:
    """Yield other laws, boxes and uncertainties in the same cell, honest or not."""
    about, rate = subject(cell), stated(cell).sizes["wind_rate"]
    law = about.law
    slow = 3 * rate + F(1, 100)
    yield "still", about, F(0)
    yield "faster", about, 7 * rate + F(1, 50)
    yield "lead", other(about, "law", lead=about.plant.lag / 2), rate
    yield "long lead", other(about, "law", lead=3 * about.plant.lag), 5 * rate + F(1, 10)
    yield "no lead", other(about, "law", lead=F(0)), rate
    for name, f, g, rho in (
        ("fed", F(-1, 10), F(1, 500), rate),
        ("fed, limited", F(1, 7), F(1, 90), F(3, 10)),
        ("fed, none", F(1, 7), F(0), rate),
    ):
        yield name, other(about, "law", inertia=[f], inertia_limit=[g]), rho
    yield "light", other(about, "uncertainty", inertia=(F(7, 10), F(13, 10))), rate
    yield "no wake", other(about, "uncertainty", frozen_wake=False), rate
    yield "power", other(about, "uncertainty", power=(F(9, 10), F(21, 20))), rate
    yield "narrow ramp", other(about, "law", overlap=law.overlap / 50), rate
    yield "wide ramp", other(about, "law", overlap=3 * law.overlap), rate
    small = {"speed_signal": F(1, 1000), "effort_lag": F(1, 2000)}
    yield "small box", other(about, "box", **small), rate
    steep = [law.effectiveness[0], 3 * law.effectiveness[1]]
    yield "steep", other(about, "law", effectiveness=steep), slow
    yield "steeper", other(about, "law", effectiveness=steep), 40 * slow
    names = ("speed", "effort", "effectiveness", "limit", "gamma")
    falling = {name: getattr(law, name)[::-1] for name in names}
    yield "falling", other(about, "law", **falling), slow
    yield "low torque", other(about, "law", rated_torque=F(9000)), rate
    yield "low pitch", other(about, "law", pitch_max=F(1, 50)), rate
    yield "slow drive", other(about, "plant", rate_limit=F(1, 200)), rate


def of_moving(cell: str) -> Named:
    for name, about, rate in variants(cell):
        yield from ((f"{name}: {what}", value) for what, value in moving(Moving(about, 0, rate)))


def of_variants(cell: str) -> Named:
    names = (
        "light",
        "no wake",
        "power",
        "small box",
        "falling",
        "low pitch",
        "slow drive",
        "long lead",
    )
    for name, about, rate in variants(cell):
        if name in (names[1:] if cell == "rated" else names[:5]):
            at = Loop(about, 0, rate)
            yield f"{name}: ranges", said(dict, at.ranges())
            yield f"{name}: sizes", said(dict, at.sizes())
            yield f"{name}: limits", at.limits_failure()
            yield f"{name}: pieces", list(at._pieces())


def of_middle_cell() -> Named:
    """Yield the numbers of a cell that has neighbours with other tables."""
    about, rate = subject("rated"), stated("rated").sizes["wind_rate"]
    law = about.law
    low, high = law.wind
    nodes = ("speed", "effort", "effectiveness", "limit", "gamma")
    columns = {name: [F(7, 8) * getattr(law, name)[0], *getattr(law, name),
                      F(9, 8) * getattr(law, name)[1]] for name in nodes}  # fmt: skip
    cells = {name: [F(1, 9), *getattr(law, name), F(1, 7)] for name in ("nu", "inertia_limit")}
    columns |= cells | {"inertia": [F(1, 8), F(1, 30), F(1, 6)]}
    cells = {"wind": [low - F(1, 8), low, high, high + F(1, 8)]}
    at = Loop(other(about, "law", **columns, **cells), 1, rate)
    yield from moving(at)
    yield from loop(at)


def of_residual(cell: str) -> Named:
    """Yield the jets that bound how far the tables leave the trim."""
    at = Moving(subject(cell), 0, F(0))
    yield "ratio", coherent_residual._ratio(at)
    yield "pitch", coherent_residual._pitch(at)
    jets = coherent_residual._ratio(at), coherent_residual._pitch(at)
    yield "coefficient", coherent_residual._coefficient(at, *jets)
    yield "curvature", coherent_residual._curvature(at)
    yield "at nodes", [coherent_residual._at_node(at, i) for i in (0, 1)]
    yield "demanded", [coherent_residual._demanded(at, i) for i in (0, 1)]
    for power in ((F(1), F(1)), (F(9, 10), F(1)), (F(1), F(11, 10)), (F(9, 10), F(6, 5))):
        yield f"power {power[0]} to {power[1]}", coherent_residual.residual(at, power)


def of_bends() -> Named:
    eps = F(1, 8)
    ends = [F(k, 16) for k in range(-4, 5)]
    for low, high in product(ends, ends):
        if low <= high:
            yield f"{low} to {high}", coherent_residual._bend(low, high, eps)


# ------------------------------------------------------------------ matrices


def of_corners(cell: str) -> Named:
    """Yield the integers of the corner inequalities, and on which side of each a number is."""
    about, claim = stated(cell), read(cell)["claims"][0]
    P = [[F(entry) for entry in row] for row in claim["P"]]
    at = Corners(about)
    yield "numbers", (at.ends, at.moving_ends, at.nu, at.alpha, at.rho, at.residual, at.w, at.z)
    corner = tuple(ends[-1] for ends in at.ends)
    A = coherent_corners._matrix(corner, at.nu)
    yield "matrix", A
    whole = [[int(entry * 10**9) for entry in row] for row in P]
    yield "shifted", coherent_corners._shifted(A, whole, at.alpha)
    yield "drift", about.drift
    for share in (F(1, 4), F(9, 10), F(1), F(11, 10), F(3), F(50)):
        yield f"P times {share}", at.failure([[share * entry for entry in row] for row in P])
    for name, factors in (
        ("decay_rate", (F(1), F(2), F(20))),
        ("multiplier", (F(1, 8), F(1, 2), F(1), F(2), F(16))),
        ("residual", (F(1), F(2), F(100))),
        ("wind_error", (F(1), F(2), F(100))),
        ("lag_disturbance", (F(1), F(2), F(100))),
        ("wind_rate", (F(1), F(2), F(100))),
        ("reference_slope", (F(1), F(2), F(100))),
        ("effectiveness_slope", (F(1), F(2), F(1000))),
    ):
        size = about.sizes[name] or F(1, 10**4)
        found = []
        for factor in factors:
            value = F(round(factor * size * 10**7), 10**7)
            found.append(Corners(replace(about, sizes={**about.sizes, name: value})).failure(P))
        yield f"{name} changed", found
    settling = Settling.read(claim, "claim")
    rates = [F(k, 100) for k in range(0, 60, 6)]
    yield "settles", [at.settles(settling.P, rate) for rate in (settling.decay_rate, *rates)]


SIZES = ("decay_rate", "multiplier", "residual", "wind_error", "wind_gain", "inertia_gain")
SIZES += ("lag_disturbance", "wind_rate", "reference_slope", "effectiveness_slope")


def of_thresholds(cell: str, part: int) -> Named:
    """Yield about the largest number of each kind that the corner inequalities bear, over 10^7."""
    about, claim = stated(cell), read(cell)["claims"][0]
    P = matrix(claim, "P", "claim")
    for name in SIZES[part::5]:

        def holds(k: int, name: str = name) -> bool:
            sizes = {**about.sizes, name: F(k, 10**7)}
            return not Corners(replace(about, sizes=sizes)).failure(P)

        yield name, _largest(holds, int(about.sizes[name] * 10**7))
    for name in coherent_corners.RANGES[part::5]:
        for end, sign in ((0, -1), (1, 1)):

            def inside(k: int, name: str = name, end: int = end, sign: int = sign) -> bool:
                ends = [*about.ranges[name]]
                ends[end] += sign * F(k, 10**7)
                return not Corners(replace(about, ranges={**about.ranges, name: ends})).failure(P)

            yield f"{name} {end}", _largest(inside, 0)
    at, settling = Corners(about), Settling.read(claim, "claim")
    if part == 0:
        yield "settles", _largest(lambda k: at.settles(settling.P, F(k, 10**7)), 0)
    if part == 1:
        yield "P", _largest(lambda k: not at.failure(_times(P, F(k, 10**7))), 10**7)
    if part == 2:
        yield "P, least", _largest(lambda k: not at.failure(_times(P, F(10**7, k + 1))), 10**7)


def _times(P: list[list[Fraction]], share: Fraction) -> list[list[Fraction]]:
    return [[share * entry for entry in row] for row in P]


def _largest(holds: Callable[[int], bool], start: int) -> int:
    """Return about the last number from a start on for which something holds; -1 for none."""
    if not holds(start):
        return -1
    step = 256
    while holds(start + step) and step < 10**9:
        step *= 8
    low, high = start, start + step
    while high - low > max(1, low // 512):
        middle = (low + high) // 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def of_rounding() -> Named:
    for value in (F(0), F(1, 3), F(-1, 3), F(2, 10**7), F(-2, 10**7), F(1, 10**8), F(-1, 10**8)):
        yield f"up {value}", coherent_corners._up(value)
        yield f"scaled {value}", said(coherent_corners._scaled, value, "here")
    P = [[F(4), F(1), F(0)], [F(1), F(3), F(1)], [F(0), F(1), F(2)]]
    for h in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, -1), (1, 2, -3)):
        peaks = [F(k, 8) for k in range(1, 25)]
        yield f"bounds {h}", "".join("ny"[bounds_row(P, h, peak)] for peak in peaks)


# ------------------------------------------------------------------ the claim


def of_claim(cell: str) -> Named:
    """Yield the whole answer to the claim."""
    for claim in check_document(document(cell, "coherent-loop")).claims:
        yield "answer", (claim.verdict.name, claim.name, claim.text, claim.assumes)


def of_failures(cell: str) -> Named:
    """Yield what is said with one number of the claim changed, to either side."""
    about, own, claim = subject(cell), stated(cell), read(cell)["claims"][0]
    P = matrix(claim, "P", "claim")
    settling = Settling.read(claim, "claim")

    def failure(cell: Stated, common: Settling = settling) -> Any:
        return said(coherent._cell_failure, about, 0, cell, P, common)

    yield "as recorded", failure(own)
    yield "common rate", failure(own, replace(settling, decay_rate=F(9)))
    for name in ("wind_rate", "wind_error", "multiplier", "decay_rate", "integral_rate"):
        for value in (F(-1, 10**7), F(0), own.sizes[name] + F(1, 10**7), F(9)):
            yield f"{name} {value}", failure(replace(own, sizes={**own.sizes, name: value}))
    for name in ("residual", "inertia_gain", "reference_slope"):
        less = {**own.sizes, name: own.sizes[name] * F(9, 10)}
        yield f"{name} less", failure(replace(own, sizes=less))
    for name in ("wind", "effectiveness_limit", "stiffness", "lag_gain"):
        for place in (0, 1):
            ends = [*own.ranges[name]]
            ends[place] += F(1 - 2 * place, 100)
            yield f"{name} {place}", failure(replace(own, ranges={**own.ranges, name: ends}))


def of_set() -> Named:
    """Yield which peaks the set keeps."""
    about, claim = subject("torque"), read("torque")["claims"][0]
    P, peaks = matrix(claim, "P", "claim"), claim["peaks"]
    for name, peak in peaks.items():
        for factor in (F(0), F(-1), F(1, 2), F(1), F(3, 2), F(90)):
            other_peak = Number(repr(float(factor * F(peak))))
            changed = {**claim, "peaks": {**peaks, name: other_peak}}
            yield f"{name} times {factor}", list(coherent._set_failures(P, changed, about, "here"))


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {
        "ramp bends": of_bends,
        "rounding": of_rounding,
        "set": of_set,
        "middle cell": of_middle_cell,
    }
    for cell, part in product(("rated",), range(5)):
        found[f"thresholds, {cell}, {part}"] = lambda c=cell, p=part: of_thresholds(c, p)
    for cell in CELLS:
        for name, numbers in (
            ("cell", in_cell),
            ("moving", of_moving),
            ("variants", of_variants),
            ("residual", of_residual),
            ("corners", of_corners),
            ("claim", of_claim),
            ("failures", of_failures),
        ):
            found[f"{name}, {cell}"] = lambda numbers=numbers, cell=cell: numbers(cell)
    return found
