"""What a proved claim says: each figure and each number by hand, rounded so that it says no more.

The plants have two states that differ, so that a smallest entry, a quotient or an order counts.
"""

from __future__ import annotations

from math import pi

import pytest

from takagi.certificates import Verdict
from takagi.certificates.checker.words.figure import Figure
from tests.certificates.kinds.claims import Data, law_data, model_data, said_of

UNIT, TALL = [[1, 0], [0, 1]], [[4, 0], [0, 1]]
PLANT: Data = {"A": [[[-1, 0], [0, -2]]]}
TWO: Data = {"A": PLANT["A"] * 2}
PUSHED: Data = {"E": [UNIT]}
NOISY: Data = {"E": [[[1], [0]]], "C": [[[1, 0.5]]], "disturbance_names": ["d [-]"]}
NAMES = ["f [-]", "g [-]"]
FED: Data = {"B": [UNIT], "K": [UNIT], "input_names": NAMES}
SAMPLED: Data = {"A": [[[0.5, 0], [0, 0.2]]], "sample_time": 1}
OF_THE_MODEL = {"disturbance": "disturbances"}
BOUNDED = OF_THE_MODEL | {"disturbance_bounds": [0.12345678, 0.2], "level": 1, "multiplier": 1}
WEIGHTS = {"degrees": [1], "polya": 0, "rates": [[0.2, 0.12345678]]}
WEIGHTS |= {"P": [{"powers": [row], "matrix": UNIT} for row in UNIT]}
ROUNDED: Data = {"tau": [1, 1], "decay_rate": 0.5, "relative": 0}
RATE, STEPS = "decay rate", "absolute rounding of gains, least"
LIMITED = {"level": 1, "multiplier": 2, "input_limits": [1.1234567, 2]}
LIMITS = {"-limit of input 1": 1.1234567, "-limit of input 2": 2}
BOUNDS = {"bound on disturbance 1": 0.12345678, "bound on disturbance 2": 0.2}
UNIT_SET = {f"safe start of x{k}, others at rest": 1.0 for k in (1, 2)}
UNIT_SET |= {"volume of the set": pi}
SIZES = {"decay_rate": 0.91234567, "scales": [1, 1], "lower": 1, "overshoot": 2.12345678}

# Kind, model and gains, evidence, figures (with a minus where the smaller is better), and words:
# those with a minus are not said.
CASES: list[tuple[str, Data, Data, dict[str, float], tuple[str, ...]]] = [
    ("decay", {}, {"decay_rate": 0.61234567}, {RATE: 0.61234567}, ("as exp(-1.22469 t) along",)),
    (
        "invariant-ellipsoid",
        {},
        {"P": TALL, "level": 2.25, "multiplier": 1.12345678},
        {
            "volume of the set": 1.125 * pi,
            "safe start of x1, others at rest": 0.75,
            "safe start of x2, others at rest": 1.5,
        },
        ("{x'Px <= 2.25} is invariant, along", "falls as exp(-1.12345 t)", "-box", "-disturb"),
    ),
    (
        "invariant-ellipsoid",
        PUSHED | {"box": {"x2 [-]": [-1, 1]}},
        BOUNDED,
        UNIT_SET | BOUNDS,
        (
            "and lies in the model's box, along",
            "for the model's disturbance with |w_k| <= 0.123456, 0.2; from outside, but within",
        ),
    ),
    (
        "input-limits",
        FED,
        LIMITED,
        UNIT_SET | LIMITS,
        ("|u_k| <= 1.12346, 2 for u = -Kx, from anywhere in {x'Px <= 1}, along", "-box"),
    ),
    (
        "gain-rounding",
        FED,
        ROUNDED | {"absolute": [[0.03, 0.01], [0.02, 0.04]], "relative": 0.00123456789},
        {RATE: 0.5, "relative rounding of gains": 0.00123456789, STEPS: 0.01},
        ("exp(-1 t)", "by up to 0.123456 % of themselves and the stated absolute steps"),
    ),
    (
        "gain-rounding",
        FED,
        ROUNDED | {"absolute": [[0.03, 0], [0, 0]]},
        {RATE: 0.5, "relative rounding of gains": 0, STEPS: 0},
        ("by up to the stated absolute steps",),
    ),
    (
        "gain-rounding",
        FED,
        ROUNDED | {"absolute": [[0, 0], [0, 0]]},
        {RATE: 0.5, "relative rounding of gains": 0, STEPS: 0},
        ("by up to nothing",),
    ),
    (
        "h2-norm",
        NOISY,
        OF_THE_MODEL | {"norm": 1.1234567},
        {"-norm": 1.1234567},
        ("at most 1.12346^2 for white noise of unit intensity, along", "(w the model's dist"),
    ),
    (
        "h2-norm",
        FED | NOISY,
        {"disturbance": "inputs", "norm": 1.9},
        {"-norm": 1.9},
        ("(w added to u, without the model's disturbance, y the output of the model)",),
    ),
    (
        "l2-gain",
        NOISY,
        OF_THE_MODEL | {"gain": 2.1234567, "energy_bound": 0.51234567},
        {"-gain": 2.1234567, "energy bound": 0.51234567},
        ("at most 2.12346^2 times that of w", "w of energy at most 0.512345^2 no state leaves"),
    ),
    (
        "peak",
        NOISY,
        OF_THE_MODEL
        | {"disturbance_norm": 0.51234567, "gain": 2.1234567, "level": 0.5, "multiplier": 1},
        {"-gain": 2.1234567, "bound on disturbance": 0.51234567},
        ("|y| <= 1.08795 at", "for |w|_2 <= 0.512345 at all times (gain 2.12346)", "-box"),
    ),
    (
        "transient",
        {},
        SIZES | {"settled_share": 0.02123456, "settling_time": 5.1234567},
        {RATE: 0.91234567, "-overshoot": 2.12345678, "-settling time": 5.1234567},
        (
            "|x(t)| <= 2.12346 exp(-0.912345 t) |x(0)|, so",
            "at most 0.0212346 |x(0)| after 5.12346 s",
        ),
    ),
    (
        "fuzzy-decay",
        TWO,
        WEIGHTS | {"decay_rate": 0.61234567},
        {RATE: 0.61234567, "rates of weights 1": 0.12345678},
        ("exp(-1.22469 t)", "while the weights keep to their rates: 0.2, 0.123456 1/s"),
    ),
    (
        "fuzzy-l2-gain",
        TWO | NOISY,
        WEIGHTS | OF_THE_MODEL | {"gain": 2.1234567},
        {"-gain": 2.1234567, "rates of weights 1": 0.12345678},
        ("at most 2.12346^2 times", "while the weights keep to their rates: 0.2, 0.123456 1/s"),
    ),
    (
        "fuzzy-decay",
        SAMPLED | {"A": SAMPLED["A"] * 2},
        {key: WEIGHTS[key] for key in ("degrees", "polya", "P")} | {"decay_rate": 0.61234567},
        {RATE: 0.61234567},
        ("exp(-1.22469 t)", "however the weights move"),
    ),
    (
        "invariant-ellipsoid",
        SAMPLED | NOISY,
        {"level": 1, "multiplier": 0.51234567},
        UNIT_SET,
        ("from inside V = x'Px falls as (1 - 0.512345)^k without disturbance",),
    ),
    (
        "invariant-ellipsoid",
        FED | NOISY,
        BOUNDED | {"disturbance": "inputs"},
        UNIT_SET | BOUNDS,
        ("for w added to u, without the model's disturbance, with |w_k| <=", "; from outside V - "),
    ),
    (
        "h2-norm",
        SAMPLED | NOISY,
        OF_THE_MODEL | {"P": [[3, 0], [0, 3]], "norm": 1.9},
        {"-norm": 1.9},
        ("white noise of unit covariance in each sample, along",),
    ),
    (
        "exit-probability",
        NOISY,
        OF_THE_MODEL
        | {"noise": [0.11234567], "rate": 0.5, "exponent": 20, "start": 0.11234567}
        | {"horizon": 9.1234567, "probability": 0.11234567},
        {"horizon": 9.1234567, "-probability of leaving the set": 0.11234567},
        (
            "within 9.12345 s is at most 0.112346, from x'Px <= 0.112345 at the start",
            "; the model's disturbance is white noise, independent, of intensity 0.112345^2 for d",
            "-w added to u",
            "-without the model's disturbance",
        ),
    ),
    (
        "exit-probability",
        FED | NOISY,
        {"disturbance": "inputs", "noise": [0.1, 0], "disturbance_bounds": [0, 0.11234567]}
        | {"multipliers": [0.02], "rate": 1, "exponent": 20, "start": 0}
        | {"horizon": 1, "probability": 0.9},
        {"horizon": 1, "-probability of leaving the set": 0.9},
        (
            "from x = 0 at the start",
            "; w added to u is white noise, independent, of intensity 0.1^2 for f [-], g [-] moves "
            "by at most 0.112345 besides, without the model's disturbance",
        ),
    ),
    (
        "observer",
        {"C": [[[1, 0]]]},
        {"L": [[[1], [0]]], "decay_rate": 0.61234567, "secants": [[[0, 0], [0, 0]]]},
        {RATE: 0.61234567},
        ("for exact outputs and secants of f in the stated hull, decays as exp(-1.22469 t)",),
    ),
    (
        "observer",
        TWO | {"C": [[[1, 0]]]},
        {"L": [[[1], [0]]], "decay_rate": 0.5, "secants": [[[0, 0], [0, 0]]]},
        {RATE: 0.5},
        ("in the stated hull and premises that the observer measures, decays",),
    ),
]


@pytest.mark.parametrize(("kind", "loop", "evidence", "figures", "words"), CASES)
def test_figures_and_words_by_hand(
    kind: str, loop: Data, evidence: Data, figures: dict[str, float], words: tuple[str, ...]
) -> None:
    parts = PLANT | loop
    named = {"input_names": NAMES, "sample_time": parts.get("sample_time")}
    gains = law_data(parts.pop("K"), **named) if "K" in parts else None
    claim = {"name": "x", "kind": kind, "P": UNIT} | evidence

    found = said_of(model_data(parts.pop("A"), **parts), gains, claim)

    assert found.verdict is Verdict.PROVED, found.text
    shown = {
        "-" * (not one.larger) + one.name: float(one.value or 0)
        for one in found.figures
        if isinstance(one, Figure)
    }
    assert shown == pytest.approx(figures, rel=1e-12)
    for word in words:
        assert (word.removeprefix("-") in found.text) is not word.startswith("-"), found.text
