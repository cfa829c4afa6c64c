"""Regions of attraction of polynomials: exact thresholds, van der Pol's oscillator, forgeries."""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from takagi.certificates import CertificateError, certify
from takagi.certificates.checker import check_document
from takagi.certificates.checker.words.figure import Figure
from takagi.certificates.coq.coq_export import coq_file
from takagi.certificates.cross_check.comparison import cross_checked
from takagi.certificates.document.certificate_file import certificate_document, dumps
from takagi.certificates.requests import AttractionRegion
from takagi.lmi import StatePolynomial
from takagi.lmi.sums_of_squares.attraction_set import multipliers
from takagi.models import Interval, ModelError, Plant, TSModel, Variable, sector_model
from tests.certificates.kinds.claims import resealed, verdicts
from tests.certificates.weights.cells import cubic, plant_document

Data = dict[str, Any]
x, y, u, w = sp.symbols("x y u w", real=True)
FILE = Path(__file__).with_name("van_der_pol_region.json")
AMPLITUDE = 2.0086  # of the limit cycle of van der Pol's oscillator, Andersen and Geer (1982)


def one(degree: int, squares: float, multiplier: float, least: int = 0) -> Data:
    """An identity with y of one monomial; S is found from the identity."""
    size = degree + 1 - least
    rows = [[squares if i == j else 0 for j in range(size)] for i in range(size)]
    return {
        "degree": degree,
        "squares": rows,
        "multiplier_degree": least,
        "multiplier": [[multiplier]],
    }


def line(level: float, multiplier: float, **members: Any) -> Data:
    """A claim about V = x^2 of a plant with one state and no inputs."""
    claim = {"kind": "attraction-region", "function": "x^2", "level": level, "box": [[-2, 2]]}
    claim |= {"decrease": [one(2, 1, multiplier, 1)], "states": [one(0, 1, 1)], "inputs": []}
    return claim | members


def unstable_beyond_one(rest: float = 0) -> TSModel:
    """x' = -d + d^3 with d = x - rest."""
    d = x - sp.Rational(str(rest))
    state = Variable(x, "-", Interval.of(rest - 2, rest + 2), rest=Fraction(str(rest)))
    return sector_model(Plant(equations=(sp.expand(-d + d**3),), states=(state,), name="line"))


@pytest.mark.parametrize("rest", [0, 1.5])
def test_the_threshold_is_that_of_the_equation(rest: float) -> None:
    """x' = -x + x^3: |x| < 1 is the region, so V = x^2 has the levels below 1, about any rest."""
    model = unstable_beyond_one(rest)
    name = "x" if rest == 0 else str(model.states[0]).split()[0]

    def at(level: float, multiplier: float) -> str:
        claim = line(level, multiplier, function=f"{name}^2")
        return verdicts(plant_document(model, claim))[-1]

    assert at(0.999, 2.0005) == "PROVED"
    assert all(at(1.001, m) == "UNDECIDED" for m in (0, 1.5, 1.9, 1.998, 1.999, 2, 2.001, 3))


def test_an_input_keeps_its_range_to_the_threshold() -> None:
    """x' = x^3 + u, u = -2 x, |u| <= 1: exactly |x| <= 1/2 keeps it, V = x^2 has levels to 1/4."""
    plant = Plant(
        equations=(x**3 + u,),
        states=(Variable(x, "-", Interval.of(-2, 2)),),
        inputs=(Variable(u, "-", Interval.of(-1, 1)),),
    )
    model = sector_model(plant)
    rules = len(model.rules)

    def at(level: float, multiplier: float) -> str:
        claim = line(level, 0, inputs=[one(0, 1, multiplier)])
        claim["decrease"] = [one(2, 1, 2.5, 1)]
        return verdicts(plant_document(model, claim, [[[2.0]]] * rules))[-1]

    # 1 - 4 x^2 = S + m (c - x^2) needs m = 4 and S = 1 - 4 c > 0.
    assert at(0.249, 4) == "PROVED"
    assert at(0.251, 4) == at(0.249, 3.99) == at(0.249, 4.01) == "UNDECIDED"
    missing = line(0.249, 2.5)
    assert verdicts(plant_document(model, missing, [[[2.0]]] * rules)) == ["REFUSED"]


def test_the_gains_of_the_file_decide() -> None:
    """x' = -x - x^3 + u with rules' gains; others make the loop unstable near rest, or far off."""
    claim = line(0.9, 1, box=[[-1, 1]])

    def with_gains(*gains: float) -> str:
        return verdicts(plant_document(cubic(), claim, [[[k]] for k in gains]))[-1]

    assert with_gains(1, 1.5) == "PROVED"
    assert with_gains(-1.1, 1.5) == with_gains(1.5, -3) == "UNDECIDED"


@pytest.mark.parametrize(
    ("equation", "words"),
    [
        (-sp.sin(x), "no polynomial in the states"),
        (-x / (1 + x**2), "no polynomial in the states"),
        (-x - x**2 * sp.Abs(x), "no polynomial in the states"),
        (-x + 0 * w + x * w, "uncertain|PROVED"),
    ],
)
def test_a_loop_that_is_no_polynomial_is_not_claimed(equation: sp.Expr, words: str) -> None:
    """Each would make the identities about another loop."""
    plant = Plant(
        equations=(equation,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        disturbances=(Variable(w, "-", Interval.of(-0.1, 0.1)),),
    )
    checked = check_document(
        plant_document(sector_model(plant), line(0.5, 1, box=[[-1, 1]]))
    ).claims[-1]

    assert checked.verdict.name == "UNDECIDED" or "with disturbances at rest" in checked.text
    assert sp.S(equation).has(w) or words in checked.text


# ---------------------------------------------------------------- van der Pol, in reverse time


def van_der_pol() -> TSModel:
    sides = (Variable(s, "-", Interval.of(-3, 3)) for s in (x, y))
    return sector_model(Plant(equations=(-y, x + (x**2 - 1) * y), states=tuple(sides)))


def document() -> Data:
    """The oscillator with the region that the search found; no solver is needed."""
    return dict(json.loads(FILE.read_text(encoding="utf-8")))


def function() -> StatePolynomial:
    return StatePolynomial.of(document()["claims"][1]["function"], ["x", "y"])


def border(V: StatePolynomial, level: float = 1.0, count: int = 360) -> Any:
    """Points of {V = level} on rays from rest."""
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rays = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    r = np.linspace(0, 4, 1601)[1:]
    first = (V(r[:, None, None] * rays) >= level).argmax(axis=0)
    return r[first, None] * rays


def area(points: Any) -> float:
    a, b = points.T
    return float(abs(np.dot(a, np.roll(b, -1)) - np.dot(b, np.roll(a, -1))) / 2)


def test_the_proved_set_is_most_of_the_region_and_lies_inside_the_limit_cycle() -> None:
    """The cycle has the published amplitude; its area is 13.72, that of Khalil's ellipse 6.4.

    Khalil (2002), example 8.9: V = 1.5 x^2 - x y + y^2 with c = 2.25.
    """
    assert verdicts(document()) == ["PROVED", "PROVED"]
    motion = solve_ivp(
        lambda t, s: [s[1], -s[0] + (1 - s[0] ** 2) * s[1]],
        (0, 25),
        [2, 0],
        rtol=1e-8,
        t_eval=np.linspace(18, 25, 5001),
    )
    cycle = np.asarray(motion.y)
    assert np.abs(cycle[0]).max() == pytest.approx(AMPLITUDE, abs=1e-3)

    points = border(function())
    khalil = border(StatePolynomial.of("1.5*x^2 - x*y + y^2", ["x", "y"]), 2.25)
    turn = np.argsort(np.arctan2(cycle[1], cycle[0]))
    whole = area(cycle[:, turn].T)

    assert area(khalil) == pytest.approx(np.pi * 2.25 / np.sqrt(1.25), rel=1e-2)
    assert whole == pytest.approx(13.72, rel=5e-3)
    assert 1.8 * area(khalil) < area(points) < whole
    at = np.interp(
        np.arctan2(points[:, 1], points[:, 0]), np.arctan2(cycle[1], cycle[0])[turn],
        np.hypot(*cycle)[turn], period=2 * np.pi,
    )  # fmt: skip
    assert np.all(np.hypot(*points.T) < at)


def test_starts_in_the_proved_set_converge_and_starts_outside_of_the_region_do_not() -> None:
    """Runge-Kutta from random points of the set, and from points 30 % outside of its border."""

    def last(starts: Any, time: float) -> Any:
        h, s = 0.01, starts.T
        for _ in range(int(time / h)):

            def f(z: Any) -> Any:
                return np.array([-z[1], z[0] + (z[0] ** 2 - 1) * z[1]])

            k1 = f(s)
            k2 = f(s + h / 2 * k1)
            k3 = f(s + h / 2 * k2)
            s = np.clip(s + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(s + h * k3)), -1e3, 1e3)
        return np.abs(s).max(axis=0)

    points = border(function(), count=200)
    shares = np.sqrt(np.random.default_rng(3).uniform(0, 1, len(points)))[:, None]

    assert np.all(last(np.concatenate([points * 0.995, points * shares]), 60) < 1e-2)
    assert np.all(last(1.5 * points, 20) > 3)


def test_khalils_function_has_multipliers_up_to_its_level() -> None:
    """Khalil (2002), example 8.9: V' = 0 first at 2.3047; 2.30 has squares, 2.31 none."""
    names = ["x", "y"]
    field = [StatePolynomial.of(text, names) for text in ("-y", "x + (x^2 - 1)*y")]

    def at(level: str) -> bool:
        V = StatePolynomial.of(f"(1.5*x^2 - x*y + y^2)/{level}", names)
        return multipliers(field, [], V) is not None

    assert at("2.30") and not at("2.31")


def test_the_second_decider_and_coq_read_the_same_obligations() -> None:
    """Six matrices: S and Lambda of the decrease and of each state."""
    compared = cross_checked(FILE)

    assert compared.agrees and [row.matrices for row in compared.rows][-1] == 6
    assert coq_file(FILE).matrices == {1: 0, 2: 6}


Change = Callable[[Data], None]


def of_claim(**members: Any) -> Change:
    return lambda data: data["claims"][1].update(members)


def added(words: str) -> Change:
    def change(data: Data) -> None:
        data["claims"][1]["function"] += f" {words}"

    return change


def scaled(factor: float) -> Change:
    def change(data: Data) -> None:
        data["claims"][1]["function"] = f"{factor}*({data['claims'][1]['function']})"

    return change


def in_identity(key: str, k: int, **members: Any) -> Change:
    return lambda data: data["claims"][1][key][k].update(members)


def negative(name: str, key: str, k: int) -> Change:
    def change(data: Data) -> None:
        entry = data["claims"][1][key][k]
        entry[name] = [[-v for v in row] for row in entry[name]]

    return change


def larger_entry(name: str, key: str, row: int, column: int, value: float) -> Change:
    def change(data: Data) -> None:
        data["claims"][1][key][0][name][row][column] += value

    return change


def equation(k: int, text: str) -> Change:
    def change(data: Data) -> None:
        data["model"]["equations"][k] = text

    return change


def forward_time(data: Data) -> None:
    data["model"]["equations"] = ["y", "-x + (1 - x^2)*y"]


def without_state(data: Data) -> None:
    del data["claims"][1]["states"][0]


def narrower_range(data: Data) -> None:
    data["model"]["states"][1]["range"] = [-2, 2]


FORGED: dict[str, Change] = {
    "V with the other sign": scaled(-1),
    "a set that is 1 % larger in level": of_claim(level=1.01),
    "the same by a smaller V": scaled(0.99),
    "a set beyond the limit cycle": of_claim(level=1.4),
    "no level": of_claim(level=0),
    "a negative level": of_claim(level=-1),
    "a level that is no number": of_claim(level="NaN"),
    "V with a constant": added("+ 0.1"),
    "V with a negative constant": added("- 9"),
    "V with a linear term": added("+ x/9"),
    "V with a cubic term": added("+ x^3"),
    "V of an unknown name": of_claim(function="x^2 + q^2"),
    "V with a name that is no number": of_claim(function="x^2 + nan*y^2"),
    "V that is no polynomial": of_claim(function="x^2 + y^2 + sin(x)^2"),
    "V with a quotient": of_claim(function="x^2 + y^4/(1 + y^2)"),
    "V of one state alone": of_claim(function="x^2"),
    "V that is zero": of_claim(function="x^2 - x*x"),
    "a box beyond the ranges": of_claim(box=[[-3.1, 3.1], [-3, 3]]),
    "a box that the set leaves": of_claim(box=[[-1.5, 1.5], [-3, 3]]),
    "a box without rest": of_claim(box=[[0, 3], [-3, 3]]),
    "a box the wrong way": of_claim(box=[[3, -3], [-3, 3]]),
    "a box of one state": of_claim(box=[[-3, 3]]),
    "a multiplier below 0": negative("multiplier", "decrease", 0),
    "no multiplier": in_identity("decrease", 0, multiplier_degree=1, multiplier=[[0, 0], [0, 0]]),
    "no sum of squares": negative("squares", "states", 1),
    "squares that are not symmetric": larger_entry("squares", "decrease", 0, 1, 5.0),
    "an indefinite multiplier": larger_entry("multiplier", "decrease", 0, 0, -50.0),
    "a degree that is too small": in_identity(
        "decrease", 0, degree=2, squares=[[float(i == j) for j in range(5)] for i in range(5)]
    ),
    "squares of another degree": in_identity("decrease", 0, degree=5),
    "a degree that is no number": in_identity("decrease", 0, degree=True),
    "a degree of a million": in_identity("decrease", 0, degree=10**6),
    "no identity of one state": without_state,
    "an identity of an input": lambda d: of_claim(inputs=d["claims"][1]["states"][:1])(d),
    "the oscillator in forward time": forward_time,
    "a stronger spring of the other sign": equation(1, "x + (x^2 - 1)*y + x^3"),
    "less damping": equation(1, "x + (x^2 - 0.9)*y"),
    "a plant with a sine": equation(1, "sin(x) + (x^2 - 1)*y"),
    "a rest that is none": equation(1, "x + (x^2 - 1)*y + 0.001"),
    "a range that the set leaves": narrower_range,
    "no claim of the plant": lambda d: d["claims"].pop(0) and None,
}  # fmt: skip


@pytest.mark.parametrize("name", FORGED)
def test_forged_regions_are_not_proved(name: str) -> None:
    """A change that makes the claim false, or its evidence none, with the hashes made anew."""
    data = deepcopy(document())
    FORGED[name](data)

    assert verdicts(resealed(data))[-1] != "PROVED"


def test_evidence_in_other_decimals_is_evidence_too() -> None:
    """S is moved on the identity: its last digits do not matter, nor a zero in its place."""
    data = deepcopy(document())
    for row in data["claims"][1]["decrease"][0]["squares"]:
        row[:] = [float(f"{v:.5g}") for v in row]

    assert verdicts(resealed(data)) == ["PROVED", "PROVED"]


def test_a_law_with_an_observer_has_no_such_region() -> None:
    """The claim is about u = -K x, which such a law does not run."""
    data = plant_document(cubic(), line(0.9, 1, box=[[-1, 1]]), [[[1.0]], [[1.5]]])
    data["gains"]["observer"] = {"weights": "measured", "measured": ["y"], "L": [[[1]]]}

    with pytest.raises(CertificateError, match="attraction-region would be about another law"):
        check_document(resealed(data))


@pytest.mark.parametrize(("premise", "words"), [("abs(x)/x", "z2, which jumps"), ("x", "")])
def test_gains_on_a_premise_that_jumps_have_no_region(premise: str, words: str) -> None:
    """u = -2 z1 z2 y, y' = y + u: z1 z2 = 1 but at x = 0, where any value is one of sign(x).

    With sign(0) = 0 the law is u = 0 there, and y grows from (0, y).  For z = x it is u = -2 x^2 y,
    which is no region's either: y' = y at x = 0.
    """
    variables = [{"name": n, "unit": "-", "rest": 0, "range": [-1, 1]} for n in ("x", "y")]
    premises = [{"name": f"z{k}", "expression": premise, "lower": -1, "upper": 1} for k in (1, 2)]
    model: Data = {"kind": "plant", "name": "jump", "sample_time": None, "states": variables}
    model |= {"inputs": [{"name": "u", "unit": "-", "rest": 0, "range": None}]}
    model |= {"disturbances": [], "equations": ["-2*x", "y + u"], "outputs": []}
    A = [["-2 + z1 - z2", "0"], ["0", "1"]]
    model |= {"embedding": {"premises": premises, "A": A, "B": [["0"], ["1"]]}}
    law: Data = {
        "name": "pdc",
        "sample_time": None,
        "state_names": ["x [-]", "y [-]"],
        "premises": premises,
    }
    law |= {"trim": {"state": [0, 0], "input": [0]}, "K": [[[0, k]] for k in (2, -2, -2, 2)]}
    rows: Data = {"multiplier_degree": 0, "multiplier": [[1.05]]}
    S = [[float(i == j) for j in range(3)] for i in range(3)]
    claim: Data = {"name": "r", "kind": "attraction-region", "function": "x^2 + y^2", "level": 0.9}
    claim |= {
        "box": [[-1, 1]] * 2,
        "states": [{"degree": 1, "squares": S} | rows] * 2,
        "inputs": [],
    }
    claim |= {"decrease": [{"degree": 1, "squares": [[1, 0], [0, 1]], "multiplier_degree": 1}]}
    claim["decrease"][0] |= {"multiplier": [[0, 0], [0, 0]]}
    embedding = {"name": "e", "kind": "sector-embedding"}
    checked = check_document(
        certificate_document(model=model, gains=law, claims=[embedding, claim], provenance={})
    )

    assert [c.verdict.name for c in checked.claims] == ["PROVED", "UNDECIDED"]
    assert words in checked.claims[1].text


def in_samples(data: Data) -> None:
    for part in ("model", "gains"):
        data[part]["sample_time"] = 1


def negative_mass(data: Data) -> None:
    """-x' = -x - x^3 + u: the motion backwards."""
    data["model"]["mass"] = [["-1"]]
    for letter in ("A", "B", "E"):
        rows = data["model"]["embedding"][letter]
        data["model"]["embedding"][letter] = [[f"-({entry})" for entry in row] for row in rows]


def uncertain(data: Data) -> None:
    """x' = (w - 1) x - x^3 + u with w up to 9, which no law knows."""
    model, law = data["model"], data["gains"]
    model["equations"] = ["-x - x^3 + u + w*x"]
    model["disturbances"][0] |= {"range": [-1, 9], "unknown": True}
    premises = [{"name": "square", "expression": "x^2", "lower": 0, "upper": 1, "unit": "-"}]
    premises += [{"name": "factor", "expression": "w", "lower": -1, "upper": 9, "unit": "-"}]
    model["embedding"] |= {"premises": premises, "A": [["-1 - square + factor"]], "E": [["0"]]}
    law |= {"premises": premises, "K": [[[1.0]]] * 4}
    law.pop("rules", None)


def other_weights(data: Data) -> None:
    data["gains"]["premises"][0]["upper"] = 2


@pytest.mark.parametrize(
    "change",
    [
        None,
        of_claim(box=[[-1, 1.1]], states=[one(1, 1, 1.05)]),
        of_claim(box=[[-1.1, 1]], states=[one(1, 1, 1.05)]),
        in_samples,
        negative_mass,
        uncertain,
        other_weights,
    ],
)
def test_each_condition_on_plant_law_and_box_is_needed(change: Change | None) -> None:
    """The embedding is proved each time, so that the region's conditions alone refuse."""
    data = plant_document(cubic(), line(0.9, 1, box=[[-1, 1]]), [[[1.0]], [[1.5]]])
    data = json.loads(dumps(data))
    if change is not None:
        change(data)
    expected = "PROVED" if change is None else "UNDECIDED"

    assert verdicts(resealed(data)) == ["PROVED", expected]


@pytest.mark.parametrize("gains", [[], "K", 1, True, {}])
def test_gains_that_are_no_law_are_refused(gains: Any) -> None:
    """Also where the region is the first claim, which reads the law first."""
    data = plant_document(cubic(), line(0.9, 1, box=[[-1, 1]]))
    data["claims"].reverse()

    with pytest.raises(CertificateError, match="gains: 'trim' is missing"):
        check_document(resealed(data | {"gains": gains}))


def test_a_set_is_found_and_proved() -> None:
    """x' = -x + x^3: from the request to the verdict, near the whole of |x| < 1."""
    answer = certify(unstable_beyond_one(), claims=[AttractionRegion()])
    (start,) = (f.value for f in answer.checked.claims[1].figures if isinstance(f, Figure))

    assert answer.verdict.name == "PROVED"
    assert start is not None and 0.95 < start < 1


def test_what_has_no_such_set_says_so() -> None:
    sine = Plant(equations=(-sp.sin(x),), states=(Variable(x, "-", Interval.of(-1, 1)),))

    with pytest.raises(ModelError, match="no polynomial in the states"):
        certify(sector_model(sine), claims=[AttractionRegion()])
    unstable = Plant(equations=(x + x**3,), states=(Variable(x, "-", Interval.of(-1, 1)),))
    with pytest.raises(ModelError, match="not stable at rest"):
        certify(sector_model(unstable), claims=[AttractionRegion()])


@pytest.mark.slow
def test_the_search_finds_most_of_van_der_pols_region() -> None:
    """Quartic V: more than 1.7 times Khalil's ellipse of example 8.9, whose area is 6.32."""
    answer = certify(van_der_pol(), claims=[AttractionRegion(4)])
    V = StatePolynomial.of(answer.document["claims"][1]["function"], ["x", "y"])

    assert answer.verdict.name == "PROVED"
    assert area(border(V)) > 1.7 * 6.32
