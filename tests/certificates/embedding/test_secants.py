"""Secant embeddings: differences of a plant from rest, without premises that a law must measure."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from takagi.certificates import Verdict, certify
from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.replay.loop_reading import read_model_loop
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models import Interval, ModelError, Output, Parameter, Plant, Variable
from takagi.models.plant_files.loader import load_plant
from tests.certificates.embedding.plants import (
    one_state,
)
from tests.certificates.kinds.claims import Data, as_read

x, v, u, w = sp.symbols("x v u w", real=True)


def pendulum(rest: str = "0") -> Plant:
    """Return theta'' = -9 sin theta - v/2 + u + w cos(theta), held at rest by its input."""
    return Plant(
        equations=(v, -9 * sp.sin(x) - v / 2 + u + w * sp.cos(x)),
        states=(
            Variable(x, "rad", Interval.of(-1, 1), Interval.of(rest, rest).lower),
            Variable(v, "rad/s", Interval.of(-2, 2)),
        ),
        inputs=(Variable(u, "rad/s^2"),),
        disturbances=(Variable(w, "rad/s^2", Interval.of("-0.5", "0.5")),),
        outputs=(Output("height", sp.cos(x), "m"),),
        name="pendulum",
    )


@pytest.mark.parametrize("rest", ["0", "0.5"])
def test_the_secants_of_a_pendulum_are_proved(rest: str) -> None:
    """Upright or held aside; and the decay of the vertices with one gain is about the plant."""
    model = secant_model(pendulum(rest), rest="solve inputs")

    certificate = certify(model, np.array([[1.0, 2.0]]))

    assert certificate.verdict is Verdict.PROVED
    assert [c["kind"] for c in certificate.document["claims"]] == ["secant-embedding", "decay"]


def test_differences_are_blends_of_the_vertices() -> None:
    """Two ways: f(x) - f(0) in floats lies in the interval hull of vertices times deviations."""
    model = secant_model(pendulum())
    family = plant_loop(as_read(plant_data(model)))
    A = np.array([[[float(M[i, j]) for j in range(2)] for i in range(2)] for M in family.A])
    E = np.array([[float(M[i, 0]) for i in range(2)] for M in family.E])
    rng = np.random.default_rng(5)
    for _ in range(200):
        angle, rate, wind = rng.uniform([-1, -2, -0.5], [1, 2, 0.5])
        f = np.array([rate, -9 * np.sin(angle) - rate / 2 + wind * np.cos(angle)])
        ends = A @ [angle, rate] + E * wind
        assert np.all(ends.min(axis=0) <= f + 1e-9) and np.all(f <= ends.max(axis=0) + 1e-9)


def test_a_law_cannot_have_the_weights_of_secants() -> None:
    """Gains that differ from rule to rule are checked in all pairs."""
    from takagi.certificates.checker.replay.loop_reading import read_model_loop

    model = secant_model(load_plant("flexible_joint"))
    gains = np.array([[[1.0, 0.0, 0.0, 0.0]], [[2.0, 0.0, 0.0, 0.0]]])
    document = certify(model, gains).document

    family = read_model_loop(as_read(document["model"]), as_read(document["gains"]))

    assert not family.shared_weights
    assert len(family.groups()) == 4


@pytest.mark.parametrize("name", ["tora", "cart_pole_2rules"])
def test_plants_without_secants_are_refused(name: str) -> None:
    """A mass matrix, and an absolute value."""
    with pytest.raises(ModelError):
        secant_model(load_plant(name))


def test_premises_have_names_of_their_own() -> None:
    """A plant with a state s1 and a parameter s3: its slopes are s_1, s_2, ..., and are proved."""
    s1, s3 = sp.symbols("s1 s3", real=True)
    plant = Plant(
        equations=(v, -s3 * sp.sin(s1) - v**3 + u),
        states=(
            Variable(s1, "rad", Interval.of(-1, 1)),
            Variable(v, "rad/s", Interval.of(-2, 2)),
        ),
        inputs=(Variable(u, "rad/s^2"),),
        parameters=(Parameter(s3, Fraction(9)),),
        name="names",
    )
    model = secant_model(plant)

    assert [premise.name for premise in model.premises] == ["s_1", "s_2"]
    certificate = certify(model, np.array([[1.0, 2.0]]))
    assert certificate.verdict is Verdict.PROVED


def loop_verdict(data: Data) -> str:
    read = as_read(data)
    found = replay(read["claim"], None, read_model_loop(read["model"], None), [], "claim")
    return found.verdict.name


def turning(**number: object) -> Data:
    data = one_state("-x/pi", "1", 1, 1)
    listed = {"name": "c", "expression": "1/pi", "lower": "0.3183", "upper": "0.3184"}
    data["embedding"] |= {"premises": [], "numbers": [listed | number], "A": [["-c"]]}
    return data


def test_a_claim_about_the_loop_holds_at_all_ends_of_a_number() -> None:
    """x' = -c x decays at the rate 0.318 for every c in its bounds, and at no greater one."""
    claim = {"name": "decay", "kind": "decay", "P": [[1]], "decay_rate": 0.318}

    assert loop_verdict({"model": turning(), "claim": claim}) == "PROVED"
    assert loop_verdict({"model": turning(upper=0.5), "claim": claim}) == "PROVED"
    assert loop_verdict({"model": turning(lower=0.31), "claim": claim}) == "UNDECIDED"
    assert (
        loop_verdict({"model": turning(), "claim": claim | {"decay_rate": 0.31835}}) == "UNDECIDED"
    )


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
