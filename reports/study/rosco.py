"""ROSCO's library (NREL) around the validation plant, through the interface that OpenFAST uses.

The library is called every 20 ms with what a turbine measures: speeds of generator and rotor,
pitch, torque and power of the generator, wind at the hub, acceleration of the tower's top.  Its
commands pass the plant's own limits and drive, as those of all laws do.

A tuning is the text of a ``DISCON.IN`` with its rotor tables: that of the package for the NREL 5-MW
turbine, one of a file, or one that ROSCO's toolbox makes from the turbine's figures here.

The library has global state, so every run loads a copy of its own.

Sources: Abbas et al. (2022), A reference open-source controller for fixed and floating offshore
wind turbines, Wind Energy Science 7; the interface is that of OpenFAST's Bladed-style controllers.
"""

from __future__ import annotations

import ctypes
import importlib.util
import io
import os
import re
import shutil
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from math import degrees, isfinite
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from takagi.models.errors import ModelError
from takagi.models.simulation.closed_loop import (
    TIME_STEP,
    Diverged,
    History,
    Record,
    history_of,
    limit_torque,
    plant_step,
    step_counts,
)
from takagi.models.simulation.turbine_plant import SimulatedTurbine, advance
from takagi.models.simulation.wind import WindSeries
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind

PACKAGE = "rosco"
NEEDED = "ROSCO is not installed: pip install 'takagi[compare]'"
# Of the package's own examples: where the tuning of a turbine is, by the name in its file here.
SHIPPED = {"NREL 5-MW": "NREL-5MW"}
# Bandwidth [rad/s] and damping of the pitch loop; the package has 0.6 and 0.7 for the NREL 5-MW,
# which shakes the tower of an aeroelastic code near rated wind (docs/openfast.md).
RETUNED = (0.3, 1.0)
# Of the torque loop, and the share of the largest thrust that peak shaving leaves: the package's.
TORQUE_LOOP, SHAVED = (0.15, 0.7), 0.8
# What a plant with one pitch, one wind and no sea has no use for, or has no sensor of.
NOT_HERE = (
    *("IPC_ControlMode", "Y_ControlMode", "Fl_Mode", "Flp_Mode", "OL_Mode", "Ext_Mode"),
    *("ZMQ_Mode", "CC_Mode", "StC_Mode", "SU_Mode", "SD_Mode"),
)
# Records of the interface, counted from 1, and how many OpenFAST passes.
RECORDS = 3300
(STATUS, TIME, STEP, PITCH, SHAFT_POWER, POWER, GENERATOR, ROTOR, TORQUE, WIND, INDIVIDUAL) = (
    *(1, 2, 3, 4, 14, 15, 20, 21, 23, 27, 28),
)
MESSAGE, INPUT, OUTPUT, LENGTH, TOP, BLADES = 49, 50, 51, 52, 53, 61
PITCH_ASKED, TORQUE_ASKED = 42, 47


@dataclass(frozen=True, slots=True)
class Tuning:
    """A ``DISCON.IN`` and the rotor tables that it names, as texts."""

    discon: str
    tables: str

    def without_shaving(self) -> Tuning:
        """Return the tuning with its pitch free to be the smallest."""
        return Tuning(_set(self.discon, "PS_Mode", "0"), self.tables)


def require_rosco() -> None:
    """Raise a ModelError that says what to install if the package is not there."""
    if importlib.util.find_spec(PACKAGE) is None:
        raise ModelError(NEEDED)


def library_path() -> Path:
    """Return the place of the package's library; ModelError without it."""
    require_rosco()
    import rosco

    return Path(rosco.discon_lib_path)


def shipped_tuning(turbine: Turbine) -> Tuning:
    """Return the package's tuning of a turbine; ModelError if it has none."""
    if turbine.name not in SHIPPED:
        raise ModelError(
            f"ROSCO's package has no tuning of {turbine.name} that is known here (known: "
            f"{', '.join(SHIPPED)}); give a file as --rosco NAME=DISCON.IN, or take retuned"
        )
    examples = library_path().parents[2] / "Examples" / "Test_Cases"
    return filed_tuning(examples / SHIPPED[turbine.name] / "DISCON.IN")


def filed_tuning(path: Path) -> Tuning:
    """Return the tuning of a ``DISCON.IN``.

    Raises
    ------
    ModelError : a file that cannot be read, that names no tables, or that needs what the plant does
        not have.
    """
    try:
        discon = path.read_text(encoding="utf-8", errors="replace")
        named = _value(discon, "PerfFileName")
        if named is None:
            raise ModelError(f"{path} names no rotor tables (PerfFileName); it is no DISCON.IN")
        for flag in NOT_HERE:
            if (_value(discon, flag) or "0") != "0":
                raise ModelError(
                    f"{path}: {flag} is {_value(discon, flag)}; the validation plant has no part "
                    "for it, so 0 is needed"
                )
        tables = (path.parent / named.strip("\"'")).read_text(encoding="utf-8")
    except OSError as error:
        raise ModelError(f"{error.filename}: {error.strerror}") from error
    return Tuning(discon, tables)


def retuned(turbine: Turbine, bandwidth: float, damping: float) -> Tuning:
    """Return what ROSCO's toolbox makes of the turbine's figures and coefficient tables.

    Parameters
    ----------
    bandwidth : of the pitch loop [rad/s];  damping : of it [-].

    Raises
    ------
    ModelError : the package is missing.
    """
    require_rosco()
    # The toolbox's libraries warn of their own future, and it prints what it does.
    with warnings.catch_warnings(), redirect_stdout(io.StringIO()), TemporaryDirectory() as folder:
        warnings.simplefilter("ignore")
        try:
            from rosco.toolbox import controller, utilities
            from rosco.toolbox import turbine as described
            from rosco.toolbox.inputs.validation import load_rosco_yaml
        except ImportError as error:
            raise ModelError(f"ROSCO's toolbox cannot be used ({error}); {NEEDED}") from error
        asked = load_rosco_yaml(_parameters(turbine, bandwidth, damping))
        machine = described.Turbine(asked["turbine_params"])
        _describe(machine, described.RotorPerformance, turbine)
        law = controller.Controller(asked["controller_params"])
        law.tune_controller(machine)
        files = Path(folder) / "DISCON.IN", Path(folder) / "tables.txt"
        utilities.write_rotor_performance(machine, txt_filename=str(files[1]))
        utilities.write_DISCON(machine, law, str(files[0]), txt_filename=files[1].name)
        discon, tables = (file.read_text(encoding="utf-8") for file in files)
    # The dates in the heads would make every day's tuning another one.
    return Tuning(
        *(re.sub(r"on \S+( using.*)?\n", "\n", text, count=1) for text in (discon, tables))
    )


def _parameters(turbine: Turbine, bandwidth: float, damping: float) -> dict[str, Any]:
    return {
        "path_params": dict.fromkeys(
            ("FAST_InputFile", "FAST_directory", "rotor_performance_filename"), ""
        ),
        "turbine_params": {
            "rotor_inertia": turbine.rotor_inertia,
            "rated_rotor_speed": turbine.rated_rotor_speed,
            "v_min": turbine.cut_in,
            "v_rated": float(rated_wind(turbine)),
            "v_max": turbine.cut_out,
            "max_pitch_rate": turbine.pitch_rate_limit,
            "max_torque_rate": turbine.torque_rate_limit,
            "rated_power": turbine.rated_power,
            # The toolbox sets its low-pass to a quarter of this.
            "bld_edgewise_freq": 4 * turbine.speed_filter,
            "bld_flapwise_freq": turbine.flap.frequency if turbine.flap else 0.0,
        },
        "controller_params": {
            "LoggingLevel": 0,
            "F_LPFType": 1, "VS_ControlMode": 2, "VS_ConstPower": 1, "PC_ControlMode": 1,
            "SS_Mode": 1, "WE_Mode": 2, "PS_Mode": 1, "ps_percent": SHAVED,
            "min_pitch": turbine.pitch_min, "max_pitch": turbine.pitch_max,
            "zeta_pc": damping, "omega_pc": bandwidth,
            "omega_vs": TORQUE_LOOP[0], "zeta_vs": TORQUE_LOOP[1],
            "max_torque_factor": turbine.maximum_torque / turbine.rated_torque,
        },
    }  # fmt: skip


def _describe(machine: Any, performance: Any, turbine: Turbine) -> None:
    """Give the toolbox's turbine what it would read from a model of OpenFAST."""
    low, high = turbine.torque.y_range
    least, most = turbine.torque.x_range
    pitch = np.radians(np.arange(np.ceil(degrees(low)), np.floor(degrees(high)) + 0.5))
    ratio = np.arange(least, most + 0.01, 0.5)
    grid = np.meshgrid(ratio, pitch, indexing="ij")
    moment, thrust = np.asarray(turbine.torque(*grid)), np.asarray(turbine.thrust(*grid))
    machine.TurbineName = turbine.name
    machine.rotor_radius = machine.TipRad = turbine.rotor_radius
    machine.rho, machine.Ng, machine.NumBl = turbine.air_density, turbine.gear_ratio, 3
    machine.hubHt = machine.TowerHt = turbine.hub_height
    machine.GenEff, machine.GBoxEff = 100 * turbine.generator_efficiency, 100.0
    machine.generator_inertia, machine.J = turbine.generator_inertia, turbine.inertia
    machine.rated_torque = turbine.rated_torque
    machine.pitch_initial_rad, machine.TSR_initial = pitch, ratio
    for name, table in (("Cp", moment * grid[0]), ("Ct", thrust), ("Cq", moment)):
        setattr(machine, f"{name}_table", table)
        setattr(machine, name, performance(table, pitch, ratio))
    machine.TSR_operational = machine.TSR_operational or machine.Cp.TSR_opt
    machine.Cp_operational = machine.Cp.interp_surface(
        machine.Cp.pitch_opt, machine.TSR_operational
    )


def _value(discon: str, name: str) -> str | None:
    at = re.search(rf"^\s*(\S+)[^!\n]*!\s*{name}\b", discon, flags=re.MULTILINE)
    return at[1] if at else None


def _set(discon: str, name: str, value: str) -> str:
    return re.sub(rf"^\s*\S+([^!\n]*!\s*{name}\b)", rf"{value}\1", discon, flags=re.MULTILINE)


class Controller:
    """The library, started with a tuning; ``step`` after ``step`` it keeps its own states."""

    def __init__(self, discon: Any, file: Path, start: Mapping[int, float], period: float) -> None:
        """Start the library at the first measurements; ModelError if it refuses."""
        self._call, self._records = discon, (ctypes.c_float * RECORDS)()
        self._failed, self._message = ctypes.c_int32(0), ctypes.create_string_buffer(1000)
        self._file, self._root = str(file).encode(), str(file.parent / "run").encode()
        fixed = {
            STEP: period, INDIVIDUAL: 1, BLADES: 3, MESSAGE: 500, INPUT: len(self._file) + 1,
            OUTPUT: len(self._root) + 1, LENGTH: 500,
        }  # fmt: skip
        for record, value in fixed.items():
            self._records[record - 1] = value
        self.step({STATUS: 0, **start})
        self._records[STATUS - 1] = 1

    def step(self, measured: Mapping[int, float]) -> tuple[float, float]:
        """Return torque [N m] and pitch [rad] that the library wants at these measurements."""
        records = self._records
        for record, value in measured.items():
            records[record - 1] = value
        pitch = measured[PITCH]
        records[32] = records[33] = pitch
        failed = ctypes.byref(self._failed)
        self._call(records, failed, self._file, self._root, self._message)
        if self._failed.value < 0:
            raise ModelError(f"ROSCO refuses: {self._message.value.decode(errors='replace')}")
        return float(records[TORQUE_ASKED - 1]), float(records[PITCH_ASKED - 1])


@contextmanager
def started(tuning: Tuning) -> Iterator[tuple[Any, Path]]:
    """Yield the entry of a library of its own, and the file of the tuning."""
    import _ctypes

    with TemporaryDirectory(prefix="rosco-") as folder, _no_output():
        # The original is loaded for the libraries beside it; the copy has states of its own.
        original = library_path()
        ctypes.CDLL(str(original))
        library = ctypes.CDLL(shutil.copy(original, folder))
        tables, file = Path(folder) / "tables.txt", Path(folder) / "DISCON.IN"
        discon = _set(_set(tuning.discon, "PerfFileName", f'"{tables.name}"'), "LoggingLevel", "0")
        tables.write_text(tuning.tables, encoding="utf-8")
        file.write_text(discon, encoding="utf-8")
        try:
            yield library.DISCON, file
        finally:
            # What its Fortran has still to print, which would come at the end of the process.
            if hasattr(library, "_gfortran_flush_i4"):
                library._gfortran_flush_i4(None)
            _ctypes.dlclose(library._handle)


@contextmanager
def _no_output() -> Iterator[None]:
    """Let nothing that a library prints reach the output of this process."""
    sys.stdout.flush()
    out = os.dup(1)
    try:
        with open(os.devnull, "w", encoding="utf-8") as nowhere:
            os.dup2(nowhere.fileno(), 1)
        yield
    finally:
        os.dup2(out, 1)
        os.close(out)


def simulate_rosco(plant: SimulatedTurbine, name: str, tuning: Tuning, wind: WindSeries) -> History:
    """Return ROSCO's loop over the whole wind series, from the trim of its first wind.

    Raises
    ------
    ModelError : the package is missing, or it refuses the tuning.
    Diverged : a ModelError; the states grow beyond all numbers.
    """
    turbine, period = plant.turbine, TIME_STEP
    step = plant_step(plant, period, 0.0)
    inner, samples = step_counts(step, period, wind)
    state, point = plant.initial_state(float(wind.speed[0]))
    winds = wind.at(wind.time[0] + np.arange(2 * inner * samples + 1) * (step / 2))
    states = np.empty((samples + 1, len(state)))
    signals = np.empty((samples + 1, 3))
    generator = plant.index("generator speed") or 0
    top, acting = plant.index("tower"), plant.index("generator torque")
    sent, top_speed = (point.torque, point.pitch), 0.0
    controller = None
    with started(tuning) as (library, file):
        for number in range(samples + 1):
            x = state.tolist()
            if not isfinite(sum(x)):
                raise Diverged(name, wind.name, number * period)
            speed = turbine.gear_ratio * x[generator]
            torque = sent[0] if acting is None else x[acting]
            moving = 0.0 if top is None else x[top + 1]
            measured = {
                TIME: number * period,
                PITCH: x[1],
                GENERATOR: speed,
                ROTOR: x[0],
                TORQUE: torque,
                SHAFT_POWER: torque * speed,
                POWER: turbine.generator_efficiency * torque * speed,
                WIND: winds[2 * inner * number],
                TOP: (moving - top_speed) / period if number else 0.0,
            }
            top_speed = moving
            if controller is None:
                controller = Controller(library, file, measured, period)
            wanted, pitch = controller.step(measured)
            limited = limit_torque(plant, sent[0], wanted, period)
            states[number] = state
            signals[number] = wanted, pitch, limited
            ahead = winds[2 * inner * number : 2 * inner * (number + 1) + 1]
            state = advance(plant, state, np.array([*sent, limited, pitch]), 0, ahead, step)
            sent = limited, pitch
    seen = winds[:: 2 * inner].copy()
    wanted_torque, reference, limited_torque = (column.copy() for column in signals.T)
    record = Record(
        states, seen, seen, wanted_torque, reference, limited_torque, np.empty((samples + 1, 0))
    )
    return history_of(plant, wind, record, period, point.torque)
