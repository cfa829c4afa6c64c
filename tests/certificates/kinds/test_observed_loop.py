"""Loops through an observer: limits by hand, both kinds of weights, and what is claimed."""

from __future__ import annotations

from copy import deepcopy
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import solve_continuous_lyapunov

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kinds.observer import hidden_premises
from takagi.certificates.checker.loop.observer_law import states_at_start
from takagi.certificates.document.certificate_file import certificate_document
from takagi.certificates.document.plant_embedding import slope_claim
from takagi.certificates.requests import ObservedLoop
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import Interval, ModelError, Output, Plant, TSModel, Variable, sector_model
from tests.certificates.kinds.claims import law_data, model_data, verdict_of
from tests.certificates.kinds.observed_documents import (
    SEEN,
    Data,
    _by_estimate,
    cubic,
    hidden,
    line,
    of_cubic,
    outcome,
    u,
    x,
)


@pytest.mark.parametrize(
    ("changed", "proved"),
    [
        ({}, True),
        ({"P": [[1, 0], [0, 0.375]]}, False),
        ({"level": 1.0001}, False),
        ({"decay_rate": 0.01}, False),
        ({"P": [[1, 0], [0, -1]]}, False),
        ({"P": [[1, 0.1], [0, 1]]}, False),
        # u = -3 (x - e): 9 (1 + 8/3) = 33, so that 5.75^2 > 33 is kept and 5.74^2 is not.
        ({"input_limits": [5.75]}, True),
        ({"input_limits": [5.74]}, False),
        ({"input_limits": [-6]}, False),
        # With a term of x and e: 9 c (1 + 1 + 0.4) / 0.96 = 21.6 for c = 0.96, 4.647...^2.
        ({"P": [[1, 0.2], [0.2, 1]], "level": 0.96, "input_limits": [4.65]}, True),
        ({"P": [[1, 0.2], [0.2, 1]], "level": 0.96, "input_limits": [4.64]}, False),
    ],
)
def test_limits_of_a_linear_plant_from_both_sides(changed: Data, proved: bool) -> None:
    verdict, text = outcome(*line(**changed))

    assert (verdict == "PROVED") is proved, text


def test_the_rate_from_both_sides() -> None:
    """P = diag(1, s), s large: the rate tends to the slowest pole, 2 1/s."""
    far = {"P": [[1, 0], [0, 1000000]]}
    assert outcome(*line(**far, decay_rate=1.999))[0] == "PROVED"
    assert outcome(*line(**far, decay_rate=2))[0] == "UNDECIDED"


def test_the_sentence_says_where_it_may_start() -> None:
    """xhat starts at the measured x: e = 0, so that V = x^2 and |x| <= 1 may start."""
    text = outcome(*line())[1]
    assert "a state alone may start up to 1 in x1" in text
    assert "exact outputs" in text


def test_discrete_time() -> None:
    """x+ = 2 x + u, K = 1.5, L = 1.5: z' = [[0.5, 1.5], [0, 0.5]] z, P = diag(1, s), s > 4.

    P - G'PG = [[0.75, -0.75], [-0.75, 0.75 s - 2.25]]: positive for s > 4.
    """
    model = model_data(
        [[[2]]], B=[[[1]]], C=[[[1]]], output_names=["y"], box={"x1 [-]": [-1, 1]}, sample_time=1
    )
    gains = law_data([[[1.5]]], sample_time=1, observer=SEEN | {"L": [[[1.5]]]})
    claim = {"name": "d", "kind": "observed-loop", "level": 1, "decay_rate": 0}
    assert outcome(model, gains, claim | {"P": [[1, 0], [0, 4.0001]]})[0] == "PROVED"
    assert outcome(model, gains, claim | {"P": [[1, 0], [0, 4]]})[0] == "UNDECIDED"


@pytest.mark.parametrize(
    ("changed", "proved"),
    [
        ({}, True),
        ({"P": [[1, 0], [0, 0.66]], "level": 0.3}, False),
        ({"level": 0.4118}, False),
        ({"input_limits": [1.93]}, True),
        ({"input_limits": [1.92]}, False),
    ],
)
def test_limits_with_weights_at_the_estimate(changed: Data, proved: bool) -> None:
    verdict, text = outcome(*of_cubic(**changed))

    assert (verdict == "PROVED") is proved, text
    assert not proved or "weights at the estimate" in text


def test_the_motion_of_the_plant_stays_in_the_proved_set() -> None:
    """x and xhat of the nonlinear plant, integrated by themselves from the set's boundary."""
    from scipy.integrate import solve_ivp

    s, c = 0.7, 0.4117

    def rate(_: float, both: Any) -> list[float]:
        plant, estimate = both
        command = -3 * estimate
        gap = 4 * (plant - estimate)
        return [plant - plant**3 + command, estimate - estimate**3 + command + gap]

    for angle in np.linspace(0, 2 * np.pi, 16, endpoint=False):
        z = np.sqrt(c) * np.array([np.cos(angle), np.sin(angle) / np.sqrt(s)])
        found = solve_ivp(rate, (0, 10), [z[0] + z[1], z[0]], rtol=1e-9, atol=1e-12)
        value = found.y[1] ** 2 + s * (found.y[0] - found.y[1]) ** 2
        assert np.all(np.diff(value) <= 1e-9)
        assert np.abs(found.y).max() <= 1 and value[-1] < 1e-8


def test_weights_of_a_model_without_a_plant_are_assumed() -> None:
    """Two rules, nothing about what they depend on: the sentence says that they are known."""
    model, gains, claim = line()
    two = {**model, "A": [[[1]], [[0.5]]]}
    text = outcome(two, gains, claim)[1]
    assert "which it is assumed to know" in text


def test_an_observer_at_its_estimate_does_not_know_a_signal_from_outside() -> None:
    """x' = x - x^3 + w x/10 + u: the weights of w are not those at the estimate."""
    w = sp.Symbol("w", real=True)
    verdicts = []
    for drift in (sp.Integer(0), w * x / 10):
        moving = Variable(w, "-", Interval.of(-1, 1), schedules=True)
        plant = Plant(
            equations=(x - x**3 + drift + u,),
            states=(Variable(x, "-", Interval.of(-1, 1)),),
            inputs=(Variable(u, "-", Interval.of(-4, 4)),),
            disturbances=(moving,) if drift else (),
            outputs=(Output("y", x, "-"),),
            measured=("y",),
            name="moved",
        )
        model, gains = _by_estimate(plant, [[3.0]], [[4.0]])
        parts = of_cubic(P=[[1, 0], [0, 2]], level=0.1)
        verdicts.append(outcome(model, gains, *parts[2:]))
    assert [found[0] for found in verdicts] == ["PROVED", "UNDECIDED"]
    assert "premises depend on w [-], which the observer does not know" in verdicts[1][1]


@pytest.mark.parametrize(
    ("C", "hidden"),
    [
        ([[[2, 0]], [[2, 0]]], ""),
        ([[[1, 0]], [[1, 1]]], "x1"),
        ([[[1, 1]], [[1, 0]]], "x1"),
        ([[[1, 0]], [[2, 0]]], "x1"),
        ([[[1, 1], [1, 0]], [[1, 0], [1, 0]]], ""),
        ([[[0, 0]], [[0, 0]]], "x1"),
        ([], "x1"),
    ],
)
def test_a_premise_is_measured_by_one_output_in_all_rules(C: Any, hidden: str) -> None:
    stack = [Matrix.of([[Fraction(e) for e in row] for row in M]) for M in C]
    family: Any = SimpleNamespace(
        C=stack, D=(), states=("x1", "x2"), inputs=(), scheduled_by=("x1",)
    )
    assert hidden_premises(family) == hidden


def test_one_state_with_a_range_is_enough_for_a_box() -> None:
    """The loop of ``line`` beside x2' = -x2, which has no range."""
    box = {"x1 [-]": [-1, 1]}
    model = model_data(
        [[[1, 0], [0, -1]]], B=[[[1], [0]]], C=[[[1, 0]]], output_names=["y"],
        input_names=["u [-]"], box=box,
    )  # fmt: skip
    observer = SEEN | {"L": [[[4], [0]]]}
    gains = law_data([[[3, 0]]], input_names=["u [-]"], observer=observer)
    claim = line()[2] | {"P": np.diag([1, 1, 0.375000001, 1]).tolist()}
    found = outcome(model, gains, claim)
    assert found[0] == "PROVED"
    assert "in which x stays in the model's box" in found[1]


def test_the_sentence_keeps_ranges_of_disturbances_apart() -> None:
    """Without disturbance: no range of one is granted."""
    model, gains, claim = line()
    box = {"x1 [-]": [-1, 1], "w [-]": [-0.5, 0.5]}
    pushed = model | {"E": [[[1]]], "disturbance_names": ["w [-]"], "box": box}
    text = outcome(pushed, gains, claim)[1]
    assert "without disturbance" in text and "w" not in text.split("box")[1].split(";")[0]


@pytest.mark.parametrize(
    ("side", "verdict"),
    [([0, 0.5], "PROVED"), ([-0.5, 0], "PROVED"), ([1e-9, 0.5], "UNDECIDED")],
)
def test_no_disturbance_is_in_its_range(side: list[float], verdict: str) -> None:
    """The claim is about the loop without disturbance: 0 must be where the model holds."""
    model, gains, claim = line()
    pushed = model | {"E": [[[1]]], "disturbance_names": ["w [-]"]}
    pushed["box"] = {"x1 [-]": [-1, 1], "w [-]": side}
    found = outcome(pushed, gains, claim)
    assert found[0] == verdict
    assert ("w [-] is bounded less tightly" in found[1]) == (verdict == "UNDECIDED")


@pytest.mark.parametrize(("entry", "verdict"), [(0, "PROVED"), (1e-9, "UNDECIDED")])
def test_a_signal_that_moves_no_state_need_not_be_at_zero(entry: float, verdict: str) -> None:
    """It only sets the weights, and the sentence says that it stays in its range."""
    model, gains, claim = line()
    pushed = model | {"E": [[[entry]]], "disturbance_names": ["w [-]"]}
    pushed["box"] = {"x1 [-]": [-1, 1], "w [-]": [1, 2]}
    found = outcome(pushed, gains, claim)
    assert found[0] == verdict
    assert ("while w [-] stays in the model's box" in found[1]) == (verdict == "PROVED")


@pytest.mark.parametrize(
    ("C", "D", "seen"),
    [
        ([[[1, 0]]], [], [True, False]),
        ([[[0, 1], [1, 0]]], [], [True, True]),
        ([[[2, 0]]], [], [False, False]),
        ([[[1, 1]]], [], [False, False]),
        ([[[0, 0]]], [], [False, False]),
        ([[[1, 0]], [[1.01, 0]]], [], [False, False]),
        ([[[1, 0]]], [[[0]], [[1]]], [False, False]),
        ([[[1, 0]]], [[[0, 1]]], [False, False]),
        ([[[1, 0], [0, 1]]], [[[0], [1]]], [True, False]),
        ([], [], [False, False]),
    ],
)
def test_an_estimate_starts_at_states_that_are_outputs(C: Any, D: Any, seen: list[bool]) -> None:
    """A factor of 1 in all rules, one state, and no input that is added."""
    matrices = [[Matrix.of([[Fraction(str(e)) for e in r] for r in M]) for M in S] for S in (C, D)]
    assert states_at_start(matrices[0], matrices[1], 2) == seen


def test_the_sentence_says_what_is_assumed_and_kept() -> None:
    model, gains, claim = line()
    assert "which its measured outputs tell" in outcome(model, gains, claim)[1]
    text = outcome({k: v for k, v in model.items() if k != "box"}, gains, claim)[1]
    assert "in the model's box" not in text
    assert "in which x stays in the model's box" in outcome(model, gains, claim)[1]
    only = model | {"box": {"u [-]": [-9, 9]}}
    assert "in the model's box" in outcome(only, gains, claim)[1]
    assert "in which x and xhat stay in the model's box" in outcome(*of_cubic())[1]
    # An output that is not a state: the estimate starts at rest, e = x, V = x'(1 + s) x.
    twice = model | {"C": [[[2]]], "A": [[[1]]]}
    text = outcome(twice, gains, claim | {"P": [[1, 0], [0, 1]], "level": 0.5})[1]
    assert "where the estimate starts at rest, a state alone may start up to 0.5 in x1" in text


def test_an_observer_is_needed() -> None:
    model, gains, claim = line()
    del gains["observer"]
    document = certificate_document(model=model, gains=gains, claims=[claim], provenance={})
    with pytest.raises(CertificateError, match="observer"):
        check_document(document)


def test_the_request_finds_the_set() -> None:
    """The loop of ``line``: no start beyond 1 stays, and nearly all up to 1 do (e starts at 0)."""
    model, gains, _ = line()
    plant = TSModel(
        [[[1.0]]], [[[1.0]]], C=[[[1.0]]], states=["x1 [-]"], inputs=["u [-]"], outputs=["y"],
        box={"x1 [-]": (-1, 1)},
    )  # fmt: skip
    loop = ClaimedLoop.of(plant, [[[3.0]]], model_data=model, law=gains)

    found = ObservedLoop().attempt(loop)

    assert found.proved
    P, level = np.array(found.claim["P"]), found.claim["level"]
    assert 0.99 < np.sqrt(level / P[0, 0]) <= 1
    assert not ObservedLoop(2.01).attempt(loop).proved
    with pytest.raises(ModelError, match="positive numbers"):
        ObservedLoop(input_limits=[-1.0]).attempt(loop)


def test_a_model_without_an_observer_is_refused_by_the_request() -> None:
    model = sector_model(
        Plant(
            equations=(x - x**3 + u,),
            states=(Variable(x, "-", Interval.of(-1, 1)),),
            inputs=(Variable(u, "-"),),
        )
    )
    with pytest.raises(ModelError, match="needs gains.observer"):
        ObservedLoop().attempt(ClaimedLoop.of(model, np.full((2, 1, 1), 3.0)))


@pytest.mark.parametrize("end", ["lower", "upper"])
def test_slopes_that_are_not_the_plants_prove_nothing(end: str) -> None:
    model, *others = of_cubic()
    forged = deepcopy(model)
    (premise,) = forged["slopes"]["premises"]
    width = float(premise["upper"]) - float(premise["lower"])
    premise[end] = float(premise[end]) + (0.1 if end == "lower" else -0.1) * width

    verdict, text = outcome(forged, *others)

    assert verdict == "UNDECIDED"
    assert "not proved to be the plant's" in text


def test_slopes_have_to_be_claimed() -> None:
    model, gains, first, _, claim = of_cubic()
    document = certificate_document(model=model, gains=gains, claims=[first, claim], provenance={})
    with pytest.raises(CertificateError, match="no claim about the slopes"):
        check_document(document)


def test_a_premise_that_is_not_measured_cannot_give_the_plants_weights() -> None:
    model, gains = hidden()
    forged = deepcopy(gains)
    forged["observer"] |= {"weights": "measured"}
    first = {"name": "model", "kind": "sector-embedding"}
    claim = {"name": "h", "kind": "observed-loop", "decay_rate": 0, "level": 1e-6}

    verdict, text = outcome(model, forged, first, claim | {"P": np.eye(4).tolist()})

    assert verdict == "UNDECIDED"
    assert "not measured" in text


def test_a_claim_about_another_law_is_refused() -> None:
    """decay of u = -K x says nothing of u = -K xhat."""
    model, gains, _ = line()
    claim = {"name": "d", "kind": "decay", "P": [[1]], "decay_rate": 1}
    document = certificate_document(model=model, gains=gains, claims=[claim], provenance={})
    with pytest.raises(CertificateError, match="another law"):
        check_document(document)


@pytest.mark.parametrize(
    "observer",
    [
        {"weights": "guessed", "measured": ["y"], "L": [[[4]]]},
        {"weights": "measured", "measured": ["w"], "L": [[[4]]]},
        {"weights": "measured", "measured": [], "L": [[[4]]]},
        {"weights": "measured", "measured": ["y", "y"], "L": [[[4, 4]]]},
        {"weights": "measured", "measured": ["y"], "L": [[[4], [4]]]},
        {"weights": "measured", "measured": ["y"], "L": [[[4]], [[4]]]},
        {"weights": "estimated", "measured": ["y"], "L": [[[4]]]},
        {"weights": "estimated", "measured": ["y"], "L": [[[4]], [[4]]]},
        {"weights": "measured", "measured": [["y"]], "L": [[[4]]]},
        {"weights": "measured", "measured": "y", "L": [[[4]]]},
    ],
)
def test_an_observer_that_does_not_fit_is_refused(observer: Data) -> None:
    model, gains, claim = line()
    document = certificate_document(
        model=model, gains=gains | {"observer": observer}, claims=[claim], provenance={}
    )
    with pytest.raises(CertificateError):
        check_document(document)


@pytest.mark.parametrize("names", [None, "y", {"y": 1}, 1])
def test_the_names_of_outputs_are_a_list(names: Any) -> None:
    """``null`` in their place ended the check in a traceback."""
    model, gains, claim = line()
    document = certificate_document(
        model=model | {"output_names": names}, gains=gains, claims=[claim], provenance={}
    )
    with pytest.raises(CertificateError, match="'y' is not one output"):
        check_document(document)


def test_outputs_are_needed() -> None:
    """A name of an output without its C: nothing says what L acts on."""
    model, gains, claim = line()
    stable = {**model, "A": [[[-1]]]}
    del stable["C"]
    document = certificate_document(
        model=stable, gains=gains, claims=[claim | {"P": [[1, 0], [0, 9]]}], provenance={}
    )
    with pytest.raises(CertificateError, match="no output"):
        check_document(document)


def test_one_gain_of_an_observer_at_its_estimate() -> None:
    """The weights at the estimate are not those of the error, so that L cannot go by them."""
    model, gains, *claims = of_cubic()
    two = deepcopy(gains)
    two["observer"]["L"] *= 2
    assert verdict_of(model, gains, *claims) == "PROVED"
    assert verdict_of(model, two, *claims) == "REFUSED"


@pytest.mark.parametrize("slopes", [None, [], 5, "A"])
def test_slopes_are_an_object_of_the_model(slopes: Any) -> None:
    model, gains, *claims = of_cubic()
    changed = deepcopy(model) | {"slopes": slopes}
    assert verdict_of(changed, gains, *claims) == "REFUSED"
    measured = deepcopy(gains)
    measured["observer"]["weights"] = "measured"
    assert verdict_of(changed, measured, *claims[:2]) == "REFUSED"


def test_slopes_have_those_of_the_outputs() -> None:
    model, gains, *claims = of_cubic()
    changed = deepcopy(model)
    del changed["slopes"]["C"]
    assert verdict_of(changed, gains, *claims) == "REFUSED"


def test_slopes_are_a_plants() -> None:
    """Matrices with the slopes of some plant beside them are not that plant's."""
    model, gains, _, slopes, claim = of_cubic()
    plain = {**model_data([[[1]], [[0]]], B=[[[1]]], C=[[[1]]]), "output_names": ["y"]}
    plain |= {"state_names": gains["state_names"], "input_names": gains["input_names"]}
    law = {k: v for k, v in gains.items() if k not in ("premises", "rules", "trim")}
    for whole in (plain, {**model, **plain}):
        for claims in ([claim], [slopes, claim]):
            found = verdict_of({**whole, "slopes": model["slopes"]}, law, *claims)
            assert found == "REFUSED"


def test_gains_are_those_of_the_rules() -> None:
    """Without gains, or with weights of their own, the loop is another."""
    model, gains, *claims = of_cubic()
    own = deepcopy(gains)
    own["premises"][0]["expression"] = "2*x"
    own["K"][0] = [[3.1]]
    assert verdict_of(model, own, *claims) != "PROVED"
    assert verdict_of(model, None, *claims) != "PROVED"


def test_a_state_and_an_input_of_one_name() -> None:
    """Their range in the box would be one, and nobody knows of which."""
    model, gains, claim = line()
    assert verdict_of(model, gains, claim) == "PROVED"
    named = {"input_names": ["x1 [-]"]}
    assert verdict_of(model | named, gains | named, claim) == "REFUSED"


@pytest.mark.parametrize("box", [[-1, 1], [-1, 3], [-3, 1]])
def test_the_nearer_end_of_a_range_counts(box: list[int]) -> None:
    """The range of a state, and that of an input: u = -3 (x - e), within 5.75 of ``line``."""
    model, gains, claim = line()
    for level, verdict in ((1, "PROVED"), (1.001, "UNDECIDED")):
        changed = model | {"box": {"x1 [-]": box}}
        assert verdict_of(changed, gains, claim | {"level": level}) == verdict
    for end, verdict in ((5.75, "PROVED"), (5.74, "UNDECIDED")):
        wide = [end * side if abs(side) == 1 else 9 * side for side in box]
        changed = model | {"box": {"x1 [-]": [-1, 1], "u [-]": wide}}
        assert verdict_of(changed, gains, claim) == verdict


def test_the_estimate_keeps_the_ranges_too() -> None:
    """P = diag(1, 100): x = xhat + e reaches sqrt(1.01 c), xhat sqrt(c)."""
    wide = deepcopy(cubic()[0])
    wide["inputs"][0]["range"] = [-4, 4]
    for P, level, verdict in (
        ([[1, 0], [0, 100]], 0.99, "PROVED"),
        ([[1, 0], [0, 100]], 0.9902, "UNDECIDED"),
        # x = xhat + e reaches less than xhat where both are opposed.
        ([[1.2, 1], [1, 100]], 1.19, "PROVED"),
        ([[1.2, 1], [1, 100]], 1.1901, "UNDECIDED"),
    ):
        found = verdict_of(*of_cubic(wide, P=P, level=level))
        assert found == verdict, (P, level)


def test_a_disturbance_at_rest_lies_in_its_range() -> None:
    """Its range has 0 inside or is refused; at rest it leaves no range, however small."""
    model, gains, claim = line()
    pushed = model | {"E": [[[1]]], "disturbance_names": ["w [-]"]}
    for box, verdict in (([-0.5, 0.5], "PROVED"), ([-0.5, 0], "PROVED")):
        changed = pushed | {"box": {"x1 [-]": [-1, 1], "w [-]": box}}
        assert verdict_of(changed, gains, claim) == verdict
    for box in ([0.1, 0.5], [-0.5, -0.1]):
        changed = pushed | {"box": {"x1 [-]": [-1, 1], "w [-]": box}}
        assert verdict_of(changed, gains, claim) != "PROVED"


@pytest.mark.parametrize("changed", [{"level": 0}, {"level": -1}, {"decay_rate": -0.001}])
def test_numbers_without_a_meaning_are_refused(changed: Data) -> None:
    assert verdict_of(*line(**changed)) == "REFUSED"


def test_products_of_gains_and_slopes_have_their_order() -> None:
    """Two states, one output: L R is 2 by 2, R L a number."""
    model, gains = hidden()
    # V of both parts at v^2 = 1/2, each alone, the error's 300 times as large.
    one, other = np.array([[0, 1], [-1, -1.5]]), np.array([[-3, 1], [-3, -1.5]])
    shape = np.zeros((4, 4))
    for k, (A, size) in enumerate(((one, 1), (other, 300))):
        part = slice(2 * k, 2 * k + 2)
        shape[part, part] = solve_continuous_lyapunov(A.T, -size * np.eye(2))
    claim = {"name": "h", "kind": "observed-loop", "decay_rate": 0, "level": 0.01}
    claims = [
        {"name": "model", "kind": "sector-embedding"},
        slope_claim("hidden"),
        claim | {"P": np.round(shape, 6).tolist()},
    ]
    assert verdict_of(model, gains, *claims) == "PROVED"
    text = outcome(model, gains, *claims)[1]
    assert "where the estimate starts at the measured states and else at rest" in text
