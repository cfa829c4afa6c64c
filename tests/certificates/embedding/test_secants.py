"""Secant embeddings: differences of a plant from rest, without premises that a law must measure."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

from takagi.certificates import Verdict, certify
from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models import Interval, ModelError, Output, Parameter, Plant, Variable
from takagi.models.plant_files.loader import load_plant
from tests.certificates.embedding.plants import changed, embedding_outcome
from tests.certificates.kinds.claims import as_read

x, v, u, w = sp.symbols("x v u w", real=True)
CLAIM = {"name": "secants", "kind": "secant-embedding"}
Data = dict[str, Any]


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


def said_of(data: Data) -> Any:
    return embedding_outcome(as_read(data), claim=CLAIM)


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


def cut(data: Data) -> None:
    """Take a hundredth of its range from the upper end of the first premise."""
    first = data["embedding"]["premises"][0]
    first["upper"] -= (first["upper"] - first["lower"]) / 100


WRONG = {
    "a bound": cut,
    "an entry": lambda d: d["embedding"]["A"][1].__setitem__(1, "-0.51"),
    "the equation": lambda d: d["equations"].__setitem__(1, "u - 9*sin(x)"),
    "not at rest": lambda d: d["equations"].__setitem__(1, d["equations"][1] + " + 1/1000000"),
    "a larger box": lambda d: d["states"][0].update({"range": [-1, 1.1]}),
    "a kink": lambda d: d["equations"].__setitem__(1, d["equations"][1] + " + abs(x) - abs(x)"),
    "no range": lambda d: d["states"][0].update({"range": None}),
}


@pytest.mark.parametrize("what", WRONG)
def test_wrong_secants_are_not_proved(what: str) -> None:
    """Each differs from what is proved in one place."""
    data = plant_data(secant_model(pendulum()))
    assert said_of(data).verdict is Verdict.PROVED
    assert said_of(changed(data, WRONG[what])).verdict is Verdict.UNDECIDED


def test_products_of_premises_are_refused() -> None:
    """The mean of a product is not a product of means."""
    data = plant_data(secant_model(pendulum()))
    name = data["embedding"]["premises"][0]["name"]
    other = data["embedding"]["premises"][1]["name"]
    data["embedding"]["A"][0][0] = f"{name}*{other}"
    with pytest.raises(CertificateError, match="product of premises"):
        said_of(data)


def test_one_form_is_not_taken_for_the_other() -> None:
    """Secants are no sectors: sin x = cos(z) x holds for no z that is x."""
    secants = plant_data(secant_model(load_plant("flexible_joint")))
    with pytest.raises(CertificateError, match="not 'sector'"):
        embedding_outcome(as_read(secants))
    secants["embedding"]["form"] = "sector"
    assert embedding_outcome(as_read(secants)).verdict is Verdict.UNDECIDED
    with pytest.raises(CertificateError, match="not 'secant'"):
        said_of(secants)


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
