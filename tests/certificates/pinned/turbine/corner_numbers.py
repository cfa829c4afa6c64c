"""Corner matrices of the effort-sharing loop: what their inequalities allow, what is told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.reader import Number, matrix
from takagi.certificates.checker.turbine.effort_sharing import corners as coherent_corners
from takagi.certificates.checker.turbine.effort_sharing import loop_claim as coherent
from takagi.certificates.checker.turbine.effort_sharing.corners import Corners, Stated, bounds_row
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Settling
from tests.certificates.pinned.turbine.coherent_numbers import stated, subject
from tests.certificates.pinned.turbine.inputs import CELLS, document, read
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


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


SIZES = (
    *("decay_rate", "multiplier", "residual", "wind_error", "wind_gain", "inertia_gain"),
    *("lag_disturbance", "wind_rate", "reference_slope", "effectiveness_slope"),
)


def of_thresholds(cell: str, part: int) -> Named:
    """Yield about the largest number of each kind that the corner inequalities allow, over 10^7."""
    about, claim = stated(cell), read(cell)["claims"][0]
    P = matrix(claim, "P", "claim")
    for name in SIZES[part::5]:

        def holds(k: int, name: str = name) -> bool:
            sizes = {**about.sizes, name: F(k, 10**7)}
            return not Corners(replace(about, sizes=sizes)).failure(P)

        yield name, largest(holds, int(about.sizes[name] * 10**7))
    for name in coherent_corners.RANGES[part::5]:
        for end, sign in ((0, -1), (1, 1)):

            def inside(k: int, name: str = name, end: int = end, sign: int = sign) -> bool:
                ends = [*about.ranges[name]]
                ends[end] += sign * F(k, 10**7)
                return not Corners(replace(about, ranges={**about.ranges, name: ends})).failure(P)

            yield f"{name} {end}", largest(inside, 0)
    if part == 2:
        # With the second state's sign changed the worst sign of z is the other one.
        mirrored = {name: [-end for end in reversed(about.ranges[name])]
                    for name in ("lag_gain", "share_gain")}  # fmt: skip
        signs = (1, -1, 1)
        Q = [[a * signs[i] * signs[j] for j, a in enumerate(row)] for i, row in enumerate(P)]

        def mirror(k: int) -> bool:
            sizes = {**about.sizes, "lag_disturbance": F(k, 10**7)}
            other = replace(about, ranges={**about.ranges, **mirrored}, sizes=sizes)
            return not Corners(other).failure(Q)

        yield "lag_disturbance, mirrored", largest(mirror, 0)
    at, settling = Corners(about), Settling.read(claim, "claim")
    if part == 0:
        yield "settles", largest(lambda k: at.settles(settling.P, F(k, 10**7)), 0)

        def rests(k: int) -> bool:
            sizes = {**about.sizes, "residual": F(k, 10**7)}
            return Corners(replace(about, sizes=sizes))._equilibrium_inside(P)

        yield "equilibrium", largest(rests, 0)
    if part == 1:
        yield "P", largest(lambda k: not at.failure(_times(P, F(k, 10**7))), 10**7)
    if part == 2:
        yield "P, least", largest(lambda k: not at.failure(_times(P, F(10**7, k + 1))), 10**7)


def _times(P: list[list[Fraction]], share: Fraction) -> list[list[Fraction]]:
    return [[share * entry for entry in row] for row in P]


def largest(holds: Callable[[int], bool], start: int) -> int:
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


def of_claim(cell: str) -> Named:
    """Yield the whole answer to the claim."""
    for claim in check_document(document(cell, "coherent-loop")).claims:
        yield "answer", (claim.verdict.name, claim.name, claim.text, claim.assumes)


def of_changed() -> Named:
    """Yield what is said of the claim with other matrices, and of one that is not about its law."""
    data = read("torque")
    claim, own = data["claims"][0], data["claims"][0]["P"]
    negative = [[Number(f"-{entry}".replace("--", "")) for entry in row] for row in own]
    other = {**claim["settling"], "P": negative}
    forged = {**other, "decay_rate": Number("50")}
    gains = {**data["gains"], "pitch_max": Number("1.5")}
    for name, changes in (
        ("two rows", {"P": own[:2]}),
        ("two columns", {"P": [row[:2] for row in own]}),
        ("four columns", {"P": [[*row, Number("0")] for row in own]}),
        ("negative", {"P": negative}),
        ("not symmetric", {"P": [own[0], own[1], [Number("9"), *own[2][1:]]]}),
        ("settling", {"settling": other}),
        ("settling, forged", {"settling": forged}),
        ("settling, two rows", {"settling": {**other, "P": own[:2]}}),
        ("settling, two columns", {"settling": {**other, "P": [row[:2] for row in own]}}),
        ("no cells", {"cells": []}),
        ("two cells", {"cells": claim["cells"] * 2}),
        ("wide peak", {"peaks": {**claim["peaks"], "integral": Number("9")}}),
    ):
        changed = {**claim, **changes}
        found = said(coherent.check_effort_sharing, changed, data["model"], data["gains"], "here")
        yield name, found if isinstance(found, str) else _told(found)
    yield "other gains", said(coherent.check_effort_sharing, claim, data["model"], gains, "here")


def _told(found: Any) -> Any:
    data = found.given
    return found.verdict.name, data.get("why"), data.get("failures")


def of_laws_read() -> Named:
    """Yield which tables of a law are read."""
    gains = read("torque")["gains"]
    zero, less, some = Number("0"), Number("-1"), Number("0.5")
    for name, value in gains.items():
        others = (zero, less, some) if isinstance(value, Number) else (
            [zero] * len(value), value[:1], [less, *value[1:]], [*value, some],
        ) if isinstance(value, list) else ()  # fmt: skip
        for number, other in enumerate(others):
            found = said(Law.read, {**gains, name: other})
            yield f"{name} {number}", found if isinstance(found, str) else "read"
    columns = [name for name, value in gains.items() if isinstance(value, list)]
    for count in (1, 2, 2000, 2001):
        many = {name: [*gains[name]] * count for name in columns}
        many = {name: values[: count - (len(gains[name]) == 1)] for name, values in many.items()}
        many["wind"] = [Number(str(3 + k / 100)) for k in range(count)]
        found = said(Law.read, {**gains, **many})
        yield f"{count} winds", found if isinstance(found, str) else "read"
    still = {"pitch_lead": zero, "inertia_feedforward": [zero], "wind_filter": zero}
    for name in still:
        found = said(Law.read, {**gains, **still, name: gains[name]})
        yield f"nothing fed but {name}", found if isinstance(found, str) else "read"


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
        "rounding": of_rounding,
        "set": of_set,
        "claim changed": of_changed,
        "laws read": of_laws_read,
    }
    for part in range(5):
        found[f"thresholds, rated, {part}"] = lambda part=part: of_thresholds("rated", part)
    for cell in CELLS:
        for name, numbers in (
            ("corners", of_corners), ("claim", of_claim), ("failures", of_failures),
        ):  # fmt: skip
            found[f"{name}, {cell}"] = lambda numbers=numbers, cell=cell: numbers(cell)
    return found
