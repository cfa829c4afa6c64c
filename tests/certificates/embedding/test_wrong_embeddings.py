"""Embeddings that are wrong by one digit, sign, term or name are not proved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from takagi.certificates import Verdict
from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.replay.loop_reading import read_model_loop
from takagi.certificates.document.plant_embedding import plant_data
from tests.certificates.embedding.plants import (
    changed,
    embedding_outcome,
    one_state,
    said_of,
)
from tests.certificates.kinds.claims import as_read
from tests.models.library_plants import library_model

Data = dict[str, Any]


@pytest.fixture(scope="module")
def cart_pole() -> Data:
    return plant_data(library_model("cart_pole"))


@pytest.fixture(scope="module")
def tora() -> Data:
    return plant_data(library_model("tora"))


@pytest.fixture(scope="module")
def truck() -> Data:
    return plant_data(library_model("truck_trailer"))


def premise(number: int, key: str, value: object) -> Callable[[Data], object]:
    return lambda data: data["embedding"]["premises"][number].update({key: value})


def entry(letter: str, i: int, j: int, value: str) -> Callable[[Data], object]:
    def change(data: Data) -> None:
        data["embedding"][letter][i][j] = value

    return change


def equation(number: int, old: str, new: str) -> Callable[[Data], object]:
    def change(data: Data) -> None:
        data["equations"][number] = data["equations"][number].replace(old, new)

    return change


CART_POLE = {
    "lower bound of inertia one digit up": premise(0, "lower", 1.5011367),
    "upper bound of gravity below its limit at 0": premise(1, "upper", 0.9999999),
    "lower bound of gravity one digit up": premise(1, "lower", 0.6649967),
    "upper bound of swing too small": premise(2, "upper", 3.9999999),
    "lower bound of arm too large": premise(3, "lower", 0.0707373),
    "premise sin/2": premise(1, "expression", "sin(angle)/(2*angle)"),
    "premise of another variable": premise(3, "expression", "cos(rate)"),
    "premise cos of twice the angle": premise(3, "expression", "cos(2*angle)"),
    "sign of an entry": entry("A", 1, 1, "inertia*swing/20"),
    "coefficient of an entry": entry("A", 1, 0, "49*gravity*inertia/6"),
    "another premise in an entry": entry("B", 1, 0, "-swing*inertia/10"),
    "an entry that should be 0": entry("A", 0, 0, "1/1000000000000"),
    "output": entry("C", 0, 0, "2"),
    "direct feed-through": entry("D", 0, 0, "1"),
    "a term dropped in the equation": equation(1, "sin(2*angle)", "0"),
    "a sign in the equation": equation(1, "force*cos(angle)", "(-force)*cos(angle)"),
    "an exponent in the equation": equation(1, "rate^2", "rate^3"),
    "parameter": lambda data: data["parameters"].update({"l": 0.50001}),
    "box enlarged by a hundredth": lambda data: data["states"][0].update({"range": [-1.5, 1.51]}),
    "rate enlarged": lambda data: data["states"][1].update({"range": [-4.1, 4]}),
    "no range": lambda data: data["states"][0].update({"range": None}),
    "another trim": lambda data: data["states"][0].update(
        {"rest": 0.1, "symbol": "delta_angle", "range": [-1.5, 1.5]}
    ),
}


@pytest.mark.parametrize("what", CART_POLE)
def test_a_wrong_cart_pole_is_not_proved(what: str, cart_pole: Data) -> None:
    """The right one is; each of these differs from it in one place."""
    assert said_of(cart_pole).verdict is Verdict.PROVED

    found = said_of(changed(cart_pole, CART_POLE[what]))

    assert found.verdict is Verdict.UNDECIDED
    assert found.text.startswith("not proved: ")


TORA = {
    "mass entry": lambda data: data["mass"][1].__setitem__(3, "-eps*cos(theta)"),
    "mass coupling lost": lambda data: data["mass"][3].__setitem__(1, "0"),
    "singular mass": lambda data: data["mass"].__setitem__(3, list(data["mass"][1])),
    "parameter of the mass": lambda data: data["parameters"].update({"eps": 0.11}),
    "box": lambda data: data["states"][2].update({"range": [-1, 1.001]}),
    "z1 a digit low": premise(0, "upper", 0.01010101),
}


@pytest.mark.parametrize("what", TORA)
def test_a_wrong_mass_matrix_is_not_proved(what: str, tora: Data) -> None:
    """TORA: M(x) x' = f, with the coupling eps cos(theta) in M."""
    assert said_of(tora).verdict is Verdict.PROVED
    assert said_of(changed(tora, TORA[what])).verdict is Verdict.UNDECIDED


def test_a_wrong_discrete_plant_is_not_proved(truck: Data) -> None:
    """Truck and trailer: x(t + T); in continuous time the same numbers are another plant's."""
    assert said_of(truck).verdict is Verdict.PROVED
    wrong = changed(truck, entry("A", 2, 2, "1.0000001"))
    assert said_of(wrong).verdict is Verdict.UNDECIDED


SINGULAR = {
    "a pole inside": one_state("x/(x - 1)", "1/(x - 1)", -10, 10),
    "a pole at the end": one_state("x/(2 - x)", "1/(2 - x)", 0, 10**9),
    "a pole at the origin": one_state("1", "1/x", -(10**9), 10**9),
    "a pole that is no removable one": one_state("sin(x)/x", "sin(x)/x^2", -(10**6), 10**6),
    "|x|/x beyond its bounds": one_state("abs(x)", "abs(x)/x", -0.99, 1),
    "|x|/x that is not continuous": one_state("abs(x)/x", "abs(x)/x^2", -(10**6), 10**6),
    "log of 0": one_state("x*log(x + 1)", "log(x + 1)", -(10**6), 2),
    "root of what is negative": one_state("x*sqrt(x)", "sqrt(x)", -2, 2),
    "a power of what is negative": one_state("x*x^(1/3)", "x^(1/3)", -2, 2),
    "asin beyond 1": one_state("x*asin(x)", "asin(x)", -2, 2),
    "tan over its pole": one_state("x*tan(x)", "tan(x)", -(10**6), 10**6),
    "an equation that is nowhere defined": one_state("x*z0/(x - x)", "1", 0, 2),
    "0/0 at the upper end": one_state("x*(2 - x)/(2 - x)", "1", 1, 1),
    "0/0 at the upper end, from below": one_state("x*(x - 2)/(x - 2)", "1", 1, 1),
    "0/0 at the lower end": one_state("x*(1 + x)^2/(1 + x)^2", "1", 1, 1),
    "log of 0, cancelled": one_state("x + log(2 - x) - log(2 - x)", "1", 1, 1),
    "tan of a pole, cancelled": one_state("x + tan(x) - tan(x)", "1", 1, 1),
    "acosh below 1, cancelled": one_state("x + acosh(x) - acosh(x)", "1", 1, 1),
    "atanh of 1, cancelled": one_state("x + atanh(x) - atanh(x)", "1", 1, 1, range=[0, 1]),
    "asin beyond 1, cancelled": one_state("x + asin(x) - asin(x)", "1", 1, 1),
    "a negative root, cancelled": one_state("x + sqrt(x) - sqrt(x)", "1", 1, 1),
    "a negative power of 0, cancelled": one_state(
        "x + x^(-1/2) - x^(-1/2)", "1", 1, 1, range=[0, 1]
    ),
    "0/0 cancelled in the text": one_state("x*(x - 1)/(x - 1)", "(x - 1)/(x - 1)", 1, 1),
}


@pytest.mark.parametrize("what", SINGULAR)
def test_a_singular_plant_is_not_proved(what: str) -> None:
    """The identity alone would hold for each of them."""
    try:
        found = said_of(SINGULAR[what])
    except CertificateError:
        return
    assert found.verdict is Verdict.UNDECIDED, found.text


def loop_verdict(data: Data) -> str:
    """Return the verdict on one claim about the model's loop."""
    read = as_read(data)
    found = replay(read["claim"], None, read_model_loop(read["model"], None), [], "claim")
    return found.verdict.name


JUMP = "sqrt(2 - x/abs(x)*y)"


def valve(equation: str, entries: list[str], premise: str = JUMP) -> Data:
    """Return x' = equation = entries (x, y), y' = -y, with 1 <= z <= 2 on |x|, |y| <= 1."""
    names = [{"name": n, "unit": "-", "rest": 0, "range": [-1, 1]} for n in "xy"]
    listed = [{"name": "z", "expression": premise, "lower": 0.9999999, "upper": 1.7320509}]
    embedding = {"premises": listed, "A": [entries, ["0", "-1"]]}
    return {
        "kind": "plant", "sample_time": None, "states": names,
        "equations": [equation, "-y"], "embedding": embedding,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("equation", "entries", "premise", "proved"),
    [
        (f"x*{JUMP}", ["z", "0"], JUMP, True),
        (
            "x*(sqrt(2-y)+sqrt(2+y))/2 + abs(x)*(sqrt(2-y)-sqrt(2+y))/2",
            ["z", "0"],
            "(sqrt(2-y)+sqrt(2+y) + abs(x)/x*(sqrt(2-y)-sqrt(2+y)))/2",
            True,
        ),
        (f"y*{JUMP}", ["0", "z"], JUMP, False),  # x' jumps where x = 0
        (f"(x + y)*{JUMP}", ["z", "z"], JUMP, False),
        ("x*sqrt(2 - (x + y)/abs(x + y)*y)", ["z", "0"], "sqrt(2 - (x + y)/abs(x + y)*y)", False),
        (f"x*{JUMP}", ["z", "0"], "sqrt(1.99 - x/abs(x)*y)", False),
    ],
)
def test_a_premise_that_jumps_is_proved_in_the_column_of_its_zero(
    equation: str, entries: list[str], premise: str, proved: bool
) -> None:
    """x sqrt(2 - y sign x) is continuous, and any z in the bounds gives it at x = 0."""
    found = said_of(valve(equation, entries, premise))

    assert found.verdict is (Verdict.PROVED if proved else Verdict.UNDECIDED)


def turning(**number: object) -> Data:
    """Return x' = -c x with the number c = 1/pi, or as changed."""
    data = one_state("-x/pi", "1", 1, 1)
    listed = {"name": "c", "expression": "1/pi", "lower": "0.3183", "upper": "0.3184"}
    data["embedding"] |= {"premises": [], "numbers": [listed | number], "A": [["-c"]]}
    return data


@pytest.mark.parametrize("wrong", [{"lower": 0.31831}, {"upper": 0.3183}, {"expression": "1/3"}])
def test_a_number_that_is_no_fraction_stands_in_an_entry(wrong: Data) -> None:
    """With proved bounds; a name that moves, a square and a form of secants are refused."""
    assert said_of(turning()).verdict is Verdict.PROVED
    assert said_of(turning(**wrong)).verdict is Verdict.UNDECIDED
    for bad in (
        turning(expression="x"),
        changed(turning(), entry("A", 0, 0, "-c^2")),
        changed(turning(), lambda data: data["embedding"].update({"form": "secant"})),
    ):
        with pytest.raises(CertificateError):
            said_of(bad)


def test_a_claim_about_the_loop_holds_at_all_ends_of_a_number() -> None:
    """x' = -c x decays at the rate 0.318 for every c in its bounds, and at no greater one."""
    claim = {"name": "decay", "kind": "decay", "P": [[1]], "decay_rate": 0.318}

    assert loop_verdict({"model": turning(), "claim": claim}) == "PROVED"
    assert loop_verdict({"model": turning(upper=0.5), "claim": claim}) == "PROVED"
    assert loop_verdict({"model": turning(lower=0.31), "claim": claim}) == "UNDECIDED"
    assert (
        loop_verdict({"model": turning(), "claim": claim | {"decay_rate": 0.31835}}) == "UNDECIDED"
    )


def test_a_singular_mass_matrix_entry_is_not_proved() -> None:
    """M = [[1, 1/x], [0, 1]] has determinant 1 and is not defined at x = 0."""
    data = {
        "kind": "plant",
        "sample_time": None,
        "states": [
            {"name": "x", "unit": "-", "rest": 0, "range": [-1, 1]},
            {"name": "y", "unit": "-", "rest": 0, "range": [-1, 1]},
        ],
        "equations": ["y", "0"],
        "mass": [["1", "1/x"], ["0", "1"]],
        "embedding": {"premises": [], "A": [["0", "1"], ["0", "0"]]},
    }
    assert said_of(data).verdict is Verdict.UNDECIDED
    data["mass"] = [["1", "1"], ["0", "1"]]
    assert said_of(data).verdict is Verdict.PROVED


@pytest.mark.parametrize("written", ["z^2", "1/z", "sin(z)", "x*z", "pi*z", "z*z", "sqrt(2)*z"])
def test_entries_that_weights_do_not_blend_are_refused(written: str) -> None:
    """Only polynomials of degree one in each premise, with rational coefficients."""
    data = one_state("x*sin(x)", "sin(x)", -1, 1)
    data["embedding"]["A"] = [[written]]
    with pytest.raises(CertificateError):
        said_of(data)


def test_a_premise_with_agreeing_bounds_is_a_constant() -> None:
    """x' = 3 x with z = 3 is one vertex; z = x with agreeing bounds is not a constant."""
    assert said_of(one_state("3*x", "3", 3, 3)).verdict is Verdict.PROVED
    assert said_of(one_state("x^2", "x", 1, 1)).verdict is Verdict.UNDECIDED


def test_a_law_about_another_trim_is_refused(cart_pole: Data) -> None:
    """u = u* - K (x - x*) with another x* is another loop."""
    law: Data = {"trim": {"state": [0, 0], "input": [0]}}
    assert embedding_outcome(as_read(cart_pole), as_read(law))
    law["trim"]["state"][1] = 1.1e-12
    with pytest.raises(CertificateError, match="rate rests at 0"):
        embedding_outcome(as_read(cart_pole), as_read(law))


@pytest.mark.parametrize(
    ("letter", "output", "drift", "bounds"),
    [("C", "(p*p - 2)*x", "", (-1e-6, 1e-6)), ("E", "x", " + (p*p - 3/2)*w", (0, 0.6))],
)
def test_a_number_that_may_vanish_is_refused(
    letter: str, output: str, drift: str, bounds: tuple[float, float]
) -> None:
    """y = 0 x shows no premise, though its factor is not 0 at the ends of its bounds."""
    data = one_state(f"-x - x^3{drift}", "x^2", 0, 1)
    root = {"value": "1.4142135623", "within": "1e-8", "equals": "sqrt(2)"}
    number: Data = {"name": "c", "expression": "p*p - 2" if letter == "C" else "p*p - 3/2"}
    number |= {"lower": bounds[0], "upper": bounds[1]}
    data |= {"parameters": {"p": root}}
    data["outputs"] = [{"name": "y", "unit": "-", "expression": output}]
    data["embedding"] |= {"numbers": [number], "A": [["-1 - z"]], "C": [["1"]]}
    if letter == "E":
        data["disturbances"] = [{"name": "w", "unit": "-", "range": [-1, 1], "rest": 0}]
        data["embedding"] |= {"E": [["c"]]}
    else:
        data["embedding"] |= {"C": [["c"]]}

    with pytest.raises(CertificateError, match="embedding.numbers"):
        read_model_loop(as_read(data), None)
