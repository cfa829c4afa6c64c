"""Times ROSCO's Python simulator, for ``validation_plant.py``; runs where the package rosco is.

    PYTHON rosco_simulation.py WIND.json DIR

WIND.json has the times and the winds.  Turbine and tuning are those that the package ships for the
NREL 5-MW, as in its example 04; DIR takes the controller's files.  Prints the seconds of the run,
by the clock and of the core.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

import numpy as np
import rosco
from rosco import discon_lib_path
from rosco.toolbox import control_interface, controller, sim, turbine
from rosco.toolbox.inputs.validation import load_rosco_yaml
from rosco.toolbox.utilities import write_DISCON


def main() -> None:
    """Run the simulator once in the wind."""
    times, winds = (np.array(row) for row in json.loads(Path(sys.argv[1]).read_text()))
    os.chdir(sys.argv[2])
    tuning = Path(rosco.__file__).parents[1] / "Examples" / "Tune_Cases"
    asked = load_rosco_yaml(str(tuning / "NREL5MW.yaml"))
    paths, model = asked["path_params"], turbine.Turbine(asked["turbine_params"])
    tables = str(tuning / paths["rotor_performance_filename"])
    model.load_from_fast(
        paths["FAST_InputFile"],
        str(tuning / paths["FAST_directory"]),
        rot_source="txt",
        txt_filename=tables,
    )
    law = controller.Controller(asked["controller_params"])
    law.tune_controller(model)
    write_DISCON(model, law, param_file="DISCON.IN", txt_filename=tables)
    library = control_interface.ControllerInterface(
        discon_lib_path, param_filename="DISCON.IN", sim_name="benchmark"
    )
    simulation = sim.Sim(model, library)
    began, core = time.perf_counter(), time.process_time()
    simulation.sim_ws_series(times, winds, rotor_rpm_init=12.0, make_plots=False)
    spent = time.perf_counter() - began, time.process_time() - core
    fastest = float(np.max(simulation.rot_speed)) * 30 / np.pi
    if not 10.0 < fastest < 16.0:
        raise SystemExit(f"the rotor reached {fastest:.1f} rpm: the run is not what it should be")
    print(*spent)


if __name__ == "__main__":
    main()
