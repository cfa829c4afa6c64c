"""What a design cannot serve is refused before the long work, with the wind and a number."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from takagi.certificates import DesignSettings
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import check_limits
from takagi.lmi.turbine.effort import EffortSettings
from takagi.models import ModelError, Turbine, nrel5mw
from takagi.models.files.library import resolve_model
from takagi.models.turbine.loader import load_turbine

TURBINE = nrel5mw()
ASKED = default_settings(TURBINE)
# n_g T_rated / J of the 5-MW turbine: 97 x 43093.55 / (38759228 + 97^2 x 534.116).
RESERVE = 0.0954688


def told(asked: DesignSettings, turbine: Turbine = TURBINE) -> str:
    with pytest.raises(ModelError) as caught:
        check_limits(turbine, asked)
    return str(caught.value)


@pytest.mark.parametrize("name", ["nrel5mw", "iea15mw"])
@pytest.mark.parametrize("law", ["coherent", "paper", "paper-two-integrators"])
def test_the_defaults_pass(name: str, law: str) -> None:
    """Each built-in turbine with each law."""
    turbine = load_turbine(name)
    check_limits(turbine, replace(default_settings(turbine), law=law))


def test_the_overlap_ends_where_the_torque_reserve_does() -> None:
    """From both sides of n_g T_rated / J, and the number that is offered works."""
    check_limits(TURBINE, replace(ASKED, overlap=RESERVE - 1e-5))
    message = told(replace(ASKED, overlap=RESERVE + 1e-5))

    assert "below 0.09547 rad/s^2 is needed" in message and "3 m/s" in message
    offered = re.search(r"try ([0-9.]+)", message)
    assert offered is not None
    check_limits(TURBINE, replace(ASKED, overlap=float(offered.group(1))))


def test_the_bandwidth_ends_at_the_pitch_drive() -> None:
    """1 / 0.2 s."""
    check_limits(TURBINE, replace(ASKED, effort=EffortSettings(bandwidth=5.0)))

    message = told(replace(ASKED, effort=EffortSettings(bandwidth=5.001)))

    assert "at most 5 1/s" in message and "11.45 m/s; try 0.62" in message


def test_so_does_a_bandwidth_that_has_grown() -> None:
    """0.6 1/s may grow to 5, and no further."""
    grown = EffortSettings(bandwidth=0.6, bandwidth_growth=8.33)
    check_limits(TURBINE, replace(ASKED, effort=grown))

    message = told(replace(ASKED, effort=replace(grown, bandwidth_growth=8.34)))

    assert "growth 8.34" in message and "at most 5 1/s" in message and "try 4.2" in message


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"torque_overlap": 9000.0}, "at most 8618.72 N m is needed"),
        ({"speed_overlap": 5.0}, "pitch would act at every wind from 3 m/s on"),
        ({"speed_overlap": 0.6, "ramp_placement": 0.99}, "pitch acts fully at no speed"),
        ({"ramp_placement": 1.0}, "no equilibrium at 11.45 to 25 m/s; try 0.5"),
    ],
)
def test_overlaps_of_the_coupling_filter_that_leave_no_law(
    changes: dict[str, float], words: str
) -> None:
    """What is needed, and at which winds."""
    assert words in told(replace(ASKED, law="paper", **changes))  # type: ignore[arg-type]


def test_two_integrators_may_have_the_ramp_above_rated_speed() -> None:
    """They rest at a small overspeed there (docs/turbulence.md)."""
    check_limits(TURBINE, replace(ASKED, law="paper-two-integrators", ramp_placement=1.0))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"rated_torque": 2e5, "maximum_torque": 3e5}, "rated torque must lie between"),
        ({"rated_torque": 4000.0}, "none exists"),
        ({"pitch_max": 0.1745}, "no steady state at wind 15 m/s"),
        ({"pitch_max": 0.1745}, "it exists from 3 to 14.5 m/s"),
        ({"cut_out": 40.0}, "no steady state at wind 32.5 m/s"),
    ],
)
def test_a_turbine_that_cannot_be_trimmed_is_told_the_wind(
    changes: dict[str, float], words: str
) -> None:
    """Rated torque out of reach, too little pitch, winds beyond the table."""
    turbine = replace(TURBINE, **changes)  # type: ignore[arg-type]

    assert words in told(default_settings(turbine), turbine)


def test_a_wind_that_the_torque_does_not_show_is_refused(tmp_path: Path) -> None:
    """Below a tip-speed ratio of 5, c_P = c_P(5) (lambda / 5)^p has d ln T_r / d ln v = 3 - p."""
    flat, steep = with_low_ratios(tmp_path, 3), with_low_ratios(tmp_path, 2)

    check_limits(steep, default_settings(steep))
    message = told(default_settings(flat), flat)

    found = re.search(r"at ([0-9.]+) m/s 1 % more wind gives only (-?[0-9.e-]+) %", message)
    assert found is not None
    # 5 is reached at the set-point at 1.2671 x 63 / 5 m/s; the spline has its own way near it.
    assert 15.5 <= float(found.group(1)) <= 17 and float(found.group(2)) < 0.05
    assert "correct the power coefficients around this place" in message


def with_low_ratios(folder: Path, power: float) -> Turbine:
    """The 5-MW turbine with c_P proportional to a power of the tip-speed ratio below 5."""
    data = Path(resolve_model("nrel5mw")).parent
    lines = (data / "nrel5mw_cp.csv").read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("tip_speed")) + 1
    table = np.array([[float(x) for x in line.split(",")] for line in lines[first:] if line])
    five = table[table[:, 0] == 5][0]
    below = table[:, 0] < 5
    table[below, 1:] = five[1:] * (table[below, :1] / 5) ** power
    rows = [",".join(f"{x:.10g}" for x in row) for row in table]
    (folder / "nrel5mw_cp.csv").write_text("\n".join([*lines[:first], *rows]) + "\n")
    for name in ("nrel5mw_ct.csv", "nrel5mw.toml"):
        (folder / name).write_bytes((data / name).read_bytes())
    return load_turbine(folder / "nrel5mw.toml")
