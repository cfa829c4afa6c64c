"""Parameters that are known within a range: read, derived, refused; the built-in example."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from takagi.models import ModelError, Plant, load_model, sector_model

SPRING = """
format = 1
kind = "plant"
name = "cart"

[states]
x = { unit = "m", range = [-1, 1] }
v = { unit = "m/s", range = [-3, 3] }

[inputs]
F = { unit = "N", range = [-20, 20] }

[parameters]
m = "[900, 1100] g"
k = { range = [4, 6], value = 4.5, unit = "N/m", source = "measured" }
c = { value = "tau*k", unit = "kg/s" }
tau = { value = 0.1, unit = "s" }

[equations]
x = "v"
v = "(F - k*x - c*v)/m"
"""


def cart(folder: Path, *changes: tuple[str, str]) -> Plant:
    text = SPRING
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "cart.toml"
    path.write_text(text, encoding="utf-8")
    plant = load_model(path)
    assert isinstance(plant, Plant)
    return plant


def test_it_is_a_signal_that_no_law_knows(tmp_path: Path) -> None:
    """In SI, at rest at its value or in the middle; a derived one is put into the equations."""
    plant = cart(tmp_path)
    mass, stiffness = plant.uncertain

    assert (mass.name, mass.unit, mass.rest) == ("m", "kg", Fraction(1))
    assert mass.range is not None
    assert (mass.range.lower, mass.range.upper) == (Fraction(9, 10), Fraction(11, 10))
    assert (stiffness.rest, stiffness.description) == (
        Fraction(9, 2),
        "uncertain parameter: measured",
    )
    assert [p.symbol.name for p in plant.parameters] == ["tau"]
    v, k, tau = (sp.Symbol(name, real=True) for name in ("v", "k", "tau"))
    assert sp.expand(plant.equations[1] * sp.Symbol("m", real=True)).coeff(v) == -k * tau


def test_the_ways_of_writing_one_are_equal(tmp_path: Path) -> None:
    table = ('"[900, 1100] g"', '{ range = [0.9, 1.1], unit = "kg" }')
    assert cart(tmp_path) == cart(tmp_path, table)

    bare = cart(tmp_path, ("tau = { value = 0.1,", "tau = { range = [0.1, 0.2],"))
    assert [v.name for v in bare.uncertain] == ["m", "k", "tau"]


def test_the_model_is_the_plant_for_every_value(tmp_path: Path) -> None:
    """Corners and random values of m and k: the blend gives (F - k x - k v/10)/m."""
    model = sector_model(cart(tmp_path))
    draw = np.random.default_rng(1)
    for _ in range(50):
        x, v, F = draw.uniform([-1, -3, -20], [1, 3, 20])
        m, k = draw.choice([0.9, 1.0, 1.1]), draw.choice([4.0, 4.7, 6.0])
        z = model.premise_values(x=x, v=v, F=F, delta_m=m - 1, delta_k=k - 4.5)
        now = model.blend(z)
        moved = now.A @ [x, v] + now.B @ [F]
        assert moved == pytest.approx([v, (F - k * x - 0.1 * k * v) / m], abs=1e-9)
    assert not np.any(model.E)


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("[900, 1100]", "[1100, 900]", "parameters.m.range", "smaller end first"),
        ("[900, 1100]", "[900, 900]", "parameters.m.range", "has no width"),
        ("[900, 1100]", "[-900, 1100]", "parameters.m.range", "divides by m, which may be 0"),
        ("value = 4.5", "value = 7", "parameters.k.value", "outside the range [4, 6] N/m"),
        ("value = 4.5", 'value = "tau"', "parameters.k.value", "a range of its own"),
        ("value = 4.5,", "vague = 1,", "parameters.k.vague", "is not known"),
        ("range = [4, 6], value = 4.5,", "", "parameters.k.value", "is missing"),
        ("[900, 1100] g", "[900, 1100] furlong", "parameters.m.unit", "not known"),
        ("value = 0.1, unit", 'value = "c/k", unit', "parameters.c", "depends on itself"),
        ('"tau*k", unit = "kg/s"', '"tau*k", unit = "kg"', "parameters.c", "correct one"),
    ],
)
def test_a_wrong_one_is_refused_at_its_place(
    tmp_path: Path, old: str, new: str, place: str, words: str
) -> None:
    with pytest.raises(ModelError) as caught:
        cart(tmp_path, (old, new))
    assert f"field '{place}'" in str(caught.value)
    assert words in str(caught.value)


def test_a_rest_that_is_given_by_one_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="moves with k, m, which is known within a range only"):
        cart(tmp_path, ("x = { unit", 'x = { rest = "tau^2*k/m*x0", unit'),
             ("tau = {", 'x0 = { value = 1, unit = "m" }\ntau = {'))  # fmt: skip


def test_a_rest_that_moves_with_one_is_refused(tmp_path: Path) -> None:
    """F = m g holds the mass: at 0.9 and 1.1 kg 1.09 and -0.892 m/s^2 are left."""
    plant = cart(
        tmp_path,
        ("- c*v)/m", "- c*v)/m - g"),
        ("tau = {", 'g = { value = 9.81, unit = "m/s^2" }\ntau = {'),
        ("range = [-20, 20]", "range = [-20, 20], rest = 9.81"),
    )
    with pytest.raises(ModelError, match=r"moves with the uncertain m: .* 1\.09 at m = 0\.9 and"):
        sector_model(plant)


def test_two_masses_of_wie_and_bernstein() -> None:
    """Problem 1: x1'' = u - k (x1 - x2), x2'' = k (x1 - x2), 0.5 < k < 2: poles 0, 0, +-i sqrt(2k).

    Wie and Bernstein (1992), J. Guidance, Control, and Dynamics 15(5), 1057-1059.
    """
    plant = load_model("two_mass_spring")
    assert isinstance(plant, Plant)
    model = sector_model(plant)
    frequencies = [np.abs(np.linalg.eigvals(A).imag).max() for A in model.A]

    assert frequencies == pytest.approx([1.0, 2.0], abs=1e-6)
    assert model.B[:, :, 0] == pytest.approx(np.array([[0, 0, 1, 0]] * 2))
    assert float(plant.uncertain[0].rest) == 1
