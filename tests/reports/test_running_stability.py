"""A design whose loop that runs is unstable is refused before the long work, with wind and cure."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from takagi.certificates.design import design
from takagi.certificates.design.turbine import default_settings
from takagi.cli.options import given
from takagi.cli.runs import makers
from takagi.models import ModelError, Turbine, nrel5mw
from takagi.models.files import resolve_model
from takagi.reports.margins import NoEquilibrium, effort_of, require_stable, unstable_loop

# A look at all winds takes 3 s, and three cures are tried for each refusal.
pytestmark = pytest.mark.slow

TURBINE = nrel5mw()


def with_tower(frequency: float) -> Turbine:
    """The 5-MW turbine with another tower mode [rad/s]; its own has 2.04."""
    return replace(TURBINE, tower_stiffness=frequency**2 * TURBINE.tower_mass)


def test_the_default_law_is_stable_and_nothing_is_noted() -> None:
    assert require_stable(TURBINE, default_settings(TURBINE)) == ()


def test_a_tower_mode_at_the_crossover_of_pitch_is_refused() -> None:
    """The pitch loop crosses over at 0.57 rad/s near rated wind; 0.7 rad/s is stable."""
    soft = with_tower(0.48)

    assert unstable_loop(with_tower(0.7), default_settings(soft)) is None
    with pytest.raises(ModelError) as caught:
        require_stable(soft, default_settings(soft))

    message = str(caught.value)
    assert "at 11.5509 m/s" in message
    assert re.search(r"unstable at 11\.\d+ to 11\.\d+ m/s", message)
    assert "the tower mode, 0.48 rad/s" in message and "a stiffer tower" in message
    offered = re.search(r"--bandwidth ([0-9.]+)", message)
    assert offered is not None
    effort = replace(effort_of(default_settings(soft)), bandwidth=float(offered.group(1)))
    assert unstable_loop(soft, replace(default_settings(soft), effort=effort)) is None


def test_a_loop_that_grows_between_the_winds_looked_at_is_refused() -> None:
    """With 0.63 rad/s it grows at 11.53 to 11.57 m/s alone, at most at a node of the law."""
    soft = with_tower(0.63)
    found = unstable_loop(soft, default_settings(soft))

    assert found is not None
    growth = re.search(r"at 11\.5509 m/s .* it grows at ([0-9.]+) 1/s", found.reason)
    assert growth is not None and 0.0005 < float(growth[1]) < 0.003
    assert "unstable at 11.5509 m/s" in found.reason


def test_a_loop_without_an_equilibrium_is_not_called_stable(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """There is nothing to linearise at, at any wind."""

    def no_rest(*_: object, **__: object) -> None:
        raise NoEquilibrium("no rest")

    monkeypatch.setattr("takagi.reports.margins.running_stability.linearised_loop", no_rest)
    with pytest.raises(
        ModelError, match="3 to 25 m/s .* at no wind, so its stability is not known"
    ):
        require_stable(TURBINE, default_settings(TURBINE))


def test_a_torsion_mode_far_below_the_one_of_the_defaults_is_refused() -> None:
    """The band-stop is left at 9.3 rad/s, and the mode is at 1.5 rad/s."""
    assert TURBINE.torsion is not None
    soft = replace(TURBINE, torsion=replace(TURBINE.torsion, frequency=1.5))

    found = unstable_loop(soft, default_settings(TURBINE))

    assert found is not None and not found.by_filter
    assert "at 3 m/s" in found.reason and "the torsion mode, 1.5 rad/s" in found.reason


def test_a_law_for_a_lidar_is_noted() -> None:
    """With 0.05 s it oscillates in OpenFAST with an estimate from speed, see docs/laws.md."""
    notes = require_stable(TURBINE, replace(default_settings(TURBINE), wind_filter=0.05))

    assert len(notes) == 1
    assert "the wind filter of 0.05 s does it, 12 s does not" in notes[0]
    assert "a wind that is measured" in notes[0]


def test_the_filter_is_no_excuse_for_a_soft_tower() -> None:
    """With the default filter this loop is unstable too."""
    soft = with_tower(0.48)

    with pytest.raises(ModelError, match="is unstable"):
        require_stable(soft, replace(default_settings(soft), wind_filter=0.05))


def test_takagi_design_ends_before_the_proof(tmp_path: Path) -> None:
    data = Path(resolve_model("nrel5mw")).parent
    for table in data.glob("nrel5mw_*.csv"):
        (tmp_path / table.name).write_bytes(table.read_bytes())
    text = (data / "nrel5mw.toml").read_text().replace("value = 1.81e6,", "value = 1e5,")
    (tmp_path / "soft.toml").write_text(text)
    told: list[str] = []

    def tell(step: str, done: float | None = None) -> None:
        told.append(step)

    found = makers.maker_of(
        str(tmp_path / "soft.toml"), given.defaults_of(makers.DESIGN_OPTIONS)
    ).design(tell)

    assert isinstance(found, design.NoDesign) and "the tower mode, 0.479 rad/s" in found.reason
    assert told == ["stability of the loop that runs"]
