"""How wrong an actuator may be: proved up to a point, and a motion that leaves beyond it.

x' = a x + U with a = 1 under U' = -k1 x - k2 U: with an actuator that moves the plant 1 + delta
times as much as told, s^2 + (k2 - a) s + (1 + delta) k1 - a k2 is stable exactly where
(1 + delta) k1 > a k2.  For k1 = 40, k2 = 20 that is delta > -1/2.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from takagi.certificates import Verdict
from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.arrays import Floats
from takagi.models.blending.blending import RunTimeBlending, blending_of
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_simulation.runs import COMPLETE, ExperimentRun, run
from takagi.reports.loops.plant_loop import PlantLoop, plant_loop
from takagi.reports.loops.plant_motion import Outside, experiment_of
from tests.models.blending.plants import plant_of

GAINS = [[40.0, 20.0]]


def certified(folder: Path, error: str) -> PlantDesign:
    plant = plant_of(
        folder,
        a="a = { value = 0.5 } -> a = { value = 1 }",
        b=", error = 0.1 -> ",
        c="error = 0.2 -> error = " + error,
        d=", rate = 20 -> ",
    )
    return certify_plant(plant, lambda m: np.array([GAINS] * len(m.A)), PlantSettings())


def with_error(loop: PlantLoop, error: float, start: Floats, duration: float) -> ExperimentRun:
    """Return a motion whose heating moves the plant 1 + error times as much as told."""
    blending = blending_of(loop.plant)
    assert blending is not None
    rate = RunTimeBlending(blending, {"heating": error}).disturbed_rate((), told=False)
    return run(replace(experiment_of(loop, Outside()), rate=rate), start, duration)


def test_up_to_the_threshold_decay_is_proved(tmp_path: Path) -> None:
    """45 % of 50 %: the motions with either error come to rest too."""
    design = certified(tmp_path, "0.45")
    loop = plant_loop(design)

    assert design.verdict is Verdict.PROVED
    for error in (-0.45, 0.0, 0.45):
        motion = with_error(loop, error, np.array([-0.05, 0.3]), 40.0)
        assert motion.ended == COMPLETE
        assert abs(motion.state[-1]).max() < 1e-3


def test_beyond_it_decay_is_refuted_and_a_motion_leaves(tmp_path: Path) -> None:
    """55 %: at -55 %, heated alone, the loop has a root at +0.1; from far enough it drifts away.

    Nearer to rest cooling, which does as it is told, still has its share.
    """
    design = certified(tmp_path, "0.55")
    loop = plant_loop(design)

    kinds = [claim["kind"] for claim in design.document["claims"]]
    assert kinds == ["sector-embedding", "effort-blend", "no-common-decay"]
    assert design.verdict is Verdict.DISPROVED
    start = np.array([-0.9, 1.79])
    motion = with_error(loop, -0.55, start, 60.0)
    assert abs(motion.state[-1, 0]) > 1.0  # outside the box
    sure = with_error(loop, 0.0, start, 60.0)
    assert abs(sure.state[-1, 0]) < 1e-3
