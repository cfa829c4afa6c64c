"""The proved set: its picture and table, half-widths, settling time and overshoot."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm
from sympy import Symbol

from takagi.certificates.claims.certification import USEFUL
from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Interval, Plant, Variable
from takagi.reports.figures.plant.proved_set import pairs, section, set_figure
from takagi.reports.loops.plant_claims import half_widths, overshoots, settling_time
from takagi.reports.loops.plant_loop import plant_loop
from takagi.reports.sections.plant.claims import set_section
from tests.reports.plant_designs import U, V, X, two_integrators

A, B, C, JERK = sp.symbols("a b c u", real=True)
SIDE = Interval.of(-1, 1)


def three_states() -> Plant:
    """A chain of three integrators, the first state in deg in its file."""
    return Plant(
        equations=(B, C, JERK),
        states=(
            Variable(A, "rad", SIDE, written="deg"),
            Variable(B, "rad/s", SIDE, written="rad/s"),
            Variable(C, "rad/s^2", Interval.of(-8, 8), written="rad/s^2"),
        ),
        inputs=(Variable(JERK, "rad/s^3"),),
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


@pytest.mark.parametrize("disturbed", [False, True])
def test_one_state_settles_as_its_pole_says(*, disturbed: bool) -> None:
    """x' = u = -2 x: the set is all of |x| <= 1, and 2 % are reached after ln(50) / 2.

    So it is with a disturbance that stays at rest.
    """
    W = Symbol("W", real=True)
    plant = Plant(
        equations=(U + W if disturbed else U,),
        states=(Variable(X, "-", Interval.of(-1, 1)),),
        inputs=(Variable(U, "-", Interval.of(-3, 3)),),
        disturbances=(Variable(W, "-", Interval.of(-0.1, 0.1)),) if disturbed else (),
    )
    loop = plant_loop(certify_plant(plant, np.array([[[2.0]]])))
    reach, time = half_widths(loop), settling_time(loop)

    assert reach is not None and np.isclose(reach[0], 1.0, rtol=1e-3)
    # The proved rate is a little below the pole.
    assert time is not None and np.log(50) / 2 <= time <= 1.05 * np.log(50) / 2


def test_motions_from_the_set_s_edge_keep_both_bounds() -> None:
    """Two poles at -1; exp(A t) moves sixty starts on the edge of {x' P x <= c}."""
    loop = plant_loop(two_integrators(1, 2, room=3))
    reach, time = half_widths(loop), settling_time(loop)
    assert reach is not None and time is not None
    P, level = loop.ellipsoid
    angle = np.linspace(0, np.pi, 60)
    edge = np.linalg.solve(
        np.linalg.cholesky(P).T, np.sqrt(level) * np.array([np.cos(angle), np.sin(angle)])
    )
    A = np.array([[0.0, 1.0], [-1.0, -2.0]])

    for t in np.linspace(0, 2 * time, 41):
        part = np.abs(expm(A * t) @ edge).max(axis=1) / reach
        assert np.all(part <= (0.02 if t >= time else 1.0) * (1 + 1e-9))
    assert np.isclose((np.abs(edge).max(axis=1) / reach).max(), 1.0, rtol=1e-2)


W = sp.Symbol("w", real=True)


@pytest.mark.parametrize("damping", [0.6, 2.0])
def test_motions_keep_the_bound_and_come_near_it(damping: float) -> None:
    design = two_integrators(1.0, damping)
    found = overshoots(design, plant_loop(design))
    A = np.array([[0.0, 1.0], [-1.0, -damping]])
    peaks = np.abs([expm(A * t) for t in np.linspace(0, 20, 801)]).max(axis=0)

    for k, name in enumerate(("x", "v")):
        assert peaks[k, k] <= found[name] < 1.6 * peaks[k, k]


def test_units_do_not_matter_and_a_useless_claim_is_made_again() -> None:
    """x'' = -1e4 x - 200 v, v up to 100: over the half-widths of the set as of poles at -1."""
    design = two_integrators(1e4, 200.0, side=100.0)
    slow = two_integrators(1.0, 2.0)
    claims = [c for c in design.document["claims"] if c["kind"] == "transient"]

    assert all(float(claim["overshoot"]) <= USEFUL for claim in claims)
    fast = overshoots(design, plant_loop(design))
    for name, most in overshoots(slow, plant_loop(slow)).items():
        assert np.isclose(fast[name], most, rtol=0.2)


def test_no_range_for_one_state_takes_the_set_s_own_width() -> None:
    """Scales of 1 would say 100 times: v gets 100 times as large as x."""
    plant = Plant(
        equations=(V, U),
        states=(Variable(X, "-", Interval.of(-1, 1)), Variable(V, "-")),
        inputs=(Variable(U, "-"),),
    )
    design = certify_plant(plant, np.array([[[1e4, 100.0]]]))
    (claim,) = (c for c in design.document["claims"] if c["kind"] == "transient")

    assert "half-widths" in claim["name"] and float(claim["overshoot"]) <= USEFUL
    assert float(claim["scales"][1]) > 10 * float(claim["scales"][0])


def test_nothing_is_said_without_a_proved_set_or_with_a_disturbance() -> None:
    design = two_integrators(1.0, 2.0)
    loop = plant_loop(design)
    pushed = replace(loop.plant, equations=(V, U + W), disturbances=(Variable(W, "-"),))

    assert overshoots(design, replace(loop, level_proved=False)) == {}
    assert overshoots(design, replace(loop, plant=pushed)) == {}
