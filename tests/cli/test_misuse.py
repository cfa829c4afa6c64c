"""Misuse of the verbs: one message that names what was given and what is needed, and no file."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from takagi.cli.main import main
from tests.cli.cubic import CUBIC, NOISY_ROD, ROD

PLANTS = {"cubic.toml": CUBIC, "noisy.toml": NOISY_ROD, "rod.toml": ROD}
# Verb and model, then options => what the message has, several texts between ampersands.
MISUSE = """
design nrel5mw
    --overlap -1 => option --overlap: -1 was given; it must be positive
    --bandwidth 0 => option --bandwidth: 0 was given; it must be positive
    --bandwidth inf => option --bandwidth: inf was given
    --bandwidth nan => option --bandwidth: nan was given
    --bandwidth 1e9 => at most 5 1/s is needed, the rate of the pitch drive
    --overlap nan => option --overlap: nan was given; it must be positive
    --overlap 0.2 => below 0.09547 rad/s^2 is needed
    --law paper --torque-overlap 9000 => at most 8618.72 N m is needed
    --law paper --speed-overlap 5 => at every wind from 3 m/s on; try 0.11
    --law paper --speed-overlap 0.6 --ramp-placement 0.99 => pitch acts fully at no speed
    --law paper --ramp-placement 1 => no equilibrium at 11.45 to 25 m/s
    --law papr => choose one of coherent, paper
    --law paper --overlap 0.1 => option --overlap belongs to the effort-sharing law
    --speed-overlap 0.1 => option --speed-overlap belongs to Schulte's law
    --speed-setpoint 1.2 => a number with its unit is needed
    --speed-setpoint 11knots => unit 'knots' is not known
    --speed-setpoint 5rpm => it must lie above the minimum 0.723322
    --speed-setpoint '20 rpm' => at or below the rated 1.26711 rad/s
    --inertia 1.2 0.8 => lower end 1.2 exceeds upper end 0.8
    --inertia 1.1 1.3 => 0 < LOW <= 1 <= HIGH is needed
    --inertia half 2 => a finite number is needed
    --bandwidth-growth 20 => bandwidth growth 20 was given
    --bandwidth-growth -1 => option --bandwidth-growth: -1 was given
    --objective decya => did you mean 'decay'
    --objective decay --two-step => leave one of the two out
    --one-step --two-step => leave one of the two out
    --two-step --law paper => --two-step belongs to the effort-sharing law
    --damping 0.7 => --damping is about a plant
design nrel5wm
    => did you mean 'nrel5mw'?
design no.toml
    => no.toml: no such file; check the path
certify noisy.toml
    --noise gust=1 => horizon is missing
    --horizon 10s => noise is missing
    --noise dust=1 --horizon 10s => there is no dust
    --noise gust=-1 --horizon 10s => positive
    --noise gust=1 --horizon 10m => no unit of time
    --noise flow=1 --horizon 10s => has a range
certify rod.toml
    --sample-time soon => a time such as 10ms is needed
    --sample-time 3kg => is no unit of time
    --sample-time -1ms => a positive number is needed
    --tolerance=x => --tolerance
    '--tolerance=5 %%' => --tolerance
    --tolerance=-1% => --tolerance
    --tolerance=1/3 => --tolerance
    --tolerance=1e9 => --tolerance
    --tolerance=101% => --tolerance
    --tolerance=nan => --tolerance
    --tolerance= => --tolerance
certify nrel5mw
    --sample-time 10ms => --sample-time is about a plant
    --gains no.json --bandwidth 0.4 => --bandwidth is about designing gains
    --gains rod.toml => not JSON
    --gains no.json => cannot be read
sweep cart_pole
    --law effort-sharing --over overlap=0.01 => model cart_pole is a plant
sweep nrel5mw
    --law papr --over overlap=0.01 => --law papr & effort-sharing, schulte
    --law effort-sharing => no axis was given: add --over & overlap, bandwidth
    --law effort-sharing --over inertia=0.1,0.95 => at most 0.9
    --over z=1 => 'z' cannot be swept & speed-overlap [rad/s] & wind [m/s]
    --over wind=2,8 => 2 m/s was given & from 3 to 24.996 m/s
    --law effort-sharing --over overlap=0.01 --workers 0 => at least 1
tune nrel5mw
    --require energy => limit
    --require 'energy <= 1 %' => energy takes >=
    --require 'recovery 30 %' => recovery takes <=
    --require 'tower-del 0.9 s' => no unit
    --require 'recovery 30s, recovery 20s' => twice
    --require 'recovry 30s' => recovery
study overlap cart_pole
    => model cart_pole is a plant
study overlp nrel5mw
    => 'overlp' is not a study (did you mean 'overlap'?)
study controllers nrel5mw
    --law efort-sharing => did you mean 'effort-sharing'
    --winds 8,26 => 26 m/s was given & from 3 to 25 m/s
    --winds eight => --winds eight & 8,12,16
    --seeds 0 => 0 seeds & at least 1 seed
    --duration 5 => duration of 5 s & 10 s are needed
    --weibull 8.5 => MEAN:SHAPE is needed
    --workers 1 --scheduler tcp://127.0.0.1:1 => leave --workers out
study overlap nrel5mw
    --over speed-overlap=0.7 => begin below the smallest speed & every wind from 3
    --over torque-overlap=9kNm => at most 8618 & at rated wind
    --over overlap=0 => overlap must be above 0
    --over bandwidth=1 => cannot be swept & centred-overlap [rad/s]
    --over wind=8,26 => 26 m/s was given & from 3 to 25 m/s
    --seeds 0 => 0 seeds & at least 1 seed
    --duration 5 => duration of 5 s & 10 s are needed
    --workers 1 --scheduler tcp://127.0.0.1:1 => leave --workers out
simulate nrel5mw
    --law coherrent => did you mean 'coherent'
    --duration -5 => above 0
    --duration nan => above 0
    --duration 1e9 => at most 3600
    --wind gust --duration 5 => longer duration
    --duration soon => a valid number
    --wind storm => paper, step, ramp, gust, coherent
    --wind turbulant:9 => did you mean 'turbulent'
    --wind 26 => runs from 3 to 25 m/s
    --wind turbulent:9:D => A, B and C
    --wind turbulent:9:B:-1 => '-1' is SEED
    --wind turbulent:9:B:6-1 => seeds from 6 to 1
    --wind step:9 => written step:FROM:TO
    --wind gust:fast => 'fast' is MEAN; a number
    --wind missing.csv => missing.csv
    --wind README.md => wind.csv
    --wake none => equilibrium, dynamic
    --without towr => did you mean 'tower'
    --speed-filter -1 => speed_filter = -1
    --ripple 3 => 0 to 0.2 of the wind
    --wind step --wind 9 --seed 1 => step, 9 has no turbulence
    --seed -1 => 0 or more
    --law baseline --sample-time 0 => sample time 0 s was given; 0.001 to 1 s
    --law baseline --sample-time nan => option --sample-time: 'nan' was given
    --law baseline --computation-time 0.03 => 0 up to the sample time
    --law baseline --computation-time 0.0037177 => a simple fraction of the sample time
    --law-from nowhere.json => nowhere.json: cannot be read
    --start x=1 => --start is about a plant
    --disturbance 'w=step 1 at 1s' => --disturbance is about a plant
    --law baseline --sample-time 1h => sample time 3600 s
design cubic.toml
    --time=0s => a time above 0 is needed
    --time=-5min => a time above 0 is needed
    --time=60 => a number with a unit is needed
    --time=soon => a number with a unit is needed
    --time=1e999s => --time 1e999s
    --time=3kg => is no unit of time
    --overlap 1 => --overlap is about a wind turbine
    --law paper => --law is about a wind turbine
    --law coherent => a plant's law is by rules: --relaxation and [design] of its file
    --decay-rate fast => a number in 1/s
    --decay-rate -1 => option --decay-rate
    --decay-rate max => give gain_bound
    --relaxation tuam => tuam
    --choice few => option --choice
    --damping 1.5 => option --damping
    --input-limit x=1 => there is no x
    --initial y=1 => there is no y
certify cubic.toml
    --gains none.json --law coherent => --law is about a wind turbine
    --gains no.json --decay-rate 1 => option --decay-rate is about designing gains
    --gains no.json --damping 0.5 => option --damping is about designing gains
    --gains no.json --input-limit u=1 => option --input-limit is about designing gains
    --gains no.json --gain-bound 4 => option --gain-bound is about designing gains
    --gains no.json --initial x=1 => option --initial is about designing gains
    --gains-out g.json => --gains-out writes the file of --gains anew
    --inertia 0.9 1.1 => about a wind turbine
simulate truck_trailer
    --sample-time 1s => its law runs every 2 s already
simulate cubic.toml
    --wind gust => --wind is about a wind turbine
    --start y=1 => option --start: there is no y; the plant has x
    --start x => NAME=VALUE is needed
    --start x=1kg => option --start x=1kg
    --duration -1 => option --duration: -1 was given
    --gains no.json => no.json
tune nrel5mw
    --tries 3 => Error
    --workers 1 --minimise towerdel => Error
    --workers 1 --seeds 0 => Error
tune cart_pole
    --workers 1 => Error
"""


def misuses() -> Iterator[tuple[str, str]]:
    verb = ""
    for line in MISUSE.strip().splitlines():
        options, _, words = line.strip().partition("=> ")
        if words:
            yield f"{verb} {options}", words
        else:
            verb = line


@pytest.mark.parametrize(("command", "words"), tuple(misuses()))
def test_misuse_is_one_message_and_writes_nothing(
    command: str, words: str, tmp_path: Path, monkeypatch: Any, capsys: Any
) -> None:
    """Status 2, before the long work."""
    for name, text in PLANTS.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("takagi.certificates.design.turbine.design.design_turbine", None)

    assert main([*shlex.split(command), "--out", "out"]) == 2

    captured = capsys.readouterr()
    message = " ".join(captured.err.split())
    assert captured.out == "" and "Error: " in message and "Traceback" not in message
    assert all(word in message for word in words.split(" & ")), message
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(PLANTS)
