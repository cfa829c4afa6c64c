"""What the coherent loop's checks do exactly at their limits, told what they ask for."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from types import SimpleNamespace as Told
from typing import Any
from unittest.mock import patch

from takagi.certificates import Claim, Verdict
from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import ONE, UNIT, ZERO, Interval, point
from takagi.certificates.checker.files import frozen_wake
from takagi.certificates.checker.kernel.reader import Number, matrix
from takagi.certificates.checker.turbine.effort_sharing import actuator_rates, wind_rate
from takagi.certificates.checker.turbine.effort_sharing import loop_claim as coherent
from takagi.certificates.checker.turbine.effort_sharing.corners import Corners
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant, Settling, Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.effort_sharing.moving_schedule import Moving
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range
from takagi.certificates.checker.turbine.equilibria import effort_sharing as coherent_rest
from takagi.certificates.checker.turbine.equilibria import equilibrium_claim as equilibrium
from takagi.certificates.checker.turbine.equilibria.effort_sharing import EDGE, _Equilibrium
from takagi.certificates.checker.turbine.published import interval_matrices as interval_family
from tests.certificates.pinned.turbine.coherent_numbers import other, stated, subject
from tests.certificates.pinned.turbine.inputs import read
from tests.certificates.pinned.turbine.pairs_and_limits import refused
from tests.certificates.pinned.turbine.rests_of_coherent import coherent_loop
from tests.certificates.pinned.turbine.values import Named, said
from tests.certificates.pinned.turbine.wind_rate_numbers import a_range

F = Fraction


def of_cells() -> Named:
    """Yield what a cell is told where all it asks for holds, or fails in one place."""
    about, own, claim = subject("torque"), stated("torque"), read("torque")["claims"][0]
    P, settling = matrix(claim, "P", "claim"), Settling.read(claim, "claim")
    loop = Told(
        range_failure=lambda _: "", size_failure=lambda _: "", limits_failure=lambda: "the limits"
    )
    corners = Told(failure=lambda _: "", settles=lambda *_: True)
    share, low = about.box.wind_share, about.law.wind[0]
    wide = other(about, "law", wind=[*about.law.wind, F(30)])
    with patch.object(coherent, "Loop", lambda *_: loop), patch.object(
        coherent, "Corners", lambda *_: corners
    ):  # fmt: skip
        yield "limits", said(coherent._cell_failure, about, 0, own, P, settling)
        loop.limits_failure = lambda: ""
        for name, error in (("at", share * low), ("above", share * low + F(1, 10**7)), ("1", F(1))):
            cell = replace(own, sizes={**own.sizes, "wind_error": error})
            yield f"error {name}", said(coherent._cell_failure, about, 0, cell, P, settling)
        yield "first of two", said(coherent._cell_failure, wide, 0, own, P, settling)
    peaks = {name: F(peak) for name, peak in claim["peaks"].items()}
    box = {name: peaks[name] for name in ("speed_error", "effort_lag", "speed_signal")}
    exact = other(other(about, "box", **box), "law", integral_limit=peaks["integral"])
    yield "peaks at their limits", list(coherent._set_failures(P, claim, exact, "here"))
    for rate in ("0", "0.5"):
        yield (
            f"settling {rate}",
            said(
                Settling.read,
                {"settling": {**claim["settling"], "decay_rate": Number(rate)}},
                "here",
            ),
        )


def of_equilibrium() -> Named:
    """Yield whether a rest is inside, on and outside the set."""
    at = Corners(stated("torque"))
    for gain, residual, size in product((0, 1, 2), (0, 1, 2), (0, 1, 4)):
        at.ends[1], at.residual = [gain], residual
        P = [[F(1) if i == j else F(0) for j in range(3)] for i in range(3)]
        P[2][2] = F(size)
        yield f"{gain} {residual} {size}", at._equilibrium_inside(P)
    far, claim = stated("torque"), read("torque")["claims"][0]
    far = replace(far, sizes={**far.sizes, "residual": F(10)})
    yield "far away", Corners(far).failure(matrix(claim, "P", "claim"))


def of_limits() -> Named:
    """Yield on which side of a limit torque, pitch, lead and curve are."""
    top = F(1, 4)
    for torque, reached, asked, lag in product(
        (F(-1, 10**9), F(0), F(1, 2)), (ONE // 4, ONE // 4 + 1), (top, top + F(1, 10**9)), (1, None)
    ):
        told = Told(
            least_torque=lambda t=torque: t, law=Told(pitch_max=top), reached=Interval(0, reached),
            largest_pitch=lambda p=asked: p, lag_rates=lambda r=lag: r,
        )  # fmt: skip
        yield f"{torque} {reached} {asked} {lag}", Loop.limits_failure(told)  # type: ignore[arg-type]
    for led in (F(1, 10), F(1, 10) - F(1, 10**9), F(1, 10) + F(1, 10**9)):
        lead: Any = Told(box=Told(effort_lag=F(1)), least_b=F(2), led=lambda x=led: x,
                         plant=Told(lag=F(3), rate_limit=F(1, 10)))  # fmt: skip
        yield f"led {led}", Moving.lag_rates(lead)
    for share in (F(0), F(1, 10**9), F(1)):
        lead = Told(lead=share, asked=(F(1), F(1)), rate=F(1, 2), _cut=lambda: F(7))
        yield f"cut {share}", Moving.lag_disturbance(lead)
    for held in ((0, 0), (0, 1), (-1, 0), (0, ONE)):
        looked: list[Any] = []
        curve: Any = Told(
            law=Told(effort_torque=F(3)), plant=Told(gear_per_inertia=F(2)),
            _pieces=lambda: [(F(0), F(1))], share=lambda *_, h=held: Interval(*h),
            psi=lambda *_: ZERO, pitch=lambda _: ZERO,
            _sigma=lambda *given, seen=looked: seen.append(given) or point(F(1, 7)),
        )  # fmt: skip
        yield f"curve {held}", (Loop._curve_gain(curve, UNIT), len(looked))
    about = subject("rated")
    yield "gain of the wind", Loop(about, 0, F(0))._wind_gain()


class _Quotient:
    """An effort that has its quotient at once."""

    def __init__(self, dual: Dual) -> None:
        self.dual = dual

    def __truediv__(self, _: Any) -> Dual:
        return self.dual


def of_rest_pitch() -> Named:
    """Yield the pitch of a rest about the end of the table, whose last place is not a decimal."""
    last = point(F(1, 3) - EDGE)[0]
    for low, high in product((last - 5, last, last + 1), repeat=2):
        if low <= high:
            held = Dual(Interval(low, high), (UNIT, UNIT))
            rest: Any = Told(
                _ramp=lambda _, h=held: _Quotient(h), _column=lambda *_: None,
                law=Told(pitch_max=F(1), pitch_min=F(0), effectiveness=None),
                plant=Told(surface=Told(y=Told(breaks=[F(0), F(1, 3)]))),
            )  # fmt: skip
            yield f"{low - last} {high - last}", _Equilibrium._pitch(rest, (F(8), F(9)), held)
    plant, law, winds = coherent_loop("rated")
    end = plant.surface.x.breaks[-1] - EDGE
    speed = [(end - step) * v / plant.radius for step, v in zip((1, 0), winds, strict=True)]
    with patch.object(coherent_rest, "count_zeros", lambda *_, **__: None):
        found = said(
            coherent_rest.effort_sharing_equilibria, plant, replace(law, speed=speed), winds
        )
    yield "at the last ratio", isinstance(found, str)
    three = Told(pitch_min=F(0), pitch_max=F(1), wind=[F(4), F(5), F(6)])
    turbine = Told(pitch_min=F(0), pitch_max=F(1))
    with patch.object(Plant, "read", lambda _: turbine), patch.object(
        Law, "read", lambda _: three
    ):  # fmt: skip
        yield "known winds", equilibrium.equilibrium_reader({}, {"name": "coherent"})[:2]
    for low, high in ((0, ONE // 4 - 1), (0, ONE // 4), (0, ONE // 4 + 1)):
        spline: Any = Told(bounds=lambda *_, e=(low, high): e)
        yield f"below {high - ONE // 4}", frozen_wake._below(spline, UNIT, UNIT, F(1, 4))


def of_families() -> Named:
    """Yield weights of a set that is very flat, and rows longer than there are states."""
    flat = [[10**60, 0], [0, 3]]
    low, high = [[-3, 1], [0, -4]], [[-2, 2], [1, -4]]
    yield "flat", interval_family._spare(flat, 1, low, high)
    long = [[6, 1, 0], [1, 5, 0]]
    given = long, long, 1, 10**7, [1, 2], F(1)
    yield "long rows", refused(interval_family._invariant, *given)


def of_winds() -> Named:
    """Yield where ranges of winds begin and end, exactly."""
    law, one = subject("torque").law, a_range()
    slack = {"wind_rate": Number("9"), "wind_error": Number("9")}
    none = {"wind_rate": Number("0"), "wind_error": Number("0")}
    wide = replace(law, wind=[F(7), F(8), F(12)])
    yield "cell below", wind_rate._outside_class(one, wide, [none, slack], F(1))
    single = Range([F(9)], [F(0)], [F(0)], F(0))
    narrow = replace(law, wind=[F(8), F(12)])
    yield "one wind", wind_rate._outside_class(single, narrow, [slack], F(1))
    yield "cells", refused(wind_rate._outside_class, one, narrow, [slack, slack], F(1))
    still = replace(one, schedule=[F(0)] * 4)
    for i, ahead in product(range(3), (F(1), F(-1))):
        yield f"bends {i} {ahead}", list(wind_rate._bends(still, i, ahead))


def of_torque_steps() -> Named:
    law = subject("torque").law
    own = replace(law, inertia=[F(4), F(1)], inertia_limit=[F(1, 4), F(1)])
    yield "at a limit between", actuator_rates.torque_step(own, [F(1, 4), F(1, 4)])
    data = read("torque")
    loop, wind, claim = data["claims"][:3]
    two = replace(law, wind=[F(8), F(9), F(10)], inertia=[F(0)] * 2, inertia_limit=[F(0)] * 2)
    proved = [Claim("loop", Verdict.PROVED, "")] * 2 + [Claim("wind", Verdict.PROVED, "")]
    claims = [loop, {**loop, "cells": loop["cells"] * 2}, {**wind, "loop": Number("0")}]
    bounds = [Told(fed=F(1, 2)), Told(fed=F(0))]
    for name, failure in (("fails", "no"), ("another loop", ""), ("holds", "")):
        kept = [*claims[:2], {**claims[2], "loop": Number("1" if name == "holds" else "0")}]
        own_claim = {**claim, "loop": Number("1"), "wind_rate": Number("2"),
                     "cells": [{"schedule_bend": Number("9")}] * 2}  # fmt: skip
        if name == "fails":
            own_claim.pop("wind_rate")
        with (
            patch.object(actuator_rates, "cell_rates", lambda *_: bounds),
            patch.object(Subject, "read", lambda *_: Told(law=two)),
            patch.object(actuator_rates, "_failure", lambda *_, f=failure: f),
            patch.object(actuator_rates, "largest_bends", lambda *_: [F(1), F(2)]),
        ):
            whole = {**data, "claims": [*kept, own_claim]}
            found = said(actuator_rates.check_actuator_rates, own_claim, whole, proved, "here")
        if isinstance(found, str):
            yield name, found
        else:
            told = [found.given.get(key) for key in ("failures", "fed", "kept")]
            yield name, (found.verdict.name, told)
    with (
        patch.object(actuator_rates, "cell_rates", lambda *_: bounds[:1]),
        patch.object(actuator_rates, "listed", lambda *_: [{}, {}]),
        patch.object(actuator_rates, "_failure", lambda *_: ""),
    ):
        asked = {**claim, "loop": Number("0")}
        asked.pop("wind_rate", None)
        given_ = asked, {**data, "claims": claims}, proved, "here"
        yield "cells", refused(actuator_rates.check_actuator_rates, *given_)


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    return {
        "edges of cells": of_cells,
        "edges of the set": of_equilibrium,
        "edges of limits": of_limits,
        "edges of pitch": of_rest_pitch,
        "edges of families": of_families,
        "edges of winds": of_winds,
        "edges of torque": of_torque_steps,
    }
