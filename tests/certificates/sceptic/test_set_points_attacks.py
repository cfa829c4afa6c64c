"""Forged certificates of ``set-points``; its brackets beside floats, its boxes and the program."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.controller.effort_sharing_program import effort_sharing_program
from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.effort_sharing.set_points import Cell, CellLoop, covers
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.models import nrel5mw
from takagi.models.turbine.data import rotor_torque
from tests.certificates.kinds.claims import Data
from tests.certificates.recorded.answers import recorded

PROVED = next(text for answer, text in recorded("set-points") if answer[0] == ["PROVED"])
RATED_TORQUE = 43093.55


def test_nested_boxes_are_answered_at_once() -> None:
    """Cut along their faces, the region would fall into a hundred thousand parts."""
    spans = [(Fraction(k, 60), 1 - Fraction(k, 60)) for k in range(29, 0, -1)]
    unit = Fraction(0), Fraction(1)
    assert not covers([*((span,) * 3 for span in spans), (unit,) * 3], (unit,) * 3)


def test_the_bracket_of_the_torque_balance_holds_it() -> None:
    """With columns that all rise or fall over the wind, unlike those of the recorded law."""
    rng, turbine = np.random.default_rng(2), nrel5mw()
    data = read_text(PROVED, "test")
    plant, law = Plant.read(data["model"]), Law.read(data["gains"])
    assert law.setpoints is not None
    slanted = replace(
        law, speed=[Fraction(n, 100) for n in (121, 124, 122, 127)],
        effectiveness=[Fraction(n, 100) for n in (50, 60, 45, 58)],
    )  # fmt: skip
    efforts = replace(law.setpoints, speed_effort=[Fraction(n, 10) for n in (-2, 3, -1, 1)])
    nodes, columns = (
        np.array(law.wind, dtype=float),
        (slanted.speed, law.effort, slanted.effectiveness, efforts.speed_effort),
    )
    for raw in data["claims"][0]["cells"]:
        cell = Cell.read(raw, "cell")
        loop = CellLoop(plant, slanted, efforts, cell)
        for shift in cell.shifts:
            bracket = [end / ONE for end in loop.excess(shift)]
            for _ in range(20):
                v, r, torque = (
                    rng.choice([*s, rng.uniform(*s)]) for s in np.array(cell.box, dtype=float)
                )
                speed, rest, b, s = (np.interp(v, nodes, np.array(c, dtype=float)) for c in columns)
                E, eps = float(law.effort_torque), float(law.overlap)
                U = rest + s * r + (RATED_TORQUE - torque) / E + float(shift)
                shed = U if U > eps else max(U + eps, 0.0) ** 2 / (4 * eps)
                balance = rotor_torque(turbine, speed + r, shed / b, v)
                balance -= turbine.gear_ratio * (torque - E * (shed - U))
                excess = float(balance) / turbine.inertia
                assert bracket[0] - 1e-9 <= excess <= bracket[1] + 1e-9


def test_each_input_of_the_program_lies_in_a_cell() -> None:
    document = json.loads(PROVED)
    gains, cells = document["gains"], document["claims"][0]["cells"]
    steps = {s["set"]: s["formula"] for s in effort_sharing_program(gains)["steps"]}
    names: Data = {"limit": lambda x, a, b: min(max(x, a), b), "line": np.interp, "min": min}
    names |= {"last": lambda row: row[-1], **gains, **gains["setpoints"]}
    for speed in (-1e9, 0.0, 1.22, 1.25, gains["rotor_speed"][-1], 1e9):
        for power in (-1e12, 0.0, 4.6e6, 4.8e6, 5e6, 1e12):
            for v in np.linspace(gains["wind"][0], gains["wind"][-1], 7):
                names |= {"speed_setpoint": speed, "power_setpoint": power, "v_s": v}
                for name in ("speed_most", "torque_setpoint", "reduction"):
                    names[name] = eval(steps[name], {"__builtins__": {}}, names)
                point = {"wind": v, "reduction": names["reduction"],
                         "torque": names["torque_setpoint"]}  # fmt: skip
                assert any(
                    all(c[n][0] - 1e-12 <= x <= c[n][1] + 1e-12 for n, x in point.items())
                    for c in cells
                )
