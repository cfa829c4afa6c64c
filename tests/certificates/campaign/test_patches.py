"""The campaign's own reading of the coefficient surface, against another library's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import NdBSpline

from takagi.certificates.campaign.spline_patches import PatchAxis, spline_patches
from takagi.models import ModelError


def table(document: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Knots and coefficients as the certificate states them."""
    found = document["model"]["torque_surface"]
    names = ("tip_speed_ratio_knots", "pitch_knots", "coefficients")
    x, y, c = (np.array(found[name]) for name in names)
    return x, y, c


def test_polynomials_are_the_spline(built: Any) -> None:
    """At random points, and at every knot, where a point belongs to the piece on its right."""
    x, y, c = table(built.document)
    patches, draw = spline_patches(x, y, c), np.random.default_rng(1)
    ratio = np.concatenate([draw.uniform(x[0], x[-1], 4000), x, x])
    pitch = np.concatenate([draw.uniform(y[0], y[-1], 4000), np.resize(y, 2 * len(x))])
    wanted = NdBSpline((x, y), c, 3)(np.stack([ratio, pitch], axis=-1))

    assert patches(ratio, pitch) == pytest.approx(wanted, abs=1e-13)
    assert patches.inside(ratio, pitch).all()


def test_points_outside_take_the_edge_and_are_told(built: Any) -> None:
    """A hair outside on each side."""
    x, y, c = table(built.document)
    patches = spline_patches(x, y, c)
    ratio = np.array([x[0] - 1e-6, x[-1] + 1e-6, 7.0, 7.0])
    pitch = np.array([0.1, 0.1, y[0] - 1e-6, y[-1] + 1e-6])

    assert not patches.inside(ratio, pitch).any()
    held = patches(np.clip(ratio, x[0], x[-1]), np.clip(pitch, y[0], y[-1]))
    assert patches(ratio, pitch) == pytest.approx(held, abs=0)


def test_pieces_of_uneven_axes_are_found() -> None:
    """Against a search, with pieces from 1 to 30 wide; and a point on each end."""
    breaks = np.array([0.0, 1.0, 1.5, 4.0, 34.0, 35.0])
    points = np.concatenate([np.random.default_rng(2).uniform(0, 35, 2000), breaks])
    piece, beyond = PatchAxis.of(breaks).placed(points)

    wanted = np.clip(np.searchsorted(breaks, points, side="right") - 1, 0, 4)
    assert np.array_equal(piece, wanted)
    assert breaks[piece] + beyond == pytest.approx(points, abs=1e-13)


def test_sizes_that_do_not_fit_are_refused(built: Any) -> None:
    """One row of coefficients too few."""
    x, y, c = table(built.document)
    with pytest.raises(ModelError, match="its knots ask for"):
        spline_patches(x, y, c[1:])
