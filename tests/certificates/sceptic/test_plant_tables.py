"""Tables at numbers: the point value of the spline, for plants that rest on a table."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker.arithmetic.interval import point
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.plant.table import Table, read_table
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models import Surface, interpolate_curve, sector_model
from takagi.models.plant_files.loader import load_plant
from takagi.models.splines.spline import interpolate
from tests.certificates.embedding.plants import changed, said_of
from tests.certificates.kinds.claims import as_read

CURVE = interpolate_curve([-4, -2, 0, 1, 2.5, 4], [-0.5, -0.3, 0, 0.3, 0.2, 0.5])
FRICTION = {
    "tables": {
        "friction": {"knots": [CURVE.knots.tolist()], "coefficients": CURVE.coefficients.tolist()}
    }
}


def table_of(data: dict[str, Any], name: str) -> Table:
    return read_table(as_read(data["tables"]), name, "tables")


@given(x=st.fractions(min_value=-4, max_value=4, max_denominator=100), order=st.integers(0, 2))
def test_the_value_is_that_of_the_model_and_lies_in_the_enclosure(x: Fraction, order: int) -> None:
    """Two programs, one in Bernstein form and one by de Boor's recursion, agree exactly."""
    table = table_of(FRICTION, "friction")
    found = table.exact([x], (order,))
    assert found == CURVE.exact(x, order)
    low, high = table.bounds([point(x)], (order,))
    assert low <= found * 10**36 <= high


@given(
    x=st.fractions(min_value=0, max_value=3, max_denominator=50),
    y=st.fractions(min_value=-1, max_value=3, max_denominator=50),
    dx=st.integers(0, 2),
    dy=st.integers(0, 2),
)
def test_a_surface_too(x: Fraction, y: Fraction, dx: int, dy: int) -> None:
    surface: Surface = SURFACE
    data = {
        "tables": {
            "s": {
                "knots": [surface.x_knots.tolist(), surface.y_knots.tolist()],
                "coefficients": surface.coefficients.tolist(),
            }
        }
    }
    found = table_of(data, "s").exact([x, y], (dx, dy))
    assert found is not None
    assert float(found) == pytest.approx(float(surface(float(x), float(y), dx, dy)), abs=1e-9)


SURFACE = interpolate(
    np.array([0.0, 0.5, 1.0, 2.0, 3.0]),
    np.array([-1.0, 0.0, 1.0, 3.0]),
    np.cos(np.arange(20.0).reshape(5, 4)),
)


def test_outside_the_table_there_is_no_value() -> None:
    table = table_of(FRICTION, "friction")
    assert table.exact([Fraction(4)], (0,)) == Fraction("0.5")
    assert table.exact([Fraction(4) + Fraction(1, 10**30)], (0,)) is None


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("pendulum")
    page = (Path(__file__).parents[3] / "docs/plants.md").read_text(encoding="utf-8")
    for start, name in (("```csv\n", "friction.csv"), ("```toml\n", "pendulum.toml")):
        text = page.split(start)[1].split("```")[0]
        (folder / name).write_text(text, encoding="utf-8")
    file = folder / "pendulum.toml"
    data = plant_data(sector_model(load_plant(file), rest="solve inputs"))
    return file, data


def test_the_pendulum_of_the_page_on_plant_files_is_proved(
    pendulum: tuple[Path, dict[str, Any]],
) -> None:
    """Its friction is a table through 0, whose spline passes 0 by 1e-17."""
    _, data = pendulum
    assert said_of(data).verdict is Verdict.PROVED
    wrong = changed(data, coefficient(2, 0.01))
    assert said_of(wrong).verdict is Verdict.UNDECIDED


def coefficient(place: int, value: float) -> Callable[[dict[str, Any]], None]:
    def change(data: dict[str, Any]) -> None:
        data["tables"]["friction"]["coefficients"][place] = value

    return change


def another_knot(data: dict[str, Any]) -> None:
    data["tables"]["friction"]["knots"][0].insert(5, 1)
    data["tables"]["friction"]["coefficients"].append(0.5)


def moved_knot(data: dict[str, Any]) -> None:
    knots = np.array(data["tables"]["friction"]["knots"][0])
    knots[4] = 0.5
    x, values = [-4, -2, 0, 2, 4], [-0.5, -0.3, 0, 0.3, 0.5]
    spline = make_interp_spline(x, values, k=3, t=knots)
    data["tables"]["friction"].update(knots=[knots.tolist()], coefficients=spline.c.tolist())


def test_a_table_is_that_of_its_file(pendulum: tuple[Path, dict[str, Any]]) -> None:
    """A hash alone would let a certificate have friction of its own beside the real file."""
    file, data = pendulum
    assert "tables pass their files' values" in compare_plant(as_read(data), file)
    others = (coefficient(0, -0.501), coefficient(4, 5.0), another_knot, moved_knot)
    for change in others:
        with pytest.raises(CertificateError, match="friction"):
            compare_plant(as_read(changed(data, change)), file)


@pytest.mark.parametrize(
    "written",
    ["-4, -0.5\n-2, -0.3\n0, 0\n2, 0.3\n4, 0.6", "-4, -0.5\n-1, -0.3\n0.1, 0\n2, 0.3\n4, 0.5",
     "-4, -0.5\n-2, -0.3\n0, 0\n2, 0.3", "", "-4\n-2\n0\n2\n4", "a, b", "1, 1e999\n2, 1"],
)  # fmt: skip
def test_another_file_is_refused(
    written: str, pendulum: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    file, data = pendulum
    other = tmp_path / "pendulum.toml"
    other.write_text(file.read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "friction.csv").write_text(written, encoding="utf-8")
    with pytest.raises(CertificateError, match="friction"):
        compare_plant(as_read(data), other)
