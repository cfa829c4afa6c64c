"""The picture and the table of the proved set, in the units of the plant's file."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import sympy as sp

from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Interval, Plant, Variable
from takagi.reports.figures.plant.proved_set import pairs, section, set_figure
from takagi.reports.loops.plant_loop import plant_loop
from takagi.reports.sections.plant.certificate import set_section

A, B, C, U = sp.symbols("a b c u", real=True)
SIDE = Interval.of(-1, 1)


def three_states() -> Plant:
    """A chain of three integrators, the first state in deg in its file."""
    return Plant(
        equations=(B, C, U),
        states=(
            Variable(A, "rad", SIDE, written="deg"),
            Variable(B, "rad/s", SIDE, written="rad/s"),
            Variable(C, "rad/s^2", Interval.of(-8, 8), written="rad/s^2"),
        ),
        inputs=(Variable(U, "rad/s^3"),),
    )


@cache
def design() -> PlantDesign:
    return certify_plant(three_states(), np.array([[[6.0, 11.0, 6.0]]]))


def test_every_pair_has_a_panel_with_units_on_its_outer_axes() -> None:
    """Three states have three pairs; the projection of the first is its half-width in deg."""
    loop = plant_loop(design())
    figure = set_figure(loop)
    shown = [axes for axes in figure.axes if axes.get_visible()]
    assert len(shown) == len(pairs(loop)) == 3
    assert {axes.get_xlabel() for axes in shown} == {"a [deg]", "b [rad/s]", ""}
    assert {axes.get_ylabel() for axes in shown} == {"b [rad/s]", "c [rad/s^2]", ""}
    P, level = loop.ellipsoid
    widest = np.degrees(np.sqrt(level * np.linalg.inv(P)[0, 0]))
    border = next(line for line in shown[0].lines if "projection" in str(line.get_label()))
    assert np.isclose(np.abs(np.asarray(border.get_xdata())).max(), widest, rtol=1e-3)


def test_the_section_is_the_set_with_all_other_states_at_rest() -> None:
    P = np.array([[2.0, 0.5, 0.3], [0.5, 1.0, 0.2], [0.3, 0.2, 3.0]])
    border = section(P, 4.0, (0, 2))
    points = np.stack((border[0], np.zeros_like(border[0]), border[1]))
    assert np.allclose(np.einsum("ik,ij,jk->k", points, P, points), 4.0)


def test_the_table_is_in_the_file_s_units_and_absent_without_a_set() -> None:
    loop = plant_loop(design())
    found = set_section(design(), loop)
    assert found is not None
    rows = found.content["table"].rows
    P, level = loop.ellipsoid
    assert rows[0][:2] == ("a", "deg")
    alone = float(rows[0][2].removeprefix("±"))
    assert np.isclose(alone, np.degrees(np.sqrt(level / P[0, 0])), rtol=1e-2)
    assert set_section(design(), replace(loop, level_proved=False)) is None
