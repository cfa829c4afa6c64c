"""Families of claims with closed forms, thrown straight at the checker with fitting evidence.

Each function draws one loop, puts the claimed number at its exact limit or a hair beside it, and
returns the same claim with several P: the one that is best, and wrong ones.  ``truth`` is whether
the sentence of the claim can be true at all, whatever P is.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

from exact_truth import diagonal, is_at_most_exp, logarithm
from known_loops import Random
from modes import (
    Disguise,
    Known,
    beside,
    claim_of,
    functions,
    law_of,
    model_of,
    short,
    signs,
    some,
)

STEP = Fraction(1, 10)
W = {"disturbance": "disturbances"}


def decay(rng: Random) -> list[Known]:
    """Modes -a_i: V cannot fall faster than the slowest."""
    n = int(rng.integers(1, 5))
    a = [some(rng) for _ in range(n)]
    if rng.random() < 0.2:
        a[0] = Fraction(0)
    hidden = Disguise.draw(rng, n)
    model = model_of([hidden.loop(diagonal([-value for value in a]))])
    rate = max(beside(rng, min(a)), Fraction(0))
    truth = min(a) >= rate and min(a) > 0
    best = hidden.function([Fraction(1)] * n)
    return [
        Known(model, None, claim_of("decay", decay_rate=rate, P=P), truth, fits)
        for P, fits in functions(rng, best)
    ]


def sampled_decay(rng: Random) -> list[Known]:
    """Modes f_i in discrete time: |f| <= e^(-alpha T), alpha at -ln|f| / T to 30 digits."""
    n = int(rng.integers(1, 4))
    f = [Fraction(int(k), 100) for k in rng.integers(1, 100, size=n)]
    signed = [s * value for s, value in zip(signs(rng, n), f, strict=True)]
    hidden = Disguise.draw(rng, n)
    model = model_of([hidden.loop(diagonal(signed))], STEP)
    rate = max(beside(rng, short(logarithm(max(f), 30) / STEP)), Fraction(0))
    truth = is_at_most_exp(max(f), rate * STEP)
    best = hidden.function([Fraction(1)] * n)
    return [
        Known(model, None, claim_of("decay", decay_rate=rate, P=P), truth, fits)
        for P, fits in functions(rng, best)
    ]


def region(rng: Random) -> list[Known]:
    """Poles p +- i q of a Pythagorean triangle: half-plane, disc, strip, sector, to their edge."""
    legs = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (7, 24, 25))[int(rng.integers(4))]
    unit = some(rng)
    p, q, size = (unit * k for k in legs)
    hidden = Disguise.draw(rng, 2)
    model = model_of([hidden.loop([[-p, q], [-q, -p]])])
    which = int(rng.integers(4))
    one, zero = Fraction(1), Fraction(0)
    if which == 0:
        x = beside(rng, p)
        part, truth = {"L": [[2 * x]], "M": [[one]]}, p > x
    elif which == 1:
        x = beside(rng, size)
        part, truth = {"L": [[-x, zero], [zero, -x]], "M": [[zero, one], [zero, zero]]}, size < x
    elif which == 2:
        x = beside(rng, p)
        part, truth = {"L": [[-2 * x]], "M": [[-one]]}, p < x
    else:
        x = beside(rng, Fraction(legs[1], legs[0]))
        part, truth = {"L": [[zero, zero], [zero, zero]], "M": [[x, one], [-one, x]]}, q < x * p
    best = hidden.function([one, one])
    return [
        Known(model, None, claim_of("region", parts=[part], P=P), truth, fits)
        for P, fits in functions(rng, best)
    ]


def l2_gain(rng: Random) -> list[Known]:
    """Modes z' = -a z + b w, y = c z (or z+ = f z + b w): the gain is the largest |bc| / a."""
    n, step = int(rng.integers(1, 4)), STEP if rng.random() < 0.5 else None
    a, b, c = ([some(rng, 1, 100) for _ in range(n)] for _ in range(3))
    hidden = Disguise.draw(rng, n)
    motion = [-value for value in a] if step is None else _kept(rng, a)
    model = model_of(
        [hidden.loop(diagonal(motion))],
        step,
        E=[hidden.entering(diagonal(b))],
        C=[hidden.leaving(diagonal(c))],
    )
    limit = max(y * z / x for x, y, z in zip(a, b, c, strict=True))
    gain = beside(rng, limit)
    weights = []
    for x, y, z in zip(a, b, c, strict=True):
        if step is None:
            weights.append(short(x * gain / y**2))
        else:
            weights.append(short((gain * (2 * x - x**2) + z**2 * y**2 / gain) / (2 * y**2)))
    best = hidden.function(weights)
    return [
        Known(model, None, claim_of("l2-gain", gain=gain, P=P, **W), gain >= limit, fits)
        for P, fits in functions(rng, best, scaled_fits=False)
    ]


def _kept(rng: Random, a: list[Fraction]) -> list[Fraction]:
    """Return f_i of size 1 - a_i, of either sign."""
    return [s * (1 - value) for s, value in zip(signs(rng, len(a)), a, strict=True)]


def h2_norm(rng: Random) -> list[Known]:
    """The same modes under white noise: E|y|^2 is the sum of b^2 c^2 / (2a), or / (1 - f^2)."""
    n, step = int(rng.integers(1, 4)), STEP if rng.random() < 0.5 else None
    a, b, c = ([some(rng, 1, 100) for _ in range(n)] for _ in range(3))
    hidden = Disguise.draw(rng, n)
    motion = [-value for value in a] if step is None else _kept(rng, a)
    model = model_of(
        [hidden.loop(diagonal(motion))],
        step,
        E=[hidden.entering(diagonal(b))],
        C=[hidden.leaving(diagonal(c))],
    )
    lost = [2 * x if step is None else 2 * x - x**2 for x in a]
    variance = sum((y * z) ** 2 / x for x, y, z in zip(lost, b, c, strict=True))
    norm = beside(rng, short(Fraction(str(float(variance) ** 0.5))))
    more = 1 + Fraction(1, 10**30)
    best = hidden.function([short(z**2 / x * more) for x, z in zip(lost, c, strict=True)])
    return [
        Known(model, None, claim_of("h2-norm", norm=norm, P=P, **W), norm**2 >= variance, fits)
        for P, fits in functions(rng, best, scaled_fits=False)
    ]


def peak(rng: Random) -> list[Known]:
    """One mode that w moves and y shows, and others: |y| <= |bc| / a, or / (1 - |f|)."""
    n, step = int(rng.integers(1, 4)), STEP if rng.random() < 0.5 else None
    a = [some(rng, 1, 50)]
    a += [min(a[0] + some(rng, 0, 50), Fraction(1)) for _ in range(n - 1)]
    b, c, bound = some(rng), some(rng), some(rng)
    hidden = Disguise.draw(rng, n)
    motion = [-value for value in a] if step is None else [1 - value for value in a]
    column = [[b], *([Fraction(0)] for _ in range(n - 1))]
    row = [[c, *(Fraction(0) for _ in range(n - 1))]]
    model = model_of(
        [hidden.loop(diagonal(motion))],
        step,
        E=[hidden.entering(column)],
        C=[hidden.leaving(row)],
    )
    gain = beside(rng, b * c / a[0])
    best = hidden.function([Fraction(1)] * n)
    level = short((b * bound / a[0]) ** 2, 50)
    found = {"level": level, "multiplier": a[0], "disturbance_norm": bound, "gain": gain}
    return [
        Known(model, None, claim_of("peak", P=P, **found, **W), gain * a[0] >= b * c, fits)
        for P, fits in functions(rng, best, scaled_fits=False)
    ]


def observer(rng: Random) -> list[Known]:
    """Modes a_i, all measured: L = X diag(l_i) leaves a_i - l_i, so the slowest decides."""
    n = int(rng.integers(1, 4))
    a, wanted = [some(rng, -200, 200) for _ in range(n)], [some(rng) for _ in range(n)]
    hidden = Disguise.draw(rng, n)
    one = diagonal([Fraction(1)] * n)
    model = model_of([hidden.loop(diagonal(a))], C=[hidden.leaving(one)])
    L = hidden.entering(diagonal([x + y for x, y in zip(a, wanted, strict=True)]))
    rate = max(beside(rng, min(wanted)), Fraction(0))
    best = hidden.function([Fraction(1)] * n)
    truth = min(wanted) >= rate
    return [
        Known(model, None, claim_of("observer", L=[L], decay_rate=rate, P=P), truth, fits)
        for P, fits in functions(rng, best)
    ]


def transient(rng: Random) -> list[Known]:
    """Modes in their own states: settled to a share e after -ln(e) / alpha, to 30 digits."""
    n = int(rng.integers(1, 4))
    a = [some(rng, 10, 400) for _ in range(n)]
    scales = [Fraction(10) ** int(k) for k in rng.integers(-4, 5, size=n)]
    model = model_of([diagonal([-value for value in a])])
    share, rate = some(rng, 1, 99), beside(rng, min(a) * (1 - Fraction(1, 10**6)))
    kappa, time = beside(rng, Fraction(1)), beside(rng, short(logarithm(share, 30) / rate))
    truth = kappa >= 1 and rate <= min(a) and is_at_most_exp_of(share, min(a) * time)
    best = diagonal([1 / s**2 for s in scales])
    found: dict[str, Any] = {"scales": scales, "lower": Fraction(1), "overshoot": kappa}
    found |= {"settled_share": share, "settling_time": time, "decay_rate": rate}
    return [
        Known(model, None, claim_of("transient", P=P, **found), truth, fits)
        for P, fits in functions(rng, best, scaled_fits=False)
    ]


def is_at_most_exp_of(share: Fraction, x: Fraction) -> bool:
    """Return whether e^-x <= share."""
    return not is_at_most_exp(share, x)


def gain_rounding(rng: Random) -> list[Known]:
    """x' = a x + b u: all gains within d of k hold the rate when b k - a - |b| d >= alpha."""
    step = STEP if rng.random() < 0.5 else None
    b, off = some(rng), Fraction(int(rng.integers(1, 30)), 1000)
    if step is None:
        wanted, a = some(rng), some(rng, -300, 300)
        k = short((a + wanted + b * off) / b, 20)
        worst = a - b * k + b * off
        rate = max(beside(rng, -worst), Fraction(0))
        truth = worst <= -rate and worst < 0
    else:
        b, wanted = b / 10, some(rng, 1, 90)
        a = some(rng, 100, 200)
        k = short((a - wanted) / b, 20)
        worst = max(abs(a - b * k + b * off), abs(a - b * k - b * off))
        rate = Fraction(0) if worst >= 1 else beside(rng, short(logarithm(worst, 30) / step))
        truth = worst < 1 and is_at_most_exp(worst, rate * step)
    relative = off / abs(k) if rng.random() < 0.3 and k else Fraction(0)
    if relative and relative != short(relative, 20):
        relative = Fraction(0)
    absolute = Fraction(0) if relative else off
    model = model_of([[[a]]], step, B=[[[b]]])
    found: dict[str, Any] = {"decay_rate": rate, "relative": relative, "absolute": [[absolute]]}
    found["tau"] = [short(off / b) if step is None else short(off / (b * (wanted + b * off)))]
    return [
        Known(model, law_of([[[k]]], step), claim_of("gain-rounding", P=P, **found), truth, fits)
        for P, fits in functions(rng, [[Fraction(1)]], scaled_fits=False)
    ]


def blended_gains(rng: Random) -> list[Known]:
    """Scalar rules with their own gains: the largest of a quadratic in h on [0, 1]."""
    a = [some(rng, -400, 200) for _ in range(2)]
    b, k = ([some(rng, 1, 200) for _ in range(2)] for _ in range(2))
    g = [[a[i] - b[i] * k[j] for j in range(2)] for i in range(2)]
    mean = (g[0][1] + g[1][0]) / 2
    ends = [g[0][0], g[1][1]]
    bend = ends[0] - 2 * mean + ends[1]
    worst = max(ends)
    if bend < 0:
        h = (ends[1] - mean) / bend
        if 0 < h < 1:
            worst = max(worst, h**2 * ends[0] + 2 * h * (1 - h) * mean + (1 - h) ** 2 * ends[1])
    model = model_of([[[x]] for x in a], B=[[[x]] for x in b])
    rate = max(beside(rng, short(-worst)), Fraction(0))
    law, truth = law_of([[[x]] for x in k]), -worst >= rate and worst < 0
    return [
        Known(model, law, claim_of("decay", decay_rate=rate, P=P), truth, fits)
        for P, fits in functions(rng, [[Fraction(1)]])
    ]


CLAIMS: dict[str, Callable[[Random], list[Known]]] = {
    "decay of modes": decay,
    "decay of sampled modes": sampled_decay,
    "rules with their own gains": blended_gains,
    "region of poles": region,
    "gain of energy": l2_gain,
    "norm under white noise": h2_norm,
    "gain of peaks": peak,
    "observer": observer,
    "overshoot and settling": transient,
    "gains that are off": gain_rounding,
}
