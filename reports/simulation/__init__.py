"""`takagi simulate`: laws side by side in the same winds, as a table, figures and series.

scenarios          the winds to choose from: the paper's, steps, gusts, a ramp
laws, filed_law    the laws to choose from, made from one design; the law of a gain file
runs               every law in every wind; failed runs are reported
tables             rows, Markdown, CSV, JSON; the series of a run
figures, folder    the figures; everything that is written, by file name
plant              a plant under its law, from chosen starts
plant_scenario     the signals that act on it, and the timing of its law
plant_runs         its runs, and quantities that are computed from them
plant_words        the results in sentences, and as a table
plant_figures      the results over time, in the units of its file
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.simulation.laws import ChosenLaws as ChosenLaws
    from takagi.reports.simulation.laws import chosen_laws as chosen_laws
    from takagi.reports.simulation.plant import jump_motions as jump_motions
    from takagi.reports.simulation.plant import proved_jumps as proved_jumps
    from takagi.reports.simulation.plant import simulate_plant as simulate_plant
    from takagi.reports.simulation.plant import simulation_data as simulation_data
    from takagi.reports.simulation.plant_scenario import PlantScenario as PlantScenario
    from takagi.reports.simulation.runs import Simulation as Simulation
    from takagi.reports.simulation.runs import run_simulation as run_simulation
    from takagi.reports.simulation.scenarios import SCENARIOS as SCENARIOS
    from takagi.reports.simulation.scenarios import scenario_winds as scenario_winds
    from takagi.reports.simulation.tables import as_csv as as_csv
    from takagi.reports.simulation.tables import as_json as as_json
    from takagi.reports.simulation.tables import as_markdown as as_markdown
    from takagi.reports.simulation.tables import simulation_files as simulation_files
    from takagi.reports.simulation.tables import table_rows as table_rows

__getattr__, __dir__ = lazy_names(__name__)
