"""`takagi check --margins`: what is asked, and both sides of a threshold."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from takagi.cli import main as command
from takagi.models import ModelError
from takagi.models.files.library import data_folder
from takagi.reports.margins.running_loop import RunningLoops
from takagi.reports.margins.running_over_wind import (
    Mode,
    RunningMargins,
    searched_margins,
    wind_ranges,
    winds_between,
    worst_of_sides,
)
from takagi.reports.margins.thresholds import AskedMargins, asked_margins, failed, measured
from tests.reports.margin_rows import margin_row

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

Capture = pytest.CaptureFixture[str]


def row(wind: float, gain: float, alpha: float = 0.8, **changed: Any) -> RunningMargins:
    """A wind whose torque loop may grow by ``gain``, with a phase margin of 60 deg and 0.5 s."""
    return margin_row(wind, "torque", gain, alpha, **changed)


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("gain 2", {"gain": 2.0}),
        ("gain 6.0206dB", {"gain": 2.0}),
        ("gain 2, phase 30deg,delay 100 ms", {"gain": 2.0, "phase": math.pi / 6, "delay": 0.1}),
        (
            "disk 0.5, sample 10ms, computing 0.005s",
            {"disk": 0.5, "sample": 0.01, "computing": 0.005},
        ),
        ("phase 0.5rad, computing 0s", {"phase": 0.5}),
    ],
)
def test_what_is_asked_is_read(written: str, expected: dict[str, float]) -> None:
    found = asdict(asked_margins(written))
    assert found == pytest.approx({**asdict(AskedMargins()), **expected}, rel=1e-5)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ("gan 2", "did you mean 'gain'"),
        ("gain", "a name, a number and its unit"),
        ("gain 2deg", "gain needs no unit or dB"),
        ("phase 30", "phase needs deg"),
        ("gain 0.5", "gain must lie above 1"),
        ("gain 1..5", "no number"),
        ("delay 0s", "delay must lie above 0"),
        ("disk 2", "no loop has"),
        ("gain 2, gain 3", "given twice"),
        ("sample 10ms", "asks for none"),
        ("", "a name, a number and its unit"),
    ],
)
def test_what_says_nothing_is_refused(written: str, words: str) -> None:
    with pytest.raises(ModelError, match=words):
        asked_margins(written)


def test_a_threshold_has_two_sides() -> None:
    rows = [row(9.0, 2.5), row(11.0, 2.01), row(12.0, 3.0)]
    assert failed(rows, AskedMargins(gain=2.01)) == ()
    assert failed(rows, AskedMargins(gain=2.02)) == (
        "at 11 m/s the gain margin of torque is 2.01, 2.02 is asked; missed at 11 m/s",
    )
    (text,) = failed(rows, AskedMargins(gain=2.6))
    assert text.endswith("missed at 9 to 11 m/s")


@pytest.mark.parametrize(
    ("asked", "passes"),
    [
        (AskedMargins(phase=math.radians(59)), True),
        (AskedMargins(phase=math.radians(61)), False),
        (AskedMargins(delay=0.4999), True),
        (AskedMargins(delay=0.5001), False),
        (AskedMargins(disk=0.79), True),
        (AskedMargins(disk=0.81), False),
    ],
)
def test_each_margin_has_its_own_threshold(asked: AskedMargins, passes: bool) -> None:
    assert (failed([row(9.0, 2.5)], asked) == ()) is passes


def test_the_loop_with_the_least_margin_counts() -> None:
    one = row(14.0, 5.0)
    assert one.torque is not None
    both = replace(one, pitch=replace(one.torque, gain_increase=3.0, phase=math.radians(40)))
    (text,) = failed([both], AskedMargins(gain=4))
    assert "the gain margin of pitch is 3, 4 is asked" in text
    (text,) = failed([both], AskedMargins(phase=math.radians(50)))
    assert "the phase margin of pitch is 40 deg" in text
    # A gain that must not fall counts, too.
    low = replace(one, torque=replace(one.torque, gain_decrease=0.8))
    (text,) = failed([low], AskedMargins(gain=1.5))
    assert "the gain margin of torque is 1.25" in text


def test_at_a_kink_every_margin_is_that_of_its_worse_side() -> None:
    """The side with the smaller disk may have the larger gain margin."""
    left, right = row(4.0, 7.2, 0.81), row(4.0, 5.5, 0.82, decay_rate=0.05)
    assert left.torque is not None
    left = replace(left, torque=replace(left.torque, phase=0.9))
    for sides in ([left, right], [right, left]):
        worst = worst_of_sides(sides)
        assert worst.torque is not None
        assert (worst.torque.gain_increase, worst.torque.phase) == (5.5, 0.9)
        assert (worst.both.alpha, worst.decay_rate, worst.pitch) == (0.81, 0.05, None)


def test_the_plant_and_an_unstable_loop_are_named() -> None:
    bad = row(11.0, 1.0, 0.0, inertia=0.9, wake="frozen", decay_rate=-0.1)
    (text,) = failed([row(9.0, 2.5), bad], AskedMargins(disk=0.3))
    assert text.startswith(
        "at 11 m/s (inertia 0.9 of nominal, frozen wake, where the loop is unstable) the disk "
        "margin of torque and pitch is 0, 0.3 is asked"
    )


def test_what_was_measured_says_that_it_is_not_proved_and_names_modes() -> None:
    torsion = (("torque", Mode("torsion", 10.3)),)
    first, second = measured(
        [row(9.0, 2.5), row(11.0, 2.0, modes_met=torsion)], AskedMargins(gain=1.5), "gains.json"
    )
    assert "least gain 2 (torque, 11 m/s), phase 60 deg" in first
    assert first.endswith("measured, not proved")
    assert "the torsion mode (1.64 Hz) lies inside the crossover of the torque loop at 11 m/s" in (
        second
    )


def test_winds_are_multiples_of_a_step_and_neighbours_are_a_range() -> None:
    assert winds_between(3.5, 6.2, 1.0) == (3.5, 4.0, 5.0, 6.0, 6.2)
    assert winds_between(3.0, 3.3, 0.1) == (3.0, 3.1, 3.2, 3.3)
    every = [3.0, 4.0, 5.0, 6.0, 7.0]
    assert wind_ranges([4.0], every) == "4 m/s"
    assert wind_ranges([3.0, 4.0, 6.0], every) == "3 to 4 and 6 m/s"
    assert wind_ranges([3.0, 5.0, 7.0], every) == "3, 5 and 7 m/s"


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--margins", "gain 2"], "--margins needs --gains FILE and --model FILE"),
        (["--model", "m.toml", "--margins", "gan 2"], "'gan' is not known"),
    ],
)
def test_what_is_asked_wrongly_is_refused_before_the_check(
    more: list[str], words: str, capsys: Capture
) -> None:
    assert command.main(["check", "none.json", "--gains", "g.json", *more]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.slow
def test_the_default_law_has_margins_and_not_any(
    turbine_design: TurbineDesign,
    tmp_path: Path,
    capsys: Capture,
    monkeypatch: pytest.MonkeyPatch,
    reduced: bool,
) -> None:
    """The NREL 5-MW default: PROVED, status 1 above a margin; every 4 m/s where reduced."""
    from takagi.certificates.document.certificate_file import dumps
    from takagi.reports.gains_file.envelope import dump_gains, gain_file

    found: dict[float, Any] = {}

    def once(loops: RunningLoops) -> Any:
        time = loops.program.computation_time
        if time not in found:
            found[time] = searched_margins(loops)
        return found[time]

    monkeypatch.setattr("takagi.reports.simulation.measured_loop.searched_margins", once)
    if reduced:
        monkeypatch.setattr("takagi.reports.margins.running_over_wind.FINE", 4.0)

    gains, certificate = tmp_path / "gains.json", tmp_path / "certificate.json"
    gains.write_text(dump_gains(gain_file(turbine_design)), encoding="utf-8")
    certificate.write_text(dumps(turbine_design.document), encoding="utf-8")
    summary, junit = tmp_path / "s.md", tmp_path / "j.xml"
    base = ["check", str(certificate), "--gains", str(gains)]
    base += ["--model", str(data_folder() / "nrel5mw.toml")]
    base += ["--summary", str(summary), "--junit", str(junit)]

    assert command.main([*base, "--margins", "gain 1.15, phase 20deg, delay 0.1s, disk 0.15"]) == 0
    told = capsys.readouterr().out
    assert "PROVED" in told and "measured, not proved" in told
    assert "measured, not proved" in summary.read_text(encoding="utf-8")

    assert command.main([*base, "--margins", "gain 1.15, delay 0.2s"]) == 1
    told = capsys.readouterr().out
    assert "PROVED" in told
    assert "the delay margin of torque is 0.1" in told
    assert "gain margin" not in told and "margins grow with a smaller --bandwidth" in told
    assert "the loop that runs has the margins asked" in junit.read_text(encoding="utf-8")

    # With a low-pass of 8 rad/s and no band-stop, a whole sample of computation lost the
    # drivetrain's torsion near rated wind.
    assert command.main([*base, "--margins", "gain 1.15, delay 0.1s, computing 20ms"]) == 0
    assert command.main([*base, "--margins", "gain 1.15, delay 0.18s, computing 20ms"]) == 1
    assert "0.18 s is asked" in capsys.readouterr().out
    assert sorted(found) == [0.0, 0.02]
